//! What to compute: reduction, modes, frequencies, quantity, damping.

use super::analysis_model::{Analysis, ComponentAnalysis, Damping, Quantity, ReductionMethod};
use super::error::MachineError;
use super::frequencies::read_frequencies;
use super::parts::read_loss_factor;
use super::quantity::Dimension;
use super::table::{Bound, Item, Table};

type Result<T> = std::result::Result<T, MachineError>;

/// Component modes a part at least, and modes a position, where the file names no number: the paper's.
const DEFAULT_COMPONENT_MODES: usize = 50;
const DEFAULT_MODES: usize = 30;

pub(super) fn read_analysis(root: &Table<'_>) -> Result<Analysis> {
    let table = root.need("analysis", "an [analysis] section with frequencies and damping")?.table()?;
    let component = table.get("component").map(|item| read_component(&item)).transpose()?;
    let modes = table.get("modes").map(|item| item.count()).transpose()?;
    let (frequencies, grid) = read_frequencies(
        &table.need("frequencies", "frequencies = { from = \"0 Hz\", to = \"900 Hz\", step = \"1 Hz\" }")?,
    )?;
    let quantity = table.get("quantity").map(|item| read_quantity(&item)).transpose()?.unwrap_or_default();
    let damping = read_damping(&table.need("damping", "damping = { ratio = 0.02 }")?)?;
    table.finish()?;
    Ok(Analysis {
        component: component.unwrap_or(DEFAULT_COMPONENT),
        modes: modes.unwrap_or(DEFAULT_MODES),
        frequencies,
        grid,
        quantity,
        damping,
    })
}

const DEFAULT_COMPONENT: ComponentAnalysis = ComponentAnalysis {
    modes: DEFAULT_COMPONENT_MODES,
    follows: true,
    band: f64::INFINITY,
    method: ReductionMethod::CraigBampton,
    second_moment: true,
};

fn read_component(item: &Item<'_>) -> Result<ComponentAnalysis> {
    let table = item.table()?;
    let mut component = DEFAULT_COMPONENT;
    if let Some(item) = table.get("modes") {
        (component.modes, component.follows) = (item.count()?, false);
    }
    if let Some(item) = table.get("band") {
        (component.band, component.follows) = (item.quantity(Dimension::Frequency, Bound::Positive)?, false);
    }
    if let Some(item) = table.get("method") {
        component.method = match item.text()? {
            "craig-bampton" => ReductionMethod::CraigBampton,
            "free-interface" => ReductionMethod::FreeInterface,
            _ => {
                let allowed = "\"craig-bampton\" or \"free-interface\"";
                return Err(item.refuse(allowed, "write one of them"));
            }
        };
    }
    if let Some(item) = table.get("second_moment") {
        component.second_moment = item.boolean()?;
    }
    table.finish()?;
    Ok(component)
}

fn read_quantity(item: &Item<'_>) -> Result<Quantity> {
    Quantity::named(item.text()?)
        .ok_or_else(|| item.refuse("\"receptance\", \"mobility\" or \"accelerance\"", "write one of them"))
}

/// Reads a `damping` table: `ratio`, `ratios`, `rayleigh`, `loss_factor`, `solution`.
pub(crate) fn read_damping(item: &Item<'_>) -> Result<Damping> {
    let table = item.table()?;
    let (one, many) = (table.get("ratio"), table.get("ratios"));
    let rayleigh = table.get("rayleigh").map(|item| read_rayleigh(&item)).transpose()?;
    let loss_factor = table.get("loss_factor").map(|item| read_loss_factor(&item)).transpose()?;
    let projected = match table.get("solution") {
        None => false,
        Some(item) => match item.text()? {
            "exact" => false,
            "projected" => true,
            _ => return Err(item.refuse("\"exact\" or \"projected\"", "leave it out for the exact solution")),
        },
    };
    let ratios = match (&one, &many) {
        (Some(_), Some(many)) => {
            return Err(many.refuse("either `ratio` or `ratios`", "remove one of them"));
        }
        (Some(one), None) => vec![read_ratio(one)?],
        (None, Some(many)) => {
            let ratios = many.list()?.iter().map(read_ratio).collect::<Result<Vec<_>>>()?;
            if ratios.is_empty() {
                return Err(many.refuse("one ratio a mode", "give at least one; the last holds for all further modes"));
            }
            ratios
        }
        (None, None) => Vec::new(),
    };
    let says_nothing = ratios.is_empty() && rayleigh.is_none() && loss_factor.is_none();
    table.finish()?;
    if says_nothing {
        return Err(item.refuse(
            "at least one of ratio, ratios, rayleigh, loss_factor",
            "write { ratio = 0 } for a machine without damping",
        ));
    }
    let ratios = if ratios.is_empty() { vec![0.0] } else { ratios };
    Ok(Damping { ratios, rayleigh, loss_factor: loss_factor.unwrap_or(0.0), projected })
}

fn read_ratio(item: &Item<'_>) -> Result<f64> {
    let zeta = item.quantity(Dimension::Ratio, Bound::Any)?;
    if (0.0..1.0).contains(&zeta) {
        return Ok(zeta);
    }
    Err(item.refuse("a damping ratio from 0 to less than 1", "write 0.02 or \"2 %\" for two per cent"))
}

fn read_rayleigh(item: &Item<'_>) -> Result<[f64; 2]> {
    let table = item.table()?;
    let alpha = table.need("alpha", "alpha = \"10 1/s\"")?.quantity(Dimension::InverseTime, Bound::NotNegative)?;
    let beta = table.need("beta", "beta = \"1e-5 s\"")?.quantity(Dimension::Time, Bound::NotNegative)?;
    table.finish()?;
    Ok([alpha, beta])
}

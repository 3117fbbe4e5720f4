//! What to compute: reduction, modes, frequencies, damping.

use super::error::MachineError;
use super::model::{Analysis, ComponentAnalysis, Damping, ReductionMethod};
use super::parts::read_loss_factor;
use super::quantity::Dimension;
use super::table::{Bound, Item, Table};

type Result<T> = std::result::Result<T, MachineError>;

/// Component modes a part, and modes a position, where the file names no number: the paper's.
const DEFAULT_COMPONENT_MODES: usize = 50;
const DEFAULT_MODES: usize = 30;
/// Most frequencies of the grid.
const MOST_FREQUENCIES: f64 = 1_000_000.0;

pub(super) fn read_analysis(root: &Table<'_>) -> Result<Analysis> {
    let table = root.need("analysis", "an [analysis] section with frequencies and damping")?.table()?;
    let component = table.get("component").map(|item| read_component(&item)).transpose()?;
    let modes = table.get("modes").map(|item| item.count()).transpose()?;
    let frequencies = read_frequencies(
        &table.need("frequencies", "frequencies = { from = \"0 Hz\", to = \"900 Hz\", step = \"1 Hz\" }")?,
    )?;
    let damping = read_damping(&table.need("damping", "damping = { ratio = 0.02 }")?)?;
    table.finish()?;
    Ok(Analysis {
        component: component.unwrap_or(DEFAULT_COMPONENT),
        modes: modes.unwrap_or(DEFAULT_MODES),
        frequencies,
        damping,
    })
}

const DEFAULT_COMPONENT: ComponentAnalysis = ComponentAnalysis {
    modes: DEFAULT_COMPONENT_MODES,
    band: f64::INFINITY,
    method: ReductionMethod::CraigBampton,
    second_moment: true,
};

fn read_component(item: &Item<'_>) -> Result<ComponentAnalysis> {
    let table = item.table()?;
    let mut component = DEFAULT_COMPONENT;
    if let Some(item) = table.get("modes") {
        component.modes = item.count()?;
    }
    if let Some(item) = table.get("band") {
        component.band = item.quantity(Dimension::Frequency, Bound::Positive)?;
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

/// A range `{ from, to, step }` or an ascending list.
fn read_frequencies(item: &Item<'_>) -> Result<Vec<f64>> {
    if item.is_table() { read_range(item) } else { read_list(item) }
}

fn read_range(item: &Item<'_>) -> Result<Vec<f64>> {
    let table = item.table()?;
    let hertz = |item: Item<'_>, bound| item.quantity(Dimension::Frequency, bound);
    let from = hertz(table.need("from", "from = \"0 Hz\"")?, Bound::NotNegative)?;
    let to_item = table.need("to", "to = \"900 Hz\"")?;
    let to = hertz(to_item.clone(), Bound::NotNegative)?;
    let step_item = table.need("step", "step = \"1 Hz\"")?;
    let step = hertz(step_item.clone(), Bound::Positive)?;
    table.finish()?;
    if to < from {
        return Err(to_item.refuse(format!("at least `from`, {from} Hz"), "exchange the two"));
    }
    let intervals = (to - from) / step;
    if intervals > MOST_FREQUENCIES {
        let allowed = format!("a step that divides the range into at most {MOST_FREQUENCIES} intervals");
        return Err(step_item.refuse(allowed, "make the step larger"));
    }
    // A last step that misses `to` by rounding alone still reaches it.
    let count = (intervals * (1.0 + 1e-9)).floor() as usize;
    let mut grid: Vec<f64> = (0..=count).map(|i| (from + step * i as f64).min(to)).collect();
    if grid.last().is_some_and(|last| to - last > 1e-9 * step) {
        grid.push(to);
    }
    Ok(grid)
}

fn read_list(item: &Item<'_>) -> Result<Vec<f64>> {
    const ALLOWED: &str = "an ascending list of frequencies, or { from, to, step }";
    if !item.is_list() {
        return Err(item.refuse(ALLOWED, "write one of them"));
    }
    let mut list: Vec<f64> = Vec::new();
    for entry in item.list()? {
        let frequency = entry.quantity(Dimension::Frequency, Bound::NotNegative)?;
        if let Some(&last) = list.last().filter(|&&last| frequency <= last) {
            return Err(entry.refuse(format!("more than the one before, {last} Hz"), "put them in ascending order"));
        }
        list.push(frequency);
    }
    if list.is_empty() {
        return Err(item.refuse(ALLOWED, "give at least one frequency"));
    }
    Ok(list)
}

fn read_damping(item: &Item<'_>) -> Result<Damping> {
    let table = item.table()?;
    let (one, many) = (table.get("ratio"), table.get("ratios"));
    let rayleigh = table.get("rayleigh").map(|item| read_rayleigh(&item)).transpose()?;
    let loss_factor = table.get("loss_factor").map(|item| read_loss_factor(&item)).transpose()?;
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
    Ok(Damping { ratios, rayleigh, loss_factor: loss_factor.unwrap_or(0.0) })
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

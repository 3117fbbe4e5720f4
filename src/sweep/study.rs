//! The study file: what is varied, how it is sampled, what is measured and wanted.

use super::Design;
use super::goals::{Bound, Cost, Figure, Names, Objective, read_cost, read_goals};
use super::metrics::{Column, Metric, Quantity, read_metrics};
use super::optimise::{Search, read_search};
use super::sampling::{Sampling, read_sampling};
use super::study_error::StudyError;
use super::variable_reading::read_variables;
use super::variables::{Variable, design};
use crate::files::Inputs;
use crate::machine::table::{Bound as Sign, Item, Source, Table};
use crate::machine::{Dimension, Machine, MachineError, read_damping, read_machine};
use std::path::{Path, PathBuf};
use toml::de::DeTable;

/// A study: a machine and the sweep over its designs.
#[derive(Clone, Debug)]
pub struct Study {
    /// Name, for headings and the default output folder.
    pub name: String,
    /// The study file.
    pub file: PathBuf,
    /// The nominal machine.
    pub machine: Machine,
    /// What is varied.
    pub variables: Vec<Variable>,
    /// Which designs.
    pub sampling: Sampling,
    /// What is measured.
    pub metrics: Vec<Metric>,
    /// The families that the metrics need, in the order of [`super::PositionMetrics::families`].
    pub families: Vec<usize>,
    /// What a design costs.
    pub cost: Option<Cost>,
    /// What it must keep.
    pub bounds: Vec<Bound>,
    /// What is improved.
    pub objectives: Vec<Objective>,
    /// Positions, m.
    pub positions: Vec<f64>,
    /// First and last frequency of the band, Hz.
    pub band: [f64; 2],
    /// How the best design is looked for.
    pub search: Search,
    /// Study and machine file as they were read.
    pub inputs: Inputs,
}

impl Study {
    /// The values of the design with an index, SI.
    pub fn values(&self, index: u64) -> Vec<f64> {
        self.sampling.values(&self.variables, index)
    }

    /// The design with the given value of each variable.
    pub fn design(&self, values: &[f64]) -> Design {
        design(&self.machine, &self.variables, values)
    }

    /// Designs at the corners of the variables' ranges: all of them up to six variables, the two opposite
    /// ones and each end alone beyond. They differ from each other in every place that is varied.
    pub fn probes(&self) -> Vec<Design> {
        let n = self.variables.len();
        let corner = |high: &dyn Fn(usize) -> bool| -> Vec<f64> {
            self.variables.iter().enumerate().map(|(i, v)| v.at(if high(i) { 1.0 } else { 0.0 })).collect()
        };
        let corners: Vec<Vec<f64>> = if n <= 6 {
            (0..1_usize << n).map(|bits| corner(&|i| bits >> i & 1 == 1)).collect()
        } else {
            let alone = (0..n).flat_map(|k| [corner(&|i| i == k), corner(&|i| i != k)]);
            [corner(&|_| false), corner(&|_| true)].into_iter().chain(alone).collect()
        };
        corners.iter().map(|values| self.design(values)).collect()
    }

    /// The frequencies of the machine's grid within the band, Hz, its ends among them.
    pub fn frequencies(&self) -> Vec<f64> {
        let [from, to] = self.band;
        let grid = self.machine.analysis.frequencies.iter().copied();
        let mut inside: Vec<f64> = grid.filter(|f| *f > from && *f < to).collect();
        inside.insert(0, from);
        if to > from {
            inside.push(to);
        }
        inside
    }

    /// Columns of the variables.
    pub fn variable_columns(&self) -> Vec<Column> {
        self.variables.iter().map(|v| Column { name: v.name.clone(), unit: v.unit().to_owned() }).collect()
    }

    /// Columns of cost and metrics.
    pub fn result_columns(&self) -> Vec<Column> {
        let cost = self.cost.iter().map(|c| Column { name: "cost".to_owned(), unit: c.unit.clone() });
        cost.chain(self.metrics.iter().flat_map(|m| m.columns(&self.positions))).collect()
    }

    /// Place of a figure's value among the result columns.
    pub fn result_place(&self, figure: Figure) -> usize {
        let Figure::Metric(metric) = figure else { return 0 };
        let before = self.metrics[..metric].iter().map(|m| m.columns(&self.positions).len());
        usize::from(self.cost.is_some()) + before.sum::<usize>()
    }

    /// What a reader of the table should know, in sentences.
    pub fn remarks(&self) -> Vec<String> {
        let own =
            self.machine.joints.iter().map(|j| j.loss_factor).chain(self.machine.parts.iter().map(|p| p.loss_factor));
        let eta = self.machine.analysis.damping.loss_factor + own.flatten().fold(0.0, f64::max);
        let is_static = |metric: &Metric| matches!(metric.quantity, Quantity::StaticStiffness(_));
        if eta == 0.0 || !self.metrics.iter().any(is_static) {
            return Vec::new();
        }
        let percent = 100.0 * ((1.0 + eta * eta).sqrt() - 1.0);
        vec![format!(
            "static-stiffness is that of the machine without damping; with loss factors of up to {eta} 1/|H(0)| of a map \
             is larger by up to {percent:.2} %"
        )]
    }

    /// Unit of a figure.
    pub fn unit(&self, figure: Figure) -> String {
        self.result_columns()[self.result_place(figure)].unit.clone()
    }
}

/// Reads a study and its machine.
///
/// # Errors
/// [`StudyError`] with file, line, key, the value seen, what is allowed and what to do, for the first thing that is
/// wrong in the study or in its machine file.
pub fn read_study(path: &Path) -> Result<Study, StudyError> {
    let unreadable = |source| StudyError::Unreadable { file: path.to_path_buf(), source };
    let mut inputs = Inputs::default();
    let text = inputs.read_text(path).map_err(unreadable)?;
    let source = Source { path, text: &text };
    let document = DeTable::parse(&text).map_err(|error| {
        let (line, column) = source.line_column(error.span().map_or(0, |span| span.start));
        MachineError::Syntax { file: path.to_path_buf(), line, column, message: error.message().to_owned() }
    })?;
    let root = Table::root(&source, document.get_ref());
    let mut machine = read_its_machine(&root, path)?;
    inputs.extend(&machine.inputs)?;
    if let Some(item) = root.get("damping") {
        machine.analysis.damping = read_damping(&item)?;
    }
    let name_item = root.need("name", "name = \"my study\"")?;
    let name = name_item.text()?;
    name_item.check_name(name)?;
    let variables = read_variables(&root, &machine)?;
    let sampling = read_sampling(&root, &variables)?;
    let (metrics, families) = read_metrics(&root, &machine)?;
    let cost = read_cost(&root, &variables)?;
    let (bounds, objectives) = read_goals(&root, &metrics, cost.as_ref())?;
    let positions = match root.get("positions") {
        Some(item) => read_positions(&item, &machine)?,
        None => machine.axis.stations(),
    };
    let band = match root.get("band") {
        Some(item) => read_band(&item)?,
        None => {
            let grid = &machine.analysis.frequencies;
            [grid[0], grid[grid.len() - 1]]
        }
    };
    let search = read_search(&root, &objectives, Names { metrics: &metrics, has_cost: cost.is_some() })?;
    let whole = root.item.clone();
    root.finish()?;
    let file = path.to_path_buf();
    let study = Study {
        name: name.to_owned(),
        file,
        machine,
        variables,
        sampling,
        metrics,
        families,
        cost,
        bounds,
        objectives,
        positions,
        band,
        search,
        inputs,
    };
    check_columns(&study, &whole)?;
    Ok(study)
}

/// Refuses two columns of one name, which a reader of the table would take for one.
fn check_columns(study: &Study, file: &Item<'_>) -> Result<(), StudyError> {
    let mut names = vec!["design".to_owned(), "bounds_met".to_owned(), "error".to_owned()];
    for column in study.variable_columns().into_iter().chain(study.result_columns()) {
        if names.contains(&column.name) {
            let place = file.place();
            return Err(MachineError::Duplicate { place, kind: "column of the table", name: column.name }.into());
        }
        names.push(column.name);
    }
    Ok(())
}

fn read_its_machine(root: &Table<'_>, study: &Path) -> Result<Machine, StudyError> {
    let item = root.need("machine", "machine = \"machine.toml\", relative to the study")?;
    let folder = study.parent().unwrap_or(Path::new(""));
    let path = folder.join(item.text()?);
    if !path.exists() {
        return Err(item
            .refuse("an existing machine file, named relative to the study's folder", "correct the name")
            .into());
    }
    Ok(read_machine(&path)?)
}

/// A list of positions, or `{ from, to, step }`.
fn read_positions(item: &Item<'_>, machine: &Machine) -> Result<Vec<f64>, StudyError> {
    let length = |item: &Item<'_>| item.quantity(Dimension::Length, Sign::Any);
    let [a, b] = machine.axis.travel;
    let inside = |item: &Item<'_>, p: f64| -> Result<f64, StudyError> {
        if p >= a.min(b) - 1e-9 && p <= a.max(b) + 1e-9 {
            return Ok(p);
        }
        let allowed = format!("a position within the travel, {a} to {b} m");
        Err(item.refuse(allowed, "correct it").into())
    };
    if item.is_table() {
        let table = item.table()?;
        let (from_item, to_item) = (table.need("from", "from = \"0 mm\"")?, table.need("to", "to = \"-600 mm\"")?);
        let travel = [inside(&from_item, length(&from_item)?)?, inside(&to_item, length(&to_item)?)?];
        let step_item = table.need("step", "step = \"5 mm\"")?;
        let step = step_item.quantity(Dimension::Length, Sign::Positive)?;
        table.finish()?;
        if (travel[1] - travel[0]).abs() / step > 100_000.0 {
            return Err(step_item.refuse("a step that gives at most 100000 positions", "make the step larger").into());
        }
        return Ok(crate::machine::Axis { travel, step, ..machine.axis.clone() }.stations());
    }
    let mut positions: Vec<f64> = Vec::new();
    for entry in item.list()? {
        let p = inside(&entry, length(&entry)?)?;
        if positions.contains(&p) {
            let (place, name) = (entry.place(), entry.seen());
            return Err(MachineError::Duplicate { place, kind: "position", name }.into());
        }
        positions.push(p);
    }
    if positions.is_empty() {
        return Err(item.refuse("at least one position", "leave the key out for the machine's stations").into());
    }
    Ok(positions)
}

fn read_band(item: &Item<'_>) -> Result<[f64; 2], StudyError> {
    let table = item.table()?;
    let from = table.need("from", "from = \"0 Hz\"")?.quantity(Dimension::Frequency, Sign::NotNegative)?;
    let to_item = table.need("to", "to = \"900 Hz\"")?;
    let to = to_item.quantity(Dimension::Frequency, Sign::NotNegative)?;
    table.finish()?;
    if to <= from {
        return Err(to_item.refuse(format!("more than `from`, {from} Hz"), "exchange the two").into());
    }
    Ok([from, to])
}

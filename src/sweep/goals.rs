//! What a study wants of a design: bounds to keep, objectives to improve, and what it costs.
//!
//! Bounds, objectives and the search name a metric as the table's columns do. With several ports such a name holds a
//! point, `dyn_tool.x`, which TOML takes for a table within a table unless it is quoted; both are read as the name, and
//! so is `dyn_tool_x` with underscores for points and spaces.

use super::metrics::{Metric, Over, Quantity};
use super::study_error::StudyError;
use super::variables::Variable;
use crate::machine::table::{Bound as Sign, Item, Table, find_name};
use crate::machine::{Dimension, MachineError};

/// A number that bounds and objectives may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// A metric of the study by index.
    Metric(usize),
    /// The cost.
    Cost,
}

/// What a design costs: a constant and a share of each variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// Unit, such as `EUR`.
    pub unit: String,
    /// Cost of every design.
    pub constant: f64,
    /// Variable by index, and cost for each SI unit of it.
    pub terms: Vec<(usize, f64)>,
}

impl Cost {
    /// The cost of a design's values.
    ///
    /// ```text
    /// cost = constant + sum of costs_v value_v / per_v
    /// ```
    pub fn of(&self, values: &[f64]) -> f64 {
        self.constant + self.terms.iter().map(|&(v, slope)| slope * values[v]).sum::<f64>()
    }
}

/// What a design must keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Name in the study.
    pub name: String,
    /// What is bounded.
    pub figure: Figure,
    /// Smallest value allowed, SI.
    pub min: Option<f64>,
    /// Largest value allowed, SI.
    pub max: Option<f64>,
}

impl Bound {
    /// By how much a value misses the bound, relative to the bound; 0 where it is kept.
    pub fn violation(&self, value: f64) -> f64 {
        let below = self.min.map_or(0.0, |min| (min - value) / min.abs().max(f64::MIN_POSITIVE));
        let above = self.max.map_or(0.0, |max| (value - max) / max.abs().max(f64::MIN_POSITIVE));
        below.max(above).max(0.0)
    }
}

/// What is to be made larger or smaller.
#[derive(Clone, Debug, PartialEq)]
pub struct Objective {
    /// Name in the study.
    pub name: String,
    /// What is improved.
    pub figure: Figure,
    /// Whether larger is better.
    pub maximise: bool,
}

impl Objective {
    /// To improve a figure in its own sense: a stiffness, a frequency or a real part larger, a compliance or the cost
    /// smaller.
    pub(super) fn natural(figure: Figure, name: &str, metrics: &[Metric]) -> Self {
        let maximise = matches!(figure, Figure::Metric(at) if metrics[at].quantity.larger_is_better());
        Self { name: name.to_owned(), figure, maximise }
    }

    /// A value as something to make small.
    pub fn to_minimise(&self, value: f64) -> f64 {
        if self.maximise { -value } else { value }
    }
}

type Result<T> = std::result::Result<T, StudyError>;

/// Reads `[cost]`.
pub(super) fn read_cost(root: &Table<'_>, variables: &[Variable]) -> Result<Option<Cost>> {
    let Some(item) = root.get("cost") else { return Ok(None) };
    let table = item.table()?;
    let unit = table.need("unit", "unit = \"EUR\"")?.text()?.to_owned();
    let constant = table.get("constant").map(|item| item.plain_number()).transpose()?.unwrap_or(0.0);
    let names: Vec<&str> = variables.iter().map(|v| v.name.as_str()).collect();
    let mut terms = Vec::new();
    for (name, item) in
        table.need("terms", "[cost.terms] with VARIABLE = { per = \"1 mm\", costs = 10 }")?.table()?.entries()?
    {
        let at = find_name(&item, "variable", name, &names)?;
        let Some(dimension) = variables[at].dimension else {
            return Err(item
                .refuse_seen(format!("{name:?}"), "a variable whose values are numbers", "remove the term")
                .into());
        };
        let term = item.table()?;
        let per =
            term.need("per", "per = \"1 mm\", the step that costs so much")?.quantity(dimension, Sign::Positive)?;
        let costs = term.need("costs", "costs = 10")?.plain_number()?;
        term.finish()?;
        terms.push((at, costs / per));
    }
    table.finish()?;
    Ok(Some(Cost { unit, constant, terms }))
}

/// Names that bounds, objectives and the search may use.
#[derive(Clone, Copy)]
pub(super) struct Names<'a> {
    pub metrics: &'a [Metric],
    pub has_cost: bool,
}

/// A name with underscores for points and spaces.
fn plain(name: &str) -> String {
    name.replace(['.', ' '], "_")
}

impl<'a> Names<'a> {
    /// All of them, the cost last.
    fn all(&self) -> Vec<&'a str> {
        let metrics = self.metrics.iter().map(|m| m.name.as_str());
        metrics.chain(self.has_cost.then_some("cost")).collect()
    }

    /// The figure of a name, and the name as columns have it.
    pub fn find(&self, item: &Item<'_>, name: &str) -> Result<(Figure, &'a str)> {
        let names = self.all();
        // Underscores for points serve where they leave no doubt.
        let mut alike = names.iter().filter(|known| plain(known) == plain(name));
        let meant = match (names.contains(&name), alike.next(), alike.next()) {
            (false, Some(known), None) => known,
            _ => name,
        };
        let at = find_name(item, "metric", meant, &names)?;
        Ok((self.figure(item, at)?, names[at]))
    }

    fn figure(&self, item: &Item<'_>, at: usize) -> Result<Figure> {
        if at == self.metrics.len() {
            return Ok(Figure::Cost);
        }
        let name = &self.metrics[at].name;
        if self.metrics[at].over == Over::Each {
            let seen = format!("{name:?}, which has a value at each position");
            let allowed = "a metric over \"worst\" or \"mean\"";
            return Err(item.refuse_seen(seen, allowed, "add such a metric and name it here").into());
        }
        Ok(Figure::Metric(at))
    }

    /// The entries of `[bounds]` or `[objectives]` with the names they are for, in the order of the file.
    ///
    /// A table whose key is how a name begins up to a point is not a goal but the beginning of that name.
    fn entries<'t>(&self, table: &Table<'t>, before: &str) -> Result<Vec<(String, Item<'t>)>> {
        let mut entries = Vec::new();
        for (key, item) in table.children() {
            let name = format!("{before}{key}");
            let begins = |known: &&str| known.strip_prefix(name.as_str()).is_some_and(|rest| rest.starts_with('.'));
            if item.is_table() && self.all().iter().any(begins) {
                entries.extend(self.entries(&item.table()?, &format!("{name}."))?);
            } else {
                entries.push((name, item));
            }
        }
        Ok(entries)
    }

    /// The same of a section that may be left out.
    fn section<'t>(&self, root: &Table<'t>, key: &'static str) -> Result<Vec<(String, Item<'t>)>> {
        root.get(key).map_or_else(|| Ok(Vec::new()), |item| self.entries(&item.table()?, ""))
    }

    fn value(&self, item: &Item<'_>, figure: Figure) -> Result<f64> {
        let Figure::Metric(at) = figure else { return Ok(item.plain_number()?) };
        let dimension = match self.metrics[at].quantity {
            Quantity::DynamicStiffness(_) | Quantity::StaticStiffness(_) => Dimension::Stiffness,
            Quantity::Compliance(_) | Quantity::NegativeReal(_) => Dimension::Compliance,
            Quantity::Eigenfrequency(_) => Dimension::Frequency,
        };
        Ok(item.quantity(dimension, Sign::Any)?)
    }
}

/// Reads `[bounds]` and `[objectives]`.
pub(super) fn read_goals(
    root: &Table<'_>,
    metrics: &[Metric],
    cost: Option<&Cost>,
) -> Result<(Vec<Bound>, Vec<Objective>)> {
    let names = Names { metrics, has_cost: cost.is_some() };
    let twice = |item: &Item<'_>, kind, name: &str| MachineError::Duplicate {
        place: item.place(),
        kind,
        name: name.to_owned(),
    };
    let mut bounds: Vec<Bound> = Vec::new();
    for (name, item) in names.section(root, "bounds")? {
        let (figure, name) = names.find(&item, &name)?;
        if bounds.iter().any(|bound| bound.figure == figure) {
            return Err(twice(&item, "bound", name).into());
        }
        let table = item.table()?;
        let (low, high) = (table.get("min"), table.get("max"));
        let min = low.as_ref().map(|item| names.value(item, figure)).transpose()?;
        let max = high.as_ref().map(|item| names.value(item, figure)).transpose()?;
        table.finish()?;
        match (min, max) {
            (None, None) => return Err(item.refuse("min, max or both", "add one of them").into()),
            (Some(a), Some(b)) if a > b => {
                return Err(item.refuse("a `min` that is at most `max`", "exchange the two").into());
            }
            _ => bounds.push(Bound { name: name.to_owned(), figure, min, max }),
        }
    }
    let mut objectives: Vec<Objective> = Vec::new();
    for (name, item) in names.section(root, "objectives")? {
        let (figure, name) = names.find(&item, &name)?;
        if objectives.iter().any(|objective| objective.figure == figure) {
            return Err(twice(&item, "objective", name).into());
        }
        let maximise = match item.text()? {
            "maximise" => true,
            "minimise" => false,
            _ => return Err(item.refuse("\"maximise\" or \"minimise\"", "write one of them").into()),
        };
        objectives.push(Objective { name: name.to_owned(), figure, maximise });
    }
    Ok((bounds, objectives))
}

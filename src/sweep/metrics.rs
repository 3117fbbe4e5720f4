//! What a study reads from each design: metrics, and how they are brought together over the positions.

use super::study_error::StudyError;
use super::{Evaluation, PositionMetrics, Sensitivity};
use crate::frf::metrics::direct_pairs_of;
use crate::machine::Machine;
use crate::machine::table::{Item, Table, find_name};

/// What is measured at a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Smallest element-wise dynamic stiffness 1/|H| over the band, N/m: direct pair by index.
    DynamicStiffness(usize),
    /// Largest |H| over the band, m/N: direct pair by index.
    Compliance(usize),
    /// Smallest Re H over the band, m/N (the chatter criterion): direct pair by index.
    NegativeReal(usize),
    /// Static stiffness 1/H(0), N/m: direct pair by index.
    StaticStiffness(usize),
    /// Eigenfrequency of a family, Hz: place in [`PositionMetrics::families`].
    Eigenfrequency(usize),
}

/// How the positions come together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// The smallest stiffness, frequency or real part, the largest compliance.
    Worst,
    /// The arithmetic mean.
    Mean,
    /// Every position by itself.
    Each,
}

/// One metric of the study.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// Name, the beginning of its columns' names.
    pub name: String,
    /// What is measured.
    pub quantity: Quantity,
    /// How positions come together.
    pub over: Over,
    /// Whether position and frequency of the value have columns of their own.
    pub place: bool,
}

/// A column of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name, unique in the table.
    pub name: String,
    /// Unit, empty for a plain number.
    pub unit: String,
}

impl Column {
    /// The header: `name [unit]`.
    pub fn header(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{} [{}]", self.name, self.unit) }
    }
}

impl Quantity {
    /// Unit of the value.
    pub fn unit(self) -> &'static str {
        match self {
            Self::DynamicStiffness(_) | Self::StaticStiffness(_) => "N/m",
            Self::Compliance(_) | Self::NegativeReal(_) => "m/N",
            Self::Eigenfrequency(_) => "Hz",
        }
    }

    /// Whether a design is better for a larger value.
    pub fn larger_is_better(self) -> bool {
        !matches!(self, Self::Compliance(_))
    }

    /// Value at a position, with its frequency where it has one; `None` where tracking lost the family.
    pub fn of(self, at: &PositionMetrics) -> Option<(f64, Option<f64>)> {
        Some(match self {
            Self::DynamicStiffness(pair) => {
                (at.pairs[pair].smallest_dynamic_stiffness(), Some(at.pairs[pair].peak.frequency))
            }
            Self::Compliance(pair) => (at.pairs[pair].peak.value, Some(at.pairs[pair].peak.frequency)),
            Self::NegativeReal(pair) => {
                let real = at.pairs[pair].most_negative_real;
                (real.value, Some(real.frequency))
            }
            Self::StaticStiffness(pair) => (at.static_compliance[pair].recip(), None),
            Self::Eigenfrequency(family) => ((*at.families.get(family)?)?, None),
        })
    }

    /// Derivative of the value at a position by a variable, from those of the position's metrics.
    pub fn rate(self, at: &PositionMetrics, by: &Sensitivity) -> Option<f64> {
        Some(match self {
            Self::DynamicStiffness(pair) => -by.peak[pair] / at.pairs[pair].peak.value.powi(2),
            Self::Compliance(pair) => by.peak[pair],
            Self::NegativeReal(pair) => by.most_negative_real[pair],
            Self::StaticStiffness(pair) => -by.static_compliance[pair] / at.static_compliance[pair].powi(2),
            Self::Eigenfrequency(family) => (*by.families.get(family)?)?,
        })
    }

    fn has_frequency(self) -> bool {
        !matches!(self, Self::StaticStiffness(_) | Self::Eigenfrequency(_))
    }
}

impl Metric {
    /// The columns of the metric, over the positions (m).
    pub fn columns(&self, positions: &[f64]) -> Vec<Column> {
        let column = |name: String, unit: &str| Column { name, unit: unit.to_owned() };
        let value = |name: String| column(name, self.quantity.unit());
        let mut columns = Vec::new();
        let frequency = self.place && self.quantity.has_frequency();
        match self.over {
            Over::Each => {
                for position in positions {
                    columns.push(value(format!("{} at {position} m", self.name)));
                    if frequency {
                        columns.push(column(format!("{} frequency at {position} m", self.name), "Hz"));
                    }
                }
            }
            Over::Mean => columns.push(value(self.name.clone())),
            Over::Worst => {
                columns.push(value(self.name.clone()));
                if self.place {
                    columns.push(column(format!("{} position", self.name), "m"));
                }
                if frequency {
                    columns.push(column(format!("{} frequency", self.name), "Hz"));
                }
            }
        }
        columns
    }

    /// The values of its columns for a design, and what is missing in words.
    ///
    /// Where tracking lost the family or a value is not finite, the text says so with the position; no column has a
    /// value then, but with [`Over::Each`] those of the other positions.
    pub fn values(&self, positions: &[f64], evaluation: &Evaluation) -> (Vec<Option<f64>>, Option<String>) {
        let at: Vec<Option<(f64, Option<f64>)>> =
            evaluation.iter().map(|at| self.quantity.of(at).filter(|(value, _)| value.is_finite())).collect();
        let missing = at.iter().position(Option::is_none).map(|p| {
            let what = match self.quantity.of(&evaluation[p]) {
                Some((value, _)) => format!("the value is {value}"),
                None => "tracking lost the family".to_owned(),
            };
            format!("{}: {what} at {} m", self.name, positions[p])
        });
        let frequency = self.place && self.quantity.has_frequency();
        if self.over == Over::Each {
            let cells = at.iter().flat_map(|value| {
                let first = [value.map(|(v, _)| v)];
                first.into_iter().chain(frequency.then(|| value.and_then(|(_, f)| f)))
            });
            return (cells.collect(), missing);
        }
        let whole: Option<Vec<(f64, Option<f64>)>> = at.into_iter().collect();
        let Some(whole) = whole.filter(|w| !w.is_empty()) else {
            return (vec![None; self.columns(positions).len()], missing);
        };
        if self.over == Over::Mean {
            return (vec![Some(whole.iter().map(|(v, _)| v).sum::<f64>() / whole.len() as f64)], None);
        }
        let values: Vec<f64> = whole.iter().map(|(v, _)| *v).collect();
        let worst = self.worst(&values).unwrap_or(0);
        let mut cells = vec![Some(whole[worst].0)];
        if self.place {
            cells.push(Some(positions[worst]));
        }
        if frequency {
            cells.push(whole[worst].1);
        }
        (cells, None)
    }
}

impl Metric {
    /// Derivative of the metric over its worst position, or of its mean, by a variable; `None` where a value is missing
    /// and for [`Over::Each`].
    pub fn rate(&self, evaluation: &Evaluation, by: &[Sensitivity]) -> Option<f64> {
        let values: Vec<f64> =
            evaluation.iter().map(|at| self.quantity.of(at).map(|(v, _)| v)).collect::<Option<_>>()?;
        let rates: Vec<f64> =
            evaluation.iter().zip(by).map(|(at, by)| self.quantity.rate(at, by)).collect::<Option<_>>()?;
        match self.over {
            Over::Each => None,
            Over::Mean => Some(rates.iter().sum::<f64>() / rates.len() as f64),
            Over::Worst => rates.get(self.worst(&values)?).copied(),
        }
    }

    /// Place of the worst value.
    fn worst(&self, values: &[f64]) -> Option<usize> {
        let sign = if self.quantity.larger_is_better() { 1.0 } else { -1.0 };
        (0..values.len()).min_by(|&a, &b| (sign * values[a]).total_cmp(&(sign * values[b])))
    }
}

type Result<T> = std::result::Result<T, StudyError>;

const KINDS: [&str; 5] =
    ["dynamic-stiffness", "compliance", "negative-real-part", "static-stiffness", "eigenfrequency"];

/// Names of the direct pairs' directions, as the coupled model names outputs and inputs: `x`, of a machine with several
/// ports `tool.x`, and `sensor.x from tool.x` where no output is an input too.
pub fn directions(machine: &Machine) -> Vec<String> {
    let names = |wanted: fn(&crate::machine::Port) -> bool| -> Vec<String> {
        let ports = machine.ports.iter().filter(|p| wanted(p));
        let all = ports.flat_map(|port| {
            port.directions.iter().map(|(label, _)| {
                if machine.ports.len() == 1 { label.clone() } else { format!("{}.{label}", port.name) }
            })
        });
        all.collect()
    };
    let (outputs, inputs) = (names(|p| p.output), names(|p| p.input));
    let name = |(o, i): (usize, usize)| match (&outputs[o], &inputs[i]) {
        (output, input) if output == input => output.clone(),
        (output, input) => format!("{output} from {input}"),
    };
    direct_pairs_of(&outputs, &inputs).into_iter().map(name).collect()
}

/// Reads `[metrics]`; returns the metrics and the families that they need.
pub(super) fn read_metrics(root: &Table<'_>, machine: &Machine) -> Result<(Vec<Metric>, Vec<usize>)> {
    let item = root.need("metrics", "a [metrics.NAME] section with kind and directions")?;
    let entries = item.table()?.entries()?;
    if entries.is_empty() {
        return Err(item.refuse_seen("no metric", "at least one metric", "add a [metrics.NAME] section").into());
    }
    let known = directions(machine);
    let mut metrics: Vec<Metric> = Vec::new();
    let mut families: Vec<(usize, usize)> = Vec::new();
    for (name, item) in &entries {
        let table = item.table()?;
        let kind_item = table.need("kind", "kind = \"dynamic-stiffness\"")?;
        let kind = find_name(&kind_item, "metric kind", kind_item.text()?, &KINDS)?;
        let over = match table.get("over") {
            None => Over::Worst,
            Some(item) => match item.text()? {
                "worst" => Over::Worst,
                "mean" => Over::Mean,
                "each" => Over::Each,
                _ => return Err(item.refuse("\"worst\", \"mean\" or \"each\"", "write one of them").into()),
            },
        };
        let place_item = table.get("place");
        let place = place_item.as_ref().map(Item::boolean).transpose()?.unwrap_or(kind == 1 && over != Over::Mean);
        if place && over == Over::Mean {
            let item = place_item.unwrap_or(item.clone());
            return Err(item.refuse("no `place` for a mean", "remove it").into());
        }
        let before = metrics.len();
        let mut add = |suffix: String, quantity| {
            metrics.push(Metric { name: format!("{name}_{suffix}"), quantity, over, place });
        };
        if kind == 4 {
            for item in table.need("families", "families = [1, 2]")?.list()? {
                let family = item.count()?;
                let most = machine.analysis.modes;
                if family > most {
                    let allowed =
                        format!("a family from 1 to {most}, the elastic modes that the machine file asks for");
                    let advice = "correct it, or raise `modes` in the machine file's [analysis]";
                    return Err(item.refuse(allowed, advice).into());
                }
                let at = families.iter().position(|(f, _)| *f == family).unwrap_or_else(|| {
                    families.push((family, families.len()));
                    families.len() - 1
                });
                add(family.to_string(), Quantity::Eigenfrequency(at));
            }
        } else {
            let list = table.need("directions", "directions = [\"x\", \"y\", \"z\"]")?.list()?;
            for item in list {
                let names: Vec<&str> = known.iter().map(String::as_str).collect();
                let pair = find_name(&item, "direction", item.text()?, &names)?;
                let quantity = match kind {
                    0 => Quantity::DynamicStiffness(pair),
                    1 => Quantity::Compliance(pair),
                    2 => Quantity::NegativeReal(pair),
                    _ => Quantity::StaticStiffness(pair),
                };
                add(known[pair].replace(' ', "_"), quantity);
            }
        }
        table.finish()?;
        if metrics.len() == before {
            return Err(item.refuse("at least one direction or family", "name one").into());
        }
        if let Some(name) = twice(&metrics) {
            return Err(crate::machine::MachineError::Duplicate { place: item.place(), kind: "metric", name }.into());
        }
    }
    Ok((metrics, families.into_iter().map(|(family, _)| family).collect()))
}

/// A name that two metrics have.
fn twice(metrics: &[Metric]) -> Option<String> {
    let before = |(i, metric): &(usize, &Metric)| metrics[..*i].iter().any(|other| other.name == metric.name);
    metrics.iter().enumerate().find(before).map(|(_, metric)| metric.name.clone())
}

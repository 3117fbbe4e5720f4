//! The `[variables]` of a study file.

use super::paths::{Entry, Target, catalogue, find, suggest};
use super::study_error::StudyError;
use super::variables::{Domain, SUPPORTS, Variable};
use crate::machine::table::{Bound, Item, Table};
use crate::machine::{Dimension, Machine, MachineError};

type Result<T> = std::result::Result<T, StudyError>;

/// Reads `[variables]`.
pub(super) fn read_variables(root: &Table<'_>, machine: &Machine) -> Result<Vec<Variable>> {
    let item = root.need("variables", "a [variables.NAME] section with path and range")?;
    let entries = item.table()?.entries()?;
    if entries.is_empty() {
        return Err(item.refuse_seen("no variable", "at least one variable", "add a [variables.NAME] section").into());
    }
    let known = catalogue(machine);
    let mut variables: Vec<Variable> = Vec::new();
    for (name, item) in &entries {
        variables.push(read_variable(name, item, &known, &variables)?);
    }
    Ok(variables)
}

fn read_variable(name: &str, item: &Item<'_>, known: &[Entry], before: &[Variable]) -> Result<Variable> {
    let table = item.table()?;
    let given = match (table.get("path"), table.get("paths")) {
        (Some(_), Some(paths)) => return Err(paths.refuse("either `path` or `paths`", "remove one of them").into()),
        (None, Some(paths)) => paths.list()?,
        (path, None) => {
            let path = path.map_or_else(|| table.need("path", "path = \"joints.NAME.stiffness.x\""), Ok)?;
            vec![path]
        }
    };
    if given.is_empty() {
        return Err(item.refuse_seen("no path", "at least one path", "name what the variable changes").into());
    }
    let mut entries: Vec<&Entry> = Vec::new();
    for path in &given {
        for entry in entries_of(path, known)? {
            let taken = |targets: &[Target]| targets.iter().any(|t| entry.targets.contains(t));
            let other = before.iter().find(|v| taken(&v.targets)).map(|v| v.name.as_str());
            let own = entries.iter().any(|e| taken(&e.targets)).then_some(name);
            if let Some(by) = other.or(own) {
                let (seen, by) = (entry.path.clone(), by.to_owned());
                return Err(StudyError::VariedTwice { place: path.place(), path: seen, by });
            }
            if let Some(first) = entries.first()
                && first.dimension != entry.dimension
            {
                let seen = format!("{} beside {}", entry.path, first.path);
                return Err(path.refuse_seen(seen, "paths whose values measure the same", "make two variables").into());
            }
            entries.push(entry);
        }
    }
    let factor = table.get("factor").map(|item| item.boolean()).transpose()?.unwrap_or(false);
    let reading = Reading { factor, entries: &entries };
    reading.check_nominal(&given[0])?;
    let domain = reading.domain(item, &table)?;
    let span = reading.span(&table, &domain)?;
    table.finish()?;
    let nominals: Vec<Option<f64>> = entries.iter().map(|e| e.nominal).collect();
    let same = nominals.iter().all(|n| *n == nominals[0]);
    Ok(Variable {
        name: name.to_owned(),
        paths: entries.iter().map(|e| e.path.clone()).collect(),
        targets: entries.iter().flat_map(|e| e.targets.iter().copied()).collect(),
        factor,
        dimension: if factor { Some(Dimension::Ratio) } else { entries[0].dimension },
        nominal: if factor { Some(1.0) } else { nominals[0].filter(|_| same) },
        domain,
        span,
    })
}

fn entries_of<'a>(item: &Item<'_>, known: &'a [Entry]) -> Result<Vec<&'a Entry>> {
    let path = item.text()?;
    let found = find(known, path);
    if found.is_empty() {
        let (nearest, existing) = suggest(known, path);
        return Err(StudyError::UnknownPath { place: item.place(), path: path.to_owned(), nearest, existing });
    }
    Ok(found)
}

/// What the values of a variable may be.
struct Reading<'a> {
    factor: bool,
    entries: &'a [&'a Entry],
}

impl Reading<'_> {
    /// Factors multiply, and a part's material is scaled: both need the machine's own value.
    fn check_nominal(&self, path: &Item<'_>) -> Result<()> {
        for entry in self.entries {
            let of_part = matches!(entry.targets[0], Target::PartYoung(_) | Target::PartDensity(_));
            let refused = if entry.dimension.is_none() && self.factor {
                Some(("a path whose values are numbers", "remove factor = true"))
            } else if of_part && !self.factor && entry.nominal.is_none() {
                Some((
                    "an absolute value only where the machine file gives the part's `material`",
                    "write factor = true, or give the part a material in the machine file",
                ))
            } else if self.factor
                && !of_part
                && entry.targets != [Target::Ratio]
                && entry.nominal.is_none_or(|v| v == 0.0)
            {
                Some((
                    "a factor only on a value that the machine file gives and that is not zero",
                    "remove factor = true and give absolute values",
                ))
            } else {
                None
            };
            if let Some((allowed, advice)) = refused {
                return Err(path.refuse_seen(format!("{:?}", entry.path), allowed, advice).into());
            }
        }
        Ok(())
    }

    fn domain(&self, item: &Item<'_>, table: &Table<'_>) -> Result<Domain> {
        let (range, values) = (table.get("range"), table.get("values"));
        let scale = table.get("scale");
        let points = table.get("points");
        if let Some(values) = &values {
            for (other, what) in [(&range, "range"), (&scale, "scale"), (&points, "points")] {
                if let Some(other) = other {
                    return Err(other.refuse(format!("no `{what}` beside `values`"), "remove one of them").into());
                }
            }
            return self.list(values);
        }
        let Some(range) = range else {
            table.need("range", "range = [\"50 N/um\", \"150 N/um\"], or values = [ ... ]")?;
            return Err(item.refuse("a `range` or `values`", "add one of them").into());
        };
        if self.entries[0].dimension.is_none() {
            return Err(range.refuse("values = [\"one-end\", \"both-ends\"]", "list the supports").into());
        }
        let [low, high] = range.array()?;
        let (from, to) = (self.value(&low)?, self.value(&high)?);
        if from > to {
            return Err(low.refuse(format!("at most the second value, {}", high.seen()), "exchange the two").into());
        }
        if from == to {
            return Err(range
                .refuse("two different values", "take the variable out of the study, or write values = [ ... ]")
                .into());
        }
        let logarithmic = match &scale {
            None => false,
            Some(item) => match item.text()? {
                "linear" => false,
                "log" => true,
                _ => return Err(item.refuse("\"linear\" or \"log\"", "write one of them").into()),
            },
        };
        if logarithmic && from <= 0.0 {
            return Err(low
                .refuse("a value above zero, where the scale is \"log\"", "raise it or write scale = \"linear\"")
                .into());
        }
        let points = match points {
            Some(item) => match item.count()? {
                1 => return Err(item.refuse("at least 2 points, the two ends", "raise it").into()),
                n => Some(n),
            },
            None => None,
        };
        Ok(Domain::Range { from, to, logarithmic, points })
    }

    fn list(&self, item: &Item<'_>) -> Result<Domain> {
        let mut values: Vec<f64> = Vec::new();
        for entry in item.list()? {
            let value = self.value(&entry)?;
            if values.contains(&value) {
                let (place, name) = (entry.place(), entry.seen());
                return Err(MachineError::Duplicate { place, kind: "value", name }.into());
            }
            values.push(value);
        }
        if values.is_empty() {
            return Err(item.refuse("at least one value", "list the values").into());
        }
        Ok(Domain::Values(values))
    }

    /// One value in SI units, within what its places may take.
    fn value(&self, item: &Item<'_>) -> Result<f64> {
        let entry = self.entries[0];
        let Some(dimension) = entry.dimension else {
            let name = item.text()?;
            let at = SUPPORTS.iter().position(|support| *support == name);
            return at
                .map(|i| i as f64)
                .ok_or_else(|| item.refuse("\"one-end\" or \"both-ends\"", "write one of them").into());
        };
        let may_vanish =
            matches!(entry.targets[0], Target::Damper(..) | Target::JointLoss(_) | Target::Ratio | Target::LossFactor);
        let bound = if may_vanish { Bound::NotNegative } else { Bound::Positive };
        let value = item.quantity(if self.factor { Dimension::Ratio } else { dimension }, bound)?;
        let own = if self.factor { entry.nominal.unwrap_or(1.0) * value } else { value };
        // A part whose material its mesh file gives has no value here that a factor could be judged by.
        let known = !self.factor || entry.nominal.is_some();
        if let Some(allowed) = dimension.refused_range(own, matches!(bound, Bound::Positive)).filter(|_| known) {
            let seen = format!("{}, which makes {own:e} {}", item.seen(), dimension.units()[0]);
            return Err(item.refuse_seen(seen, allowed, "correct the value or its unit").into());
        }
        let allowed = match entry.targets[0] {
            Target::Ratio if own >= 1.0 => "a damping ratio from 0 to less than 1",
            Target::JointLoss(_) | Target::LossFactor if own > 2.0 => "a loss factor from 0 to 2",
            _ => return Ok(value),
        };
        Err(item.refuse(allowed, "write 0.02 or \"2 %\" for two per cent").into())
    }

    /// The `span` of a second support that the machine does not have.
    fn span(&self, table: &Table<'_>, domain: &Domain) -> Result<Option<f64>> {
        let held_at_one = self.entries[0].dimension.is_none() && self.entries.iter().any(|e| e.nominal == Some(0.0));
        let wanted = matches!(domain, Domain::Values(values) if held_at_one && values.contains(&1.0));
        if wanted {
            let item = table.need("span", "span = \"1300 mm\", the distance between the two supports")?;
            return Ok(Some(item.quantity(Dimension::Length, Bound::Positive)?));
        }
        match table.get("span") {
            Some(item) => {
                let allowed = "a span only where a screw that the machine holds at one end may be held at both";
                Err(item.refuse(allowed, "remove it").into())
            }
            None => Ok(None),
        }
    }
}

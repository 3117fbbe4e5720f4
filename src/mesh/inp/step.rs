//! Displacements held, and the frequency step of a deck.

use super::keywords::{pass_over, say_passed_over};
use super::lines::{Keyword, Lines, bad_value, fields, number};
use super::parameters::{Neutral, check_parameters};
use super::raw::{FrequencyStep, Raw, RawBoundary};
use super::surfaces::target;
use crate::mesh::{MeshError, Warning};

type Result<T> = std::result::Result<T, MeshError>;

/// Abaqus's named boundary types with the displacements they hold; rotations mean nothing to solids.
const NAMED: [(&str, [bool; 3]); 8] = [
    ("ENCASTRE", [true; 3]),
    ("PINNED", [true; 3]),
    ("XSYMM", [true, false, false]),
    ("YSYMM", [false, true, false]),
    ("ZSYMM", [false, false, true]),
    ("XASYMM", [false, true, true]),
    ("YASYMM", [true, false, true]),
    ("ZASYMM", [true, true, false]),
];

/// Whether `*BOUNDARY` stands before the steps, or which in the first step it is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Place {
    Model,
    /// In the step: held displacements that were there before it.
    Step(usize),
}

/// Reads `*BOUNDARY`: node or node set, first and last direction, and no value but zero. OP=NEW in a step lets go
/// what was held before the step; an amplitude scales values, which are zero.
pub fn read_boundary(keyword: &Keyword<'_>, place: Place, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const ALLOWED: &str = "OP=MOD or, in a step, OP=NEW, TYPE=DISPLACEMENT, AMPLITUDE";
    const NEUTRAL: [Neutral; 6] = [
        ("OP", &["MOD", "NEW"]),
        ("TYPE", &["DISPLACEMENT"]),
        ("AMPLITUDE", &[]),
        ("TIMEDELAY", &[]),
        ("FIXED", &[]),
        ("LOADCASE", &["1"]),
    ];
    check_parameters(keyword, "BOUNDARY", &[], &NEUTRAL, ALLOWED, lines)?;
    if keyword.get("OP").is_some_and(|op| op.eq_ignore_ascii_case("NEW")) {
        match place {
            Place::Model if !raw.boundaries.is_empty() => {
                return Err(MeshError::Parameter {
                    spot: lines.spot(keyword.line),
                    keyword: "BOUNDARY",
                    seen: "OP=NEW before the steps, after other held displacements".into(),
                    allowed: ALLOWED,
                    advice: "write all that is held before the steps, without OP",
                });
            }
            Place::Step(before) if before > 0 && !raw.let_go => {
                raw.boundaries.drain(..before);
                raw.let_go = true;
                let text = "OP=NEW lets go what *BOUNDARY held before the step".to_owned();
                raw.warnings.push(Warning { line: keyword.line, text });
            }
            _ => {}
        }
    }
    while let Some((line, data)) = lines.next_data() {
        const FORM: &str = "a node or node set, the first and the last of the directions 1 to 3, and no value but 0";
        let refuse = || bad_value(lines.spot(line), "BOUNDARY", data, FORM);
        let values: Vec<&str> = fields(data).collect();
        let (Some(of), Some(first)) = (values.first().and_then(|v| target(v)), values.get(1)) else {
            return refuse();
        };
        let named = NAMED.iter().find(|(name, _)| name.eq_ignore_ascii_case(first)).map(|(_, held)| *held);
        let directions = match named {
            Some(held) if values.len() == 2 => held,
            Some(_) => return refuse(),
            None => {
                let direction = |field: &str| field.parse::<usize>().ok().filter(|d| (1..=6).contains(d));
                let last = values.get(2).filter(|v| !v.is_empty()).unwrap_or(first);
                let (Some(first), Some(last)) = (direction(first), direction(last)) else { return refuse() };
                let zero = values.get(3).is_none_or(|v| v.is_empty() || number(v) == Some(0.0));
                if first > last || !zero || values.len() > 4 {
                    return refuse();
                }
                std::array::from_fn(|c| (first..=last).contains(&(c + 1)))
            }
        };
        raw.boundaries.push(RawBoundary { of, directions, line });
    }
    Ok(())
}

/// Reads the first step of a deck, which must compute frequencies of the model at rest.
pub fn read_step(step: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const ALLOWED: &str = "INC, NAME, PERTURBATION, NLGEOM=NO, AMPLITUDE";
    // How a load grows and how many increments a step may take mean nothing to frequencies.
    const NEUTRAL: [Neutral; 9] = [
        ("INC", &[]),
        ("INCF", &[]),
        ("NAME", &[]),
        ("PERTURBATION", &[]),
        ("NLGEOM", &["NO", "OFF"]),
        ("UNSYMM", &["NO", "OFF"]),
        ("AMPLITUDE", &[]),
        ("EXTRAPOLATION", &[]),
        ("CONVERTSDI", &[]),
    ];
    check_parameters(step, "STEP", &[], &NEUTRAL, ALLOWED, lines)?;
    lines.skip_data();
    let before = raw.boundaries.len();
    let mut frequency = None;
    loop {
        let Some(keyword) = lines.next_keyword() else {
            let detail = format!("no *END STEP for the *STEP of line {}", step.line);
            return Err(MeshError::Truncated { spot: lines.spot(lines.number()), what: "the file", detail });
        };
        match keyword.name.as_str() {
            "ENDSTEP" => break,
            "FREQUENCY" if frequency.is_none() => frequency = Some(read_frequency(&keyword, lines)?),
            "BOUNDARY" => read_boundary(&keyword, Place::Step(before), lines, raw)?,
            name if PROCEDURES.contains(&name) => {
                return Err(MeshError::Deck {
                    spot: lines.spot(keyword.line),
                    reason: format!(
                        "the first step is *{}; allowed: a first step of *FREQUENCY, as the modes are those of the model at rest; remove the steps before it if they do not matter",
                        keyword.spelling
                    ),
                });
            }
            // CalculiX adds the stress of a step's own loads to the stiffness if the step is a perturbation, else not.
            "CLOAD" | "DLOAD" if step.get("PERTURBATION").is_none() => say_passed_over(&keyword, "modes", lines, raw),
            _ => pass_over(&keyword, "modes", lines, raw)?,
        }
    }
    raw.frequency = Some(frequency.ok_or_else(|| MeshError::Deck {
        spot: lines.spot(step.line),
        reason: "the first step has no *FREQUENCY; allowed: a first step of *FREQUENCY; add it".into(),
    })?);
    Ok(())
}

/// Steps that compute something else.
const PROCEDURES: &[&str] = &[
    "BUCKLE",
    "COMPLEXFREQUENCY",
    "COUPLEDTEMPERATURE-DISPLACEMENT",
    "DYNAMIC",
    "GREEN",
    "HEATTRANSFER",
    "MODALDYNAMIC",
    "SENSITIVITY",
    "STATIC",
    "STEADYSTATEDYNAMICS",
    "UNCOUPLEDTEMPERATURE-DISPLACEMENT",
    "VISCO",
];

fn read_frequency(keyword: &Keyword<'_>, lines: &mut Lines<'_>) -> Result<FrequencyStep> {
    const ALLOWED: &str = "SOLVER, STORAGE, EIGENSOLVER, NORMALIZATION, SIM, ACOUSTIC COUPLING, DAMPING PROJECTION";
    // How the modes are computed, scaled and stored. Acoustic elements, whose coupling would count, are refused.
    const NEUTRAL: [Neutral; 10] = [
        ("SOLVER", &[]),
        ("STORAGE", &[]),
        ("GLOBAL", &[]),
        ("EIGENSOLVER", &["LANCZOS", "SUBSPACE", "AMS"]),
        ("NORMALIZATION", &["MASS", "DISPLACEMENT"]),
        ("SIM", &["", "NO", "YES"]),
        ("ACOUSTICCOUPLING", &["ON", "OFF", "PROJECTION"]),
        ("DAMPINGPROJECTION", &["ON", "OFF"]),
        ("RESIDUALMODES", &["NO", "OFF"]),
        ("NSET", &[]),
    ];
    check_parameters(keyword, "FREQUENCY", &[], &NEUTRAL, ALLOWED, lines)?;
    const FORM: &str = "a number of modes (1 to 100000), and the lowest and highest frequency or nothing";
    let Some((line, data)) = lines.next_data() else {
        return bad_value(lines.spot(keyword.line), "FREQUENCY", "", FORM);
    };
    let values: Vec<&str> = fields(data).collect();
    let modes = values.first().and_then(|v| v.parse::<usize>().ok()).filter(|n| (1..=100_000).contains(n));
    let bound = |k: usize, otherwise: f64| match values.get(k) {
        Some(v) if !v.is_empty() => number(v),
        _ => Some(otherwise),
    };
    match (modes, bound(1, f64::NEG_INFINITY), bound(2, f64::INFINITY)) {
        (Some(modes), Some(from), Some(to)) if from < to && lines.next_data().is_none() => {
            Ok(FrequencyStep { modes, from, to })
        }
        _ => bad_value(lines.spot(line), "FREQUENCY", data, FORM),
    }
}

//! First pass: what each keyword opens.

use super::keywords::pass_over;
use super::lines::{Keyword, Lines, shortened};
use super::properties::{read_density, read_elastic, read_material, read_solid_section};
use super::raw::Raw;
use super::source::Source;
use super::step::{read_boundary, read_step};
use super::surfaces::read_surface;
use super::topology::{read_elements, read_nodes, read_set};
use crate::mesh::{MeshError, Warning};

type Result<T> = std::result::Result<T, MeshError>;

/// What a file is read for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// A part of a machine: steps do not matter.
    Part,
    /// Its own frequency step.
    Deck,
}

/// Everything that stands in a file.
pub fn collect(source: &Source, purpose: Purpose, plain_bricks: bool) -> Result<Raw> {
    let mut lines = Lines::new(source);
    let mut raw = Raw::default();
    loop {
        if let Some((line, data)) = lines.next_data() {
            return Err(MeshError::StrayData { spot: lines.spot(line), seen: shortened(data) });
        }
        let Some(keyword) = lines.next_keyword() else {
            break;
        };
        match keyword.name.as_str() {
            "HEADING" => lines.skip_data(),
            "NODE" => read_nodes(&keyword, &mut lines, &mut raw)?,
            "ELEMENT" => read_elements(&keyword, plain_bricks, &mut lines, &mut raw)?,
            "NSET" => read_set(&keyword, "NSET", &mut lines, &mut raw.node_sets)?,
            "ELSET" => read_set(&keyword, "ELSET", &mut lines, &mut raw.element_sets)?,
            "MATERIAL" => read_material(&keyword, &lines, &mut raw)?,
            "ELASTIC" => read_elastic(&keyword, &mut lines, &mut raw)?,
            "DENSITY" => read_density(&keyword, &mut lines, &mut raw)?,
            "SOLIDSECTION" => read_solid_section(&keyword, &mut lines, &mut raw)?,
            "SURFACE" => read_surface(&keyword, &mut lines, &mut raw)?,
            "BOUNDARY" => read_boundary(&keyword, &mut lines, &mut raw)?,
            "STEP" if purpose == Purpose::Deck && raw.frequency.is_none() => read_step(&keyword, &mut lines, &mut raw)?,
            "STEP" => skip_step(&keyword, purpose, &mut lines, &mut raw)?,
            _ => pass_over(&keyword, "mesh", &mut lines, &mut raw)?,
        }
    }
    if source.ends_without_line_end() {
        let text = "the file does not end in a line end; it may be cut off".to_owned();
        raw.warnings.push(Warning { line: lines.number(), text });
    }
    Ok(raw)
}

/// Refuses parameters other than `known`.
pub fn check_parameters(
    keyword: &Keyword<'_>,
    name: &'static str,
    known: &[&str],
    allowed: &'static str,
    lines: &Lines<'_>,
) -> Result<()> {
    let Some((parameter, _)) = keyword.parameters.iter().find(|(p, _)| !known.contains(&p.as_str())) else {
        return Ok(());
    };
    Err(MeshError::Parameter {
        spot: lines.spot(keyword.line),
        keyword: name,
        seen: format!("the parameter {parameter} is not supported"),
        allowed,
        advice: "remove it if it does not matter",
    })
}

/// The value of a parameter that must be there.
pub fn need<'a>(
    keyword: &Keyword<'a>,
    name: &'static str,
    parameter: &str,
    allowed: &'static str,
    lines: &Lines<'_>,
) -> Result<&'a str> {
    keyword.get(parameter).filter(|value| !value.is_empty()).ok_or_else(|| MeshError::Parameter {
        spot: lines.spot(keyword.line),
        keyword: name,
        seen: format!("the parameter {parameter} is missing"),
        allowed,
        advice: "add it",
    })
}

/// Passes over everything up to `*END STEP`.
fn skip_step(step: &Keyword<'_>, purpose: Purpose, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    let text = match purpose {
        Purpose::Part => "*STEP to *END STEP is passed over; the machine file says what is clamped and computed",
        Purpose::Deck => "this later step is passed over; the modes are those of the first",
    };
    raw.warnings.push(Warning { line: step.line, text: text.to_owned() });
    loop {
        lines.skip_data();
        match lines.next_keyword() {
            Some(keyword) if keyword.name == "ENDSTEP" => return Ok(()),
            Some(_) => {}
            None => {
                let detail = format!("no *END STEP for the *STEP of line {}", step.line);
                return Err(MeshError::Truncated { spot: lines.spot(lines.number()), what: "the file", detail });
            }
        }
    }
}

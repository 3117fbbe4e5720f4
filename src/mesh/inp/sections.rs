//! First pass: what each keyword opens.

use super::Reading;
use super::keywords::{PROPERTIES, pass_over, say_passed_over};
use super::lines::{Keyword, Lines, shortened, unquoted};
use super::properties::{read_density, read_elastic, read_material, read_solid_section, read_surface_section};
use super::raw::Raw;
use super::source::Source;
use super::step::{Place, read_boundary, read_step};
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
pub fn collect(source: &Source, purpose: Purpose, how: Reading) -> Result<Raw> {
    let mut lines = Lines::new(source);
    let mut raw = Raw::default();
    loop {
        if let Some((line, data)) = lines.next_data() {
            if data.starts_with("$MeshFormat") {
                return Err(MeshError::OtherFormat { spot: lines.spot(line), seen: "a Gmsh mesh", extension: "msh" });
            }
            return Err(MeshError::StrayData { spot: lines.spot(line), seen: shortened(data) });
        }
        let Some(keyword) = lines.next_keyword() else {
            break;
        };
        match keyword.name.as_str() {
            "HEADING" => lines.skip_data(),
            "NODE" => read_nodes(&keyword, &mut lines, &mut raw)?,
            "ELEMENT" => read_elements(&keyword, how.plain_bricks, &mut lines, &mut raw)?,
            "NSET" => read_set(&keyword, "NSET", &mut lines, &mut raw.node_sets)?,
            "ELSET" => read_set(&keyword, "ELSET", &mut lines, &mut raw.element_sets)?,
            "MATERIAL" => read_material(&keyword, &lines, &mut raw)?,
            name if how.other_material && PROPERTIES.contains(&name) => lines.skip_data(),
            "ELASTIC" => read_elastic(&keyword, &mut lines, &mut raw)?,
            "DENSITY" => read_density(&keyword, &mut lines, &mut raw)?,
            "SOLIDSECTION" => read_solid_section(&keyword, &mut lines, &mut raw)?,
            "SURFACESECTION" => read_surface_section(&keyword, &mut lines)?,
            "SURFACE" => read_surface(&keyword, &mut lines, &mut raw)?,
            "BOUNDARY" => read_boundary(&keyword, Place::Model, &mut lines, &mut raw)?,
            "STEP" if purpose == Purpose::Deck && raw.frequency.is_none() => read_step(&keyword, &mut lines, &mut raw)?,
            "STEP" => skip_step(&keyword, purpose, &mut lines, &mut raw)?,
            "INITIALCONDITIONS" if is_temperature(&keyword) => say_passed_over(&keyword, "mesh", &mut lines, &mut raw),
            // The modes of a deck are those without damping, as CalculiX and Abaqus compute them.
            "DAMPING" if purpose == Purpose::Deck => say_passed_over(&keyword, "modes", &mut lines, &mut raw),
            _ => pass_over(&keyword, "mesh", &mut lines, &mut raw)?,
        }
    }
    if how.other_material && !raw.materials.is_empty() {
        let text =
            "the materials of the file are passed over; the machine file or the matrices say what the part is made of";
        raw.warnings.push(Warning { line: 0, text: text.to_owned() });
    }
    if source.ends_without_line_end() {
        let text = "the file does not end in a line end; it may be cut off".to_owned();
        raw.warnings.push(Warning { line: lines.number(), text });
    }
    Ok(raw)
}

/// Whether `*INITIAL CONDITIONS` gives temperatures, on which no material that is read depends.
fn is_temperature(keyword: &Keyword<'_>) -> bool {
    keyword.get("TYPE").is_some_and(|kind| kind.eq_ignore_ascii_case("TEMPERATURE"))
}

/// The value of a parameter that must be there.
pub fn need<'a>(
    keyword: &Keyword<'a>,
    name: &'static str,
    parameter: &str,
    allowed: &'static str,
    lines: &Lines<'_>,
) -> Result<&'a str> {
    need_name(keyword, name, parameter, allowed, lines).map(unquoted)
}

/// The name that a parameter must give, with its quotes.
pub fn need_name<'a>(
    keyword: &Keyword<'a>,
    name: &'static str,
    parameter: &str,
    allowed: &'static str,
    lines: &Lines<'_>,
) -> Result<&'a str> {
    keyword.name(parameter).filter(|value| !unquoted(value).trim().is_empty()).ok_or_else(|| MeshError::Parameter {
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

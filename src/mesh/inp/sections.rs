//! First pass: the sections of the file, one function a keyword.

use super::keywords::{advice, is_harmless};
use super::lines::{Keyword, Lines, bad_value, canonical, fields, label, number};
use super::raw::{Members, Raw, RawCell, RawMaterial, RawNode, RawSection, RawSet};
use crate::mesh::{CellKind, MeshError, Warning};
use std::path::Path;

type Result<T> = std::result::Result<T, MeshError>;

/// Everything that stands in a file.
pub fn collect(text: &str, file: &Path) -> Result<Raw> {
    let mut lines = Lines::new(text, file);
    let mut raw = Raw::default();
    loop {
        if let Some((line, data)) = lines.next_data() {
            return bad_value(lines.spot(line), "", data, "a keyword, which begins with *");
        }
        let Some(keyword) = lines.next_keyword() else {
            break;
        };
        match keyword.name.as_str() {
            "HEADING" => lines.skip_data(),
            "NODE" => read_nodes(&keyword, &mut lines, &mut raw)?,
            "ELEMENT" => read_elements(&keyword, &mut lines, &mut raw)?,
            "NSET" => read_set(&keyword, "NSET", &mut lines, &mut raw.node_sets)?,
            "ELSET" => read_set(&keyword, "ELSET", &mut lines, &mut raw.element_sets)?,
            "MATERIAL" => read_material(&keyword, &lines, &mut raw)?,
            "ELASTIC" => read_elastic(&keyword, &mut lines, &mut raw)?,
            "DENSITY" => read_density(&keyword, &mut lines, &mut raw)?,
            "SOLIDSECTION" => read_solid_section(&keyword, &mut lines, &mut raw)?,
            "STEP" => skip_step(&keyword, &mut lines, &mut raw)?,
            name if is_harmless(name) => {
                let text = format!(
                    "*{} is passed over; it does not change the mesh",
                    keyword.spelling
                );
                raw.warnings.push(Warning {
                    line: keyword.line,
                    text,
                });
                lines.skip_data();
            }
            name => {
                return Err(MeshError::Keyword {
                    spot: lines.spot(keyword.line),
                    keyword: keyword.spelling.to_owned(),
                    advice: advice(name),
                });
            }
        }
    }
    if !text.is_empty() && !text.ends_with('\n') {
        let text = "the file does not end in a line end; it may be cut off".to_owned();
        raw.warnings.push(Warning {
            line: lines.number(),
            text,
        });
    }
    Ok(raw)
}

/// Refuses parameters other than `known`.
fn check_parameters(
    keyword: &Keyword<'_>,
    name: &'static str,
    known: &[&str],
    allowed: &'static str,
    lines: &Lines<'_>,
) -> Result<()> {
    let Some((parameter, _)) = keyword
        .parameters
        .iter()
        .find(|(p, _)| !known.contains(&p.as_str()))
    else {
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
fn need<'a>(
    keyword: &Keyword<'a>,
    name: &'static str,
    parameter: &str,
    allowed: &'static str,
    lines: &Lines<'_>,
) -> Result<&'a str> {
    keyword
        .get(parameter)
        .filter(|value| !value.is_empty())
        .ok_or_else(|| MeshError::Parameter {
            spot: lines.spot(keyword.line),
            keyword: name,
            seen: format!("the parameter {parameter} is missing"),
            allowed,
            advice: "add it",
        })
}

fn read_nodes(keyword: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    check_parameters(keyword, "NODE", &["NSET"], "NSET", lines)?;
    let first = raw.nodes.len();
    while let Some((line, data)) = lines.next_data() {
        let mut values = fields(data);
        let label = values.next().and_then(label);
        let mut next = || values.next().and_then(number);
        let node = (label, next(), next(), next());
        let (Some(label), Some(x), Some(y), Some(z)) = node else {
            return bad_value(
                lines.spot(line),
                "NODE",
                data,
                "a label and three finite coordinates",
            );
        };
        if values.next().is_some() {
            return bad_value(
                lines.spot(line),
                "NODE",
                data,
                "a label and three coordinates, no more",
            );
        }
        raw.nodes.push(RawNode {
            label,
            at: [x, y, z],
            line: line as u32,
        });
    }
    add_section_set(keyword, "NSET", first, raw.nodes.len(), &mut raw.node_sets);
    Ok(())
}

fn read_elements(keyword: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const ALLOWED: &str = "TYPE=C3D10, ELSET";
    check_parameters(keyword, "ELEMENT", &["TYPE", "ELSET"], ALLOWED, lines)?;
    let kind = match need(keyword, "ELEMENT", "TYPE", ALLOWED, lines)? {
        name if name.eq_ignore_ascii_case("C3D10") => CellKind::Tet10,
        name => {
            return Err(MeshError::Parameter {
                spot: lines.spot(keyword.line),
                keyword: "ELEMENT",
                seen: format!("the element type {name:?} is not supported"),
                allowed: "TYPE=C3D10, the ten-node tetrahedron",
                advice: "mesh with it, and export volume elements alone",
            });
        }
    };
    let first = raw.cells.len();
    while let Some((line, data)) = lines.next_data() {
        read_element(kind, line, data, lines, raw)?;
    }
    add_section_set(
        keyword,
        "ELSET",
        first,
        raw.cells.len(),
        &mut raw.element_sets,
    );
    Ok(())
}

/// One element, which may take several lines.
fn read_element(
    kind: CellKind,
    first_line: usize,
    first_data: &str,
    lines: &mut Lines<'_>,
    raw: &mut Raw,
) -> Result<()> {
    let mut cell = None;
    let mut missing = kind.node_count();
    let (mut line, mut data) = (first_line, first_data);
    loop {
        for field in fields(data) {
            let Some(value) = label(field) else {
                return bad_value(
                    lines.spot(line),
                    "ELEMENT",
                    field,
                    "labels, whole numbers from 1 on",
                );
            };
            if cell.is_none() {
                cell = Some(value);
            } else if missing > 0 {
                raw.cell_nodes.push(value);
                missing -= 1;
            } else {
                let allowed = format!(
                    "an element label and {} node labels, no more",
                    kind.node_count()
                );
                return bad_value(lines.spot(line), "ELEMENT", data, allowed);
            }
        }
        if missing == 0 {
            break;
        }
        (line, data) = lines.next_data().ok_or_else(|| MeshError::Truncated {
            spot: lines.spot(line),
            what: "*ELEMENT",
            detail: format!(
                "its last element lacks {missing} of {} nodes",
                kind.node_count()
            ),
        })?;
    }
    let nodes = &raw.cell_nodes[raw.cell_nodes.len() - kind.node_count()..];
    if let Some(node) = nodes
        .iter()
        .enumerate()
        .find_map(|(i, node)| nodes[..i].contains(node).then_some(node))
    {
        let allowed = format!(
            "{} different nodes, not node {node} twice",
            kind.node_count()
        );
        return bad_value(lines.spot(line), "ELEMENT", first_data, allowed);
    }
    if let Some(label) = cell {
        raw.cells.push(RawCell {
            kind,
            label,
            line: first_line as u32,
        });
    }
    Ok(())
}

/// Adds the nodes or elements of a section to the set that its keyword names.
fn add_section_set(
    keyword: &Keyword<'_>,
    parameter: &str,
    first: usize,
    end: usize,
    sets: &mut Vec<RawSet>,
) {
    if let Some(name) = keyword.get(parameter).filter(|name| !name.is_empty()) {
        let members = Members::Section {
            first,
            end,
            line: keyword.line,
        };
        sets.push(RawSet {
            name: name.to_owned(),
            members,
        });
    }
}

fn read_set(
    keyword: &Keyword<'_>,
    kind: &'static str,
    lines: &mut Lines<'_>,
    sets: &mut Vec<RawSet>,
) -> Result<()> {
    let allowed = if kind == "NSET" {
        "NSET, GENERATE"
    } else {
        "ELSET, GENERATE"
    };
    check_parameters(
        keyword,
        kind,
        &[kind, "GENERATE", "INTERNAL", "UNSORTED"],
        allowed,
        lines,
    )?;
    let name = need(keyword, kind, kind, allowed, lines)?;
    let mut push = |members| {
        sets.push(RawSet {
            name: name.to_owned(),
            members,
        })
    };
    let mut labels = Vec::new();
    while let Some((line, data)) = lines.next_data() {
        if keyword.get("GENERATE").is_some() {
            push(read_range(kind, line, data, lines)?);
            continue;
        }
        for field in fields(data) {
            match label(field) {
                Some(label) => labels.push((label, line as u32)),
                None if field.starts_with(|c: char| c.is_alphabetic() || c == '_') => {
                    push(Members::Set {
                        name: field.to_owned(),
                        line,
                    });
                }
                None => {
                    return bad_value(
                        lines.spot(line),
                        kind,
                        field,
                        "labels from 1 on, or names of sets",
                    );
                }
            }
        }
    }
    push(Members::Labels(labels));
    Ok(())
}

/// A data line of GENERATE: first, last and, unless it is 1, the step.
fn read_range(kind: &'static str, line: usize, data: &str, lines: &Lines<'_>) -> Result<Members> {
    let values: Option<Vec<u64>> = fields(data).take(4).map(label).collect();
    match values.as_deref() {
        Some(&[first, last]) if first <= last => Ok(Members::Range {
            first,
            last,
            step: 1,
            line,
        }),
        Some(&[first, last, step]) if first <= last => Ok(Members::Range {
            first,
            last,
            step,
            line,
        }),
        _ => bad_value(
            lines.spot(line),
            kind,
            data,
            "GENERATE: first label, last label (not smaller), step (at least 1)",
        ),
    }
}

fn read_material(keyword: &Keyword<'_>, lines: &Lines<'_>, raw: &mut Raw) -> Result<()> {
    check_parameters(keyword, "MATERIAL", &["NAME"], "NAME", lines)?;
    let name = need(keyword, "MATERIAL", "NAME", "NAME", lines)?;
    if raw
        .materials
        .iter()
        .any(|other| other.name.eq_ignore_ascii_case(name))
    {
        let spot = lines.spot(keyword.line);
        return Err(MeshError::Duplicate {
            spot,
            kind: "material",
            label: name.to_owned(),
        });
    }
    raw.materials.push(RawMaterial {
        name: name.to_owned(),
        elastic: None,
        density: None,
    });
    Ok(())
}

fn read_elastic(keyword: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const ALLOWED: &str = "TYPE=ISO (or none)";
    check_parameters(keyword, "ELASTIC", &["TYPE"], ALLOWED, lines)?;
    if let Some(kind) = keyword
        .get("TYPE")
        .filter(|kind| !["ISO", "ISOTROPIC"].contains(&canonical(kind).as_str()))
    {
        return Err(MeshError::Parameter {
            spot: lines.spot(keyword.line),
            keyword: "ELASTIC",
            seen: format!("TYPE={kind} is not supported"),
            allowed: ALLOWED,
            advice: "describe the material by Young's modulus and Poisson's ratio",
        });
    }
    let (line, data, values) = single_row("ELASTIC", 2, keyword, lines)?;
    let &[young, poisson] = values.as_slice() else {
        return bad_value(
            lines.spot(line),
            "ELASTIC",
            data,
            "Young's modulus and Poisson's ratio",
        );
    };
    if young <= 0.0 {
        return bad_value(
            lines.spot(line),
            "ELASTIC",
            data,
            "a positive Young's modulus",
        );
    }
    if !(poisson > -1.0 && poisson < 0.5) {
        return bad_value(
            lines.spot(line),
            "ELASTIC",
            data,
            "a Poisson's ratio of more than -1 and less than 0.5",
        );
    }
    current_material("ELASTIC", keyword, lines, raw, |m| {
        m.elastic.replace((young, poisson)).is_some()
    })
}

fn read_density(keyword: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    check_parameters(keyword, "DENSITY", &[], "no parameter", lines)?;
    let (line, data, values) = single_row("DENSITY", 1, keyword, lines)?;
    let &[density] = values.as_slice() else {
        return bad_value(lines.spot(line), "DENSITY", data, "a density");
    };
    if density <= 0.0 {
        return bad_value(lines.spot(line), "DENSITY", data, "a positive density");
    }
    current_material("DENSITY", keyword, lines, raw, |m| {
        m.density.replace(density).is_some()
    })
}

/// The only data line of a material property: `count` numbers, and a temperature that does not matter.
fn single_row<'a>(
    name: &'static str,
    count: usize,
    keyword: &Keyword<'_>,
    lines: &mut Lines<'a>,
) -> Result<(usize, &'a str, Vec<f64>)> {
    let Some((line, data)) = lines.next_data() else {
        return Err(MeshError::Truncated {
            spot: lines.spot(keyword.line),
            what: "a material",
            detail: format!("*{name} lacks its data line"),
        });
    };
    let mut values = Vec::with_capacity(count + 1);
    for field in fields(data).take(count + 2) {
        match number(field) {
            Some(value) => values.push(value),
            None => return bad_value(lines.spot(line), name, field, "finite numbers"),
        }
    }
    if values.len() == count + 1 {
        values.pop();
    }
    if let Some((line, data)) = lines.next_data() {
        let allowed = "one row; properties that depend on temperature are not supported";
        return bad_value(lines.spot(line), name, data, allowed);
    }
    Ok((line, data, values))
}

/// Gives the latest material a property; `set` says whether it had one.
fn current_material(
    name: &'static str,
    keyword: &Keyword<'_>,
    lines: &Lines<'_>,
    raw: &mut Raw,
    set: impl FnOnce(&mut RawMaterial) -> bool,
) -> Result<()> {
    let refused = |seen: String, advice| {
        let spot = lines.spot(keyword.line);
        Err(MeshError::Parameter {
            spot,
            keyword: name,
            seen,
            allowed: "one in each *MATERIAL",
            advice,
        })
    };
    let Some(material) = raw.materials.last_mut() else {
        return refused(
            "it stands before the first *MATERIAL".to_owned(),
            "put it after its *MATERIAL",
        );
    };
    if set(material) {
        return refused(
            format!("the material {:?} has two", material.name),
            "remove one of them",
        );
    }
    Ok(())
}

fn read_solid_section(keyword: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const ALLOWED: &str = "ELSET, MATERIAL";
    check_parameters(
        keyword,
        "SOLID SECTION",
        &["ELSET", "MATERIAL"],
        ALLOWED,
        lines,
    )?;
    let element_set = need(keyword, "SOLID SECTION", "ELSET", ALLOWED, lines)?.to_owned();
    let material = need(keyword, "SOLID SECTION", "MATERIAL", ALLOWED, lines)?.to_owned();
    raw.sections.push(RawSection {
        element_set,
        material,
        line: keyword.line,
    });
    // A thickness means nothing to a solid element.
    lines.skip_data();
    Ok(())
}

/// Passes over everything up to `*END STEP`.
fn skip_step(step: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    let text =
        "*STEP to *END STEP is passed over; the machine file says what is clamped and computed";
    raw.warnings.push(Warning {
        line: step.line,
        text: text.to_owned(),
    });
    loop {
        lines.skip_data();
        match lines.next_keyword() {
            Some(keyword) if keyword.name == "ENDSTEP" => return Ok(()),
            Some(_) => {}
            None => {
                let detail = format!("no *END STEP for the *STEP of line {}", step.line);
                return Err(MeshError::Truncated {
                    spot: lines.spot(lines.number()),
                    what: "the file",
                    detail,
                });
            }
        }
    }
}

//! Sections of nodes, elements and sets.

use super::lines::{Keyword, Lines, bad_value, fields, is_name, label, number, unquoted};
use super::parameters::check_parameters;
use super::raw::{Members, Raw, RawCell, RawKind, RawNode, RawSet};
use super::sections::{need, need_name};
use crate::mesh::{CellKind, MeshError, Warning};

type Result<T> = std::result::Result<T, MeshError>;

pub fn read_nodes(keyword: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    check_parameters(keyword, "NODE", &["NSET"], &[("SYSTEM", &["R"])], "NSET, SYSTEM=R", lines)?;
    let first = raw.nodes.len();
    while let Some((line, data)) = lines.next_data() {
        let mut values = fields(data);
        let label = values.next().and_then(label);
        let mut next = || values.next().and_then(number);
        let node = (label, next(), next(), next());
        let (Some(label), Some(x), Some(y), Some(z)) = node else {
            return bad_value(lines.spot(line), "NODE", data, "a label and three finite coordinates");
        };
        if values.next().is_some() {
            return bad_value(lines.spot(line), "NODE", data, "a label and three coordinates, no more");
        }
        raw.nodes.push(RawNode { label, at: [x, y, z], line: line as u32 });
    }
    add_section_set(keyword, "NSET", first, raw.nodes.len(), &mut raw.node_sets);
    Ok(())
}

pub fn read_elements(keyword: &Keyword<'_>, plain_bricks: bool, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const ALLOWED: &str = "TYPE (C3D4, C3D6, C3D8, C3D8I, C3D10, C3D15, C3D20 or C3D20R), ELSET";
    check_parameters(keyword, "ELEMENT", &["TYPE", "ELSET"], &[], ALLOWED, lines)?;
    let name = need(keyword, "ELEMENT", "TYPE", ALLOWED, lines)?;
    let kind = find_kind(name).ok_or_else(|| MeshError::Parameter {
        spot: lines.spot(keyword.line),
        keyword: "ELEMENT",
        seen: format!("the element type {name:?} is not supported"),
        allowed: ALLOWED,
        advice: "mesh with one of them, and export volume elements alone",
    })?;
    let kind = match kind {
        RawKind::Solid(CellKind::Hex8) if !plain_bricks => RawKind::Solid(CellKind::Hex8Incompatible),
        kind => kind,
    };
    if let Some(text) = remark(name, kind) {
        raw.warnings.push(Warning { line: keyword.line, text });
    }
    let first = raw.cells.len();
    while let Some((line, data)) = lines.next_data() {
        read_element(kind, line, data, lines, raw)?;
    }
    add_section_set(keyword, "ELSET", first, raw.cells.len(), &mut raw.element_sets);
    Ok(())
}

/// The type of a name, solid or not.
fn find_kind(name: &str) -> Option<RawKind> {
    if let Some(kind) = CellKind::ALL.into_iter().find(|kind| kind.name().eq_ignore_ascii_case(name)) {
        return Some(RawKind::Solid(kind));
    }
    let line = LINES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
    let face = FACES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
    line.map(|&(known, nodes)| RawKind::Line(known, nodes)).or(face.map(|&(known, nodes)| RawKind::Face(known, nodes)))
}

/// Line elements with their nodes. Without a section they only make sets.
const LINES: [(&str, usize); 9] =
    [("T2D2", 2), ("T3D2", 2), ("T3D3", 3), ("B21", 2), ("B31", 2), ("B31R", 2), ("B32", 3), ("B32R", 3), ("R2D2", 2)];

/// Two-dimensional elements with their nodes: plane stress and strain, axisymmetric, shells, membranes, surface
/// and rigid elements. Without a section they mark faces of solids. Corners come first.
const FACES: [(&str, usize); 48] = [
    ("CPS3", 3),
    ("CPS4", 4),
    ("CPS4R", 4),
    ("CPS4I", 4),
    ("CPS6", 6),
    ("CPS6M", 6),
    ("CPS8", 8),
    ("CPS8R", 8),
    ("CPS9", 9),
    ("CPE3", 3),
    ("CPE4", 4),
    ("CPE4R", 4),
    ("CPE4I", 4),
    ("CPE6", 6),
    ("CPE6M", 6),
    ("CPE8", 8),
    ("CPE8R", 8),
    ("CPE9", 9),
    ("CAX3", 3),
    ("CAX4", 4),
    ("CAX4R", 4),
    ("CAX6", 6),
    ("CAX8", 8),
    ("CAX8R", 8),
    ("S3", 3),
    ("S3R", 3),
    ("STRI3", 3),
    ("S4", 4),
    ("S4R", 4),
    ("S6", 6),
    ("STRI65", 6),
    ("S8", 8),
    ("S8R", 8),
    ("S9R5", 9),
    ("M3D3", 3),
    ("M3D4", 4),
    ("M3D4R", 4),
    ("M3D6", 6),
    ("M3D8", 8),
    ("M3D8R", 8),
    ("M3D9", 9),
    ("SFM3D3", 3),
    ("SFM3D4", 4),
    ("SFM3D4R", 4),
    ("SFM3D6", 6),
    ("SFM3D8", 8),
    ("R3D3", 3),
    ("R3D4", 4),
];

/// What the user should know of a type.
fn remark(name: &str, kind: RawKind) -> Option<String> {
    match kind {
        RawKind::Solid(CellKind::Tet4) => {
            Some("C3D4, the four-node tetrahedron, is far too stiff in bending; mesh with C3D10 instead".into())
        }
        RawKind::Solid(CellKind::Hex8Incompatible) if name.eq_ignore_ascii_case("C3D8") => Some(
            "C3D8 is read as C3D8I, the brick with incompatible modes; the plain one is too stiff in bending".into(),
        ),
        RawKind::Solid(CellKind::Hex8) => Some("C3D8, the plain brick, is far too stiff in bending".into()),
        RawKind::Face(name, _) => Some(format!("{name} elements are no solids: they mark faces of solids")),
        RawKind::Line(name, _) => Some(format!("{name} elements are no solids: they only make sets")),
        RawKind::Solid(_) => None,
    }
}

/// One element, which may take several lines.
fn read_element(
    kind: RawKind,
    first_line: usize,
    first_data: &str,
    lines: &mut Lines<'_>,
    raw: &mut Raw,
) -> Result<()> {
    let mut cell = None;
    let mut missing = kind.node_count();
    let (mut line, mut data) = (first_line, first_data);
    let mut surplus = false;
    loop {
        for field in fields(data) {
            let Some(value) = label(field) else {
                return bad_value(lines.spot(line), "ELEMENT", field, "labels, whole numbers from 1 on");
            };
            if cell.is_none() {
                cell = Some(value);
            } else if missing > 0 {
                raw.cell_nodes.push(value);
                missing -= 1;
            } else if matches!(kind, RawKind::Solid(CellKind::Hex8 | CellKind::Hex8Incompatible)) {
                surplus = true; // CalculiX reads eight and passes over the rest of the line.
            } else {
                let allowed = format!("an element label and {} node labels, no more", kind.node_count());
                return bad_value(lines.spot(line), "ELEMENT", data, allowed);
            }
        }
        if missing == 0 {
            break;
        }
        (line, data) = lines.next_data().ok_or_else(|| MeshError::Truncated {
            spot: lines.spot(line),
            what: "*ELEMENT",
            detail: format!("its last element lacks {missing} of {} nodes", kind.node_count()),
        })?;
    }
    let nodes = &raw.cell_nodes[raw.cell_nodes.len() - kind.node_count()..];
    if let Some(node) = nodes.iter().enumerate().find_map(|(i, node)| nodes[..i].contains(node).then_some(node)) {
        let allowed = format!("{} different nodes, not node {node} twice", kind.node_count());
        return bad_value(lines.spot(line), "ELEMENT", first_data, allowed);
    }
    if surplus && !std::mem::replace(&mut raw.surplus_said, true) {
        let text = "more than eight nodes of an eight-node brick; the others are passed over, here and further on";
        raw.warnings.push(Warning { line: first_line, text: text.into() });
    }
    if let Some(label) = cell {
        raw.cells.push(RawCell { kind, label, line: first_line as u32 });
    }
    Ok(())
}

/// Adds the nodes or elements of a section to the set that its keyword names.
fn add_section_set(keyword: &Keyword<'_>, parameter: &str, first: usize, end: usize, sets: &mut Vec<RawSet>) {
    if let Some(name) = keyword.name(parameter).filter(|name| !unquoted(name).is_empty()) {
        let members = Members::Section { first, end, line: keyword.line };
        sets.push(RawSet { name: name.to_owned(), members });
    }
}

pub fn read_set(
    keyword: &Keyword<'_>,
    kind: &'static str,
    lines: &mut Lines<'_>,
    sets: &mut Vec<RawSet>,
) -> Result<()> {
    let allowed = if kind == "NSET" { "NSET, ELSET, GENERATE" } else { "ELSET, GENERATE" };
    check_parameters(
        keyword,
        kind,
        &[kind, "GENERATE", "INTERNAL", "UNSORTED", if kind == "NSET" { "ELSET" } else { kind }],
        &[],
        allowed,
        lines,
    )?;
    let name = need_name(keyword, kind, kind, allowed, lines)?;
    let mut push = |members| sets.push(RawSet { name: name.to_owned(), members });
    if let Some(elements) = keyword.name("ELSET").filter(|_| kind == "NSET") {
        push(Members::OfElements { name: elements.to_owned(), line: keyword.line });
    }
    let mut labels = Vec::new();
    while let Some((line, data)) = lines.next_data() {
        if keyword.get("GENERATE").is_some() {
            push(read_range(kind, line, data, lines)?);
            continue;
        }
        for field in fields(data) {
            match label(field) {
                Some(label) => labels.push((label, line as u32)),
                None if is_name(field) => push(Members::Set { name: field.to_owned(), line }),
                None => {
                    return bad_value(lines.spot(line), kind, field, "labels from 1 on, or names of sets");
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
        Some(&[first, last]) if first <= last => Ok(Members::Range { first, last, step: 1, line }),
        Some(&[first, last, step]) if first <= last => Ok(Members::Range { first, last, step, line }),
        _ => bad_value(
            lines.spot(line),
            kind,
            data,
            "GENERATE: first label, last label (not smaller), step (at least 1)",
        ),
    }
}

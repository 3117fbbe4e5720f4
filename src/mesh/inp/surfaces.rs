//! Surfaces, by element faces or by nodes.

use super::assemble::Places;
use super::lines::{Keyword, Lines, fields, is_name, key, label, shortened, unquoted};
use super::raw::{Members, Raw, RawSet, RawSurface, Target};
use super::sections::need_name;
use super::sets::{MOST_MEMBERS, MOST_MEMBERS_PER_LABEL, Sets};
use super::source::Source;
use crate::mesh::labels::Labels;
use crate::mesh::{Cell, CellFace, MeshError, Warning};
use std::collections::BTreeMap;

/// Reads `*SURFACE`. One that cannot be read as faces S1 to S6 or as nodes is passed over with a warning:
/// it changes nothing unless an interface names it, and then it is missed there.
pub fn read_surface(keyword: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<(), MeshError> {
    let name = need_name(keyword, "SURFACE", "NAME", "NAME, TYPE=ELEMENT or TYPE=NODE", lines)?.to_owned();
    let of_nodes = keyword.get("TYPE").is_some_and(|kind| kind.eq_ignore_ascii_case("NODE"));
    let foreign =
        keyword.parameters.iter().find(|(parameter, _)| !["NAME", "TYPE", "INTERNAL"].contains(&&**parameter));
    let mut passed_over = foreign.map(|(parameter, _)| format!("the parameter {parameter}"));
    let (mut faces, mut sets) = (Vec::new(), Vec::new());
    while let Some((line, data)) = lines.next_data() {
        let mut values = fields(data);
        let of = values.next().and_then(target);
        let face = values.next();
        match (of, face.map(str::to_ascii_uppercase).as_deref()) {
            (Some(Target::Label(label)), None | Some("" | "1.0" | "1.")) if of_nodes => {
                sets.push(RawSet { name: name.clone(), members: Members::Labels(vec![(label, line as u32)]) });
            }
            (Some(Target::Set(set)), None | Some("" | "1.0" | "1.")) if of_nodes => {
                sets.push(RawSet { name: name.clone(), members: Members::Set { name: set, line } });
            }
            (Some(of), Some(face)) if !of_nodes && FACES.contains(&face) => {
                let face = FACES.iter().position(|name| *name == face).unwrap_or_default();
                faces.push(RawSurface { name: name.clone(), of, face, line });
            }
            _ => passed_over = passed_over.or_else(|| Some(format!("{:?}", shortened(data)))),
        }
    }
    match passed_over {
        None => {
            raw.surfaces.extend(faces);
            raw.node_surfaces.extend(sets);
        }
        Some(seen) => {
            let name = unquoted(&name).to_owned();
            let reason = format!("{seen} is not supported, element faces S1 to S6 are");
            let text = format!("the surface {name:?} is passed over: {reason}");
            raw.passed_over.push((name, format!("{}: {text}", lines.spot(keyword.line))));
            raw.warnings.push(Warning { line: keyword.line, text });
        }
    }
    Ok(())
}

const FACES: [&str; 6] = ["S1", "S2", "S3", "S4", "S5", "S6"];

/// A label or the name of a set.
pub fn target(field: &str) -> Option<Target> {
    match label(field) {
        Some(label) => Some(Target::Label(label)),
        None => is_name(field).then(|| Target::Set(field.to_owned())),
    }
}

/// Surfaces by element faces: by the key of their name, with the name as it came first.
pub fn surfaces(
    raw: &Raw,
    cells: &[Cell],
    places: &Places,
    labels: &Labels,
    sets: &Sets,
    source: &Source,
) -> Result<BTreeMap<String, (String, Vec<CellFace>)>, MeshError> {
    let mut found: BTreeMap<String, (String, Vec<CellFace>)> = BTreeMap::new();
    let mut count = 0;
    for RawSurface { name, of, face, line } in &raw.surfaces {
        let elements: Vec<u32> = match of {
            Target::Label(label) => {
                let by = format!("the surface {:?}", unquoted(name));
                let missing =
                    || MeshError::MissingLabel { spot: source.spot(*line), by, kind: "element", label: *label };
                vec![labels.find(*label).ok_or_else(missing)? as u32]
            }
            Target::Set(set) => {
                let members = sets.get(set).ok_or_else(|| MeshError::UnknownName {
                    spot: source.spot(*line),
                    kind: "element set",
                    name: unquoted(set).to_owned(),
                    nearest: sets.nearest(set),
                })?;
                members.to_vec()
            }
        };
        count += elements.len();
        let limit = MOST_MEMBERS.max(MOST_MEMBERS_PER_LABEL * cells.len());
        if count > limit {
            return Err(MeshError::TooManyMembers { spot: source.spot(*line), limit });
        }
        let (_, list) = found.entry(key(name)).or_insert_with(|| (unquoted(name).to_owned(), Vec::new()));
        for &i in &elements {
            let Some(cell) = places.cell[i as usize] else { continue };
            let refuse = |allowed: String| {
                let seen = format!("S{} of element {}", face + 1, raw.cells[i as usize].label);
                Err(MeshError::Value { spot: source.spot(*line), keyword: "SURFACE", seen, allowed })
            };
            let faces = cells[cell].kind.face_count();
            if *face >= faces {
                return refuse(format!("faces S1 to S{faces} of a {}", cells[cell].kind.name()));
            }
            if places.turned[i as usize] {
                let label = cells[cell].label;
                return refuse(format!("faces of element {label}, which has the same nodes in another order"));
            }
            list.push(CellFace { cell, face: *face });
        }
    }
    for (_, list) in found.values_mut() {
        list.sort_unstable();
        list.dedup();
    }
    Ok(found)
}

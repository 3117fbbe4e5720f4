//! Surfaces, by element faces or by nodes.

use super::lines::{Keyword, Lines, fields, label, shortened};
use super::raw::{Members, Raw, RawSet, RawSurface, Target};
use super::sections::need;
use crate::mesh::{MeshError, Warning};

/// Reads `*SURFACE`. One that cannot be read as faces S1 to S6 or as nodes is passed over with a warning:
/// it changes nothing unless an interface names it, and then it is missed there.
pub fn read_surface(keyword: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<(), MeshError> {
    let name = need(keyword, "SURFACE", "NAME", "NAME, TYPE=ELEMENT or TYPE=NODE", lines)?.to_owned();
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
            raw.node_sets.extend(sets);
        }
        Some(seen) => {
            let text =
                format!("the surface {name:?} is passed over: {seen} is not supported, element faces S1 to S6 are");
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
        None if field.starts_with(|c: char| c.is_alphabetic() || c == '_') => Some(Target::Set(field.to_owned())),
        None => None,
    }
}

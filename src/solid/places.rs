//! What an interface or a clamp takes of a mesh by a name: faces where the file gives them, otherwise nodes.
//!
//! A file may call several things by one name. Where they are the same place, as the node set and the element set
//! that Gmsh writes of one surface are, any of them will do; where they are not, the name is refused.

use super::{SolidError, Surface};
use crate::machine::{Part, nearest};
use crate::mesh::{Mesh, loosely_equal, spelling};
use std::borrow::Cow;
use std::collections::BTreeSet;

/// What stands under a name.
struct Place<'m> {
    /// The name as the file spells it.
    name: &'m str,
    /// Its nodes, if it is a node set (or another thing that has nodes and no faces).
    nodes: Option<&'m [usize]>,
    /// Its faces, if the file gives them; or the label of a two-dimensional element that is no face of a solid.
    faces: Option<Result<Surface, u64>>,
}

/// The surface of a name: the faces that the file gives, or those of a node set; and what it was made from.
///
/// # Errors
/// [`SolidError::UnknownSet`], [`SolidError::TwoPlaces`], [`SolidError::NoFace`].
pub(super) fn surface_of(part: &Part, mesh: &Mesh, name: &str, user: &str) -> Result<(Surface, String), SolidError> {
    let place = find(part, mesh, name, user)?;
    match place.faces {
        Some(Ok(surface)) => Ok((surface, format!("the surface \"{}\"", place.name))),
        Some(Err(label)) => Err(no_face(part, place.name, user, label)),
        None => {
            let nodes = place.nodes.unwrap_or_default();
            let what = format!("the {} nodes of set \"{}\"", nodes.len(), place.name);
            Ok((Surface::of_node_set(mesh, nodes), what))
        }
    }
}

/// The nodes of a name: those of a node set, or all of its faces.
///
/// # Errors
/// As [`surface_of`].
pub(super) fn nodes_of<'m>(
    part: &Part,
    mesh: &'m Mesh,
    name: &str,
    user: &str,
) -> Result<Cow<'m, [usize]>, SolidError> {
    let place = find(part, mesh, name, user)?;
    match (place.nodes, place.faces) {
        (Some(nodes), _) => Ok(Cow::Borrowed(nodes)),
        (None, Some(Ok(surface))) => Ok(Cow::Owned(surface.nodes().into_iter().collect())),
        (None, Some(Err(label))) => Err(no_face(part, place.name, user, label)),
        (None, None) => Ok(Cow::Borrowed(&[])),
    }
}

/// Refuses a name that stands for different places.
///
/// # Errors
/// [`SolidError::TwoPlaces`]; an unknown name is none.
pub(super) fn check_name(part: &Part, mesh: &Mesh, name: &str, user: &str) -> Result<(), SolidError> {
    match find(part, mesh, name, user) {
        Err(error @ SolidError::TwoPlaces { .. }) => Err(error),
        _ => Ok(()),
    }
}

fn find<'m>(part: &Part, mesh: &'m Mesh, name: &str, user: &str) -> Result<Place<'m>, SolidError> {
    let two_places = |places: String| SolidError::TwoPlaces {
        part: part.name.clone(),
        user: user.to_string(),
        name: name.to_string(),
        mesh: part.mesh.display().to_string(),
        places,
    };
    let names: BTreeSet<&str> = [
        mesh.node_sets.keys().collect::<Vec<_>>(),
        mesh.surfaces.keys().collect(),
        mesh.face_sets.keys().collect(),
        mesh.namesakes.keys().collect(),
    ]
    .concat()
    .into_iter()
    .map(String::as_str)
    .collect();
    let found = spelling(names.iter().copied(), name).map_err(|all| two_places(all.join("; ")))?;
    let Some(name) = found else {
        return Err(SolidError::UnknownSet {
            part: part.name.clone(),
            user: user.to_string(),
            set: name.to_string(),
            mesh: part.mesh.display().to_string(),
            known: known(&names, mesh, name),
        });
    };
    let listed = mesh.surfaces.get(name).map(|faces| Surface::of_cell_faces(mesh, faces));
    let marked = mesh.face_sets.get(name).map(|faces| Surface::of_face_elements(mesh, faces));
    let set = mesh.node_sets.get(name).map(Vec::as_slice);
    // The nodes of two-dimensional elements are a node set too, but no other place than their faces.
    let own = match mesh.namesakes.get(name) {
        Some(own) => own.iter().map(|namesake| (namesake.what.as_str(), namesake.nodes.as_slice())).collect(),
        None if marked.is_some() => Vec::new(),
        None => set.map(|nodes| ("the node set", nodes)).into_iter().collect::<Vec<_>>(),
    };
    let surfaces: Vec<(&str, &Surface)> = [
        listed.as_ref().map(|surface| ("the surface (*SURFACE)", surface)),
        marked.as_ref().and_then(|surface| surface.as_ref().ok()).map(|surface| ("the surface elements", surface)),
    ]
    .into_iter()
    .flatten()
    .collect();
    let one_place = own.windows(2).all(|pair| pair[0].1 == pair[1].1)
        && surfaces.windows(2).all(|pair| pair[0].1.corner_sets() == pair[1].1.corner_sets())
        && own.first().is_none_or(|(_, nodes)| surfaces.iter().all(|(_, surface)| covers(surface, nodes)));
    if !one_place {
        let of_nodes = own.iter().map(|(what, nodes)| format!("{what} of {} nodes", nodes.len()));
        let of_faces = surfaces.iter().map(|(what, surface)| format!("{what} of {} faces", surface.faces.len()));
        return Err(two_places(of_nodes.chain(of_faces).collect::<Vec<_>>().join("; ")));
    }
    let nodes = own.first().map(|(_, nodes)| *nodes);
    Ok(Place { name, nodes, faces: listed.map(Ok).or(marked) })
}

/// Whether nodes are those of a surface: all of its corners, and none beside its nodes.
fn covers(surface: &Surface, nodes: &[usize]) -> bool {
    let all = surface.nodes();
    let corners = surface.faces.iter().flat_map(|face| face.nodes[..face.corners().len()].iter());
    corners.into_iter().all(|node| nodes.binary_search(node).is_ok()) && nodes.iter().all(|node| all.contains(node))
}

fn no_face(part: &Part, name: &str, user: &str, element: u64) -> SolidError {
    SolidError::NoFace { part: part.name.clone(), user: user.to_string(), name: name.to_string(), element }
}

/// The names of a mesh, for a message; why the one that is looked for is not among them, or which was probably meant.
fn known(names: &BTreeSet<&str>, mesh: &Mesh, name: &str) -> String {
    let all = match names.is_empty() {
        true => "no set at all; name node sets or surfaces (in Gmsh physical groups) in the mesh".to_owned(),
        false => names.iter().copied().collect::<Vec<_>>().join(", "),
    };
    if let Some((_, why)) = mesh.passed_over.iter().find(|(other, _)| loosely_equal(other, name)) {
        return format!("{all}; {why}");
    }
    let meant = nearest(name, names.iter().copied()).map_or_else(String::new, |n| format!("; did you mean \"{n}\"?"));
    all + &meant
}

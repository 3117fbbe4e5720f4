//! Names of a mesh file, and what stands under them.
//!
//! A file may call several things by one name: a node set, the two-dimensional elements that mark a surface, a
//! body. The readers keep them apart; `solid` takes what an interface or a clamp needs and refuses a name that
//! stands for different places.

/// A two-dimensional element of a mesh file. It has no stiffness: it marks a face of a solid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FaceElement {
    /// Label in its file, for messages.
    pub label: u64,
    /// Its corners as indices into [`super::Mesh::nodes`]; `None` where one of them belongs to no solid.
    pub corners: Option<Vec<usize>>,
}

/// One of several things of a file that have the same name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Namesake {
    /// What it is, such as "the node set (*NSET)".
    pub what: String,
    /// Its nodes: indices into [`super::Mesh::nodes`], ascending, no duplicates.
    pub nodes: Vec<usize>,
}

/// Whether two spellings may mean one name: case and blanks do not matter.
pub fn loosely_equal(a: &str, b: &str) -> bool {
    let plain = |s: &str| s.chars().filter(|c| !c.is_whitespace()).flat_map(char::to_uppercase).collect::<String>();
    a == b || plain(a) == plain(b)
}

/// The spelling that `name` stands for: itself if it is known, otherwise the only one that equals it but for case
/// and blanks.
///
/// # Errors
/// All of them, if there are several and none is exact.
pub fn spelling<'a>(known: impl Iterator<Item = &'a str>, name: &str) -> Result<Option<&'a str>, Vec<&'a str>> {
    let mut found: Vec<&str> = known.filter(|known| loosely_equal(known, name)).collect();
    if let Some(exact) = found.iter().find(|known| **known == name) {
        return Ok(Some(exact));
    }
    found.sort_unstable();
    found.dedup();
    if found.len() > 1 { Err(found) } else { Ok(found.pop()) }
}

/// A warning about two-dimensional elements that can mark no face, as a node of theirs belongs to no solid.
pub(super) fn loose_faces(name: &str, faces: &[FaceElement]) -> Option<String> {
    let mut loose = faces.iter().filter(|face| face.corners.is_none());
    let first = loose.next()?.label;
    let count = 1 + loose.count();
    Some(format!(
        "{count} surface elements of {name:?}, element {first} first, lie on no solid element; an interface or clamp cannot use {name:?}"
    ))
}

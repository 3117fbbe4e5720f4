//! The readers of `.inp` and `.msh` files: what is read, and what is refused with which words.

#[path = "../support/mod.rs"]
mod support;

use std::path::Path;
use stiffmap::machine::MeshUnits;
use stiffmap::mesh::MeshFile;
use stiffmap::mesh::inp::parse_inp;

mod any_bytes;
mod broad;
mod doubled;
mod faces;
mod groove;
mod hourglass;
mod msh;
mod names;
mod neutral;
mod reading;
mod refusals;

const SI: MeshUnits = MeshUnits::METRE_KILOGRAM_SECOND;

/// One tetrahedron with everything that a part needs; the tests change a line of it.
const TET: &str = "** a comment
*HEADING
one tetrahedron, label 7
*NODE, NSET=Nall
1, 0, 0, 0
2, 2, 0, 0
3, 0, 2, 0
4, 0, 0, 2
5, 1, 0, 0
6, 1, 1, 0
7, 0, 1, 0
8, 0, 0, 1
9, 1, 0, 1
20, 0, 1, 1.0D+0
*ELEMENT, TYPE=C3D10, ELSET=EALL
7, 1, 2, 3, 4, 5, 6, 7, 8, 9, 20
*NSET, NSET=BASE
1, 2, 3,
5, 6, 7
*MATERIAL, NAME=STEEL
*ELASTIC
210e9, 0.3
*DENSITY
7850
*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL
";

/// A brick of the unit cube.
const BRICK: &str = "*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
*ELEMENT, TYPE=C3D8I, ELSET=E
1, 1, 2, 3, 4, 5, 6, 7, 8
*NSET, NSET=FLOOR
1, 2, 3, 4
*MATERIAL, NAME=M
*ELASTIC
1, 0.3
*DENSITY
1
*SOLID SECTION, ELSET=E, MATERIAL=M
";

fn parse(text: &str) -> Result<MeshFile, String> {
    parse_inp(text.as_bytes(), Path::new("tet.inp"), SI).map_err(|error| error.to_string())
}

fn changed(from: &str, to: &str) -> String {
    assert!(TET.contains(from), "{from:?} is not in the tetrahedron");
    TET.replacen(from, to, 1)
}

#[track_caller]
fn accepted(text: &str) -> MeshFile {
    parse(text).unwrap_or_else(|message| panic!("{message}"))
}

/// Checks that a file is refused, and that the message names the file and holds every fragment.
#[track_caller]
fn refused(text: &str, fragments: &[&str]) {
    let message = match parse(text) {
        Ok(_) => panic!("accepted; expected a refusal with {fragments:?}"),
        Err(message) => message,
    };
    for fragment in ["tet.inp:"].iter().chain(fragments) {
        assert!(message.contains(fragment), "{fragment:?} is not in: {message}");
    }
}

#[track_caller]
fn refused_change(from: &str, to: &str, fragments: &[&str]) {
    refused(&changed(from, to), fragments);
}

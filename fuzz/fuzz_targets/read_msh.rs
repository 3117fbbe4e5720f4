//! Any bytes as a Gmsh file: read or refused, never a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use stiffmap::machine::MeshUnits;
use stiffmap::mesh::msh::parse_msh;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(read) = parse_msh(bytes, Path::new("fuzzed.msh"), MeshUnits::METRE_KILOGRAM_SECOND, false) {
        for cell in &read.mesh.cells {
            assert!(cell.nodes.iter().all(|&node| node < read.mesh.nodes.len()));
        }
    }
});

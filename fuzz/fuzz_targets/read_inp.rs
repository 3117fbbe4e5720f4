//! Any bytes as an Abaqus/CalculiX input file: read or refused, never a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use stiffmap::machine::MeshUnits;
use stiffmap::mesh::inp::{parse_deck, parse_inp};

fuzz_target!(|bytes: &[u8]| {
    let file = Path::new("fuzzed.inp");
    if let Ok(read) = parse_inp(bytes, file, MeshUnits::METRE_KILOGRAM_SECOND) {
        for cell in &read.mesh.cells {
            assert!(cell.nodes.iter().all(|&node| node < read.mesh.nodes.len()));
        }
    }
    let _ = parse_deck(bytes, file, true, None);
});

//! Any bytes as each of the tables beside matrices: read or refused, never a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use stiffmap::matrix::*;

fuzz_target!(|bytes: &[u8]| {
    let file = Path::new("fuzzed");
    for table in [parse_dof_table(bytes, file), parse_calculix_dofs(bytes, file)].into_iter().flatten() {
        assert!(table.labels.len() <= bytes.len() && table.nodes.len() <= table.labels.len());
    }
    let _ = parse_node_table(bytes, file);
    let _ = parse_set_table(bytes, file);
});

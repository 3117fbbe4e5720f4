//! Any bytes as an Ansys .full file: read or refused, never a panic; a matrix that is read is made symmetric or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use stiffmap::matrix::*;

fuzz_target!(|bytes: &[u8]| {
    let file = Path::new("fuzzed");
    for matrix in parse_full(bytes, file).map(|full| [Some(full.stiffness), full.mass].into_iter().flatten().collect::<Vec<_>>()).unwrap_or_default() {
        // Whoever reads a part has as many labels as rows, so a file is as long as its matrix has rows.
        if matrix.n <= bytes.len() {
            let n = matrix.n;
            if let Ok(whole) = symmetric(matrix, "stiffness", &|row| row.to_string()) {
                assert_eq!(whole.n(), n);
            }
        }
    }
});

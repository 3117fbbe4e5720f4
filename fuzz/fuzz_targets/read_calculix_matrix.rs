//! Any bytes as a CalculiX .sti file: read or refused, never a panic; a matrix that is read is made symmetric or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use stiffmap::matrix::*;

fuzz_target!(|bytes: &[u8]| {
    let file = Path::new("fuzzed");
    for matrix in parse_calculix(bytes, file).map(|m| vec![m]).unwrap_or_default() {
        // Whoever reads a part has as many labels as rows, so a file is as long as its matrix has rows.
        if matrix.n <= bytes.len() {
            let n = matrix.n;
            if let Ok(whole) = symmetric(matrix, "stiffness", &|row| row.to_string()) {
                assert_eq!(whole.n(), n);
            }
        }
    }
});

//! Ansys `.full` against ansys-mapdl-reader, on the file that its package ships.

use super::folder;
use nalgebra::DMatrix;
use stiffmap::matrix::{Coordinates, DofLabel, parse_full, symmetric};

/// Writes the package's reading of its own file: labels of free rows, then the entries of K and M.
const ORACLE: &str = r#"
import shutil, sys
import numpy as np
from ansys.mapdl import reader
from ansys.mapdl.reader import examples
shutil.copy(examples.fullfile, sys.argv[1] + "/file.full")
full = reader.read_binary(examples.fullfile)
dof, k, m = full.load_km(sort=False)
fixed = {tuple(d) for d in full.const}
np.savetxt(sys.argv[1] + "/dof.txt", [list(d) + [int(tuple(d) in fixed)] for d in dof], fmt="%d")
for name, a in (("k", k.tocoo()), ("m", m.tocoo())):
    np.savetxt(sys.argv[1] + f"/{name}.txt", np.column_stack([a.row, a.col, a.data]), fmt="%.17g")
"#;

fn table(file: &std::path::Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(file).unwrap();
    text.lines().map(|l| l.split_whitespace().map(|f| f.parse().unwrap()).collect()).collect()
}

#[test]
fn the_sample_of_ansys_mapdl_reader_is_read_as_its_own_reader_does() {
    if std::env::var("STIFFMAP_PYTHON_TESTS").is_ok_and(|v| v == "skip") {
        eprintln!("skipped: STIFFMAP_PYTHON_TESTS=skip");
        return;
    }
    let python = std::env::var("STIFFMAP_PYTHON")
        .unwrap_or_else(|_| panic!("STIFFMAP_PYTHON names no Python with ansys-mapdl-reader; see tests/run.sh"));
    let folder = folder();
    let run = std::process::Command::new(&python).args(["-c", ORACLE]).arg(folder.path()).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let file = folder.path().join("file.full");
    let full = parse_full(&std::fs::read(&file).unwrap(), &file).unwrap_or_else(|e| panic!("{e}"));

    let dofs = table(&folder.path().join("dof.txt"));
    let label = |row: &[f64]| DofLabel::Node { node: row[0] as u64, direction: row[1] as usize };
    let pick = |fixed: f64| dofs.iter().filter(|d| d[2] == fixed).map(|d| label(d)).collect::<Vec<_>>();
    assert_eq!(full.labels, pick(0.0));
    assert_eq!(full.fixed, pick(1.0));
    assert!(full.labels.len() == 900 && full.fixed.len() == 63);

    // Places of the oracle's rows, which count the fixed ones, among the free ones.
    let mut next = 0;
    let place: Vec<Option<usize>> = dofs
        .iter()
        .map(|d| {
            next += usize::from(d[2] == 0.0);
            (d[2] == 0.0).then(|| next - 1)
        })
        .collect();
    let dense = |matrix: Coordinates| {
        let matrix = symmetric(matrix, "stiffness", &|i| i.to_string()).unwrap();
        let mut out = DMatrix::zeros(matrix.n(), matrix.n());
        (0..matrix.n()).for_each(|i| matrix.row(i).for_each(|(j, v)| out[(i, j)] = v));
        out
    };
    for (name, matrix) in [("k", full.stiffness), ("m", full.mass.expect("a mass"))] {
        let seen = dense(matrix);
        let mut expected = DMatrix::zeros(900, 900);
        for entry in table(&folder.path().join(format!("{name}.txt"))) {
            if let (Some(i), Some(j)) = (place[entry[0] as usize], place[entry[1] as usize]) {
                expected[(i, j)] = entry[2];
                expected[(j, i)] = entry[2];
            }
        }
        assert_eq!(seen, expected, "{name}");
        expected[(3, 3)] *= 1.0 + 1e-15;
        assert_ne!(seen, expected, "{name}");
    }
}

//! No bytes make a reader panic, and a declared size costs no memory.

use super::data;
use proptest::prelude::*;
use std::path::Path;
use stiffmap::matrix::op4::parse_op4;
use stiffmap::matrix::*;

/// Every reader on the same bytes.
fn read_all(bytes: &[u8]) {
    let file = Path::new("bytes");
    let name = |row: usize| row.to_string();
    let found = [
        parse_market(bytes, file).ok(),
        parse_calculix(bytes, file).ok(),
        parse_abaqus(bytes, file).ok().map(|(matrix, _)| matrix),
        parse_full(bytes, file).ok().map(|full| full.stiffness),
    ];
    for matrix in found.into_iter().flatten().chain(op4(bytes)) {
        if matrix.n < 10_000 {
            let _ = symmetric(matrix, "stiffness", &name);
        }
    }
    let _ = parse_calculix_dofs(bytes, file);
    let _ = parse_dof_table(bytes, file);
    let _ = parse_node_table(bytes, file);
    let _ = parse_set_table(bytes, file);
}

fn op4(bytes: &[u8]) -> Vec<Coordinates> {
    parse_op4(bytes, Path::new("bytes")).map(|(all, _)| all.into_iter().map(|m| m.matrix).collect()).unwrap_or_default()
}

/// Cases a property is tried on; STIFFMAP_FUZZ_CASES asks for more.
fn cases() -> u32 {
    std::env::var("STIFFMAP_FUZZ_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(300)
}

fn samples() -> Vec<Vec<u8>> {
    let op4 = ["sparse_text_double", "dense_binary_single", "bigmat_binary_double", "bigmat_text_single"];
    let mut samples: Vec<Vec<u8>> = op4.iter().map(|n| std::fs::read(data(&format!("op4/{n}.op4"))).unwrap()).collect();
    samples.extend(
        [
            &b"%%MatrixMarket matrix coordinate real general\n3 3 5\n1 1 4\n1 2 -1\n2 2 5\n2 3 2.5\n3 3 6\n"[..],
            b"%%MatrixMarket matrix array real symmetric\n2 2\n1\n2\n3\n",
            b"*MATRIX INPUT, NAME=K\n1,1, 1,1, 2.\n2,1, 1,1, -1.\n2,1, 2,1, 1.\n",
            b"1 1 2.0\n1 2 -1.0\n2 2 1.0\n",
            b"1.1\n1.2\n17.6\n",
            b"node,direction,x,y,z\n1,x,0,0,0\n1,ry,0,0,0\n2,modal,,,\n",
            b"set,node,weight\nA,1,0.5\nA,2,0.5\n",
        ]
        .map(<[u8]>::to_vec),
    );
    samples
}

#[test]
fn sizes_that_are_declared_and_not_there_are_refused_at_once() {
    for text in [
        "%%MatrixMarket matrix coordinate real general\n40000000 40000000 99999999999\n1 1 1\n",
        "%%MatrixMarket matrix array real general\n40000000 40000000\n1\n",
        "%%MatrixMarket matrix coordinate real general\n99999999999999999999 1 1\n",
    ] {
        assert!(parse_market(text.as_bytes(), Path::new("bytes")).is_err());
    }
    let huge = format!("{:8}{:8}{:8}{:8}{:8}1P,3E23.16\n{:8}{:8}{:8}\n", 40000000, 40000000, 6, 2, "K", 1, 1, 80000000);
    assert!(parse_op4(huge.as_bytes(), Path::new("bytes")).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn changed_and_cut_files_do_no_harm(which in 0..11_usize, at in 0..3000_usize, with in prop::collection::vec(any::<u8>(), 0..12), end in 0..3000_usize) {
        let mut bytes = samples()[which].clone();
        let at = at % bytes.len();
        let until = (at + with.len()).min(bytes.len());
        bytes.splice(at..until, with);
        read_all(&bytes);
        bytes.truncate(end % (bytes.len() + 1));
        read_all(&bytes);
    }

    #[test]
    fn no_bytes_do_harm(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        read_all(&bytes);
    }
}

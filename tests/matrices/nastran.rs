//! OUTPUT4 text as Nastran writes it: tests/matrices/op4_nastran/make.py, pyYeti's writer confirmed by its reader.

use super::support::dense::full;
use super::support::{box_mesh, on, part};
use super::{by_matrices, data, files, folder, write_part};
use nalgebra::DMatrix;
use std::path::Path;
use stiffmap::matrix::op4::parse_op4;
use stiffmap::matrix::symmetric;
use stiffmap::mesh::read_part_mesh;

/// KAA and MAA by the formulas of the script.
fn expected() -> [DMatrix<f64>; 2] {
    let stiffness = DMatrix::from_fn(9, 9, |i, j| match i.abs_diff(j) {
        0 => 2e9,
        1 => -1e9,
        8 => -1.0,
        _ => 0.0,
    });
    let mass = DMatrix::from_fn(9, 9, |i, j| if i == j && i != 2 { (i + 1) as f64 / 7.0 } else { 0.0 });
    [stiffness, mass]
}

fn text(name: &str) -> String {
    std::fs::read_to_string(data("op4_nastran").join(name)).unwrap()
}

/// KAA and MAA of a text, and what is said of the others.
fn read(text: &str) -> Result<(Vec<DMatrix<f64>>, Vec<String>), String> {
    let (found, unusable) = parse_op4(text.as_bytes(), Path::new("k.op4")).map_err(|e| e.to_string())?;
    let names: Vec<&str> = found.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["KAA", "MAA"]);
    let place = |row: usize| row.to_string();
    let whole = found.into_iter().map(|m| full(&symmetric(m.matrix, "stiffness", &place).unwrap()));
    Ok((whole.collect(), unusable))
}

#[test]
fn dense_and_sparse_texts_are_read_with_complex_matrices_between() {
    for storage in ["dense", "bigmat", "nonbigmat"] {
        for (digits, tolerance) in [(9, 1e-9), (16, 2e-16)] {
            let name = format!("{storage}_{digits}.op4");
            let (found, unusable) = read(&text(&name)).unwrap();
            assert_eq!(unusable, ["CPH (complex)", "CPX (complex)"], "{name}");
            for (seen, right) in found.iter().zip(expected()) {
                let difference = (seen - &right).amax() / right.amax();
                assert!(difference <= tolerance, "{name}: {difference:.1e}");
            }
            let zeros = "0".repeat(digits);
            let changed = text(&name).replacen(&format!("2.{zeros}E+09"), &format!("2.1{}E+09", &zeros[1..]), 1);
            let (found, _) = read(&changed).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert!((found[0][(0, 0)] / 2.1e9 - 1.0).abs() < 1e-9, "control: another number in {name}");
        }
    }
}

#[test]
fn lengths_count_numbers_or_words_but_not_both_in_one_matrix() {
    let nastran = text("dense_16.op4");
    // Each column's header is three integers; others than Nastran announce two words a number.
    let in_words: String = nastran
        .lines()
        .map(|line| match line.split_whitespace().collect::<Vec<_>>()[..] {
            [column, row, numbers] if !line.contains('.') => {
                format!("{column:>8}{row:>8}{:>8}\n", 2 * numbers.parse::<usize>().unwrap())
            }
            _ => format!("{line}\n"),
        })
        .collect();
    assert_ne!(in_words, nastran);
    assert_eq!(read(&in_words).unwrap().0, read(&nastran).unwrap().0);
    // A column that lost its second line has half of its numbers, but not in words.
    let lines: Vec<&str> = nastran.lines().collect();
    let at = lines.iter().position(|line| line.starts_with(" 2.0000000000000000E+09-1.0")).expect("the first column");
    let cut: Vec<&str> = lines.iter().enumerate().filter(|(i, _)| *i != at + 1).map(|(_, line)| *line).collect();
    let message = read(&cut.join("\n")).unwrap_err();
    assert!(message.contains("announce"), "{message}");
}

/// Complex of single precision: two numbers of one word each a value.
#[test]
fn a_complex_matrix_of_single_precision_is_passed_over() {
    let complex = [
        "       1       2       2       3CPS     1P,5E16.9",
        "       1       0       5",
        "     327681",
        " 1.000000000E+00 2.000000000E+00 3.000000000E+00 4.000000000E+00",
        "       2       1       1",
        " 1.000000000E+00",
        "",
    ]
    .join("\n");
    let (found, unusable) = read(&(complex + &text("nonbigmat_9.op4"))).unwrap();
    assert_eq!((found.len(), unusable[0].as_str()), (2, "CPS (complex)"));
}

/// What is said of a block whose matrices come from one OUTPUT4 text.
fn of_block(text: &str, names: [Option<&str>; 2]) -> String {
    let block = part("block", &[], vec![on("XMIN")]);
    let mesh = box_mesh([0.0; 3], [0.2, 0.1, 0.1], [1, 1, 1]);
    let folder = folder();
    write_part(folder.path(), &block, &mesh);
    std::fs::write(folder.path().join("k.op4"), text).unwrap();
    let mut given = files(folder.path(), &block);
    (given.stiffness, given.mass) = (folder.path().join("k.op4"), folder.path().join("k.op4"));
    [given.stiffness_name, given.mass_name] = names.map(|name| name.map(str::to_owned));
    read_part_mesh(&by_matrices(&block, given)).map_or_else(|e| e.to_string(), |_| "accepted".into())
}

#[test]
fn two_matrices_of_one_name_and_one_matrix_for_both_are_refused() {
    let text = text("dense_16.op4");
    let twice = of_block(&(text.clone() + &text), [Some("kaa"), Some("MAA")]);
    for part in ["no single matrix kaa", "KAA of order 9, KAA of order 9", "write each matrix once"] {
        assert!(twice.contains(part), "{twice}");
    }
    let same = of_block(&text, [Some("KAA"), Some("kaa")]);
    assert!(same.contains("the matrix KAA for both stiffness and mass"), "{same}");
    // Control: the two matrices of the file are of nine rows, which the table of the block does not fit.
    let other = of_block(&text, [Some("KAA"), Some("MAA")]);
    assert!(other.contains("dofs.csv") && other.contains("has 9"), "{other}");
}

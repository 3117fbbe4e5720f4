//! The table by columns.

use super::*;

#[test]
#[cfg(not(feature = "parquet"))]
fn without_the_feature_parquet_is_refused_before_anything_is_done() {
    let folder = folder_with(STUDY);
    let refused = sweep(folder.path(), "out", &["--parquet"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("--features parquet"), "{}", stderr(&refused));
    assert!(!folder.path().join("out").exists());
}

/// Compares designs.parquet with designs.csv cell by cell; prints the empty cells and the types.
#[cfg(feature = "parquet")]
const COMPARE: &str = r#"
import csv, sys
import pyarrow.parquet as pq

table = pq.read_table(sys.argv[1])
names, *rows = csv.reader(open(sys.argv[2], newline=""))
assert table.column_names == names, table.column_names
assert table.num_rows == len(rows)
kinds = [str(field.type) for field in table.schema]
as_kind = {"int64": int, "double": float, "bool": lambda cell: cell == "yes", "string": str}
empty = 0
for name, kind, cells in zip(names, kinds, zip(*rows)):
    for value, cell in zip(table[name].to_pylist(), cells):
        expected = None if cell == "" else as_kind[kind](cell)
        assert value == expected, (name, value, cell)
        empty += expected is None
print(empty, *sorted(set(kinds)))
"#;

#[test]
#[cfg(feature = "parquet")]
fn pyarrow_reads_the_table_that_csv_holds() {
    if std::env::var("STIFFMAP_PYTHON_TESTS").is_ok_and(|v| v == "skip") {
        eprintln!("skipped: STIFFMAP_PYTHON_TESTS=skip");
        return;
    }
    let python = std::env::var("STIFFMAP_PYTHON").unwrap_or_else(|_| {
        panic!("STIFFMAP_PYTHON names no Python; set it to one that has pyarrow, or set STIFFMAP_PYTHON_TESTS=skip")
    });
    // A short span leaves the nut beyond its support: rows with empty cells and an error.
    let more = "[variables.support]\npath = \"joints.screw.support\"\nvalues = [\"one-end\", \"both-ends\"]\n\n\
                [variables.span]\npath = \"joints.screw.span\"\nrange = [\"100 mm\", \"1500 mm\"]\n\n[sampling]";
    let folder = folder_with(&changed("[sampling]", more));
    let screw = "diameter = \"16 mm\"";
    let held = MACHINE.replacen(screw, &format!("{screw}\nsupport = \"both-ends\"\nspan = \"1300 mm\""), 1);
    std::fs::write(folder.path().join("machine.toml"), held).unwrap();
    let out = folder.path().join("out");
    done(&sweep(folder.path(), "out", &["--parquet"]));
    let compare = || {
        let files = [out.join("designs.parquet"), out.join("designs.csv")];
        Command::new(&python).args(["-c", COMPARE]).args(files).output().unwrap()
    };
    let run = compare();
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    let said = String::from_utf8(run.stdout).unwrap();
    let (empty, kinds) = said.trim().split_once(' ').unwrap();
    assert!(empty.parse::<usize>().unwrap() > 24, "some rows lack values, and the others an error: {said}");
    assert_eq!(kinds, "bool double int64 string");
    let manifest = std::fs::read_to_string(out.join("manifest.json")).unwrap();
    assert!(manifest.contains("designs.parquet"));
    let table = std::fs::read_to_string(out.join("designs.csv")).unwrap();
    std::fs::write(out.join("designs.csv"), table.replacen("one-end", "both-ends", 1)).unwrap();
    assert_ne!(compare().status.code(), Some(0), "control: one changed cell");
}

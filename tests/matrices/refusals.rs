//! Matrices that cannot be used are refused with what was found.

use super::support::slide;
use super::support::{box_mesh, craig_bampton, on, part};
use super::{by_matrices, data, files, folder, write_part};
use std::path::Path;
use std::process::Command;
use stiffmap::machine::{InterfaceNodes, InterfaceWeights, MatrixFiles, Part};
use stiffmap::mesh::{MeshFile, read_part_mesh};
use stiffmap::pipeline::check_travel;
use stiffmap::reduction::{ReductionRequest, reduce};
use stiffmap::solid::interface_motions;

/// A free block with both ends as interfaces, and its matrices in a folder.
fn block() -> (Part, tempfile::TempDir) {
    let (part, mesh) =
        (part("block", &[], vec![on("XMIN"), on("XMAX")]), box_mesh([0.0; 3], [0.2, 0.1, 0.1], [2, 1, 1]));
    let folder = folder();
    write_part(folder.path(), &part, &mesh);
    (part, folder)
}

/// What is said of the block after its files or the request have been changed.
fn refusal(change: &dyn Fn(&Path, &mut MatrixFiles)) -> String {
    let (part, folder) = block();
    let mut files = files(folder.path(), &part);
    change(folder.path(), &mut files);
    let part = by_matrices(&part, files);
    let mesh = match read_part_mesh(&part) {
        Ok(file) => file.mesh,
        Err(error) => return error.to_string(),
    };
    let request = ReductionRequest { part, component: craig_bampton(10), reach: 0.0, rails: Vec::new() };
    reduce(&request, &mesh, None).map_or_else(|e| e.to_string(), |_| "accepted".into())
}

/// Changes the lines of a file.
fn edit(file: &Path, change: impl Fn(usize, &str) -> String) {
    let text = std::fs::read_to_string(file).unwrap();
    let lines: String = text.lines().enumerate().map(|(i, line)| change(i, line) + "\n").collect();
    std::fs::write(file, lines).unwrap();
}

/// Replaces the value of an entry of a Matrix Market file, given by row and column.
fn set(file: &Path, row: usize, column: usize, change: impl Fn(f64) -> f64) {
    let place = format!("{row} {column} ");
    edit(file, |i, line| match line.strip_prefix(&place) {
        Some(value) if i > 1 => format!("{place}{:e}", change(value.parse().unwrap())),
        _ => line.to_owned(),
    });
}

fn says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{message:?} does not say {part:?}");
    }
}

#[test]
fn the_block_itself_is_accepted() {
    assert_eq!(refusal(&|_, _| ()), "accepted");
}

#[test]
fn a_mass_that_is_missing_or_zero() {
    says(&refusal(&|folder, _| std::fs::remove_file(folder.join("m.mtx")).unwrap()), &["m.mtx", "cannot read"]);
    let op4 = |_: &Path, files: &mut MatrixFiles| {
        files.mass = data("op4/sparse_text_double.op4");
        files.mass_name = Some("MGG".into());
    };
    says(&refusal(&op4), &["sparse_text_double.op4", "no real square matrix MGG", "KAA, MAA, PHI (2 x 3", "mass_name"]);
    let unnamed = |_: &Path, files: &mut MatrixFiles| files.mass = data("op4/sparse_text_double.op4");
    says(&refusal(&unnamed), &["no single mass matrix", "KAA, MAA"]);
    let zero = |folder: &Path, _: &mut MatrixFiles| {
        edit(
            &folder.join("m.mtx"),
            |i, l| if i < 2 { l.into() } else { l.rsplit_once(' ').unwrap().0.to_owned() + " 0" },
        );
    };
    says(&refusal(&zero), &["the mass matrix is indefinite", "the whole matrix is zero"]);
}

#[test]
fn a_table_of_degrees_of_freedom_that_does_not_fit() {
    let short = |folder: &Path, _: &mut MatrixFiles| {
        let text = std::fs::read_to_string(folder.join("dofs.csv")).unwrap();
        let kept: Vec<&str> = text.lines().collect();
        std::fs::write(folder.join("dofs.csv"), kept[..kept.len() - 1].join("\n")).unwrap();
    };
    says(&refusal(&short), &["dofs.csv", "labels 134 rows", "has 135"]);
    let twice = |folder: &Path, _: &mut MatrixFiles| {
        edit(&folder.join("dofs.csv"), |i, l| if i == 2 { l.replace(",y,", ",x,") } else { l.into() });
    };
    says(&refusal(&twice), &["rows 1 and 2 are both node 1, x"]);
    let direction = |folder: &Path, _: &mut MatrixFiles| {
        edit(&folder.join("dofs.csv"), |i, l| if i == 2 { l.replace(",y,", ",7,") } else { l.into() });
    };
    says(&refusal(&direction), &["dofs.csv, line 3", "1 to 6, x, y, z, rx, ry, rz or modal"]);
    let moved = |folder: &Path, _: &mut MatrixFiles| {
        edit(&folder.join("dofs.csv"), |i, l| if i == 2 { "1,y,9,9,9".into() } else { l.into() });
    };
    says(&refusal(&moved), &["one place for node 1"]);
    let none = |_: &Path, files: &mut MatrixFiles| files.dofs = None;
    says(&refusal(&none), &["carry no labels", "`dofs`"]);
    let unplaced = |folder: &Path, _: &mut MatrixFiles| {
        edit(&folder.join("dofs.csv"), |_, l| l.split(',').take(2).collect::<Vec<_>>().join(","));
    };
    says(&refusal(&unplaced), &["row 1 is node 1, x", "has no coordinates"]);
    let other_mass = |folder: &Path, _: &mut MatrixFiles| {
        std::fs::write(folder.join("m.mtx"), "%%MatrixMarket matrix coordinate real symmetric\n2 2 1\n1 1 1\n")
            .unwrap();
    };
    says(&refusal(&other_mass), &["the mass matrix has 2 rows, the stiffness matrix 135"]);
}

#[test]
fn a_matrix_that_is_not_symmetric_or_not_definite() {
    let unsymmetric = |folder: &Path, _: &mut MatrixFiles| {
        let file = folder.join("k.mtx");
        let text = std::fs::read_to_string(&file).unwrap();
        let mut lines: Vec<String> = Vec::new();
        for line in text.lines().skip(2) {
            let f: Vec<&str> = line.split(' ').collect();
            lines.push(line.to_owned());
            if f[0] != f[1] {
                let value: f64 = f[2].parse().unwrap();
                lines.push(format!("{} {} {:e}", f[1], f[0], if f[..2] == ["4", "1"] { value + 1e6 } else { value }));
            }
        }
        let head = format!("%%MatrixMarket matrix coordinate real general\n135 135 {}\n", lines.len());
        std::fs::write(file, head + &lines.join("\n")).unwrap();
    };
    says(
        &refusal(&unsymmetric),
        &["k.mtx", "not symmetric", "node 1, x", "node 2, x", "mirrored", "1e-8 of the diagonal"],
    );
    let negative = |folder: &Path, _: &mut MatrixFiles| set(&folder.join("k.mtx"), 5, 5, |v| -v);
    says(&refusal(&negative), &["stiffness matrix is indefinite at row 5 (node 2, y)", "its diagonal is -"]);
    let coupled = |folder: &Path, _: &mut MatrixFiles| set(&folder.join("k.mtx"), 8, 7, |_| 1e13);
    says(&refusal(&coupled), &["stiffness matrix is indefinite", "eigenvalues are negative", "1e-9"]);
    let heavy = |folder: &Path, _: &mut MatrixFiles| set(&folder.join("m.mtx"), 4, 1, |_| 1.0);
    says(&refusal(&heavy), &["mass matrix is indefinite", "negative"]);
}

#[test]
fn a_part_that_is_held_in_part_or_hardly() {
    // A spring to ground in x alone, on node 1.
    let in_x = |folder: &Path, _: &mut MatrixFiles| set(&folder.join("k.mtx"), 1, 1, |v| 1.5 * v);
    says(&refusal(&in_x), &["leaves 5 of the six rigid motions free", "clamp the part"]);
    let soft = |folder: &Path, _: &mut MatrixFiles| set(&folder.join("k.mtx"), 1, 1, |v| v * (1.0 + 1e-6));
    says(&refusal(&soft), &["a rigid motion leaves forces of", "free = true or free = false"]);
    let said = |folder: &Path, files: &mut MatrixFiles| {
        set(&folder.join("k.mtx"), 1, 1, |v| v * (1.0 + 1e-8));
        files.free = Some(true);
    };
    assert_eq!(refusal(&said), "accepted");
}

#[test]
fn interfaces_that_cannot_be_formed() {
    let with = |nodes: &str, weights: InterfaceWeights| {
        let labels: Option<Vec<u64>> = nodes.split(',').map(|n| n.parse().ok()).collect();
        move |_: &Path, files: &mut MatrixFiles| {
            files.interfaces[0] = InterfaceNodes { labels: labels.clone(), weights: weights.clone() };
        }
    };
    says(
        &refusal(&with("1,2,99999", InterfaceWeights::Equal)),
        &["interface \"XMIN\"", "node 99999 has no coordinates"],
    );
    says(&refusal(&with("1,2,3", InterfaceWeights::Unsaid)), &["carry no weights", "weights = \"equal\""]);
    says(&refusal(&with("1,2,3", InterfaceWeights::Area)), &["needs a node set of the part's `mesh`"]);
    says(&refusal(&with("1,2,3", InterfaceWeights::Given(vec![1.0]))), &["1 weights for 3 nodes"]);
    says(&refusal(&with("1,2,3", InterfaceWeights::Equal)), &["not on one line"]);
    says(&refusal(&with("1,2,2", InterfaceWeights::Equal)), &["given twice"]);
    let unknown = |_: &Path, files: &mut MatrixFiles| files.sets = None;
    says(&refusal(&unknown), &["no node set \"XMIN\"", "`sets`"]);
    let stray = |folder: &Path, _: &mut MatrixFiles| {
        edit(&folder.join("sets.csv"), |i, l| if i == 1 { "XMIN,4711,1".into() } else { l.into() });
    };
    says(&refusal(&stray), &["set XMIN names node 4711"]);
    // Row 1 (node 1, x) is taken out of everything, and the interface still reads it.
    let without_row = |folder: &Path, _: &mut MatrixFiles| {
        for name in ["k.mtx", "m.mtx"] {
            let text = std::fs::read_to_string(folder.join(name)).unwrap();
            let kept: Vec<String> = text
                .lines()
                .skip(2)
                .filter_map(|l| {
                    let f: Vec<&str> = l.split(' ').collect();
                    let (i, j): (usize, usize) = (f[0].parse().unwrap(), f[1].parse().unwrap());
                    (i > 1 && j > 1).then(|| format!("{} {} {}", i - 1, j - 1, f[2]))
                })
                .collect();
            let head = format!("%%MatrixMarket matrix coordinate real symmetric\n134 134 {}\n", kept.len());
            std::fs::write(folder.join(name), head + &kept.join("\n")).unwrap();
        }
        let table = std::fs::read_to_string(folder.join("dofs.csv")).unwrap();
        let kept: Vec<&str> = table.lines().enumerate().filter(|(i, _)| *i != 1).map(|(_, l)| l).collect();
        std::fs::write(folder.join("dofs.csv"), kept.join("\n")).unwrap();
    };
    says(&refusal(&without_row), &["interface \"XMIN\"", "no row for node 1, x"]);
}

#[test]
fn an_unknown_format_and_broken_files() {
    let renamed = |folder: &Path, files: &mut MatrixFiles| {
        std::fs::rename(folder.join("k.mtx"), folder.join("k.rst")).unwrap();
        files.stiffness = folder.join("k.rst");
    };
    says(&refusal(&renamed), &["unknown matrix format \"rst\"", "mtx", "op4"]);
    let cut = |folder: &Path, _: &mut MatrixFiles| {
        let text = std::fs::read_to_string(folder.join("k.mtx")).unwrap();
        std::fs::write(folder.join("k.mtx"), &text[..text.len() / 2]).unwrap();
    };
    says(&refusal(&cut), &["k.mtx, line", "found"]);
    let complex = |folder: &Path, _: &mut MatrixFiles| {
        edit(&folder.join("k.mtx"), |i, l| if i == 0 { l.replace("real", "complex") } else { l.into() });
    };
    says(&refusal(&complex), &["k.mtx, line 1", "complex", "allowed"]);
    let not_full = |folder: &Path, files: &mut MatrixFiles| {
        std::fs::rename(folder.join("k.mtx"), folder.join("k.full")).unwrap();
        files.stiffness = folder.join("k.full");
    };
    says(&refusal(&not_full), &["k.full, word 0", "*EXPORT"]);
}

#[test]
fn the_machine_file_says_what_a_part_by_matrices_needs() {
    let (_, folder) = block();
    let interfaces = "interfaces = { XMIN = { nodes = \"XMIN\" } }";
    let files = "stiffness = \"k.mtx\", dofs = \"dofs.csv\", sets = \"sets.csv\"";
    let whole = format!("matrices = {{ {files}, mass = \"m.mtx\" }}\n{interfaces}");
    let machine = |part: &str| {
        let text = format!(
            "name = \"two\"\n[axes.z]\ndirection = [0, 0, 1]\ntravel = [0, 0.1]\nstep = 0.1\nmoves = [\"other\"]\n\
             [parts.block]\n{part}\n[parts.other]\n{whole}\n\
             [[joints]]\nname = \"spring\"\ntype = \"spring-damper\"\nbetween = [\"block.XMIN\", \"other.XMIN\"]\nstiffness = {{ x = 1e6 }}\n\
             [ports.tip]\ninterface = \"block.XMIN\"\ndirections = [\"x\"]\n[analysis]\nfrequencies = {{ from = 0, to = 100, step = 10 }}\ndamping = {{ ratio = 0.02 }}\n"
        );
        std::fs::write(folder.path().join("machine.toml"), text).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_stiffmap"));
        let output = command.arg("check").arg(folder.path()).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, said) = machine(&whole);
    assert_eq!(code, Some(0), "{said}");
    let (code, said) = machine(&format!("matrices = {{ {files} }}\n{interfaces}"));
    assert_eq!(code, Some(2));
    says(&said, &["machine.toml", "parts.block.matrices", "`mass` is missing"]);
    let (code, said) = machine(&format!("matrices = {{ {files}, mass = \"n.mtx\" }}\n{interfaces}"));
    assert_eq!(code, Some(2));
    says(&said, &["n.mtx does not exist"]);
    let (code, said) =
        machine(&format!("matrices = {{ {files}, mass = \"m.mtx\", damping = \"c.mtx\" }}\n{interfaces}"));
    assert_eq!(code, Some(2));
    says(&said, &["unknown key `damping`"]);
}

#[test]
fn rails_and_joints_that_single_nodes_or_bare_sets_cannot_serve() {
    let (machine, meshes) = slide::machine(true);
    let said = |which: usize, nodes: Option<Vec<u64>>| {
        let folder = folder();
        let mut machine = machine.clone();
        let part = &machine.parts[which];
        write_part(folder.path(), &Part { clamped: Vec::new(), ..part.clone() }, &meshes[which]);
        let mut given = files(folder.path(), part);
        if nodes.is_some() {
            given.interfaces[0].labels = nodes;
        }
        machine.parts[which] = by_matrices(part, given);
        let read = |i: usize| match i == which {
            true => read_part_mesh(&machine.parts[i]).unwrap_or_else(|e| panic!("{e}")),
            false => MeshFile { mesh: meshes[i].clone(), warnings: Vec::new() },
        };
        let files: Vec<MeshFile> = (0..2).map(read).collect();
        let pairs = machine.parts.iter().zip(&files);
        let centroids: Vec<Vec<[f64; 3]>> = pairs
            .map(|(p, f)| interface_motions(p, &f.mesh).unwrap().iter().map(|(_, m)| m.centroid).collect())
            .collect();
        check_travel(&machine, &files, &centroids).map_or_else(|e| e.to_string(), |_| "accepted".into())
    };
    says(&said(0, None), &["joint \"guide\"", "bed.YMAX", "without faces", "give the part's `mesh`"]);
    says(&said(1, Some(vec![1])), &["joint \"guide\"", "carriage.YMIN", "one node without rotations"]);
    assert_eq!(said(1, None), "accepted");
}

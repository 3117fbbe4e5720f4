//! Jobs that would not fit are refused by each command before anything long starts, and run with more memory.

use super::*;
use stiffmap::interrupt::Interrupt;

/// The program with at most so many kilobytes of data.
fn limited(kilobytes: u64, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("ulimit -d {kilobytes}; exec \"$0\" \"$@\"")]).arg(env!("CARGO_BIN_EXE_stiffmap"));
    let output = shell.args(arguments).env("RAYON_NUM_THREADS", "1").output().unwrap();
    (output.status.code(), said(&output), String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Refused with both figures and the limit below `little`, done with `enough`.
#[track_caller]
fn refused_then_done(arguments: &[&str], what: &str, advice: &str, [little, enough]: [u64; 2]) {
    let (code, said, _) = limited(little, arguments);
    assert_eq!(code, Some(1), "{said}");
    for expected in [what, " takes about ", "ulimit -d", advice] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
    let (code, said, _) = limited(enough, arguments);
    assert_eq!(code, Some(0), "control: {said}");
}

fn mill(file: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/vertical_mill").join(file).display().to_string()
}

#[test]
#[cfg(target_os = "linux")]
fn modes_of_a_mesh() {
    let column = mill("column.inp");
    let (code, said, _) = limited(850_000, &["modes", &column, "--modes", "120"]);
    assert_eq!(code, Some(1), "{said}");
    let expected = "120 modes of \"column\" with 39117 unknowns takes about ";
    assert!(said.contains(expected) && said.contains("ulimit -d") && said.contains("fewer modes"), "{said}");
    // Control: fewer take less. A limit that the matrix alone goes beyond is told before it is formed.
    let (code, said, _) = limited(850_000, &["modes", &column, "--modes", "2"]);
    assert_eq!(code, Some(0), "{said}");
    let (code, said, _) = limited(150_000, &["modes", &column, "--modes", "2"]);
    assert!(code == Some(1) && said.contains("the assembly of part \"column\""), "{said}");
}

#[test]
#[cfg(target_os = "linux")]
fn an_export_of_the_unreduced_machine() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().join("full").display().to_string();
    let full = ["export", "--format", "mtx", "--full", "--out", &folder];
    refused_then_done(&full, "the unreduced machine", "without --full", [600_000, 1_500_000]);
    let (code, said, _) = limited(200_000, &full);
    assert!(code == Some(1) && said.contains("the assembly of all parts"), "{said}");
    // A deck takes no more than the meshes.
    let deck = out.path().join("deck.inp").display().to_string();
    assert_eq!(limited(200_000, &["export", "--format", "inp", "--out", &deck]).0, Some(0));
}

#[test]
#[cfg(target_os = "linux")]
fn prepared_positions_of_a_sweep_by_both_routes() {
    for (route, families) in [("modes", true), ("coupling", false)] {
        let folder = tempfile::tempdir().unwrap();
        let many = r#"{ from = "300 mm", to = "-300 mm", step = "0.02 mm" }"#;
        let out = folder.path().join("out").display().to_string();
        let sweep = |positions: &str, limit: u64| {
            let study = study(folder.path(), positions, families).display().to_string();
            let words = ["sweep", &study, "--route", route, "--no-cache", "--no-figures", "--overwrite", "--out", &out];
            limited(limit, &words)
        };
        let (code, said, _) = sweep(many, 600_000);
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains("preparing 30001 positions takes about") && said.contains("fewer positions"), "{said}");
        let (code, said, _) = sweep("[0, 0.1]", 600_000);
        assert_eq!(code, Some(0), "control: {said}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn pictures_and_page_of_a_run() {
    let (machine, out) = (input("machine.toml").display().to_string(), tempfile::tempdir().unwrap());
    let folder = out.path().display().to_string();
    let run = ["run", &machine, "--no-cache", "--out", &folder];
    refused_then_done(&run, "pictures and page of 7 positions", "--no-figures", [400_000, 900_000]);
    let (code, said, _) = limited(400_000, &[&run[..], &["--no-figures"]].concat());
    assert_eq!(code, Some(0), "what is left out needs no room: {said}");
}

#[test]
#[cfg(target_os = "linux")]
fn check_says_what_the_reduction_takes_and_what_there_is() {
    let (code, said, told) = limited(4_000_000, &["check"]);
    assert_eq!(code, Some(0), "{said}");
    let line = told.lines().find(|line| line.starts_with("memory of the reduction: ")).unwrap();
    assert!(line.contains("column ") && line.contains("; left: 3.") && line.contains("ulimit -d"), "{line}");
    assert!(!told.contains("takes about"), "{told}");
    let (_, _, told) = limited(1_000_000, &["check"]);
    let expected = "warning: the reduction of part \"column\" with 37755 unknowns takes about ";
    assert!(told.contains(expected) && !told.contains("part \"headstock\" with"), "{told}");
}

#[test]
#[cfg(target_os = "linux")]
fn text_that_a_mesh_includes() {
    let folder = tempfile::tempdir().unwrap();
    let machine = edited(folder.path(), &[]);
    let comment = format!("** {}\n", "x".repeat(76));
    let mut tool = std::fs::read_to_string(input("tool.inp")).unwrap();
    for part in 0..60 {
        // Different files: one that is included again is held once.
        let text = format!("** {part}\n{}", comment.repeat(55_000));
        std::fs::write(folder.path().join(format!("part_{part}.inp")), text).unwrap();
        tool += &format!("*INCLUDE, INPUT=part_{part}.inp\n");
    }
    std::fs::write(folder.path().join("tool.inp"), tool).unwrap();
    let check = ["check", &machine.display().to_string()];
    refused_then_done(&check, "tool.inp:", "take out what the mesh does not need", [400_000, 1_000_000]);
}

#[test]
fn steps_side_by_side_are_stopped_without_the_job_and_with_it() {
    let job = Interrupt::default();
    let (some, others) = (job.within(), job.within());
    some.request();
    assert!(some.requested() && !job.requested() && !others.requested());
    job.request();
    assert!(others.requested());
}

#[test]
fn of_parts_side_by_side_the_one_that_failed_is_told() {
    use stiffmap::{machine::read_machine, pipeline, reduction::ReductionError};
    let machine = read_machine(Path::new(&mill("machine.toml"))).unwrap();
    let mut meshes = pipeline::read_meshes(&machine).unwrap();
    // A tetrahedron turned inside out in the second largest part: the largest, which was begun before, is stopped.
    let mut order: Vec<usize> = (0..meshes.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(meshes[i].mesh.nodes.len()));
    let broken = order[1];
    meshes[broken].mesh.cells[0].nodes.swap(0, 1);
    let interrupt = Interrupt::default();
    let failed = pipeline::reduce_parts(&machine, &meshes, None, &interrupt, &|| ()).unwrap_err();
    assert!(!matches!(failed, pipeline::PipelineError::Interrupted), "{failed}");
    assert!(!matches!(failed, pipeline::PipelineError::Reduction(ReductionError::Memory(_))), "{failed}");
    assert!(failed.to_string().contains(&machine.parts[broken].name) && !interrupt.requested(), "{failed}");
}

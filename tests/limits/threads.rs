//! Results do not depend on the number of threads, bit for bit.

use super::*;
use nalgebra::DMatrix;
use stiffmap::linalg::{multiply, multiply_transposed};

#[test]
fn every_file_is_the_same_on_any_number_of_threads() {
    let path =
        ["--linear", "--force", "tool.x:sine,amplitude=10,frequency=100", "--path", "0.1:0.12", "--feed-rate", "30"];
    let jobs: [(&str, &[&str]); 3] =
        [("run", &[]), ("simulate", &["--impulse", "--linear", "--duration", "0.05"]), ("simulate", &path)];
    for (command, arguments) in jobs {
        let mut first: Option<Vec<(String, Vec<u8>)>> = None;
        for threads in ["1", "2", "3", "4", "7"] {
            let out = tempfile::tempdir().unwrap();
            let mut job = program();
            job.arg(command).arg(input("machine.toml")).args(arguments);
            job.args(["--no-cache", "--no-figures", "--out"]).arg(out.path()).env("RAYON_NUM_THREADS", threads);
            let output = job.output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{command}: {}", said(&output));
            let found = results(out.path());
            assert!(!found.is_empty());
            match &first {
                None => first = Some(found),
                Some(first) => {
                    let differ = first.iter().zip(&found).filter(|(a, b)| a != b).map(|(a, _)| &a.0);
                    let differ: Vec<&String> = differ.collect();
                    assert!(differ.is_empty() && first.len() == found.len(), "{command}, {threads}: {differ:?}");
                }
            }
        }
    }
}

/// Files of each job on 1, 2, 3 and 7 threads, all the same.
fn alike(command: &str, job: impl Fn(&Path) -> Command) {
    let mut first: Option<Vec<(String, Vec<u8>)>> = None;
    for threads in ["1", "2", "3", "7"] {
        let out = tempfile::tempdir().unwrap();
        let output = job(out.path()).env("RAYON_NUM_THREADS", threads).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{command}: {}", said(&output));
        let found = results(out.path());
        assert!(!found.is_empty(), "{command}");
        let first = first.get_or_insert_with(|| found.clone());
        let differ: Vec<&String> = first.iter().zip(&found).filter(|(a, b)| a != b).map(|(a, _)| &a.0).collect();
        assert!(differ.is_empty() && first.len() == found.len(), "{command}, {threads} threads: {differ:?}");
    }
}

#[test]
fn tables_of_sweeps_and_searches_are_the_same_on_any_number_of_threads() {
    for (command, route, families) in [
        ("sweep", "modes", true),
        ("sweep", "coupling", false),
        ("optimise", "modes", true),
        ("optimise", "coupling", false),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let study = study(folder.path(), "[0.2, 0, -0.1]", families);
        alike(&format!("{command} by {route}"), |out| {
            let mut job = program();
            job.arg(command).arg(&study).args(["--route", route, "--no-cache", "--out"]).arg(out);
            if command == "sweep" {
                job.args(["--backend", "cpu", "--maps", "1", "--sensitivities=2"]);
            }
            job
        });
    }
}

#[test]
fn exports_are_the_same_on_any_number_of_threads() {
    for form in [&["mtx"][..], &["mtx", "--full"], &["mtx", "--part", "carriage"]] {
        alike(&format!("export {form:?}"), |out| {
            let mut job = program();
            // Exports use the cache: an empty one, so that each reduces the parts itself.
            job.env("STIFFMAP_CACHE", out.join("cache"));
            job.arg("export").arg(input("machine.toml")).arg("--format").args(form).arg("--out").arg(out);
            job
        });
    }
}

#[test]
fn pictures_and_page_of_a_result_are_the_same_on_any_number_of_threads() {
    let result = tempfile::tempdir().unwrap();
    let mut job = program();
    job.arg("run").arg(input("machine.toml")).args(["--no-cache", "--backend", "cpu", "--out"]).arg(result.path());
    let output = job.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    alike("figures", |out| {
        for entry in std::fs::read_dir(result.path()).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                std::fs::copy(&path, out.join(path.file_name().unwrap())).unwrap();
            }
        }
        let mut job = program();
        job.arg("figures").arg(out);
        job
    });
}

/// A matrix of numbers in (-1, 1) without a pattern.
fn matrix(rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |i, j| {
        ((i * 7919 + j * 104_729 + 13) as f64 * 0.618_033_988_749).fract() * 2.0 - 1.0
    })
}

fn on(threads: usize, work: impl FnOnce() -> DMatrix<f64> + Send) -> DMatrix<f64> {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

#[test]
fn products_large_enough_to_be_cut_are_the_same_on_any_number_of_threads_and_right() {
    let (tall, wide) = (matrix(20_000, 90), matrix(90, 40));
    let many = matrix(20_000, 130);
    let product = |threads| (on(threads, || multiply(&tall, &wide)), on(threads, || multiply_transposed(&many, &tall)));
    let (a, b) = product(1);
    for threads in [2, 3, 8] {
        assert!(product(threads) == (a.clone(), b.clone()), "{threads} threads");
    }
    // By nalgebra, which sums in another order: equal to rounding, and not to the bit (the control of equality).
    let (ours, theirs) = (multiply_transposed(&many, &tall), many.transpose() * &tall);
    assert!((&a - &tall * &wide).amax() < 1e-12 && (&b - &theirs).amax() < 1e-10);
    assert!(ours != theirs, "control: another order of summation shows");
}

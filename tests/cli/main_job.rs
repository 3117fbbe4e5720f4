//! `stiffmap run` on the bundled mill: its files, its words, its cache.

use super::*;

const FILES: [&str; 8] = [
    "compliance.mat",
    "eigenfrequencies.csv",
    "manifest.json",
    "mode_table.csv",
    "state_space.mat",
    "surface_xx.csv",
    "surface_yy.csv",
    "surface_zz.csv",
];
const REPORT: [&str; 8] = [
    "modal_database.bin",
    "mode_shapes_z_-300_mm.vtu",
    "mode_shapes_z_-600_mm.vtu",
    "mode_shapes_z_0_mm.vtu",
    "report.html",
    "surface_xx.vts",
    "surface_yy.vts",
    "surface_zz.vts",
];
const PICTURES: [&str; 9] = [
    "figures/eigenfrequencies.png",
    "figures/frf_xx_amplitude.png",
    "figures/frf_xx_frequency.png",
    "figures/frf_yy_amplitude.png",
    "figures/frf_yy_frequency.png",
    "figures/frf_zz_amplitude.png",
    "figures/frf_zz_frequency.png",
    "figures/impulse_frequency.png",
    "figures/impulse_time.png",
];

fn assert_checks_passed(manifest: &Value, at_least: usize) {
    let checks = manifest["checks"].as_array().unwrap();
    assert!(checks.len() >= at_least, "{checks:?}");
    for check in checks {
        assert_eq!(check["passed"], true, "{check}");
        let (figure, bound) = (check["figure"].as_f64(), check["bound"].as_f64());
        assert!(figure.unwrap() <= bound.unwrap(), "{check}");
    }
}

#[test]
fn a_cold_and_a_warm_run_deliver_every_file_and_the_same_numbers() {
    let cache = tempfile::tempdir().unwrap();
    let (cold, warm) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());

    let run = run_into(cache.path(), cold.path(), &[]);
    let said = stderr(&run);
    assert_eq!(run.status.code(), Some(0), "{said}");
    assert!(run.stdout.is_empty(), "{}", stdout(&run));
    for words in [
        "reduce parts",
        "reduction's error",
        "family    min Hz    max Hz",
        "spindle turns about z",
        "smallest dynamic stiffness",
        "back end",
        &*cold.path().to_string_lossy(),
    ] {
        assert!(said.contains(words), "{words:?} is missing in: {said}");
    }

    let mut expected: Vec<PathBuf> = FILES.iter().chain(&PICTURES).chain(&REPORT).map(PathBuf::from).collect();
    expected.extend(PICTURES.map(|p| Path::new(p).with_extension("svg")));
    expected.sort();
    assert_eq!(files_below(cold.path()), expected);
    for picture in PICTURES {
        let bytes = std::fs::read(cold.path().join(picture)).unwrap();
        assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"), "{picture}");
    }
    let record = manifest(cold.path());
    let listed: Vec<&str> = record["files"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    assert!(expected.iter().all(|f| listed.contains(&&*f.to_string_lossy())), "{listed:?}");
    assert_eq!(listed.len(), expected.len());
    assert_eq!(record["counts"]["parts_from_cache"], 0);
    assert_eq!(record["counts"]["positions"], 121);
    assert_eq!(record["counts"]["nodes"], 30632);
    assert_checks_passed(&record, 3);
    assert_eq!(superelements(cache.path()).len(), 5);
    assert!(files_below(cache.path()).iter().all(|f| !f.to_string_lossy().contains("tmp")));

    let run = run_into(cache.path(), warm.path(), &["--no-figures"]);
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    let record = manifest(warm.path());
    assert_eq!(record["counts"]["parts_from_cache"], 5);
    assert_checks_passed(&record, 2);
    for name in FILES.iter().filter(|name| name.ends_with(".csv")) {
        let read = |folder: &TempDir| std::fs::read(folder.path().join(name)).unwrap();
        assert!(read(&cold) == read(&warm), "{name} differs between a cold and a warm run");
    }
}

#[test]
fn the_csv_files_hold_what_their_headers_say() {
    let out = tempfile::tempdir().unwrap();
    quick(out.path(), &["--positions", "0,-0.3", "--frequencies", "0,40,80"]);
    let header = |name: &str| {
        let text = std::fs::read_to_string(out.path().join(name)).unwrap();
        text.lines().next().unwrap().to_owned()
    };
    assert_eq!(header("eigenfrequencies.csv"), "position_m,family,rank,frequency_hz,damping_ratio,reduction_error");
    assert_eq!(
        header("mode_table.csv"),
        "family,min_hz,max_hz,difference_percent,position_of_min_m,position_of_max_m,interior_extremum,reduction_error"
    );
    let frequencies = column(&out.path().join("eigenfrequencies.csv"), "frequency_hz");
    // At each position the free rotation of the spindle and 30 elastic modes.
    assert_eq!(frequencies.len(), 2 * 31);
    assert_eq!((frequencies[0], frequencies[31]), (0.0, 0.0));
    assert!(frequencies[1] > 10.0 && frequencies[30] < 900.0);
    for surface in ["surface_xx.csv", "surface_yy.csv", "surface_zz.csv"] {
        let file = out.path().join(surface);
        assert_eq!(column(&file, "position_m"), [0.0, 0.0, 0.0, -0.3, -0.3, -0.3]);
        assert_eq!(column(&file, "frequency_hz"), [0.0, 40.0, 80.0, 0.0, 40.0, 80.0]);
        assert!(column(&file, "magnitude_m_per_N").iter().all(|h| *h > 0.0));
    }
}

#[test]
fn out_that_is_a_file_is_refused_before_the_long_computation() {
    let (folder, cache) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let out = folder.path().join("out");
    std::fs::write(&out, "mine").unwrap();
    let run = run_into(cache.path(), &out, &[]);
    let said = stderr(&run);
    assert!(matches!(run.status.code(), Some(1 | 2)), "{said}");
    assert!(said.contains("--out") && said.contains(&*out.to_string_lossy()), "{said}");
    assert!(!said.contains("reduce parts"), "{said}");
    assert!(superelements(cache.path()).is_empty());
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "mine");
}

#[test]
fn no_cache_leaves_the_cache_alone() {
    let (out, cache) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let run = run_into(cache.path(), out.path(), &["--no-cache", "--no-figures", "--positions", "0"]);
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    assert!(files_below(cache.path()).is_empty());
    assert!(!out.path().join("figures").exists());
}

//! `check`, `init`, `devices`, `bench`.

use super::*;

#[test]
fn check_prints_parts_joints_axis_and_ports() {
    let cache = tempfile::tempdir().unwrap();
    let check = stiffmap(cache.path()).arg("check").output().unwrap();
    assert_eq!(check.status.code(), Some(0), "{}", stderr(&check));
    let said = stdout(&check);
    // Nodes, elements, unknowns, kilograms.
    for (part, counts) in [
        ("column", ["13039", "6629", "37755", "1068.96"]),
        ("headstock", ["6629", "3450", "19887", "464.87"]),
        ("spindle", ["7338", "3991", "22014", "20.91"]),
        ("drive", ["1744", "862", "5232", "46.64"]),
        ("magazine", ["1882", "941", "5646", "204.86"]),
    ] {
        let line = said.lines().find(|l| l.starts_with(part)).unwrap_or_else(|| panic!("no {part}: {said}"));
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(words[1..5], counts, "{line}");
    }
    for words in [
        "L 0.3600 m at 0 m (733.0 N/um)",
        "L 0.9600 m at -0.6 m (274.9 N/um)",
        "footprint 90.0 mm",
        "121 stations",
        "moves headstock, spindle, drive",
        "port tool: spindle.nose, x, y, z",
        "unknowns before the reduction: 90534",
        "coordinates after",
    ] {
        assert!(said.contains(words), "{words:?} is missing in: {said}");
    }
    assert!(files_below(cache.path()).is_empty(), "nothing is solved and nothing kept");
}

#[test]
fn init_writes_the_mill_once() {
    let (folder, cache) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mill = folder.path().join("a/mill");
    let init = || stiffmap(cache.path()).arg("init").arg(&mill).output().unwrap();
    assert_eq!(init().status.code(), Some(0));
    let expected = [
        "column.inp",
        "drive.inp",
        "headstock.inp",
        "machine.toml",
        "magazine.inp",
        "screw.toml",
        "spindle.inp",
        "study.toml",
    ];
    let found = files_below(&mill);
    assert!(expected.iter().all(|name| found.contains(&PathBuf::from(name))), "{found:?}");

    // One file of another's is enough to refuse, and it keeps its content.
    std::fs::remove_file(mill.join("machine.toml")).unwrap();
    std::fs::write(mill.join("magazine.inp"), "mine").unwrap();
    let again = init();
    assert_eq!(again.status.code(), Some(2));
    let said = stderr(&again);
    assert!(said.contains(" exists; ") && said.contains("choose an empty folder"), "{said}");
    assert_eq!(std::fs::read_to_string(mill.join("magazine.inp")).unwrap(), "mine");
    assert!(!mill.join("machine.toml").exists());
}

#[test]
fn the_written_mill_is_the_bundled_one() {
    let (mill, out) = (Mill::new(), tempfile::tempdir().unwrap());
    let mut run = stiffmap(warm_cache());
    run.arg("run").arg(mill.0.path()).args(["--no-figures", "--position", "0", "--out"]).arg(out.path());
    let run = run.output().unwrap();
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    // The content is hashed, not the folder.
    assert_eq!(manifest(out.path())["counts"]["parts_from_cache"], 5);
}

#[test]
fn devices_prints_a_list() {
    let cache = tempfile::tempdir().unwrap();
    let devices = stiffmap(cache.path()).args(["devices", "--json"]).output().unwrap();
    assert_eq!(devices.status.code(), Some(0), "{}", stderr(&devices));
    let list: Value = serde_json::from_str(&stdout(&devices)).unwrap();
    let list = list.as_array().unwrap();
    let required = std::env::var("STIFFMAP_GPU").is_ok_and(|v| v == "require");
    assert!(!required || !list.is_empty(), "STIFFMAP_GPU=require and no adapter");
    for adapter in list {
        for key in ["name", "backend", "kind", "driver"] {
            assert!(adapter[key].as_str().is_some_and(|v| !v.is_empty()), "{key}: {adapter}");
        }
        assert!(adapter["f64"].is_boolean());
        for key in ["max_storage_binding", "max_buffer", "max_workgroups", "max_invocations"] {
            assert!(adapter[key].as_u64().is_some_and(|v| v > 0), "{key}: {adapter}");
        }
    }
    let mut none = stiffmap(cache.path());
    none.args(["devices", "--json"]).env("VK_DRIVER_FILES", "/nonexistent");
    let none = none.env("VK_ICD_FILENAMES", "/nonexistent").output().unwrap();
    assert_eq!(none.status.code(), Some(0), "none is a finding");
    if cfg!(target_os = "linux") {
        assert_eq!(stdout(&none).trim(), "[]");
    }
}

#[test]
fn bench_prints_a_row_a_back_end() {
    let cache = tempfile::tempdir().unwrap();
    let sizes = ["--positions", "3", "--frequencies", "50", "--modes", "4", "--repetitions", "1"];
    let bench = stiffmap(cache.path()).arg("bench").args(sizes).arg("--json").output().unwrap();
    assert_eq!(bench.status.code(), Some(0), "{}", stderr(&bench));
    let rows: Value = serde_json::from_str(&stdout(&bench)).unwrap();
    let rows = rows.as_array().unwrap();
    assert!(rows.iter().any(|row| row["backend"] == "cpu" && row["precision"] == "f64"), "{rows:?}");
    for row in rows {
        assert_eq!((&row["positions"], &row["frequencies"], &row["modes"]), (&3.into(), &50.into(), &4.into()));
        assert!(row["device"].as_str().is_some_and(|d| !d.is_empty()));
        for key in ["median_seconds", "pairs_per_second", "values_per_second", "flops_per_second", "bytes_per_second"] {
            assert!(row[key].as_f64().is_some_and(|v| v > 0.0), "{key}: {row}");
        }
    }
    let refused = stiffmap(cache.path()).args(["bench", "--repetitions", "0"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("--repetitions: 0 is not allowed"));
}

#[test]
fn help_and_version_go_to_stdout() {
    for flag in ["--help", "--version"] {
        let said = stiffmap(Path::new("unused")).arg(flag).output().unwrap();
        assert_eq!(said.status.code(), Some(0));
        assert!(stdout(&said).contains("stiffmap"));
    }
}

#[test]
fn modes_prints_the_frequencies_of_a_deck_and_refuses_what_it_cannot() {
    let (folder, cache) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let text = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n*ELEMENT,TYPE=C3D8,ELSET=E\n\
                1,1,2,3,4,5,6,7,8\n*MATERIAL,NAME=M\n*ELASTIC\n1,0\n*DENSITY\n1\n*SOLID SECTION,ELSET=E,MATERIAL=M\n\
                *STEP\n*FREQUENCY\n9\n*END STEP\n";
    let modes = |text: &str, arguments: &[&str]| {
        let deck = folder.path().join("cube.inp");
        std::fs::write(&deck, text).unwrap();
        stiffmap(cache.path()).arg("modes").arg(&deck).args(arguments).output().unwrap()
    };
    let run = modes(text, &[]);
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    let said = stdout(&run);
    assert_eq!(said.matches("rigid motion").count(), 6, "{said}");
    assert!(said.contains("cube.inp: 8 nodes, 1 elements, 27 unknowns, mass 1.0"), "{said}");
    assert!(stderr(&run).contains("C3D8 is read as C3D8I"), "{}", stderr(&run));
    // Of 27 unknowns three combinations have no mass. The cube's shear modes are a multiple root, of more members than a
    // block has vectors: any number may be asked for.
    for wanted in [1, 6, 7, 9, 12, 13, 19, 20, 21, 23, 24, 30] {
        let json = modes(text, &["--json", "--modes", &wanted.to_string()]);
        assert_eq!(json.status.code(), Some(0), "{wanted}: {}", stderr(&json));
        let json: Value = serde_json::from_slice(&json.stdout).unwrap();
        let found = (json["frequencies"].as_array().unwrap().len(), json["rigid"].as_u64());
        assert_eq!(found, (wanted.min(24), Some(wanted.min(6) as u64)));
    }
    let none: &[&str] = &[];
    for (text, arguments, words) in [
        (text.replace("*FREQUENCY\n9", "*STATIC"), none, "first step is *STATIC"),
        (text.replace("*STEP", "*TIE, NAME=T\n*STEP"), none, "*TIE"),
        (text.to_owned(), &["--modes", "0"][..], "at least 1"),
        (
            text.replace("*STEP", "*BOUNDARY\n1,1,3\n2,1,3\n3,1,3\n4,1,3\n5,1,3\n6,1,3\n7,1,3\n8,1,3\n*STEP"),
            none,
            "every displacement is held",
        ),
    ] {
        let refused = modes(&text, arguments);
        assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
        assert!(stderr(&refused).contains(words) && refused.stdout.is_empty(), "{}", stderr(&refused));
    }
    assert!(files_below(cache.path()).is_empty());
}

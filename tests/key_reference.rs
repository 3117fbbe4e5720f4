//! docs/machine_file.md and docs/study_file.md against the readers, both ways: what a reader accepts in a table is what
//! the document lists for it.
//!
//! A reader that meets an unknown key says which keys it knows there. So each table gets one key that nobody knows, and
//! the list in the refusal is compared with the document's.

#[path = "machine_file/full.rs"]
mod full;

use full::{FULL, folder_with_all, read_full};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use stiffmap::machine::MachineError;
use stiffmap::sweep::{StudyError, read_study};

type Keys = BTreeSet<String>;

/// The keys of each table of a document, by the text of its heading.
fn documented(name: &str) -> BTreeMap<String, Keys> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(name);
    let text = std::fs::read_to_string(file).unwrap();
    let mut tables: BTreeMap<String, Keys> = BTreeMap::new();
    let mut heading = String::new();
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("##") {
            heading = title.trim_start_matches('#').trim().replace('`', "");
        } else if let Some(key) = line.strip_prefix("| `").and_then(|rest| rest.split('`').next()) {
            tables.entry(heading.clone()).or_default().insert(key.to_owned());
        }
    }
    tables
}

fn keys(error: &MachineError) -> Keys {
    match error {
        MachineError::UnknownKey { key, allowed, .. } if key == "zzz" => {
            allowed.iter().map(|key| (*key).to_owned()).collect()
        }
        other => panic!("expected an unknown key, not: {other}"),
    }
}

const GRID: &str = "{ grid = \"uniform\", from = \"0 Hz\", to = \"900 Hz\", step = \"1 Hz\" }";

/// Heading, and for each form of the table: what is replaced in the full machine, by what with the unknown key.
type Probe = (&'static [&'static str], &'static [(&'static str, &'static str)]);

const MACHINE: &[Probe] = &[
    (&["Top level"], &[("name = \"full\"", "name = \"full\"\nzzz = 1")]),
    (&["[axes.NAME]"], &[("step = \"5 mm\"", "step = \"5 mm\"\nzzz = 1")]),
    (&["[parts.NAME]"], &[("plain_bricks = true", "plain_bricks = true\nzzz = 1")]),
    (&["orientation"], &[("{ x = [0, 1, 0], z", "{ zzz = 1, x = [0, 1, 0], z")]),
    (&["material"], &[("poisson = 0.26", "poisson = 0.26, zzz = 1")]),
    (&["supported"], &[("{ nodes = \"EDGE\"", "{ zzz = 1, nodes = \"EDGE\"")]),
    (&["[parts.NAME.interfaces]"], &[("weights = \"equal\"", "weights = \"equal\", zzz = 1")]),
    (&["within"], &[("{ axis = \"z\"", "{ zzz = 1, axis = \"z\""), ("{ x = [\"10", "{ zzz = 1, x = [\"10")]),
    (&["matrices"], &[("dofs = \"dofs.csv\"", "dofs = \"dofs.csv\"\nzzz = 1")]),
    (&["[[joints]]", "linear-guide"], &[("footprint", "zzz = 1\nfootprint")]),
    (&["[[joints]]", "ball-screw"], &[("diameter", "zzz = 1\ndiameter")]),
    (&["[[joints]]", "bearing"], &[("axis = \"y\"", "axis = \"y\"\nzzz = 1")]),
    (&["[[joints]]", "bolted"], &[("type = \"bolted\"", "type = \"bolted\"\nzzz = 1")]),
    (&["[[joints]]", "spring-damper"], &[("type = \"spring-damper\"", "type = \"spring-damper\"\nzzz = 1")]),
    (&["stiffness, damping"], &[("{ x = \"77 N/um\"", "{ zzz = 1, x = \"77 N/um\"")]),
    (&["stiffness, damping of a bearing"], &[("{ radial = \"120", "{ zzz = 1, radial = \"120")]),
    (&["friction"], &[("{ coulomb", "{ zzz = 1, coulomb")]),
    (&["[ports.NAME]"], &[("input = true", "zzz = 1\ninput = true")]),
    (&["[analysis]"], &[("modes = 12", "modes = 12\nzzz = 1")]),
    (&["component"], &[("{ modes = 10", "{ zzz = 1, modes = 10")]),
    (
        &["frequencies"],
        &[
            (GRID, "{ zzz = 1, from = 0, to = 9, step = 1 }"),
            (GRID, "{ zzz = 1, grid = \"logarithmic\", from = 1, to = 9, count = 5 }"),
            (GRID, "{ zzz = 1, grid = \"clustered\", from = 0, to = 9 }"),
        ],
    ),
    (&["damping of [analysis]"], &[("{ ratio = 0.02", "{ zzz = 1, ratio = 0.02")]),
    (&["rayleigh"], &[("{ alpha = 1", "{ zzz = 1, alpha = 1")]),
];

#[test]
fn the_machine_file_takes_what_its_document_lists_and_nothing_else() {
    let mut tables = documented("machine_file.md");
    let text = FULL;
    let mut seen = BTreeSet::new();
    for (headings, forms) in MACHINE {
        let mut known = Keys::new();
        for (from, to) in *forms {
            assert!(text.contains(from), "{from:?} is not in the full machine");
            known.extend(keys(&read_full(&text.replacen(from, to, 1)).unwrap_err()));
        }
        let told: Keys = headings.iter().flat_map(|heading| &tables[*heading]).cloned().collect();
        assert_eq!(known, told, "{headings:?}: what the reader knows, and what the document lists");
        seen.extend(headings.iter().copied());
    }
    tables.retain(|heading, _| !seen.contains(heading.as_str()));
    assert!(tables.is_empty(), "tables of the document that no reader was asked about: {tables:?}");
}

const STUDY: &str = r#"name = "study"
machine = "machine.toml"
positions = { from = 0, to = -0.1, step = 0.1 }
band = { from = 0, to = 900 }
damping = { ratio = 0.02 }
[variables.screw]
path = "joints.screw.diameter"
range = ["20 mm", "40 mm"]
[sampling]
method = "sobol"
designs = 4
[metrics.dyn]
kind = "dynamic-stiffness"
directions = ["x"]
[metrics.first]
kind = "eigenfrequency"
families = [1]
[cost]
unit = "EUR"
terms = { screw = { per = "1 mm", costs = 1 } }
[bounds.dyn_x]
min = "1 N/um"
[objectives]
dyn_x = "maximise"
[optimise]
step = 0.3
"#;

const STUDY_PROBES: &[Probe] = &[
    (&["Top level of a study"], &[("name = \"study\"", "name = \"study\"\nzzz = 1")]),
    (&["[variables.NAME]"], &[("path = ", "zzz = 1\npath = ")]),
    (&["[sampling]"], &[("designs = 4", "designs = 4\nzzz = 1")]),
    (&["[metrics.NAME]"], &[("directions = ", "zzz = 1\ndirections = "), ("families = ", "zzz = 1\nfamilies = ")]),
    (&["[cost]"], &[("unit = \"EUR\"", "unit = \"EUR\"\nzzz = 1")]),
    (&["[cost.terms]"], &[("costs = 1", "costs = 1, zzz = 1")]),
    (&["[bounds.METRIC]"], &[("min = \"1 N/um\"", "min = \"1 N/um\"\nzzz = 1")]),
    (&["positions"], &[("{ from = 0, to = -0.1", "{ zzz = 1, from = 0, to = -0.1")]),
    (&["[band]"], &[("{ from = 0, to = 900", "{ zzz = 1, from = 0, to = 900")]),
    (&["[optimise]"], &[("step = 0.3", "step = 0.3\nzzz = 1")]),
];

#[test]
fn the_study_file_takes_what_its_document_lists_and_nothing_else() {
    let folder = folder_with_all(FULL);
    let study = folder.path().join("study.toml");
    let read = |text: &str| {
        std::fs::write(&study, text).unwrap();
        read_study(&study)
    };
    read(STUDY).unwrap();
    let mut tables = documented("study_file.md");
    for (headings, forms) in STUDY_PROBES {
        let mut known = Keys::new();
        for (from, to) in *forms {
            assert!(STUDY.contains(from), "{from:?} is not in the study");
            match read(&STUDY.replacen(from, to, 1)).unwrap_err() {
                StudyError::File(error) => known.extend(keys(&error)),
                other => panic!("{other}"),
            }
        }
        let told = tables.remove(headings[0]).unwrap_or_default();
        assert_eq!(known, told, "{headings:?}: what the reader knows, and what the document lists");
    }
    assert!(tables.is_empty(), "tables of the document that no reader was asked about: {tables:?}");
}

#[test]
fn every_key_that_a_reader_names_stands_in_a_document() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let listed: Keys = ["machine_file.md", "study_file.md"]
        .into_iter()
        .flat_map(|name| documented(name).into_values())
        .flatten()
        .collect();
    let mut named = Keys::new();
    for folder in ["src/machine", "src/sweep"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
            for call in [".get(\"", ".need(\""] {
                named.extend(text.split(call).skip(1).filter_map(|rest| rest.split('"').next()).map(str::to_owned));
            }
        }
    }
    assert!(named.len() > 60, "only {named:?}");
    let missing: Vec<&String> = named.difference(&listed).collect();
    assert!(missing.is_empty(), "in no document: {missing:?}");
}

#[test]
fn negative_control_a_key_too_few_or_too_many_in_the_document_is_noticed() {
    let tables = documented("machine_file.md");
    let known = keys(&read_full(&FULL.replacen("footprint", "zzz = 1\nfootprint", 1)).unwrap_err());
    let own = &tables["linear-guide"];
    assert!(own.contains("footprint") && known.contains("footprint") && !known.contains("diameter"));
    assert_ne!(&known, own, "the keys of every joint are in another table");
}

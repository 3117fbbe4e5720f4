//! Where the warnings are said: by check, by run and sweep before they compute, and in the manifest.

use super::mill;
use std::path::Path;
use std::process::{Command, Output};

fn stiffmap(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiffmap"));
    command.current_dir(folder).env("STIFFMAP_CACHE", folder.join("cache")).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

const SCREW: (&str, &str) = ("diameter = \"25 mm\"", "diameter = 25");
const WORDS: &str =
    "joints[5] \"screw\".diameter: 25 m; usual: 0.3 mm to 2 m for a ball screw's diameter; likely metres";

#[test]
fn check_says_it_beside_what_it_understood_and_before_a_refusal() {
    let folder = mill(&[SCREW]);
    let check = stiffmap(folder.path(), &["check", "machine.toml"]);
    assert_eq!(check.status.code(), Some(0), "{}", text(&check.stderr));
    assert!(text(&check.stdout).contains(&format!("warning: {WORDS}")), "{}", text(&check.stdout));
    let folder = mill(&[]);
    let check = stiffmap(folder.path(), &["check", "machine.toml"]);
    assert!(!text(&check.stdout).contains("warning"), "{}", text(&check.stdout));
    // A travel in metres leaves the rail: refused, and the reason is said.
    let folder = mill(&[("[\"0 mm\", \"400 mm\"]", "[0, 400]")]);
    let check = stiffmap(folder.path(), &["check", "machine.toml"]);
    let said = text(&check.stderr);
    assert_eq!(check.status.code(), Some(2), "{said}");
    assert!(said.contains("leaves the rail") && said.contains("warning: axes.x.travel"), "{said}");
}

#[test]
fn run_says_it_first_and_its_manifest_keeps_it_with_what_the_modes_tell() {
    let damper = ("{ y = \"2000 N s/m\"", "{ y = \"1e5 N s/mm\"");
    let edits = [damper, ("friction = { coulomb = \"50 N\", breakaway = \"80 N\", stribeck = \"1 mm/s\" }", "")];
    for (edits, expected) in [(&edits[..], 2), (&edits[1..], 0)] {
        let folder = mill(edits);
        let arguments = ["run", "machine.toml", "--no-figures", "--position", "0", "--modes", "12", "--out", "out"];
        let run = stiffmap(folder.path(), &arguments);
        let said = text(&run.stderr);
        assert_eq!(run.status.code(), Some(0), "{said}");
        let manifest = std::fs::read_to_string(folder.path().join("out/manifest.json")).unwrap();
        let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
        let warnings: Vec<&str> = manifest["warnings"].as_array().unwrap().iter().filter_map(|w| w.as_str()).collect();
        let of_damping: Vec<_> = warnings.iter().filter(|w| w.contains("a damping ratio of")).collect();
        assert_eq!(of_damping.len(), expected, "{warnings:#?}");
        for warning in of_damping {
            assert!(said.contains(*warning), "{said}");
        }
    }
}

#[test]
fn a_sweep_says_what_its_designs_would_be() {
    let folder = mill(&[]);
    let study = |range: &str| {
        format!(
            "name = \"screws\"\nmachine = \"machine.toml\"\npositions = [0]\n\
             [variables.screw]\npath = \"joints.screw.diameter\"\nrange = {range}\n\
             [sampling]\nmethod = \"latin-hypercube\"\ndesigns = 2\nseed = 1\n\
             [metrics.dyn]\nkind = \"dynamic-stiffness\"\ndirections = [\"x\"]\n"
        )
    };
    for (range, warned) in [("[\"20 mm\", 25]", true), ("[\"20 mm\", \"25 mm\"]", false)] {
        std::fs::write(folder.path().join("study.toml"), study(range)).unwrap();
        let out = if warned { "warned" } else { "quiet" };
        let sweep = stiffmap(folder.path(), &["sweep", "study.toml", "--no-figures", "--out", out]);
        let said = text(&sweep.stderr);
        assert_eq!(sweep.status.code(), Some(0), "{said}");
        let words = format!("at an end of the study's ranges, {WORDS}");
        let manifest = std::fs::read_to_string(folder.path().join(out).join("manifest.json")).unwrap();
        let kept = manifest.replace("\\\"", "\"").contains(&words);
        assert_eq!((said.contains(&words), kept), (warned, warned), "{said}\n{manifest}");
    }
}

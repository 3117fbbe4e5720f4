//! CalculiX's own frequency decks through `stiffmap modes`, against its reference results.

use crate::bench::{ccx, stiffmap, test_decks};
use rayon::prelude::*;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;

/// What became of a deck.
enum Outcome {
    /// Frequencies and those of the reference.
    Computed(Vec<f64>, Vec<f64>),
    /// Why it is refused.
    Refused(String),
    /// CalculiX is not there to compute what it is compared with.
    Skipped,
}

/// Copies the decks and their references, unpacked: Debian packs the longer ones.
fn unpacked(from: &Path) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for entry in std::fs::read_dir(from).expect("listed") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let plain = name.strip_suffix(".gz").unwrap_or(&name).to_owned();
        if !plain.ends_with(".inp") && !plain.ends_with(".dat.ref") {
            continue;
        }
        let content = if plain == name {
            std::fs::read(&path).expect("read")
        } else {
            Command::new("gzip").arg("-dc").arg(&path).output().expect("gzip").stdout
        };
        std::fs::write(folder.path().join(plain), content).expect("written");
    }
    folder
}

/// Frequencies of the first eigenvalue table of a result file.
fn frequencies(file: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(file).expect("a result file");
    let table = text.split("E I G E N V A L U E   O U T P U T").nth(1).expect("an eigenvalue table");
    let table = table.split("P A R T I C I P A T I O N").next().expect("its rows");
    let row = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = words.len() == 5 && words[0].parse::<usize>().is_ok();
        number.then(|| words[3].parse::<f64>().expect("a frequency"))
    };
    table.lines().filter_map(row).collect()
}

/// The frequencies to compare with: those of the stored reference. The one with C3D8I (dloadlinIf) was stored before
/// CalculiX gave the incompatible modes mass; what the installed CalculiX computes takes its place. Without it, `None`.
fn reference(deck: &Path) -> Option<Vec<f64>> {
    if !std::fs::read_to_string(deck).expect("a deck").to_uppercase().contains("TYPE=C3D8I") {
        return Some(frequencies(&deck.with_extension("dat.ref")));
    }
    let (job, folder) = (deck.file_stem().expect("a name"), deck.parent().expect("a folder"));
    ccx()?.arg(job).current_dir(folder).output().expect("runs");
    Some(frequencies(&deck.with_extension("dat")))
}

fn compute(deck: &Path) -> Outcome {
    // The reference's C3D8 is the plain brick.
    let out = stiffmap().args(["modes", "--json", "--plain-bricks"]).arg(deck).output().expect("runs");
    let said = String::from_utf8_lossy(&out.stderr).into_owned();
    match out.status.code() {
        Some(0) => {
            let json: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
            let list = json["frequencies"].as_array().expect("a list");
            let found: Vec<f64> = list.iter().map(|f| f.as_f64().expect("a number")).collect();
            match reference(deck) {
                Some(reference) => Outcome::Computed(found, reference),
                None => Outcome::Skipped,
            }
        }
        Some(2) => Outcome::Refused(said.lines().last().unwrap_or_default().to_owned()),
        code => panic!("{}: exit code {code:?}: {said}", deck.display()),
    }
}

/// Largest relative difference; infinite if a mode is missing.
fn worst(found: &[f64], reference: &[f64]) -> f64 {
    if found.len() != reference.len() {
        return f64::INFINITY;
    }
    found.iter().zip(reference).map(|(f, r)| (f / r - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn every_frequency_deck_of_calculix_is_refused_by_name_or_agrees_within_a_thousandth() {
    let Some(folder) = test_decks() else { return };
    let folder = unpacked(&folder);
    let mut decks: Vec<_> =
        std::fs::read_dir(folder.path()).expect("listed").map(|e| e.expect("entry").path()).collect();
    let frequency = |path: &Path| {
        let text = String::from_utf8_lossy(&std::fs::read(path).expect("read")).to_uppercase();
        text.lines().any(|line| line.trim_start().starts_with("*FREQUENCY"))
    };
    decks.retain(|path| path.extension().is_some_and(|e| e == "inp") && frequency(path));
    decks.sort();
    let outcomes: Vec<Outcome> = decks.par_iter().map(|deck| compute(deck)).collect();
    let (mut compared, mut log) = (0, std::io::stdout().lock());
    for (deck, outcome) in decks.iter().zip(&outcomes) {
        let name = deck.file_stem().unwrap_or_default().to_string_lossy();
        match outcome {
            Outcome::Computed(found, reference) => {
                let off = worst(found, reference);
                writeln!(log, "{name}: {} modes, largest difference {off:.1e}", found.len()).expect("written");
                assert!(off < 1e-3, "{name}: {found:?} against {reference:?}");
                assert!(!found.is_empty());
                let mut changed = found.clone();
                changed[0] *= 1.002;
                assert!(worst(&changed, reference) > 1e-3, "control: a change of 0.2 % is seen");
                compared += 1;
            }
            Outcome::Skipped => writeln!(log, "{name}: skipped, its reference takes CalculiX").expect("written"),
            Outcome::Refused(reason) => {
                writeln!(log, "{name}: refused: {reason}").expect("written");
                let line = reason.split_once(".inp:").and_then(|(_, rest)| rest.split(':').next());
                assert!(line.is_some_and(|l| l.trim().parse::<usize>().is_ok()), "{name}: no line in {reason:?}");
            }
        }
    }
    writeln!(log, "{compared} of {} decks compared", decks.len()).expect("written");
    assert!(decks.len() >= 60 && compared >= 15, "{compared} of {}", decks.len());
}

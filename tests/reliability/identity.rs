//! Every byte that a result depends on is read once and hashed as it was parsed.

use super::*;
use std::io::{BufRead, BufReader, Write as _};
use std::process::Stdio;
use stiffmap::files::{InputError, Inputs};
use stiffmap::machine::read_machine;
use stiffmap::pipeline::{read_meshes, reduce_parts};
use stiffmap::reduction::Cache;

/// The mass of the block that its reduction has.
fn reduced_mass(room: &Room, edit: impl FnOnce()) -> (f64, bool) {
    let machine = read_machine(&room.path("machine.toml")).unwrap();
    let meshes = read_meshes(&machine).unwrap();
    edit();
    let cache = Cache::in_folder(room.path("cache"));
    let parts = reduce_parts(&machine, &meshes, Some(&cache), &Default::default(), &|| ()).unwrap();
    (parts[1].superelement.mass, parts[1].hit)
}

#[test]
fn a_file_edited_after_it_was_read_is_not_kept_under_its_new_hash() {
    for file in ["block/more/steel.inp", "block/part.inp"] {
        let room = Room::new();
        let whole = String::from_utf8(room.read("block/part.inp")).unwrap();
        let heavy = || match file {
            "block/part.inp" => {
                room.write("block/more/heavy.inp", &material(2.0 * DENSITY));
                room.write(file, &whole.replace("steel.inp", "heavy.inp"));
            }
            _ => room.write(file, &material(2.0 * DENSITY)),
        };
        let (mass, hit) = reduced_mass(&room, heavy);
        assert!((mass / (DENSITY * VOLUME) - 1.0).abs() < 1e-9 && !hit, "{file}: what was read is reduced, {mass} kg");
        let (mass, hit) = reduced_mass(&room, || ());
        assert!(
            (mass / (2.0 * DENSITY * VOLUME) - 1.0).abs() < 1e-9 && !hit,
            "{file}: {mass} kg, from the cache: {hit}"
        );
        let (_, hit) = reduced_mass(&room, || ());
        assert!(hit, "control: without an edit it is read from the cache");
    }
}

#[test]
fn every_file_is_recorded_by_its_path() {
    let room = Room::new();
    room.write("rest.csv", "time_s,position_m\n0,0.05\n0.05,0.1\n");
    room.write("push.csv", "time_s,x\n0,0\n0.01,10\n0.02,0\n");
    let simulate = ["simulate", ".", "--no-figures", "--path-file", "rest.csv", "--force-file", "push.csv"];
    room.done(&[&QUICK[..], &["--out", "out"]].concat());
    room.done(&["sweep", "study.toml", "--no-figures", "--out", "swept"]);
    let moved = room.run(&[&simulate[..], &["--out", "moved"]].concat());
    assert!(room.path("moved/manifest.json").exists(), "{}", said(&moved));
    let parts = ["bed/part.inp", "bed/more/steel.inp", "block/part.inp", "block/more/steel.inp"];
    for (out, more) in [
        ("out", &["machine.toml"][..]),
        ("swept", &["machine.toml", "study.toml"]),
        ("moved", &["machine.toml", "--path-file rest.csv", "--force-file push.csv"]),
    ] {
        let manifest = room.manifest(out);
        let recorded = manifest["input_hashes"].as_object().unwrap();
        let expected: Vec<&str> = parts.iter().chain(more).copied().collect();
        assert_eq!(recorded.len(), expected.len(), "{out}: {recorded:?}");
        for name in expected {
            let file = name.rsplit(' ').next().unwrap();
            assert_eq!(recorded[name], room.hash(file), "{out}: {name}");
        }
    }
}

#[test]
fn a_sweep_goes_on_and_is_joined_with_its_own_inputs_only() {
    let room = Room::new();
    // The block by matrices, beside its mesh.
    room.done(&["export", ".", "--format", "mtx", "--part", "block", "--out", "given"]);
    let files = "matrices = { stiffness = \"given/stiffness.mtx\", mass = \"given/mass.mtx\", dofs = \"given/dofs.csv\", \
                 sets = \"given/sets.csv\", free = true }\nunits = \"m-kg-s\"";
    let by_sets = MACHINE
        .replace("mesh = \"block/part.inp\"", files)
        .replace("shoe = { nodes = \"YMIN\" }", "shoe = { nodes = \"shoe\" }")
        .replace(
            "nut = { nodes = \"ZMAX\" }, top = { nodes = \"YMAX\" }",
            "nut = { nodes = \"nut\" }, top = { nodes = \"top\" }",
        );
    room.write("machine.toml", &by_sets);
    let sweep = |out: &'static str| vec!["sweep", "study.toml", "--no-figures", "--out", out];
    room.done(&[&sweep("a")[..], &["--shard", "1/2"]].concat());
    room.done(&[&sweep("b")[..], &["--shard", "2/2"]].concat());
    room.done(&[&sweep("whole")[..], &["--merge", "a", "b"]].concat());
    let resume = [&sweep("a")[..], &["--shard", "1/2", "--resume"]].concat();
    room.done(&resume);
    for file in [
        "bed/part.inp",
        "bed/more/steel.inp",
        "given/stiffness.mtx",
        "given/mass.mtx",
        "given/dofs.csv",
        "given/sets.csv",
        "machine.toml",
        "study.toml",
    ] {
        let kept = room.read(file);
        std::fs::OpenOptions::new().append(true).open(room.path(file)).unwrap().write_all(b"\n").unwrap();
        let hash = format!("the hash of {file} is");
        room.refused(&resume, &[&hash]);
        room.refused(&[&sweep("joined")[..], &["--merge", "a", "b"]].concat(), &[&hash]);
        std::fs::write(room.path(file), kept).unwrap();
    }
    room.done(&resume);
    // The files alone say what is whole: a shard whose job did not end is not joined.
    std::fs::remove_file(room.path("b/manifest.json")).unwrap();
    room.refused(&[&sweep("joined")[..], &["--merge", "a", "b"]].concat(), &["no manifest.json", "--resume"]);
}

/// A run into whose reading and reducing an edit falls; the density that its manifest names.
fn edited_run(room: &Room, out: &str, step: &str) -> f64 {
    let light = blake3::hash(material(DENSITY).as_bytes()).to_hex().to_string();
    let heavy = blake3::hash(material(2.0 * DENSITY).as_bytes()).to_hex().to_string();
    let mut command = room.command(&[&QUICK[..], &["--out", out]].concat());
    let mut run = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let mut lines = BufReader::new(run.stderr.take().unwrap()).lines().map(Result::unwrap);
    let _ = step.is_empty() || lines.by_ref().any(|line| line.starts_with(step));
    room.write("block/more/steel.inp", &material(2.0 * DENSITY));
    let rest: Vec<String> = lines.collect();
    assert_eq!(run.wait().unwrap().code(), Some(0), "{rest:?}");
    let manifest = room.manifest(out);
    let recorded = manifest["input_hashes"]["block/more/steel.inp"].as_str().unwrap();
    let told = manifest["warnings"].to_string().contains("it has been changed since it was read");
    assert!([&light, &heavy].contains(&&recorded.to_owned()), "{recorded}");
    assert_eq!(told, recorded == light, "an edit after the reading is told: {}", manifest["warnings"]);
    if recorded == light { DENSITY } else { 2.0 * DENSITY }
}

#[test]
fn a_result_is_of_the_files_that_its_manifest_names_whenever_they_are_edited() {
    let mut seen = Vec::new();
    for step in ["", "read meshes", "reduce parts", "couple", "modes"] {
        let room = Room::new();
        let density = edited_run(&room, "out", step);
        assert!(is(room.frequency("out"), density), "{step}: {} Hz, {density} kg/m3", room.frequency("out"));
        seen.push(density);
        // And nothing is kept that the next run would take for its own.
        room.done(&[&QUICK[..], &["--out", "next"]].concat());
        assert!(is(room.frequency("next"), 2.0 * DENSITY), "{step}: {} Hz", room.frequency("next"));
    }
    assert!(seen.contains(&DENSITY), "control: no edit came after the reading");
}

#[test]
fn one_file_with_two_contents_is_refused() {
    let room = Room::new();
    let [mut a, mut b] = [Inputs::default(), Inputs::default()];
    let file = room.path("machine.toml");
    a.read(&file).unwrap();
    b.read(&room.path("bed/../machine.toml")).unwrap();
    assert_eq!(a.clone().extend(&b), Ok(()), "control: one content");
    room.write("machine.toml", "edited");
    let mut c = Inputs::default();
    c.read(&file).unwrap();
    assert!(matches!(a.extend(&c), Err(InputError::TwoContents { .. })));
    assert!(b.extend(&c).is_err(), "and by another spelling");
    assert!(a.read(&file).unwrap_err().to_string().contains("changed between two readings"));
}

#[test]
fn what_is_included_over_and_over_is_held_once_and_bounded() {
    let room = Room::new();
    let comment = "** a line that says nothing, of some length, as exporters write them\n".repeat(60_000);
    room.write("block/more/words.inp", &comment);
    let whole = String::from_utf8(room.read("block/part.inp")).unwrap();
    let times =
        |n: usize| room.write("block/part.inp", &(whole.clone() + &"*INCLUDE, INPUT=more/words.inp\n".repeat(n)));
    times(10);
    room.done(&[&QUICK[..], &["--out", "out"]].concat());
    assert!(is(room.frequency("out"), DENSITY));
    times(400);
    room.refused(&[&QUICK[..], &["--out", "out"]].concat(), &["words.inp", "included again", "64 MB are allowed"]);
}

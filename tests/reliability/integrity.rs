//! Damaged, renamed and swapped files are refused or made again, never used.

use super::*;
use std::os::unix::fs::PermissionsExt;
use stiffmap::figures::report::Database;
use stiffmap::machine::read_machine;
use stiffmap::pipeline::{read_meshes, reduce_parts};
use stiffmap::reduction::{Cache, Cached};

/// Bits of a file to be flipped: all of its first bytes, and some throughout.
fn bits(length: usize, head: usize, some: usize) -> impl Iterator<Item = usize> {
    let step = (8 * length / some).max(1) | 1;
    (0..8 * head.min(length)).chain((0..some).map(move |k| (k * step + 5) % (8 * length)))
}

#[test]
fn every_flipped_bit_of_a_database_is_noticed() {
    let room = Room::new();
    room.done(&["run", ".", "--frequencies", "0:60:5", "--out", "out"]);
    let file = room.path("out/modal_database.bin");
    let whole = room.read("out/modal_database.bin");
    let (database, hash) = Database::read(&file).expect("control: as it was written");
    assert_eq!(room.manifest("out")["settings"]["modal_database_blake3"], hash);
    let recorded = &room.manifest("out")["input_hashes"];
    assert!(database.header.input_hashes.iter().all(|(name, hash)| recorded[name] == *hash));
    assert_eq!(database.header.input_hashes.len(), 5);
    let mut bytes = whole.clone();
    for bit in bits(whole.len(), 600, 400) {
        bytes[bit / 8] ^= 1 << (bit % 8);
        std::fs::write(&file, &bytes).unwrap();
        assert!(Database::read(&file).is_err(), "bit {bit} of {}", 8 * whole.len());
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
    bytes[whole.len() / 2] ^= 1;
    std::fs::write(&file, &bytes).unwrap();
    room.refused(&["figures", "out"], &["modal_database.bin", "damaged", "run again"]);
    std::fs::write(&file, &whole).unwrap();
    room.done(&["figures", "out"]);
}

#[test]
fn a_database_of_another_run_is_refused() {
    let room = Room::new();
    for (out, damping) in [("a", "0.02"), ("b", "0.03")] {
        room.done(&["run", ".", "--frequencies", "0:60:5", "--damping", damping, "--out", out]);
    }
    std::fs::copy(room.path("a/modal_database.bin"), room.path("b/modal_database.bin")).unwrap();
    let picture = room.read("b/figures/frf_xx_amplitude.png");
    room.refused(&["figures", "b"], &["modal_database.bin", "the database of another run"]);
    assert!(room.read("b/figures/frf_xx_amplitude.png") == picture, "nothing is drawn");
    room.done(&["figures", "a"]);
}

/// The parts of the room's machine by its cache.
fn reduced(room: &Room) -> Vec<Cached> {
    let machine = read_machine(&room.path("machine.toml")).unwrap();
    let meshes = read_meshes(&machine).unwrap();
    let cache = Cache::in_folder(room.path("cache"));
    reduce_parts(&machine, &meshes, Some(&cache), &Default::default(), &|| ()).unwrap()
}

#[test]
fn every_flipped_bit_of_a_superelement_and_a_renamed_one_are_noticed() {
    let room = Room::new();
    let good = reduced(&room);
    assert!(reduced(&room).iter().all(|part| part.hit), "control: as they were written");
    let names = room.files("cache");
    assert_eq!(names.len(), 2);
    let whole: Vec<Vec<u8>> = names.iter().map(|name| room.read(&format!("cache/{name}"))).collect();
    let noticed = |what: String| {
        let found = reduced(&room);
        let told = found.iter().filter(|part| part.warnings.iter().any(|w| w.to_string().contains("damaged"))).count();
        assert!(told > 0, "{what}");
        assert!(
            found.iter().zip(&good).all(|(a, b)| a.superelement == b.superelement),
            "{what}: another part is taken"
        );
    };
    for bit in bits(whole[0].len(), 96, 60).step_by(7) {
        let mut bytes = whole[0].clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        std::fs::write(room.path("cache").join(&names[0]), &bytes).unwrap();
        noticed(format!("bit {bit}"));
    }
    std::fs::write(room.path("cache").join(&names[0]), &whole[1]).unwrap();
    noticed("the file of another part under this one's name".into());
    // The same part of another density under the name of this one.
    room.write("block/more/steel.inp", &material(2.0 * DENSITY));
    reduced(&room);
    let other = room.files("cache").into_iter().find(|name| !names.contains(name)).expect("a third file");
    room.write("block/more/steel.inp", &material(DENSITY));
    for name in &names {
        std::fs::copy(room.path("cache").join(&other), room.path("cache").join(name)).unwrap();
    }
    noticed("another state of the part under this one's name".into());
}

#[test]
fn files_of_the_cache_have_the_permissions_that_the_umask_leaves() {
    for (mask, expected) in [("002", 0o664), ("027", 0o640)] {
        let room = Room::new();
        let program = env!("CARGO_BIN_EXE_stiffmap");
        let line = format!("umask {mask}; exec {program} run . --no-figures --frequencies 0:60:5 --out out");
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(line).current_dir(room.0.path()).env("STIFFMAP_CACHE", room.path("cache"));
        assert_eq!(shell.output().unwrap().status.code(), Some(0));
        for name in room.files("cache").iter().map(|n| format!("cache/{n}")).chain(["out/compliance.mat".into()]) {
            let mode = std::fs::metadata(room.path(&name)).unwrap().permissions().mode() & 0o777;
            assert_eq!(mode, expected, "{name} under umask {mask}: {mode:o}");
        }
    }
}

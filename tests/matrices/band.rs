//! The band between distributing and rigid interfaces, and the distance from a fine mesh.

use super::deck::write_mesh;
use super::folder;
use super::support::dense::{frequencies, full};
use super::support::{box_mesh, slide, worst_ratio};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use stiffmap::coupling::{assembled, at_fixed_position, unreduced};
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::SurfaceCoupling;
use stiffmap::mesh::{Mesh, MeshFile};
use stiffmap::pipeline::at_position;
use stiffmap::solid::{assemble, interface_motions};

const POSITION: f64 = -0.0371;

#[test]
fn rigid_interfaces_bound_from_above_and_both_sides_are_the_unreduced_machine() {
    let (mut machine, meshes) = slide::machine(true);
    // The guide alone: the screw's faces share edges with its.
    machine.joints.truncate(1);
    let centroids: Vec<Vec<[f64; 3]>> = machine
        .parts
        .iter()
        .zip(&meshes)
        .map(|(p, m)| interface_motions(p, m).unwrap().iter().map(|(_, m)| m.centroid).collect())
        .collect();
    let files: Vec<MeshFile> = meshes.iter().map(|m| MeshFile { mesh: m.clone(), warnings: Vec::new() }).collect();
    let refs: Vec<&Mesh> = meshes.iter().collect();
    let mut found = Vec::new();
    for coupling in [SurfaceCoupling::Distributing, SurfaceCoupling::Rigid] {
        let fixed = at_fixed_position(&machine, &centroids, POSITION, coupling).unwrap();
        let modes = at_position(&fixed, &files, None, POSITION, 10, &Interrupt::default()).unwrap().modes;
        let seen: Vec<f64> = (0..10).map(|r| modes.frequency(modes.free + r)).collect();
        // The same without any reduction, by a dense solver.
        let pairs = fixed.parts.iter().zip(&meshes);
        let systems: Vec<_> = pairs.clone().map(|(p, m)| assemble(p, m).unwrap()).collect();
        let surfaces: Vec<_> = pairs.map(|(p, m)| interface_motions(p, m).unwrap()).collect();
        let whole = assembled(&systems, &unreduced(&fixed, &refs, &surfaces, POSITION).unwrap());
        let dense = frequencies(&full(&whole.stiffness), &full(&whole.mass), 1e6);
        let difference = worst_ratio(&seen, &dense[modes.free..modes.free + 10]);
        assert!(difference < 1e-5, "{coupling:?}: {difference:.1e}\n{seen:?}\n{:?}", &dense[..12]);
        found.push(seen);
    }
    let [low, high] = [&found[0], &found[1]];
    assert!(low.iter().zip(high).all(|(l, h)| *h >= l * (1.0 - 1e-9)), "{low:?}\n{high:?}");
    assert!(worst_ratio(high, low) > 1e-3);
}

const SLIDE: &str = "name = \"slide\"\n[axes.z]\ndirection = [0, 0, 1]\ntravel = [0, 0.1]\nstep = 0.1\nmoves = [\"arm\"]\n\
    [parts.post]\nmesh = \"post.inp\"\nclamped = [\"YMIN\"]\ninterfaces = { pad = { nodes = \"YMAX\" } }\n\
    [parts.arm]\nmesh = \"arm.inp\"\ninterfaces = { foot = { nodes = \"YMIN\" }, tip = { nodes = \"XMAX\" }, side = { nodes = \"ZMAX\" } }\n\
    [[joints]]\nname = \"bolts\"\ntype = \"spring-damper\"\nbetween = [\"post.pad\", \"arm.foot\"]\n\
    stiffness = { x = 2e8, y = 3e8, z = 2.5e8, rx = 4e5, ry = 3e5, rz = 2e5 }\n\
    [ports.tip]\ninterface = \"arm.tip\"\ndirections = [\"x\"]\n\
    [analysis]\ncomponent = { modes = 20 }\nmodes = 5\nfrequencies = { from = 0, to = 3000, step = 100 }\ndamping = { ratio = 0.02 }\n";

/// A beam on a post, of other sides, so that no two modes are alike, on a mesh of `n` cells across.
fn slide_of(folder: &Path, name: &str, n: usize) {
    let folder = folder.join(name);
    std::fs::create_dir(&folder).unwrap();
    write_mesh(&folder.join("post.inp"), &box_mesh([0.0; 3], [0.12, 0.2, 0.15], [n, 2 * n, n]));
    write_mesh(&folder.join("arm.inp"), &box_mesh([0.0, 0.21, 0.02], [0.6, 0.07, 0.1], [5 * n, n, n]));
    std::fs::write(folder.join("machine.toml"), SLIDE).unwrap();
}

fn converge(folder: &Path, arguments: &[&str]) -> Result<Value, String> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiffmap"));
    command
        .env("STIFFMAP_CACHE", folder.join("cache"))
        .current_dir(folder)
        .args(["converge", "--json"])
        .args(arguments);
    let output = command.output().unwrap();
    if output.status.success() {
        return Ok(serde_json::from_slice(&output.stdout).unwrap());
    }
    assert_eq!(output.status.code(), Some(2));
    Err(String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn three_meshes_show_an_order_and_a_limit_that_a_finer_one_confirms() {
    let folder = folder();
    for (name, n) in [("a", 1), ("b", 2), ("c", 3), ("fine", 4)] {
        slide_of(folder.path(), name, n);
    }
    // In any order of the arguments.
    let three = converge(folder.path(), &["c", "a", "b", "--modes", "4"]).unwrap();
    let fine = converge(folder.path(), &["c", "fine", "--modes", "4"]).unwrap();
    let mut estimated = 0;
    for rank in 0..4 {
        let (row, confirmed) = (&three["elastic_modes"][rank], &fine["elastic_modes"][rank]);
        let own = |row: &Value, k: usize| row["hz"][k].as_f64().unwrap();
        // With two meshes the order is the one that is given.
        assert_eq!(confirmed["order"].as_f64(), Some(2.0));
        let Some(limit) = row["limit_hz"].as_f64() else {
            let reason = row["refused"].as_str().unwrap_or_default();
            assert!(reason.contains("no order from 0.3 to 8") || reason.contains("not monotone"), "{row}");
            continue;
        };
        estimated += 1;
        // The finer mesh lies nearer to the limit.
        let (left, finer) = (own(row, 2) - limit, own(confirmed, 1) - limit);
        assert!(left > 0.0 && finer.abs() < 0.9 * left, "{row}, {confirmed}");
        let error = row["error"].as_f64().unwrap();
        assert!((error - (own(row, 2) / limit - 1.0)).abs() < 1e-12 && error < 0.02);
    }
    assert!(estimated >= 2, "{three}");
    assert_eq!(three["unknowns"].as_array().unwrap().len(), 3);
    let same = converge(folder.path(), &["a", "a"]).unwrap_err();
    assert!(same.contains("meshes of different size"), "{same}");
    let other = converge(folder.path(), &["a", "b", "--order", "9"]).unwrap_err();
    assert!(other.contains("--order: 9"), "{other}");
}

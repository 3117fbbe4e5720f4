//! What a superelement keeps of its part: rigid motions, component modes, and what it refuses.

mod support;

use stiffmap::machine::ComponentAnalysis;
use stiffmap::reduction::{RailSpring, RailTraining, ReductionError, ReductionRequest, reduce};
use stiffmap::solid::assemble;
use support::dense::{frequencies, full};
use support::{craig_bampton, free_interface, post_and_arm, superelement, worst_ratio};

#[test]
fn a_free_part_keeps_exactly_six_zeros_and_its_rigid_motions() {
    let (parts, meshes) = post_and_arm();
    for component in [craig_bampton(10), free_interface(10)] {
        let s = superelement(&parts[1], &meshes[1], component);
        assert!(s.eigenvalues[..6].iter().all(|l| *l == 0.0) && s.eigenvalues[6] > 1e6);
        assert!(s.eigenvalues.is_sorted());
        assert!((s.mass / (7850.0 * 0.3 * 0.1 * 0.1) - 1.0).abs() < 1e-12);
        // sum over coordinates of impulse x impulse^T is the rigid mass matrix, all of it in the six zeros.
        let six = s.impulses.columns(0, 6);
        let gram = six * six.transpose();
        assert!((gram[(0, 0)] / s.mass - 1.0).abs() < 1e-11 && (gram[(3, 3)] / s.inertia[(0, 0)] - 1.0).abs() < 1e-10);
        assert!(s.impulses.columns(6, s.n() - 6).amax() < 1e-9 * six.amax(), "elastic coordinates carry no momentum");
        // The end face 0.15 m from the centre reads a turn about z as a motion along y.
        let z = s.impulses.row(5).transpose();
        let read = &s.interfaces[1].rows * &z;
        assert!((read[5] - 1.0).abs() < 1e-10 && (read[1] - 0.15).abs() < 1e-10 && read[0].abs() < 1e-10, "{read}");
        let other = &s.interfaces[0].rows * &z;
        assert!((other[1] + 0.15).abs() < 1e-10, "control: the other end moves the other way");
        let clamped = superelement(&parts[0], &meshes[0], component);
        assert!(clamped.eigenvalues[0] > 1e5, "control: a clamped part has no zero");
    }
}

#[test]
fn component_modes_are_the_parts_own() {
    let (parts, meshes) = post_and_arm();
    let system = assemble(&parts[1], &meshes[1]).expect("assembles");
    let exact = frequencies(&full(&system.stiffness), &full(&system.mass), 1e6);
    let free = superelement(&parts[1], &meshes[1], free_interface(12));
    assert_eq!(free.component_frequencies.len(), 12);
    assert!(worst_ratio(&free.component_frequencies, &exact[6..18]) < 1e-8);
    let held = superelement(&parts[1], &meshes[1], craig_bampton(12));
    assert!(
        worst_ratio(&held.component_frequencies, &exact[6..18]) > 0.02,
        "control: with the interfaces held they are others"
    );
    let limit = 0.5 * (exact[9] + exact[10]);
    let banded = superelement(&parts[1], &meshes[1], ComponentAnalysis { band: limit, ..free_interface(12) });
    assert_eq!(banded.component_frequencies.len(), 4, "the band ends at {limit:.0} Hz");
}

// A rail that is trained for springs along x and y alone holds neither z nor the turn about z.
#[test]
fn a_free_part_whose_interfaces_do_not_hold_it_has_no_constraint_modes() {
    let (parts, meshes) = post_and_arm();
    let mut alone = parts[1].clone();
    alone.interfaces.truncate(1);
    let along = |direction| RailSpring { point: [0.1, 0.05, 0.0], direction, rotation: false };
    let rail = RailTraining {
        interface: 0,
        direction: [0.0, 0.0, 1.0],
        footprint: 0.1,
        centres: vec![0.35],
        springs: vec![along([1.0, 0.0, 0.0]), along([0.0, 1.0, 0.0])],
    };
    let request =
        |component| ReductionRequest { part: alone.clone(), component, reach: 0.0, rails: vec![rail.clone()] };
    let refused = reduce(&request(craig_bampton(5)), &meshes[1], None).err();
    assert!(matches!(&refused, Some(ReductionError::NotHeld { free: 4, .. })), "{refused:?}");
    assert!(reduce(&request(free_interface(5)), &meshes[1], None).is_ok());
    assert!(reduce(&ReductionRequest { rails: vec![], ..request(craig_bampton(5)) }, &meshes[1], None).is_ok());
}

#[test]
fn a_free_part_without_any_interface_has_no_constraint_modes() {
    let (mut parts, meshes) = post_and_arm();
    parts[1].interfaces.clear();
    let request = ReductionRequest { part: parts[1].clone(), component: craig_bampton(5), reach: 0.0, rails: vec![] };
    let refused = reduce(&request, &meshes[1], None).err();
    assert!(matches!(&refused, Some(ReductionError::NotHeld { free: 6, .. })), "{refused:?}");
}

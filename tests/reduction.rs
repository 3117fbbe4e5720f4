//! Component mode synthesis of small parts against the parts themselves.

mod support;

use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::sync::OnceLock;
use stiffmap::coupling::SideBySide;
use stiffmap::linalg::symmetric_eigen;
use stiffmap::machine::{ComponentAnalysis, Joint, Machine, Motion};
use stiffmap::reduction::Superelement;
use stiffmap::solid::{SecondOrder, assemble};
use support::dense::{frequencies, full, side_by_side};
use support::slide::{fixed_machine, side, spring, springs};
use support::{craig_bampton, free_interface, post_and_arm, superelement, worst_ratio};

fn joints() -> Vec<Joint> {
    let bolts = [(Motion::Translation, 5e8), (Motion::Rotation, 1e6)];
    let all =
        bolts.into_iter().flat_map(|(motion, k)| (0..3).map(move |c| spring(motion, c, k * (1.0 + 0.3 * c as f64))));
    let braces = (0..2).map(|c| spring(Motion::Translation, c, 2e7)).collect();
    vec![springs("bolts", [side(0, 0), side(1, 0)], all.collect()), springs("brace", [side(0, 1), side(1, 0)], braces)]
}

fn machine() -> Machine {
    fixed_machine(post_and_arm().0, joints(), side(1, 1))
}

/// The unreduced machine: K + sum k b b^T over the nodes of both parts, built from the interfaces' columns.
fn unreduced(joints: &[Joint]) -> Vec<f64> {
    let (parts, meshes) = post_and_arm();
    let systems: Vec<SecondOrder> =
        parts.iter().zip(&meshes).map(|(p, m)| assemble(p, m).expect("assembles")).collect();
    let first = [0, systems[0].n_dof()];
    let mut k = side_by_side(&full(&systems[0].stiffness), &full(&systems[1].stiffness));
    let m = side_by_side(&full(&systems[0].mass), &full(&systems[1].mass));
    for joint in joints {
        let motions = joint.between.map(|at| &systems[at.part].interfaces[at.interface]);
        let columns = joint.between.map(|at| systems[at.part].columns(&systems[at.part].interfaces[at.interface].rows));
        for spring in &joint.springs {
            let d = nalgebra::Vector3::from(spring.direction);
            let mut b = nalgebra::DVector::zeros(k.nrows());
            for (s, sign) in [-1.0, 1.0].into_iter().enumerate() {
                let arm = nalgebra::Vector3::from(motions[1].centroid) - nalgebra::Vector3::from(motions[s].centroid);
                // d . (t + theta x arm)
                let turn = if spring.motion == Motion::Rotation { d } else { arm.cross(&d) };
                let shift = if spring.motion == Motion::Rotation { 0.0 } else { 1.0 };
                let q =
                    nalgebra::DVector::from_vec(vec![shift * d.x, shift * d.y, shift * d.z, turn.x, turn.y, turn.z]);
                let part = joint.between[s].part;
                b.rows_mut(first[part], systems[part].n_dof()).axpy(sign, &(&columns[s] * q), 1.0);
            }
            let stiffmap::machine::SpringStiffness::Constant(stiffness) = spring.stiffness else {
                unreachable!("plain springs")
            };
            k.ger(stiffness, &b, &b, 1.0);
        }
    }
    frequencies(&k, &m, 0.0)[..12].to_vec()
}

fn reference() -> &'static [f64] {
    static REFERENCE: OnceLock<Vec<f64>> = OnceLock::new();
    REFERENCE.get_or_init(|| unreduced(&joints()))
}

fn reduced(component: ComponentAnalysis) -> Vec<Superelement> {
    let (parts, meshes) = post_and_arm();
    parts.iter().zip(&meshes).map(|(part, mesh)| superelement(part, mesh, component)).collect()
}

fn coupled(component: ComponentAnalysis) -> Vec<f64> {
    let model = SideBySide::new(&machine(), &reduced(component)).expect("couples");
    let eigen = symmetric_eigen(&model.coupled_stiffness(0.0).expect("stiffness")).expect("converges");
    eigen.values.iter().take(12).map(|l| l.max(0.0).sqrt() / TAU).collect()
}

fn without_second_moments(component: ComponentAnalysis) -> ComponentAnalysis {
    ComponentAnalysis { second_moment: false, ..component }
}

// Measured with 24 component modes a part: see the figures that the test prints.
#[test]
fn both_methods_give_the_unreduced_machines_frequencies() {
    for (name, method) in [("Craig-Bampton", craig_bampton(24)), ("free interface", free_interface(24))] {
        let with = worst_ratio(&coupled(method)[..10], &reference()[..10]);
        let without = worst_ratio(&coupled(without_second_moments(method))[..10], &reference()[..10]);
        println!("{name}: {with:.1e} with second moments, {without:.1e} without");
        assert!(with < 1e-6, "{name}: {with:.1e}");
        assert!(
            without > 5.0 * with && without < 1e-2,
            "{name}: {without:.1e} without second moments against {with:.1e}"
        );
        for (f, exact) in coupled(method).iter().zip(reference()) {
            assert!(*f > exact * (1.0 - 1e-9), "Ritz values lie above: {f} {exact}");
        }
    }
    let mut softer = joints();
    softer[0].springs.remove(0);
    let other = worst_ratio(&coupled(craig_bampton(24))[..10], &unreduced(&softer)[..10]);
    assert!(other > 1e-3, "control: a machine without one spring is another one, {other:.1e}");
}

#[test]
fn the_two_methods_agree_with_each_other() {
    let (fixed, free) = (coupled(craig_bampton(24)), coupled(free_interface(24)));
    let error = worst_ratio(&fixed[..10], &free[..10]);
    assert!(error < 1e-6, "{error:.1e}");
    assert!(worst_ratio(&fixed[..10], &coupled(without_second_moments(free_interface(3)))[..10]) > 1e-5);
}

#[test]
fn static_compliance_at_a_port_is_exact_even_with_few_modes() {
    let (parts, meshes) = post_and_arm();
    let system = assemble(&parts[0], &meshes[0]).expect("assembles");
    let w = system.columns(&system.interfaces[1].rows);
    let exact = w.transpose() * full(&system.stiffness).cholesky().expect("clamped").solve(&w);
    let compliance = |s: &Superelement| {
        let rows = &s.interfaces[1].rows;
        let scaled = DMatrix::from_fn(6, s.n(), |q, i| rows[(q, i)] / s.eigenvalues[i]);
        scaled * rows.transpose()
    };
    for component in [craig_bampton(2), free_interface(2), craig_bampton(24), free_interface(24)] {
        let s = superelement(&parts[0], &meshes[0], component);
        let error = (compliance(&s) - &exact).amax() / exact.amax();
        assert!(error < 1e-10, "{component:?}: {error:.1e}");
    }
    // Control: a part whose reduction does not know the port has only its modes there.
    let mut s = superelement(&parts[0], &meshes[0], craig_bampton(24));
    s.eigenvalues.truncate(20);
    s.interfaces[1].rows = s.interfaces[1].rows.columns(0, 20).into_owned();
    assert!((compliance(&s) - &exact).amax() / exact.amax() > 1e-4);
}

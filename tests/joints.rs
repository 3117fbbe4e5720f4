//! Joints against closed forms and against the same machine described otherwise.

mod support;

use nalgebra::DMatrix;
use stiffmap::coupling::SideBySide;
use stiffmap::linalg::symmetric_eigen;
use stiffmap::machine::{JointPoint, Motion};
use support::dense::eigenvalues;
use support::slide::{self, Slide, fixed_machine, side, spring, springs};
use support::{box_mesh, craig_bampton, on, part, superelement, worst_ratio};

// omega^2 = k (1/m + 1/m) for springs through both centres of mass; the boxes' own flexibility c in series makes it
// smaller by the share k c, which falls with k.
#[test]
fn two_boxes_and_a_spring_swing_at_the_closed_form() {
    let meshes = [box_mesh([0.0; 3], [0.1; 3], [1; 3]), box_mesh([0.0, 0.0, 0.2], [0.1; 3], [1; 3])];
    let parts = vec![part("lower", &[], vec![on("ZMAX")]), part("upper", &[], vec![on("ZMIN")])];
    let reduced: Vec<_> = parts.iter().zip(&meshes).map(|(p, m)| superelement(p, m, craig_bampton(6))).collect();
    let off = |k: f64| {
        let joint = springs("spring", [side(0, 0), side(1, 0)], vec![spring(Motion::Translation, 2, k)]);
        let machine = fixed_machine(parts.clone(), vec![joint], side(1, 0));
        let model = SideBySide::new(&machine, &reduced).expect("couples");
        let values = symmetric_eigen(&model.coupled_stiffness(0.0).expect("stiffness")).expect("converges").values;
        let exact = 2.0 * k / 7.85;
        assert!(values.as_slice()[..11].iter().all(|l| l.abs() < 1e-4 * exact), "eleven free motions: {values}");
        1.0 - values[11] / exact
    };
    let (hard, soft) = (off(1e8), off(1e7));
    println!("{hard:.2e} {soft:.2e}");
    assert!(soft > 0.0 && soft < 5e-3, "{soft:.1e}");
    assert!(
        (hard / soft - 10.0).abs() < 0.5,
        "what is left is the boxes' flexibility, which scales with k: {hard:.2e} {soft:.2e}"
    );
}

// Both parts may be said to move, or which of them: only the relative position counts.
#[test]
fn a_bed_that_moves_down_is_a_carriage_that_moves_up() {
    let (mut machine, meshes) = slide::machine(true);
    machine.joints.truncate(1);
    machine.joints[0].at = JointPoint::Point([0.05, 0.105, 0.5]);
    let upward = Slide::of(machine.clone(), meshes.clone());
    machine.axis.moves = vec![true, false];
    let downward = Slide::of(machine.clone(), meshes.clone());
    let rows =
        |slide: &Slide, p: f64| SideBySide::new(&slide.machine, &slide.parts).expect("couples").rows(p).expect("rows");
    let values = |slide: &Slide, p: f64| {
        let rows = rows(slide, p);
        let model = SideBySide::new(&slide.machine, &slide.parts).expect("couples");
        let n = model.n();
        let values = eigenvalues(&model.coupled_stiffness(p).expect("stiffness"), &DMatrix::identity(n, n), 1e4);
        assert_eq!(rows.ncols(), n);
        values[1..12].to_vec()
    };
    let (up, down) = (values(&upward, 0.1), values(&downward, -0.1));
    assert!(worst_ratio(&up, &down) < 1e-6, "{up:?} {down:?}");
    assert!(worst_ratio(&up, &values(&downward, 0.2)) > 1e-4, "control: another relative position");
}

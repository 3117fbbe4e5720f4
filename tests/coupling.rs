//! Superelements coupled by joints: rails, the fixed basis, counts.

mod support;

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;
use stiffmap::coupling::{BasisOptions, CoupledModel, CouplingError, SideBySide, couple};
use stiffmap::machine::{ScrewSupport, SpringStiffness};
use stiffmap::modal::modes_at;
use support::dense::eigenvalues;
use support::slide::{FOOTPRINT, Slide, TRAVEL, ratio};
use support::worst_ratio;

/// Upper end of the frequencies of interest, Hz.
const BAND: f64 = 3000.0;

struct Clamped {
    slide: Slide,
    side_by_side: SideBySide,
    model: CoupledModel,
}

fn clamped() -> &'static Clamped {
    static SLIDE: OnceLock<Clamped> = OnceLock::new();
    SLIDE.get_or_init(|| {
        let slide = Slide::new(true);
        let side_by_side = SideBySide::new(&slide.machine, &slide.parts).expect("couples");
        let model = couple(&slide.machine, &slide.parts, BasisOptions::up_to(BAND)).expect("couples");
        Clamped { slide, side_by_side, model }
    })
}

/// Reduced coordinates of a common rigid motion of both parts in their places at a position.
fn rigid(slide: &Slide, position: f64, q: [f64; 6]) -> DVector<f64> {
    let parts = slide.parts.iter().zip(&slide.machine.axis.moves).flat_map(|(part, moves)| {
        let mut centre = part.centre_of_mass;
        centre[2] += if *moves { position } else { 0.0 };
        let turn = nalgebra::Vector3::new(q[3], q[4], q[5]);
        let shift = nalgebra::Vector3::new(q[0], q[1], q[2]) + turn.cross(&nalgebra::Vector3::from(centre));
        let motion = DVector::from_iterator(6, shift.iter().chain(turn.iter()).copied());
        (part.impulses.transpose() * motion).iter().copied().collect::<Vec<f64>>()
    });
    DVector::from_vec(parts.collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn no_spring_feels_a_common_rigid_motion_at_any_position(p in -0.3..0.3f64, q in prop::array::uniform6(-1.0..1.0f64)) {
        static FLOATING: OnceLock<(Slide, SideBySide)> = OnceLock::new();
        let (slide, model) = FLOATING.get_or_init(|| {
            let slide = Slide::new(false);
            let model = SideBySide::new(&slide.machine, &slide.parts).expect("couples");
            (slide, model)
        });
        let rows = model.rows(p).expect("on the rail");
        let still = (&rows * rigid(slide, p, q)).amax();
        prop_assert!(still < 1e-9, "{still:.1e} m of elongation for a motion of some 1 m");
        // Control: the motion of another position is no rigid motion of this one, unless it does not turn.
        let elsewhere = (&rows * rigid(slide, p + 0.05, q)).amax();
        prop_assert!(elsewhere > 0.01 * q[3].abs().max(q[4].abs()), "{elsewhere:.1e}");
    }

    #[test]
    fn the_count_below_any_shift_is_the_dense_one(p in -0.3..0.3f64, place in 0.0..1.0f64) {
        let model = &clamped().side_by_side;
        let k = model.coupled_stiffness(p).expect("stiffness");
        let values = eigenvalues(&k, &DMatrix::identity(model.n(), model.n()), 0.0);
        let shift = 0.5 * values[0] * (4.0 * values[60] / values[0]).powf(place);
        let apart = |other: f64| (other / shift - 1.0).abs() > 1e-7;
        prop_assume!(values.iter().chain(model.eigenvalues.iter()).all(|l| apart(*l)));
        let counted = model.count_below(p, shift).expect("counts");
        prop_assert_eq!(counted, values.iter().filter(|l| **l < shift).count());
        let above = values.iter().position(|l| *l > shift).expect("some lie above");
        let further = model.count_below(p, values[above] * 1.000_001).expect("counts");
        prop_assert!(further > counted, "control: past the next eigenvalue there is one more");
    }
}

#[test]
fn rows_are_continuous_in_the_position() {
    let model = &clamped().side_by_side;
    // About places where the footprint's end crosses a node plane (bed cells of 1/12 m) and where it does not.
    for p in [0.11, -0.06 + 1.0 / 12.0, 0.0, 0.5 - 0.06 - 5.0 / 12.0, -0.237] {
        let jump = |h: f64| {
            let (a, b) = (model.rows(p - 0.5 * h).expect("rows"), model.rows(p + 0.5 * h).expect("rows"));
            (a - b).amax()
        };
        let (coarse, fine, finest) = (jump(1e-4), jump(1e-6), jump(1e-8));
        assert!(
            coarse > 0.0 && (coarse / fine / 100.0 - 1.0).abs() < 0.05,
            "linear in the step at {p}: {coarse:.2e} {fine:.2e}"
        );
        assert!(finest < 0.02 * fine, "no jump at {p}: {finest:.2e}");
        let scale = model.rows(p).expect("rows").amax();
        assert!(coarse < 0.01 * scale && jump(0.05) > 0.01 * scale, "control: a step of half a footprint shows");
    }
}

#[test]
fn the_fixed_basis_agrees_with_the_whole_reduced_machine_between_its_training_positions() {
    let Clamped { slide, side_by_side, model } = clamped();
    assert!(model.n() < side_by_side.n(), "{} of {}", model.n(), side_by_side.n());
    let positions = [0.3, 0.2871, 0.1234, 0.0171, -0.0457, -0.2113, -0.3];
    let exact = positions.map(|p| {
        let k = side_by_side.coupled_stiffness(p).expect("stiffness");
        let values = eigenvalues(&k, &DMatrix::identity(side_by_side.n(), side_by_side.n()), 0.0);
        let below: Vec<f64> = values.iter().map(|l| l.sqrt() / TAU).take_while(|f| *f < BAND).collect();
        assert!(below.len() >= 6, "{below:?}");
        below
    });
    let worst = |model: &CoupledModel| {
        let error = |(p, exact): (&f64, &Vec<f64>)| {
            let modes = modes_at(model, &ratio(0.0), *p).expect("modes");
            let found: Vec<f64> = (0..exact.len()).map(|r| modes.frequency(r)).collect();
            worst_ratio(&found, exact)
        };
        positions.iter().zip(&exact).map(error).fold(0.0, f64::max)
    };
    let rough =
        couple(&slide.machine, &slide.parts, BasisOptions { tolerance: 0.1, band: BAND, ..BasisOptions::up_to(BAND) })
            .expect("couples");
    let (fine, coarse) = (worst(model), worst(&rough));
    println!(
        "fixed basis: {} of {} coordinates {fine:.1e}, {} coordinates {coarse:.1e}",
        model.n(),
        side_by_side.n(),
        rough.n()
    );
    assert!(fine < 1e-6, "{fine:.1e}");
    assert!(coarse > 1e-6 && coarse < 1e-2, "control: a basis that ends at the band, {coarse:.1e}");
}

#[test]
fn the_tools_static_compliance_is_that_of_the_side_by_side_machine() {
    let Clamped { side_by_side, model, .. } = clamped();
    let ports = |rows: &[stiffmap::coupling::PortRow]| {
        DMatrix::from_rows(&rows.iter().map(|r| r.row.clone()).collect::<Vec<_>>())
    };
    let (outputs, inputs) = (ports(&side_by_side.outputs), ports(&side_by_side.inputs));
    for p in [0.3, 0.0171, -0.2113] {
        let k = side_by_side.coupled_stiffness(p).expect("stiffness");
        let exact = &outputs * k.cholesky().expect("held").solve(&inputs.transpose());
        let modes = modes_at(model, &ratio(0.0), p).expect("modes");
        let sum = |count: usize| {
            let scaled =
                DMatrix::from_fn(modes.outputs.nrows(), count, |i, r| modes.outputs[(i, r)] / modes.eigenvalues[r]);
            scaled * modes.inputs.columns(0, count).transpose()
        };
        let error = (sum(model.n()) + &modes.direct - &exact).norm() / exact.norm();
        assert!(error < 1e-8, "{p}: {error:.1e}");
        assert!((sum(5) + &modes.direct - &exact).norm() / exact.norm() > 1e-4, "control: five modes are not enough");
        assert!((&exact - exact.transpose()).norm() < 1e-9 * exact.norm(), "reciprocity");
    }
}

#[test]
fn a_ball_screw_is_as_stiff_as_its_free_length_allows() {
    let model = &clamped().side_by_side;
    // Mount at z = 1 m, nut at 0.55 m + p.
    for (p, length) in [(TRAVEL[0], 0.15), (0.0, 0.45), (TRAVEL[1], 0.75)] {
        let stiffness = model.stiffness(p).expect("stiffness");
        let expected = 210e9 * PI * 0.016 * 0.016 / (4.0 * length);
        assert!((stiffness[5] / expected - 1.0).abs() < 1e-12, "{p}: {} {expected}", stiffness[5]);
        assert_eq!(stiffness[..5], [5e7, 9e7, 2e5, 3e5, 1e5]);
        assert!((stiffness[5] / (expected * 4.0 / PI) - 1.0).abs() > 0.2, "control: not E D^2 / L");
    }
}

/// The slide with another screw, side by side.
fn with_screw(free_length: Option<f64>, support: ScrewSupport) -> Result<SideBySide, CouplingError> {
    let Slide { machine, parts, .. } = &clamped().slide;
    let mut machine = machine.clone();
    machine.joints[1].springs[0].stiffness =
        SpringStiffness::BallScrew { young: 210e9, diameter: 0.016, free_length, support };
    SideBySide::new(&machine, parts)
}

#[test]
fn a_free_length_of_its_own_follows_the_position_and_a_second_support_adds_its_side() {
    let area = 0.25 * PI * 0.016 * 0.016;
    let own = with_screw(Some(0.6), ScrewSupport::OneEnd).unwrap();
    let both = with_screw(None, ScrewSupport::BothEnds { span: 0.9 }).unwrap();
    // As drawn the free length is 0.45 m at position 0 and shrinks with p.
    for p in [TRAVEL[0], 0.0, 0.137, TRAVEL[1]] {
        let (l, drawn) = (0.6 - p, 0.45 - p);
        let k = own.stiffness(p).unwrap()[5];
        assert!((k / (210e9 * area / l) - 1.0).abs() < 1e-12, "{p}: {k}");
        assert!((k / (210e9 * area / drawn) - 1.0).abs() > 0.1, "control: the drawn length");
        let k = both.stiffness(p).unwrap()[5];
        let expected = 210e9 * area * (1.0 / drawn + 1.0 / (0.9 - drawn));
        assert!((k / expected - 1.0).abs() < 1e-12, "{p}: {k}");
        assert!((k / (210e9 * area / drawn) - 1.0).abs() > 0.1, "control: one end");
    }
    // Softest where the nut is in the middle between the supports.
    let at = |p: f64| both.stiffness(p).unwrap()[5];
    assert!(at(0.0) < at(0.1) && at(0.0) < at(-0.1));
}

#[test]
fn a_nut_that_is_not_between_its_supports_is_refused() {
    let refused = with_screw(None, ScrewSupport::BothEnds { span: 0.72 });
    assert!(
        matches!(refused, Err(CouplingError::ScrewSpan { position, .. }) if (position + 0.3).abs() < 1e-9),
        "{refused:?}"
    );
    let refused = with_screw(Some(0.25), ScrewSupport::OneEnd);
    assert!(matches!(refused, Err(CouplingError::ScrewLength { position, .. }) if position == 0.3), "{refused:?}");
}

#[test]
fn a_screw_whose_ends_meet_and_a_footprint_off_its_rail_are_refused() {
    let Slide { machine, parts, .. } = &clamped().slide;
    let refused = |travel: f64| {
        let mut far = machine.clone();
        far.axis.travel = [0.0, travel];
        SideBySide::new(&far, parts).err()
    };
    assert!(matches!(refused(0.5), Some(CouplingError::ScrewLength { length, .. }) if length <= 0.0));
    // The rail ends at z = 0; the carriage's middle stands at 0.5 m, its footprint reaches 0.06 m to either side.
    assert!(refused(-0.44).is_none(), "the footprint ends with the rail");
    let Some(CouplingError::FootprintLeavesRail { joint, position, from, rail_from, .. }) = refused(-0.6) else {
        panic!("leaves the rail")
    };
    assert_eq!(joint, "guide");
    assert!(
        position > -0.6001
            && position < -0.5
            && (from - (0.5 + position - 0.5 * FOOTPRINT)).abs() < 1e-9
            && rail_from.abs() < 1e-12
    );
    let model = &clamped().model;
    assert!(matches!(model.at(0.31), Err(CouplingError::OutsideTravel { .. })));
    assert!(matches!(model.at(f64::NAN), Err(CouplingError::OutsideTravel { .. })));
    assert!(model.at(0.3).is_ok());
}

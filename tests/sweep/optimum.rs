//! The search for the best design.

use super::*;
use stiffmap::frf::metrics::{Extremum, PairMetrics};
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::SpringStiffness;
use stiffmap::sweep::optimise::{Found, optimise};
use stiffmap::sweep::table::Row;
use stiffmap::sweep::{Design, Evaluation, Evaluator, PositionMetrics, SweepError};

/// A stiffness that peaks at guide 60 N/um and diameter 18 mm, known in closed form.
struct Hill(Vec<f64>);

fn stiffness(guide: f64, diameter: f64) -> f64 {
    1e6 * (2.0 - ((guide / 60e6).ln()).powi(2) - ((diameter - 0.018) / 0.01).powi(2))
}

impl Evaluator for Hill {
    fn route(&self) -> &'static str {
        "modes"
    }

    fn positions(&self) -> &[f64] {
        &self.0
    }

    fn batch(&self) -> usize {
        1
    }

    fn evaluate(&self, designs: &[Design]) -> Vec<Result<Evaluation, SweepError>> {
        let one = |design: &Design| {
            let SpringStiffness::Constant(guide) = design.machine.joints[0].springs[0].stiffness else { panic!() };
            let SpringStiffness::BallScrew { diameter, .. } = design.machine.joints[1].springs[0].stiffness else {
                panic!()
            };
            let at = Extremum { frequency: 100.0, value: stiffness(guide, diameter).recip() };
            let pair = |i| PairMetrics { output: i, input: i, peak: at, most_negative_real: at };
            let here = PositionMetrics {
                pairs: (0..3).map(pair).collect(),
                static_compliance: vec![0.0; 3],
                families: vec![],
            };
            Ok(vec![here; self.0.len()])
        };
        designs.iter().map(one).collect()
    }
}

fn found(text: &str, known: &[Row]) -> (Study, Found, usize) {
    let study = read(text).unwrap_or_else(|e| panic!("{e}"));
    let mut new = 0;
    let hill = Hill(study.positions.clone());
    let found = optimise(&study, &hill, known, &Interrupt::default(), &mut |_| {
        new += 1;
        Ok(())
    });
    (study, found.unwrap_or_else(|e| panic!("{e}")), new)
}

#[test]
fn the_top_of_a_known_hill_is_found() {
    let (_, found, _) = found(STUDY, &[]);
    let best = &found.rows[found.best.unwrap()];
    assert!((best.values[0] / 60e6 - 1.0).abs() < 1e-2 && (best.values[1] - 0.018).abs() < 1e-4, "{:?}", best.values);
    assert!(found.rows.len() < 450);
}

#[test]
fn a_bound_holds_where_it_cuts_the_top_off() {
    // cost = 10 + 2 per N/um of guide: at most 90 keeps the guide at 40 N/um.
    let text = changed("[bounds]", "[bounds]\ncost = { max = 90 }");
    let (_, found, _) = found(&text, &[]);
    let best = &found.rows[found.best.unwrap()];
    assert_eq!(best.bounds_met, Some(true));
    assert!((best.values[0] / 40e6 - 1.0).abs() < 2e-2 && best.values[0] <= 40e6, "{:?}", best.values);
    assert!((best.values[1] - 0.018).abs() < 5e-4, "{:?}", best.values);
}

#[test]
fn a_search_goes_on_from_its_log_to_the_same_end() {
    let (_, whole, new) = found(STUDY, &[]);
    assert_eq!(new, whole.rows.len());
    let (_, again, new) = found(STUDY, &whole.rows[..37]);
    assert_eq!(new, whole.rows.len() - 37, "known evaluations are not computed again");
    assert_eq!(again.rows, whole.rows);
    let (_, other, _) = found(&(STUDY.to_owned() + "\n[optimise]\nseed = 5\n"), &[]);
    assert_ne!(other.rows[3].values, whole.rows[3].values, "another seed looks elsewhere");
}

#[test]
fn the_command_writes_log_best_design_and_picture_and_continues() {
    let text = STUDY.to_owned() + "\n[optimise]\nobjective = \"stiffness_x\"\nevaluations = 24\nseed = 3\n";
    let folder = folder_with(&text);
    let run = |out: &str, arguments: &[&str]| {
        let mut command = stiffmap();
        command.current_dir(folder.path()).args(["optimise", "study.toml", "--out", out]).args(arguments);
        command.output().unwrap()
    };
    done(&run("out", &[]));
    let file = |out: &str, name: &str| std::fs::read_to_string(folder.path().join(out).join(name)).unwrap();
    let log = file("out", "evaluations.csv");
    assert!(log.lines().count() > 20, "{log}");
    assert!(file("out", "best.toml").contains("name = \"screw\"\ndiameter = "));
    for picture in ["figures/convergence.png", "figures/best_over_position.png"] {
        assert!(out_of(&folder).join(picture).is_file(), "{picture}");
    }
    // Cut in the middle of a row, as a kill leaves it.
    std::fs::write(out_of(&folder).join("evaluations.csv"), &log[..log.len() / 2]).unwrap();
    std::fs::remove_file(out_of(&folder).join("manifest.json")).unwrap();
    let refused = run("out", &["--no-figures"]);
    assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
    done(&run("out", &["--resume", "--no-figures"]));
    assert_eq!(file("out", "evaluations.csv"), log);
}

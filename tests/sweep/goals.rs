//! Metrics over positions, rows, bounds, fronts.

use super::*;
use stiffmap::frf::metrics::{Extremum, PairMetrics};
use stiffmap::sweep::pareto::{best, dominates, front, non_dominated};
use stiffmap::sweep::table::{Row, number};
use stiffmap::sweep::{Evaluation, PositionMetrics, SweepError};

/// An evaluation whose largest compliance (m/N) of both directions is given for each position.
fn evaluation(peaks: &[[f64; 3]], families: &[Option<f64>]) -> Evaluation {
    let at = |(p, peaks): (usize, &[f64; 3])| PositionMetrics {
        pairs: (0..3)
            .map(|i| PairMetrics {
                output: i,
                input: i,
                peak: Extremum { frequency: 100.0 + p as f64, value: peaks[i] },
                most_negative_real: Extremum { frequency: 90.0, value: -0.5 * peaks[i] },
            })
            .collect(),
        static_compliance: peaks.iter().map(|peak| 0.1 * peak).collect(),
        families: families.to_vec(),
    };
    peaks.iter().enumerate().map(at).collect()
}

/// The study with a metric of each kind at three positions.
fn study() -> Study {
    let metrics = r#"[metrics.stiffness]
kind = "dynamic-stiffness"
directions = ["x", "z"]
[metrics.weak]
kind = "compliance"
directions = ["x"]
[metrics.chatter]
kind = "negative-real-part"
directions = ["x"]
over = "mean"
[metrics.static]
kind = "static-stiffness"
directions = ["x"]
over = "each"
[metrics.mode]
kind = "eigenfrequency"
families = [3]
over = "worst"
[cost]"#;
    let text = changed("machine = ", "positions = [0, \"-150 mm\", \"-300 mm\"]\nmachine = ");
    let text = text
        .replace("[metrics.stiffness]\nkind = \"dynamic-stiffness\"\ndirections = [\"x\", \"z\"]\n\n[cost]", metrics);
    read(&text).unwrap_or_else(|e| panic!("{e}"))
}

fn cell(study: &Study, row: &Row, name: &str) -> Option<f64> {
    let at = study.result_columns().iter().position(|c| c.name == name);
    row.results[at.unwrap_or_else(|| panic!("no column {name}"))]
}

const PEAKS: [[f64; 3]; 3] = [[1e-7, 0.0, 1e-8], [4e-7, 0.0, 2e-8], [2e-7, 0.0, 5e-8]];

#[test]
fn positions_come_together_as_the_study_says() {
    let study = study();
    let row = Row::new(&study, 0, vec![50e6, 0.016], &Ok(evaluation(&PEAKS, &[Some(120.0)])));
    let about = |name: &str, expected: f64| {
        let found = cell(&study, &row, name).unwrap_or_else(|| panic!("{name} is empty"));
        assert!((found / expected - 1.0).abs() < 1e-12, "{name}: {found}, expected {expected}");
    };
    about("stiffness_x", 2.5e6);
    about("stiffness_z", 2e7);
    about("weak_x", 4e-7);
    about("weak_x position", -0.15);
    about("weak_x frequency", 101.0);
    about("chatter_x", -0.5 * 7e-7 / 3.0);
    about("static_x at -0.3 m", 5e7);
    about("mode_3", 120.0);
    about("cost", 110.0);
    assert_eq!((row.bounds_met, &row.error), (Some(true), &None));
    let units: Vec<String> = study.result_columns().iter().map(|c| c.header()).collect();
    assert!(units.contains(&"weak_x position [m]".to_owned()) && units.contains(&"chatter_x [m/N]".to_owned()));
}

#[test]
fn a_lost_family_leaves_its_cells_empty_and_the_row_says_so() {
    let study = study();
    let mut lost = evaluation(&PEAKS, &[Some(120.0)]);
    lost[1].families[0] = None;
    let row = Row::new(&study, 5, vec![50e6, 0.016], &Ok(lost));
    assert_eq!(cell(&study, &row, "mode_3"), None);
    assert!(cell(&study, &row, "stiffness_x").is_some(), "the other metrics stand");
    let said = row.error.clone().unwrap();
    assert!(said.contains("mode_3: tracking lost the family at -0.15 m"), "{said}");
    let line = String::from_utf8(row.line(&study)).unwrap();
    assert!(line.contains(",,") && !line.contains(",0,"), "empty, not 0: {line}");
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
    let mut record = csv::ByteRecord::new();
    assert!(reader.read_byte_record(&mut record).unwrap());
    assert_eq!(Row::parse(&study, &record).unwrap(), row);
}

#[test]
fn a_design_that_fails_has_a_row_without_values() {
    let study = study();
    let error = SweepError::Value { what: "screw".into(), seen: -1.0, allowed: "positive" };
    let row = Row::new(&study, 2, vec![50e6, 0.016], &Err(error));
    assert!(row.results.iter().skip(1).all(Option::is_none) && row.bounds_met.is_none());
    assert_eq!(row.error.as_deref(), Some("screw: -1; allowed: positive"));
}

#[test]
fn numbers_are_written_with_the_fewest_digits_that_read_back() {
    for value in [0.0, 1.0, -2.5e-9, 77e6, 1.0 / 3.0, 1e300, 5e-324, 123_456_789.123_456_79] {
        assert_eq!(number(value).parse::<f64>().unwrap(), value);
        assert!(number(value).len() <= 24, "{}", number(value));
    }
    assert_eq!((number(77e6), number(2.5e-9)), ("77000000".into(), "2.5e-9".into()));
}

#[test]
fn the_front_is_what_nothing_dominates() {
    let mut numbers = 1_u64;
    let mut uniform = || {
        numbers = numbers.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (numbers >> 40) as f64 / f64::from(1 << 24)
    };
    for d in [2, 3] {
        let points: Vec<Vec<f64>> = (0..300).map(|_| (0..d).map(|_| uniform()).collect()).collect();
        let beaten = |i: usize| points.iter().any(|other| dominates(other, &points[i]));
        let expected: Vec<usize> = (0..points.len()).filter(|&i| !beaten(i)).collect();
        assert_eq!(non_dominated(&points), expected);
        assert!(expected.len() > 3 && expected.len() < 200);
    }
    assert_eq!(non_dominated(&[vec![1.0, 1.0], vec![1.0, 1.0], vec![2.0, 0.0], vec![2.0, 2.0]]), [0, 1, 2]);
}

#[test]
fn bounds_keep_designs_off_the_front_and_out_of_the_best() {
    let study = read(STUDY).unwrap();
    // Stiffness in x: 1, 5 and 20 N/um; the bound asks for 0.1.
    let row = |index: u64, guide: f64, peak: f64| {
        Row::new(&study, index, vec![guide, 0.016], &Ok(evaluation(&[[peak, 1e-9, 1e-9]; 5], &[])))
    };
    let rows = [row(0, 30e6, 1e-6), row(1, 40e6, 2e-7), row(2, 90e6, 5e-8), row(3, 50e6, 2e-7), row(4, 26e6, 5e-5)];
    assert_eq!(rows[4].bounds_met, Some(false));
    let found: Vec<u64> = front(&study, &rows).iter().map(|row| row.index).collect();
    assert_eq!(found, [0, 1, 2], "3 costs more than 1, 4 misses the bound");
    assert_eq!(best(&study, &rows).unwrap().index, 2);
    assert!(best(&study, &rows[4..]).is_none());
}

#[test]
fn a_static_stiffness_beside_loss_factors_is_told_to_be_without_damping() {
    let metric = "[metrics.static]\nkind = \"static-stiffness\"\ndirections = [\"x\"]\n[cost]";
    let with = |loss: &str| {
        let text = changed("[cost]", metric).replace("[objectives]", &format!("[damping]\n{loss}\n[objectives]"));
        read(&text).unwrap_or_else(|e| panic!("{e}")).remarks()
    };
    // k (1 + 0.2 j) is stiffer than k by sqrt(1.04).
    let told = with("loss_factor = 0.2");
    assert!(told.len() == 1 && told[0].contains("without damping") && told[0].contains("1.98 %"), "{told:?}");
    assert!(with("ratio = 0.02").is_empty(), "viscous damping rests at 0 Hz");
    assert!(read(STUDY).unwrap().remarks().is_empty(), "control: no such metric");
}

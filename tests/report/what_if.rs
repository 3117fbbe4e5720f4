//! Machines that the page changes itself, against real runs of these machines: responses within the accuracy that the
//! page states, no frequency drawn that is off by more than 0.1 %.
//!
//! The bundled mill with dampers in its guides and loss factors in its bearings: damping that couples the modes.

use crate::browser::Browser;
use crate::page::ONE;
use crate::{folder, stiffmap};
use nalgebra::Complex;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::PoisonError;
use stiffmap::figures::report::{DATABASE_FILE, Database};
use stiffmap::frf::{FrfRequest, Quantity, modal_sum};

/// Ends and one station between, m; the page holds these too.
const POSITIONS: [f64; 3] = [0.0, -0.3, -0.6];
/// Frequencies: up to 900 Hz in steps of 6.
const COUNT: usize = 150;
/// What a run itself leaves out: the bound on its truncation.
const OF_THE_RUN: f64 = 1e-4;

/// Responses `[frequency]` of 3 x 3 at a position, m/N.
type Responses = Vec<[Complex<f64>; 9]>;

/// Factors of the guides' and bearings' stiffness and of the screw's diameter, and a ratio for all modes, if any.
struct Setting([f64; 3], Option<f64>);

/// The ends of the range and some between.
const FEW: [Setting; 4] = [
    Setting([0.25, 0.25, 0.5], None),
    Setting([4.0, 4.0, 2.0], Some(0.001)),
    Setting([2.47, 0.5, 1.6], None),
    Setting([0.59, 3.79, 0.64], Some(0.02)),
];

fn frequency(k: usize) -> f64 {
    6.0 * (k + 1) as f64
}

/// Runs the mill with dampers and changed joints; returns the result folder.
fn run(name: &str, Setting([guides, bearings, screw], ratio): &Setting) -> PathBuf {
    let (machine, out) = (folder(&format!("{name}-machine")), folder(name));
    stiffmap(&["init", machine.to_str().unwrap()]);
    let file = machine.join("machine.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let guide = "stiffness = { x = \"77 N/um\", y = \"77 N/um\" }";
    let bearing = "stiffness = { radial = \"119.8 N/um\", axial = \"59.5 N/um\" }";
    let diameter = "diameter = \"40 mm\"";
    assert_eq!([guide, bearing, diameter].map(|line| text.matches(line).count()), [4, 4, 1]);
    let (x, radial, axial) = (77.0 * guides, 119.8 * bearings, 59.5 * bearings);
    let text = text
        .replace(
            guide,
            &format!(
                "stiffness = {{ x = \"{x} N/um\", y = \"{x} N/um\" }}\n\
                 damping = {{ x = \"8000 N s/m\", y = \"8000 N s/m\" }}"
            ),
        )
        .replace(
            bearing,
            &format!("stiffness = {{ radial = \"{radial} N/um\", axial = \"{axial} N/um\" }}\nloss_factor = 0.1"),
        )
        .replace(diameter, &format!("diameter = \"{} mm\"", 40.0 * screw));
    std::fs::write(&file, text).unwrap();
    let list = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v.to_string()).collect::<Vec<_>>().join(",");
    let positions = list(&mut POSITIONS.into_iter());
    let frequencies = list(&mut (0..COUNT).map(frequency));
    let mut arguments = vec!["run", machine.to_str().unwrap(), "--out", out.to_str().unwrap()];
    arguments.extend(["--positions", &positions, "--frequencies", &frequencies, "--map-memory", "0"]);
    let ratio = ratio.map(|zeta| zeta.to_string());
    if let Some(zeta) = &ratio {
        arguments.extend(["--damping", zeta]);
    }
    stiffmap(&arguments);
    out
}

/// The map of a run, from a run's compliance.npy.
fn responses(run: &Path) -> Vec<Responses> {
    let bytes = std::fs::read(run.join("compliance.npy")).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8_lossy(&bytes[10..start]).into_owned();
    assert!(header.contains("<c16") && header.contains(&format!("(3, {COUNT}, 3, 3")), "{header}");
    let numbers: Vec<f64> = bytes[start..].as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
    rows(&numbers)
}

fn rows(numbers: &[f64]) -> Vec<Responses> {
    assert_eq!(numbers.len(), POSITIONS.len() * COUNT * 18);
    let value = |at: usize| Complex::new(numbers[2 * at], numbers[2 * at + 1]);
    let one = |p: usize, k: usize| std::array::from_fn(|e| value((p * COUNT + k) * 9 + e));
    (0..POSITIONS.len()).map(|p| (0..COUNT).map(|k| one(p, k)).collect()).collect()
}

/// The map that a modal database holds the sums of.
fn summed_from(file: &Path) -> Vec<Responses> {
    let database = Database::read(file).unwrap().0;
    let (positions, frequencies) = database.axes().unwrap();
    let map = modal_sum(&FrfRequest {
        positions: &positions,
        systems: &database.systems().unwrap(),
        frequencies: &frequencies,
        outputs: &database.header.outputs,
        inputs: &database.header.inputs,
        quantity: Quantity::Receptance,
    })
    .unwrap();
    let one = |p: usize, k: usize| std::array::from_fn(|e| map.at(p, k, e / 3, e % 3));
    (0..positions.len()).map(|p| (0..COUNT).map(|k| one(p, k)).collect()).collect()
}

/// Largest difference as a share of the Frobenius norm of the 3 x 3.
fn difference(own: &[Responses], exact: &[Responses]) -> f64 {
    let norm = |h: &[Complex<f64>; 9]| h.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
    let one = |(a, b): (&[Complex<f64>; 9], &[Complex<f64>; 9])| norm(&std::array::from_fn(|e| a[e] - b[e])) / norm(b);
    own.iter().flatten().zip(exact.iter().flatten()).map(one).fold(0.0, f64::max)
}

/// Elastic frequencies by rank at every position, Hz, from a run's eigenfrequencies.csv.
fn frequencies(run: &Path) -> Vec<Vec<f64>> {
    let mut reader = csv::Reader::from_path(run.join("eigenfrequencies.csv")).unwrap();
    let mut all = vec![Vec::new(); POSITIONS.len()];
    for record in reader.records() {
        let values: Vec<f64> = record.unwrap().iter().map(|v| v.parse().unwrap()).collect();
        let p = POSITIONS.iter().position(|p| (p - values[0]).abs() < 1e-9).unwrap();
        if values[3] > 0.0 {
            all[p].push(values[3]);
        }
    }
    all.iter_mut().for_each(|list| list.sort_by(f64::total_cmp));
    all
}

/// The page at a setting: all responses by `responseAt` or `projectedAt`, and the frequencies that it draws.
fn on_the_page(browser: &mut Browser, setting: &Setting, which: &str) -> (Vec<Responses>, Vec<Vec<f64>>) {
    let Setting([guides, bearings, screws], ratio) = setting;
    let state = json!({ "factors": { "guides": guides, "bearings": bearings, "screws": screws }, "damping": ratio });
    let numbers = browser.numbers(&format!(
        "stiffmap.page.set({state}).then(() => {{
            const out = [];
            const value = [0, 0];
            for (const system of stiffmap.page.engine.systems)
                for (let k = 1; k <= {COUNT}; k++)
                    for (let e = 0; e < 9; e++) {{
                        {which}(system, Math.floor(e / 3), e % 3, 3, 6 * k, 0, value);
                        out.push(...value);
                    }}
            return out;
        }})"
    ));
    let drawn = browser.evaluate("[0, 1, 2].map((p) => stiffmap.page.drawnFrequencies(p))");
    let list = |v: &Value| v.as_array().unwrap().iter().map(|f| f.as_f64().unwrap()).collect();
    (rows(&numbers), drawn.as_array().unwrap().iter().map(list).collect())
}

/// Compares the page with runs at some settings.
fn compare(settings: &[Setting]) {
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let nominal = run("what-if", &Setting([1.0; 3], None));
    let Some(mut browser) = Browser::open(false, [1300, 900]) else { return };
    browser.report(&nominal.join("report.html"), "?webgpu=off");
    let accuracy = browser.evaluate("stiffmap.page.db.header.accuracy");
    let stated = |key: &str| accuracy[key].as_f64().unwrap();
    println!("stated: {}", browser.evaluate("document.getElementById('reach').textContent"));
    assert!(stated("reach_hz") >= 900.0 && stated("response") < 5e-3 && stated("response_least") < 5e-2, "{accuracy}");

    let as_run = responses(&nominal);
    let unchanged = Setting([1.0; 3], None);
    let own = difference(&on_the_page(&mut browser, &unchanged, "responseAt").0, &as_run);
    let projected = difference(&on_the_page(&mut browser, &unchanged, "projectedAt").0, &as_run);
    println!("as run: {own:.1e} of the norm, projected {projected:.1e}");
    assert!(own < 1e-12, "the page sums what the run sums: {own:.1e}");
    assert!(projected > 1e-2, "control: this machine's damping couples its modes, {projected:.1e}");

    let again = summed_from(&nominal.join(DATABASE_FILE));
    let apart = difference(&again, &as_run);
    assert!(apart < 1e-12, "`stiffmap figures` draws from the same sums: {apart:.1e}");

    for (k, setting) in settings.iter().enumerate() {
        let changed = run("what-if-changed", setting);
        let exact = responses(&changed);
        let (page, drawn) = on_the_page(&mut browser, setting, "responseAt");
        let bound = stated(if setting.1.is_some() { "response_least" } else { "response" }) + OF_THE_RUN;
        let own = difference(&page, &exact);
        let truth = frequencies(&changed);
        assert!(drawn.iter().zip(&truth).all(|(d, t)| d.len() >= t.len()), "all listed modes lie within the reach");
        let by_rank = || drawn.iter().zip(&truth).flat_map(|(d, t)| d.iter().zip(t));
        let worst = |scale: f64| by_rank().map(|(d, t)| (scale * d / t - 1.0).abs()).fold(0.0, f64::max);
        let off = worst(1.0);
        println!(
            "{:?} {:?}: responses {own:.1e} of the norm (stated {bound:.1e}), frequencies {off:.1e}",
            setting.0, setting.1
        );
        assert!(own <= bound, "{own:.2e} of the norm");
        assert!(off <= 1e-3, "a drawn frequency is off by {off:.2e}");
        assert!(difference(&as_run, &exact) > 10.0 * bound, "control: the machine as run is another");
        assert!(worst(1.002) > 1e-3, "control: frequencies 0.2 % off");
        if k == 0 {
            at_rest(&mut browser, &exact);
        }
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
    assert_eq!(browser.evaluate("stiffmap.errors"), json!([]));
}

/// The surface, once nothing moves, has its damping exact, and the line at the top says so.
fn at_rest(browser: &mut Browser, exact: &[Responses]) {
    let shown = browser.numbers(
        "stiffmap.page.set({ output: 1, input: 1, from: 6, to: 900, resolution: 150 })
            .then(() => stiffmap.page.settled).then(() => Array.from(stiffmap.page.map.values))",
    );
    let place = |p: usize, k: usize| 2 * (p * COUNT + k);
    let value = |at: usize| Complex::new(shown[at], shown[at + 1]) * 1e-6;
    let mut worst: f64 = 0.0;
    for (p, row) in exact.iter().enumerate() {
        for (k, h) in row.iter().enumerate() {
            worst = worst.max((value(place(p, k)) - h[4]).norm() / h[4].norm());
        }
    }
    let engine = browser.evaluate("document.getElementById('engine').textContent");
    println!("surface at rest: {worst:.1e} of yy; {engine}");
    assert!(worst < 5e-3, "{worst:.2e}");
    assert!(engine.as_str().unwrap().contains("exact"), "{engine}");
}

#[test]
fn the_page_follows_its_sliders_within_what_it_states() {
    compare(&FEW);
}

/// `cargo test --release --test report -- --ignored` for twenty settings.
#[test]
#[ignore = "twenty runs"]
fn the_page_follows_its_sliders_at_twenty_settings() {
    let spread = |k: usize, g: usize| ((k * [7, 11, 13][g] + 3 * g) % 20) as f64 / 19.0;
    let of = |k: usize| {
        let factor = |g: usize| 0.25 * 16f64.powf(spread(k, g));
        let ratio = (k % 2 == 1).then(|| 0.001 * 200f64.powf(spread(k, 1)));
        Setting([factor(0), factor(1), factor(2).sqrt()], ratio)
    };
    compare(&(0..20).map(of).collect::<Vec<_>>());
}

#[test]
fn what_the_page_cannot_reach_is_neither_listed_nor_drawn() {
    let nominal = folder("reach");
    // Sixty modes reach 1150 Hz; a map to 60 Hz at 214 positions leaves no time for so many coordinates.
    let arguments = ["--frequencies", "0:60:1", "--modes", "60", "--positions", "0:-0.6:0.0025"];
    stiffmap(&[&["run", "--out", nominal.to_str().unwrap()], &arguments[..]].concat());
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(mut browser) = Browser::open(false, [1300, 900]) else { return };
    browser.report(&nominal.join("report.html"), "?webgpu=off");
    let reach = browser.evaluate("stiffmap.page.reach").as_f64().unwrap();
    println!("reach {reach:.0} Hz");
    assert!((60.0..1100.0).contains(&reach), "{reach}");
    let ask = "stiffmap.page.set({ factors: { guides: 1.5, bearings: 2, screws: 1 }, position: 0 }).then(() => {
        const p = stiffmap.page.state.position;
        const cells = Array.from(document.querySelectorAll('#mode-table tbody tr'), (row) => row.cells[4].textContent);
        return [cells, stiffmap.page.drawnFrequencies(p), stiffmap.page.engine.systems[p].frequency.length];
    })";
    let answer = browser.evaluate(ask);
    let cells: Vec<&str> = answer[0].as_array().unwrap().iter().map(|c| c.as_str().unwrap()).collect();
    let drawn = answer[1].as_array().unwrap();
    assert!(drawn.iter().all(|f| f.as_f64().unwrap() <= reach));
    let (beyond, known): (Vec<&str>, Vec<&str>) = cells.iter().partition(|c| c.contains("beyond the page's reach"));
    println!("{} listed, {} beyond", known.len(), beyond.len());
    assert!(!beyond.is_empty() && !known.is_empty());
    assert!(known.iter().filter_map(|c| c.parse::<f64>().ok()).all(|f| f <= reach));
    assert!(answer[2].as_u64().unwrap() as usize > drawn.len(), "control: there is more to hide");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

//! The page of the bundled mill: what it computes against the run's files, how fast, and what it looks like.

use crate::browser::Browser;
use crate::{folder, mill, stiffmap};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

type Complex = nalgebra::Complex<f64>;

/// One browser at a time, so that times are its own.
pub static ONE: Mutex<()> = Mutex::new(());

/// Direct responses by position and frequency (in nanometres and microhertz), from a surface file.
struct Surface(BTreeMap<(i64, i64), Complex>);

impl Surface {
    fn read(folder: &Path, name: &str) -> Surface {
        let mut reader = csv::Reader::from_path(folder.join(name)).unwrap();
        let rows = reader.records().map(|record| {
            let v: Vec<f64> = record.unwrap().iter().map(|text| text.parse().unwrap()).collect();
            (key(v[0], v[1]), Complex::from_polar(v[2], v[3].to_radians()))
        });
        Surface(rows.collect())
    }

    fn at(&self, position: f64, frequency: f64) -> Complex {
        self.0[&key(position, frequency)]
    }
}

fn key(position: f64, frequency: f64) -> (i64, i64) {
    ((position * 1e9).round() as i64, (frequency * 1e6).round() as i64)
}

/// The map on the page, um/N as m/N.
struct Map {
    positions: Vec<f64>,
    frequencies: Vec<f64>,
    values: Vec<f64>,
}

impl Map {
    fn read(browser: &mut Browser) -> Map {
        Map {
            positions: browser.numbers("Array.from(stiffmap.page.db.positions)"),
            frequencies: browser.numbers("Array.from(stiffmap.page.map.frequencies)"),
            values: browser.numbers("Array.from(stiffmap.page.map.values)"),
        }
    }

    fn at(&self, p: usize, k: usize) -> Complex {
        let at = 2 * (p * self.frequencies.len() + k);
        Complex::new(self.values[at], self.values[at + 1]) * 1e-6
    }

    /// Largest relative difference from a file at `count` pairs spread over positions and frequencies.
    fn difference(&self, file: &Surface, positions: &[usize], count: usize) -> f64 {
        let one = |s: usize| {
            let (p, k) = (positions[(s * 37) % positions.len()], (s * 101 + 7) % self.frequencies.len());
            let expected = file.at(self.positions[p], self.frequencies[k]);
            (self.at(p, k) - expected).norm() / expected.norm()
        };
        (0..count).map(one).fold(0.0, f64::max)
    }
}

/// Every direction of the tool with its surface file.
const DIRECTIONS: [(usize, &str); 3] = [(0, "surface_xx.csv"), (1, "surface_yy.csv"), (2, "surface_zz.csv")];

fn show(browser: &mut Browser, direction: usize) -> Map {
    // 451 frequencies over 900 Hz: every second of the run's.
    browser.evaluate(&format!(
        "stiffmap.page.set({{ output: {direction}, input: {direction}, resolution: 451 }}).then(() => true)"
    ));
    Map::read(browser)
}

fn pictures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("results/report")
}

/// The bundled mill with guides 1.5 times as stiff, as a machine of its own, at some stations.
fn stiffer() -> PathBuf {
    let (machine, out) = (folder("stiffer"), folder("stiffer-out"));
    stiffmap(&["init", machine.to_str().unwrap()]);
    let file = machine.join("machine.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let of = |k: f64| format!("stiffness = {{ x = \"{k} N/um\", y = \"{k} N/um\" }}");
    let (old, new) = (of(77.0), of(115.5));
    assert_eq!(text.matches(&old).count(), 4);
    std::fs::write(&file, text.replace(&old, &new)).unwrap();
    let stations = ["--no-figures", "--positions", "0,-0.095,-0.3,-0.455,-0.6"];
    stiffmap(&[&["run", machine.to_str().unwrap(), "--out", out.to_str().unwrap()], &stations[..]].concat());
    out
}

#[test]
fn the_page_computes_the_runs_map_by_webgpu_and_follows_the_guides() {
    let page = mill().join("report.html");
    let bytes = std::fs::metadata(&page).unwrap().len();
    println!(
        "page {bytes} bytes, modal database {}",
        std::fs::metadata(mill().join("modal_database.bin")).unwrap().len()
    );
    assert!(bytes <= 10_000_000, "the page has {bytes} bytes");
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(mut browser) = Browser::open(true, [1500, 1000]) else { return };
    browser.report(&page, "");
    let first = browser.evaluate("stiffmap.timings.first").as_f64().unwrap();
    let engine = browser.evaluate("document.getElementById('engine').textContent");
    println!("{engine}; first surface {first:.0} ms after navigation");
    assert!(first < 9000.0, "{first:.0} ms");
    assert!(engine.as_str().unwrap().contains("WebGPU ("), "{engine}");

    let every: Vec<usize> = (0..121).collect();
    for (direction, file) in DIRECTIONS {
        let map = show(&mut browser, direction);
        let difference = map.difference(&Surface::read(mill(), file), &every, 100);
        println!("{file}: 100 pairs within {difference:.1e}");
        assert!(difference <= 1e-5, "{file}: {difference:.2e}");
        let other = DIRECTIONS[(direction + 1) % 3].1;
        assert!(map.difference(&Surface::read(mill(), other), &every, 100) > 1e-2, "control: another direction");
    }

    let changed = stiffer();
    let before = show(&mut browser, 0);
    let slide = "(async () => {
        const slider = document.getElementById('factor-guides');
        slider.value = 1.5;
        slider.dispatchEvent(new Event('input', { bubbles: true }));
        await stiffmap.page.busy;
        return stiffmap.page.state.factors.guides;
    })()";
    assert_eq!(browser.evaluate(slide), json!(1.5));
    let stations: Vec<usize> = [0.0, -0.095, -0.3, -0.455, -0.6]
        .map(|z: f64| before.positions.iter().position(|p| (p - z).abs() < 1e-9).unwrap())
        .to_vec();
    for (direction, file) in DIRECTIONS {
        let map = show(&mut browser, direction);
        let expected = Surface::read(&changed, file);
        let difference = map.difference(&expected, &stations, 2000);
        println!("guides times 1.5, {file}: 2000 pairs within {difference:.1e}");
        assert!(difference <= 1e-3, "{file}: {difference:.2e}");
        if direction == 0 {
            assert!(before.difference(&expected, &stations, 2000) > 0.1, "control: the machine as run");
        }
    }
    measure(&mut browser);
    look(&mut browser);
    assert_eq!(browser.complaints(), Vec::<String>::new());
    assert_eq!(browser.evaluate("stiffmap.errors"), json!([]));
}

/// Times from a slider's event to the frame that shows the new surface at 121 x 450 pairs; docs/report.md says what an
/// idle machine takes, a busy one may take three times that.
fn measure(browser: &mut Browser) {
    let ask = "(async () => {
        const page = stiffmap.page;
        await page.set({ output: 0, input: 0, resolution: 450 });
        const slider = document.getElementById('factor-guides');
        const times = [];
        for (const factor of [1.1, 1.3, 1.7, 0.8, 2.2, 1.4, 0.6]) {
            await new Promise((resolve) => setTimeout(resolve, 400));
            slider.value = factor;
            const start = performance.now();
            slider.dispatchEvent(new Event('input', { bubbles: true }));
            await page.busy;
            times.push(stiffmap.timings.last.at - start);
        }
        return times;
    })()";
    let mut times = browser.numbers(ask);
    times.sort_by(f64::total_cmp);
    println!(
        "slider to surface, ms: {:.0} to {:.0}, median {:.0}",
        times[0],
        times[times.len() - 1],
        times[times.len() / 2]
    );
    let split = browser.evaluate("stiffmap.timings.last");
    println!("of the last: {split}");
    assert!(times[times.len() / 2] < 900.0, "{times:?}");
}

/// Screenshots: light and dark, the panels further down.
fn look(browser: &mut Browser) {
    browser
        .evaluate("stiffmap.page.set({ factors: { ...stiffmap.page.state.factors, guides: 1.5 } }).then(() => true)");
    let settle = "new Promise((resolve) => setTimeout(resolve, 500))";
    for (name, scheme, place) in [
        ("light", "light", "surface-panel"),
        ("dark", "dark", "surface-panel"),
        ("curves", "light", "over-frequency"),
        ("shapes", "light", "shape"),
        ("tables", "light", "family-table"),
    ] {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        browser.call("Emulation.setEmulatedMedia", json!({ "features": features }));
        browser.evaluate(&format!("document.getElementById('{place}').scrollIntoView()"));
        browser.evaluate(settle);
        browser.screenshot(&pictures().join(format!("{name}.png")));
    }
}

#[test]
fn without_webgpu_the_page_computes_the_same_in_javascript() {
    let page = mill().join("report.html");
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(mut browser) = Browser::open(false, [1300, 900]) else { return };
    browser.report(&page, "?webgpu=off");
    let engine = browser.evaluate("document.getElementById('engine').textContent");
    assert!(engine.as_str().unwrap().contains("JavaScript"), "{engine}");
    let every: Vec<usize> = (0..121).collect();
    let map = show(&mut browser, 1);
    let difference = map.difference(&Surface::read(mill(), "surface_yy.csv"), &every, 100);
    println!("JavaScript: 100 pairs within {difference:.1e}");
    assert!(difference <= 1e-7, "{difference:.2e}");
    browser
        .evaluate("stiffmap.page.set({ factors: { ...stiffmap.page.state.factors, bearings: 0.5 } }).then(() => true)");
    let changed = Map::read(&mut browser);
    assert!(
        changed.difference(&Surface::read(mill(), "surface_yy.csv"), &every, 100) > 1e-2,
        "control: softer bearings"
    );
    browser.screenshot(&pictures().join("without_webgpu.png"));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

//! The f32 kernels as WebGPU text: compiled by a browser's own compiler, run on its software adapter, same numbers.
//!
//! Runs the browser that STIFFMAP_CHROMIUM names, else `chromium`. Without one the test prints `skipped: no chromium`;
//! with STIFFMAP_GPU=require that is a failure.

mod modal_fixture;

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use modal_fixture::device::device;
use modal_fixture::springs::{AROUND, Machine, all_pairs, frobenius, grid};
use modal_fixture::{Case, differences, rich};
use nalgebra::Complex;
use serde_json::{Value, json};
use stiffmap::frf::metrics::grid_extrema;
use stiffmap::frf::modification::Work;
use stiffmap::frf::{ComplianceMap, Packing, modal_sum};
use stiffmap::gpu::Gpu;
use stiffmap::gpu::modification::{SpringRequest, spring_shader_inputs};
use stiffmap::gpu::shader::{CHUNK, CORE, Extrema, Kernel, Maxima};
use stiffmap::gpu::shader_inputs;

/// Ends the browser whatever the test does.
struct Browser(Child);

impl Drop for Browser {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The page's answer to some jobs, or nothing where there is no browser.
fn ask(jobs: &[Value]) -> Option<Value> {
    let directory = tempfile::tempdir().unwrap();
    let jobs = format!("<script>const JOBS = {};</script>", json!(jobs));
    let page = directory.path().join("page.html");
    std::fs::write(&page, format!("{jobs}\n{}", include_str!("browser/page.html"))).unwrap();
    let program = std::env::var("STIFFMAP_CHROMIUM").unwrap_or_else(|_| "chromium".to_string());
    let child = Command::new(&program)
        .args(["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run"])
        .args(["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-logging=stderr"])
        .arg(format!("--user-data-dir={}", directory.path().join("profile").display()))
        .arg(format!("file://{}", page.display()))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn();
    let mut browser = match child {
        Ok(child) => Browser(child),
        Err(e) => {
            let required = std::env::var("STIFFMAP_GPU").is_ok_and(|v| v == "require");
            assert!(!required, "STIFFMAP_GPU=require and {program} does not start: {e}");
            println!("skipped: no chromium");
            return None;
        }
    };
    let lines = BufReader::new(browser.0.stderr.take().unwrap()).lines();
    let (send, receive) = std::sync::mpsc::channel();
    std::thread::spawn(move || lines.map_while(Result::ok).try_for_each(|line| send.send(line)));
    let (mut text, deadline) = (String::new(), Instant::now() + Duration::from_secs(120));
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        let line = receive.recv_timeout(left).unwrap_or_else(|e| panic!("{program} gave no answer: {e}"));
        let Some((_, piece)) = line.split_once("PIECE<") else {
            continue;
        };
        let piece = piece.rsplit_once('>').map_or(piece, |(piece, _)| piece);
        if piece == "END" {
            break;
        }
        // The log writes quotation marks as they are, so a piece is the text itself.
        text.push_str(piece);
    }
    let answer: Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {}", &text[..200.min(text.len())]));
    assert!(answer["error"].is_null(), "{}", answer["error"]);
    println!("adapter: {} in {program}", answer["adapter"]);
    Some(answer["results"].clone())
}

fn words_of(bytes: &[u8]) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(bytes)
}

fn job(case: &Case, kernel: Kernel, words: usize) -> Value {
    let (source, params, arrays, workgroups) = shader_inputs(&case.request(), kernel);
    let arrays = arrays.map(|bytes| words_of(&bytes));
    let params = words_of(bytemuck::bytes_of(&params));
    json!({ "source": source, "params": params, "arrays": arrays, "workgroups": workgroups, "words": words })
}

/// The job of a kernel that changes springs, and the units of its pairs.
fn spring_job(gpu: &Gpu, request: &SpringRequest<'_>, kernel: Kernel, words: usize) -> (Value, Vec<f64>) {
    let (source, params, arrays, workgroups, units) = spring_shader_inputs(gpu, request, kernel).unwrap();
    let arrays = arrays.map(|bytes| words_of(&bytes));
    let params = words_of(bytemuck::bytes_of(&params));
    let job = json!({ "source": source, "params": params, "arrays": arrays, "workgroups": workgroups, "words": words });
    (job, units)
}

fn words(result: &Value) -> Vec<u32> {
    assert!(result["error"].is_null(), "{}", result["error"]);
    result["words"].as_array().unwrap().iter().map(|w| w.as_u64().unwrap() as u32).collect()
}

#[test]
fn the_kernels_compile_and_compute_the_same_in_a_browser() {
    let mut case = rich(3);
    case.frequencies.truncate(200);
    let request = case.request();
    let packing = Packing::new(&request);
    let (n_positions, n_frequencies, n_pairs) = (request.positions.len(), request.frequencies.len(), 6);
    let chunks = n_frequencies.div_ceil(CHUNK as usize);
    let mut broken = job(&case, Kernel::ModalSum, 2);
    broken["source"] = json!("fn main() { let x: u32 = 1.5; }");
    let jobs = [
        job(&case, Kernel::ModalSum, n_positions * n_frequencies * n_pairs * 2),
        job(&case, Kernel::Metrics, n_positions * chunks * n_pairs * 4),
        broken,
    ];
    let Some(results) = ask(&jobs) else { return };

    let values: Vec<[f32; 2]> =
        bytemuck::cast_vec(words(&results[0]).chunks_exact(2).map(|w| [w[0], w[1]]).collect::<Vec<[u32; 2]>>());
    let mut map: ComplianceMap = modal_sum(&request).unwrap();
    let exact = map.clone();
    for p in 0..n_positions {
        for k in 0..n_frequencies {
            for v in 0..9 {
                let [re, im] = values[(p * n_pairs + packing.pair_of_value[v]) * n_frequencies + k];
                let value = Complex::new(f64::from(re), f64::from(im)) * 1e-6;
                map.values[(p * n_frequencies + k) * 9 + v] = value;
            }
        }
    }
    let (entry, frobenius) = differences(&case, &map);
    let eps = f64::from(f32::EPSILON);
    println!("browser: entry {:.2} eps, Frobenius {frobenius:.2e}", entry / eps);
    assert!(entry <= 8.0 * eps && frobenius <= 2e-6, "entry {:.2} eps, {frobenius:.2e}", entry / eps);

    let records: Vec<Extrema<f32>> = bytemuck::pod_collect_to_vec(&words(&results[1]));
    let expected = grid_extrema(&exact, &packing.pairs);
    for (found, expected) in records.iter().zip(expected.iter().flatten()) {
        let found = (found.peak_at as usize, found.real_part_at as usize);
        assert_eq!(found, (expected.peak, expected.most_negative_real));
    }
    assert!(!results[2]["error"].is_null(), "the browser refuses a shader that is none");
}

#[test]
fn the_kernels_that_change_springs_compute_the_same_in_a_browser() {
    let Some(gpu) = device() else { return };
    let machine = Machine::new(8, 6);
    let base = machine.base(&grid()[..300], AROUND);
    let designs = machine.designs(18, 3, AROUND);
    let pairs = all_pairs();
    let request = SpringRequest { base: &base, designs: &designs, pairs: &pairs, position: 0 };
    let (n, chunk) = (base.frequencies.len(), CORE as usize);
    let chunks = n.div_ceil(chunk);
    let (values, units) = spring_job(&gpu, &request, Kernel::Modification, designs.len() * pairs.len() * n * 2);
    let (maxima, _) = spring_job(&gpu, &request, Kernel::Extrema, designs.len() * chunks * pairs.len() * 6);
    let Some(results) = ask(&[values, maxima]) else { return };

    let exact: Vec<_> = designs.iter().map(|d| base.modified(d, &pairs, &mut Work::default())).collect();
    let real = |w: u32| f64::from(f32::from_bits(w));
    let read: Vec<Complex<f64>> =
        words(&results[0]).chunks_exact(2).map(|w| Complex::new(real(w[0]), real(w[1]))).collect();
    let mut rows = read.chunks_exact(n);
    let found: Vec<Vec<Vec<Complex<f64>>>> = designs
        .iter()
        .map(|_| units.iter().zip(rows.by_ref()).map(|(unit, h)| h.iter().map(|h| h * *unit).collect()).collect())
        .collect();
    let figure = frobenius(&found, &exact);
    println!("browser: Frobenius {figure:.2e}");
    assert!(figure <= 1e-4, "{figure:.2e}");

    let records: Vec<Maxima<f32>> = bytemuck::pod_collect_to_vec(&words(&results[1]));
    for (at, record) in records.iter().enumerate() {
        let (design, part, pair) = (at / pairs.len() / chunks, at / pairs.len() % chunks, at % pairs.len());
        let h = &exact[design][pair];
        let here = part * chunk..((part + 1) * chunk).min(n);
        let top = here.clone().map(|k| h[k].norm_sqr()).fold(0.0, f64::max) / (units[pair] * units[pair]);
        assert!((f64::from(record.peak) / top - 1.0).abs() < 1e-3, "{record:?} {top:e}");
        let bits = u64::from(record.peaks[0]) | u64::from(record.peaks[1]) << 32;
        for k in here.clone().filter(|&k| k > 0 && k + 1 < n) {
            let size = |k: usize| h[k].norm_sqr();
            let clear = |other: usize| size(k) > size(other) * 1.001;
            if clear(k - 1) && clear(k + 1) && size(k) > 0.7 * top * units[pair] * units[pair] {
                assert!(bits >> (k - here.start) & 1 == 1, "the maximum at {k} is missing: {record:?}");
            }
        }
    }
}

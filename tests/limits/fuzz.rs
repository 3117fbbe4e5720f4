//! Mutated machine files through the whole analysis: answered or refused, never a panic, within 10 s and 1 GB each.
//!
//! Some hundred by default; `STIFFMAP_FUZZ=20000 cargo test --release --test limits -- mutated` for more, and
//! `STIFFMAP_FUZZ_FROM=20000` beside it for the next ones. Most changes leave most parts as they were, so reduced parts
//! come from a cache by content, and the machine has few modes. The program itself is fuzzed by
//! `benches/fuzz/machine_files.py`.

use super::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use stiffmap::frf::{FrfRequest, Selection, modal_sum, modal_systems};
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::read_machine;
use stiffmap::pipeline;
use stiffmap::reduction::Cache;

/// Longest that one mutant may take.
const SECONDS: Duration = Duration::from_secs(10);
/// Most that one mutant may bring the process to, bytes.
const BYTES: u64 = 1 << 30;
/// Mutants that share a cache, which would fill the disk otherwise.
const SHARED: u64 = 250;
const EXTREME: [&str; 14] =
    ["0", "-1", "1e-300", "1e300", "-1e300", "1e30", "1e12", "1e-12", "1e-5", "nan", "inf", "7", "1e5", "0.5"];

/// Repeatable numbers (splitmix64).
struct Chance(u64);

impl Chance {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

/// Where numbers stand in a text.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let word = at > 0 && (bytes[at - 1].is_ascii_alphanumeric() || bytes[at - 1] == b'.');
        if !bytes[at].is_ascii_digit() || word {
            at += 1;
            continue;
        }
        let end = (at..bytes.len()).find(|&i| !(bytes[i].is_ascii_digit() || b".e".contains(&bytes[i])));
        let end = end.unwrap_or(bytes.len());
        found.push(at..end);
        at = end;
    }
    found
}

/// The text with one change: a number by another or an extreme one or a power of ten, a line left out or doubled.
fn changed(text: &str, chance: &mut Chance) -> String {
    let all = numbers(text);
    let mut lines: Vec<&str> = text.lines().collect();
    match chance.below(6) {
        kind @ 0..=3 => {
            let at = all[chance.below(all.len())].clone();
            let new = match kind {
                0 => text[all[chance.below(all.len())].clone()].to_owned(),
                1 => {
                    let power = chance.below(25) as i32 - 12;
                    text[at.clone()]
                        .parse::<f64>()
                        .map_or_else(|_| "1".into(), |v| format!("{:e}", v * 10f64.powi(power)))
                }
                _ => EXTREME[chance.below(EXTREME.len())].to_owned(),
            };
            format!("{}{new}{}", &text[..at.start], &text[at.end..])
        }
        4 => {
            lines.remove(chance.below(lines.len()));
            lines.join("\n")
        }
        _ => {
            let line = lines[chance.below(lines.len())];
            lines.insert(chance.below(lines.len()), line);
            lines.join("\n")
        }
    }
}

/// The job of `run` without files: an answer, or what is wrong.
fn analyse(file: &Path, cache: &Cache) -> Result<usize, String> {
    let said = |error: &dyn std::error::Error| error.to_string();
    let machine = read_machine(file).map_err(|e| said(&e))?;
    let meshes = pipeline::read_meshes(&machine).map_err(|e| said(&e))?;
    let _ = pipeline::plausibility(&machine, &meshes);
    let interrupt = Interrupt::default();
    let parts = pipeline::reduce_parts(&machine, &meshes, Some(cache), &interrupt, &|| ()).map_err(|e| said(&e))?;
    let parts: Vec<_> = parts.into_iter().map(|p| p.superelement).collect();
    let (wanted, grid) = (machine.analysis.modes, &machine.analysis.frequencies);
    let highest = grid.iter().copied().fold(0.0, f64::max);
    let model = pipeline::build_model(&machine, &parts, wanted, highest).map_err(|e| said(&e))?.model;
    let [from, to] = machine.axis.travel;
    let positions = [from, 0.37 * to + 0.63 * from, to];
    let solved = pipeline::solve_positions(&machine, &model, &positions, wanted, &interrupt, &|| ());
    let solved = solved.map_err(|e| said(&e))?;
    let selection = Selection::Controlled { tolerance: 1e-4 };
    let (systems, _) = modal_systems(&solved.modes, highest, selection).map_err(|e| said(&e))?;
    let (outputs, inputs) = (model.output_names(), model.input_names());
    let request = FrfRequest {
        positions: &positions,
        systems: &systems,
        frequencies: grid,
        outputs: &outputs,
        inputs: &inputs,
        quantity: machine.analysis.quantity,
    };
    let map = modal_sum(&request).map_err(|e| said(&e))?;
    Ok(map.values.len())
}

/// Ends the tests with the mutant's number where one does not come back: nothing else can stop it.
struct Watch(Arc<AtomicU64>);

impl Watch {
    /// Waits three times the longest that a mutant may take.
    fn start() -> Self {
        let now = Arc::new(AtomicU64::new(0));
        let seen = now.clone();
        std::thread::spawn(move || {
            let (mut last, mut since) = (u64::MAX, Instant::now());
            loop {
                std::thread::sleep(Duration::from_millis(500));
                let number = seen.load(Ordering::Relaxed);
                if number == u64::MAX {
                    return;
                }
                if number != last {
                    (last, since) = (number, Instant::now());
                } else if since.elapsed() > 3 * SECONDS {
                    eprintln!("mutant {number} does not end");
                    std::process::abort();
                }
            }
        });
        Self(now)
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.0.store(u64::MAX, Ordering::Relaxed);
    }
}

/// From here on `resources::peak` is the largest memory since now.
fn forget_peak() {
    // Where the system cannot, the largest of all mutants so far is bounded instead.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

fn number(name: &str, without: u64) -> u64 {
    std::env::var(name).map_or(without, |n| n.parse().unwrap_or_else(|e| panic!("{name}={n}: {e}")))
}

/// The text of a mutant.
fn mutant(original: &str, number: u64) -> String {
    let mut chance = Chance(number);
    (0..=chance.below(3)).fold(original.to_owned(), |text, _| changed(&text, &mut chance))
}

#[test]
fn mutated_machine_files_are_answered_or_refused() {
    let (count, from) = (number("STIFFMAP_FUZZ", 300), number("STIFFMAP_FUZZ_FROM", 0));
    let folder = tempfile::tempdir().unwrap();
    let file = edited(folder.path(), &[("modes = 10", "modes = 5"), ("modes = 8", "modes = 4")]);
    let original = std::fs::read_to_string(&file).unwrap();
    let (mut answered, mut refused, mut bad) = (0, 0, Vec::new());
    let (mut longest, mut largest) = ((Duration::ZERO, 0), (0, 0));
    let mut shared = tempfile::tempdir().unwrap();
    let watch = Watch::start();
    for number in from..from + count {
        if number % SHARED == 0 {
            shared = tempfile::tempdir().unwrap();
        }
        std::fs::write(&file, mutant(&original, number)).unwrap();
        watch.0.store(number, Ordering::Relaxed);
        forget_peak();
        let started = Instant::now();
        let cache = Cache::in_folder(shared.path());
        match catch_unwind(AssertUnwindSafe(|| analyse(&file, &cache))) {
            Ok(Ok(_)) => answered += 1,
            Ok(Err(why)) => {
                assert!(!why.is_empty());
                refused += 1;
            }
            Err(fault) => {
                let said = fault.downcast_ref::<String>().cloned();
                let said = said.or_else(|| fault.downcast_ref::<&str>().map(|s| (*s).to_owned()));
                bad.push((number, said.unwrap_or_else(|| "a fault without words".into())));
            }
        }
        let (took, held) = (started.elapsed(), stiffmap::resources::peak().unwrap_or(0));
        if took > SECONDS || held > BYTES {
            bad.push((number, format!("{took:?}, {held} bytes")));
        }
        longest = longest.max((took, number));
        largest = largest.max((held, number));
    }
    println!("{answered} answered, {refused} refused; longest {longest:?}, largest {largest:?} bytes");
    assert!(bad.is_empty(), "{} bad: {bad:?}", bad.len());
    assert!(answered > count / 20 && refused > count / 20, "control: {answered} answered, {refused} refused");
}

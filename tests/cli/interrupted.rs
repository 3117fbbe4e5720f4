//! Runs that were stopped, and caches that were damaged.

use super::*;
use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::time::Duration;

const QUICK: [&str; 5] = ["--no-figures", "--position", "0", "--frequencies", "0,40"];

/// Ends the program if the test fails before it does.
struct Started(Child);

impl Drop for Started {
    fn drop(&mut self) {
        if matches!(self.0.try_wait(), Ok(None)) {
            // Between the question and this it may have ended by itself.
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }
}

/// Sends SIGINT, as Ctrl-C does.
#[cfg(unix)]
fn interrupt(child: &Child) {
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

#[test]
#[cfg(unix)]
fn an_interrupted_run_leaves_nothing_half_written_and_the_next_one_succeeds() {
    let [cache, out, temporaries] = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let mut command = stiffmap(cache.path());
    command.arg("run").args(QUICK).arg("--out").arg(out.path());
    command.env("TMPDIR", temporaries.path()).stderr(Stdio::piped()).stdout(Stdio::null());
    let mut run = Started(command.spawn().unwrap());
    let mut lines = BufReader::new(run.0.stderr.take().unwrap()).lines().map(Result::unwrap);
    let read = lines.find(|line| line.starts_with("read meshes"));
    assert!(read.is_some(), "the run never came to reducing its parts");
    // Well inside the reduction, which takes many times as long.
    std::thread::sleep(Duration::from_secs(1));
    interrupt(&run.0);
    let rest: Vec<String> = lines.collect();
    assert_eq!(run.0.wait().unwrap().code(), Some(130), "{rest:?}");
    assert!(rest.iter().any(|line| line.starts_with("error: interrupted")), "{rest:?}");
    assert!(!rest.iter().any(|line| line.starts_with("couple")), "{rest:?}");

    assert_eq!(files_below(out.path()), Vec::<PathBuf>::new());
    assert_eq!(files_below(temporaries.path()), Vec::<PathBuf>::new());
    // Whole superelements may have been kept by then; the next run shows that they are whole.
    assert_eq!(files_below(cache.path()).len(), superelements(cache.path()).len());
    let kept = superelements(cache.path()).len();
    assert!(kept < 5, "the interrupt came too late to test anything");

    let again = run_into(cache.path(), out.path(), &QUICK);
    assert_eq!(again.status.code(), Some(0), "{}", stderr(&again));
    let record = manifest(out.path());
    assert_eq!(record["counts"]["parts_from_cache"], kept);
    assert!(!record["warnings"].to_string().contains("damaged"), "{}", record["warnings"]);
}

fn assert_rebuilt(damage: impl FnOnce(Vec<u8>) -> Vec<u8>) {
    let cache = copied_cache();
    // The smallest is the quickest to make again.
    let size = |file: &PathBuf| std::fs::metadata(file).unwrap().len();
    let file = superelements(cache.path()).into_iter().min_by_key(size).unwrap();
    let whole = std::fs::read(&file).unwrap();
    std::fs::write(&file, damage(whole.clone())).unwrap();
    let (sound, mended) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());

    let run = run_into(cache.path(), mended.path(), &QUICK);
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    let record = manifest(mended.path());
    assert_eq!(record["counts"]["parts_from_cache"], 4);
    let warnings = record["warnings"].as_array().unwrap();
    let name = file.file_name().unwrap().to_string_lossy();
    let told = |w: &Value| w.as_str().is_some_and(|w| w.contains(&*name) && w.contains("damaged"));
    assert!(warnings.iter().any(told), "{warnings:?}");
    assert!(stderr(&run).contains("damaged"), "{}", stderr(&run));
    assert!(std::fs::read(&file).unwrap().len() == whole.len(), "the file is written anew");

    let record = quick(sound.path(), &QUICK[1..]);
    assert!(!record["warnings"].to_string().contains("damaged"));
    let frequencies = |out: &TempDir| column(&out.path().join("eigenfrequencies.csv"), "frequency_hz");
    let pairs = frequencies(&sound).into_iter().zip(frequencies(&mended));
    for (expected, found) in pairs {
        assert!((found - expected).abs() <= 1e-9 * expected, "{found} Hz, {expected} Hz");
    }
    let run = run_into(cache.path(), mended.path(), &QUICK);
    assert_eq!(run.status.code(), Some(0));
    assert_eq!(manifest(mended.path())["counts"]["parts_from_cache"], 5);
}

#[test]
fn a_truncated_cache_file_is_reported_and_rebuilt() {
    assert_rebuilt(|bytes| bytes[..bytes.len() / 2].to_vec());
}

#[test]
fn a_flipped_bit_in_a_cache_file_is_reported_and_rebuilt() {
    assert_rebuilt(|mut bytes| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        bytes
    });
}

#[test]
fn an_empty_cache_file_is_reported_and_rebuilt() {
    assert_rebuilt(|_| Vec::new());
}

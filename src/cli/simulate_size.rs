//! How large the files of a time history get and what memory they take, told before anything is computed.

use super::UsageError;
use super::simulate::Arguments;
use anyhow::{Context, Result};
use std::path::Path;
use stiffmap::export::mat5;
use stiffmap::machine::Machine;
use stiffmap::resources::room;

/// Bytes of a number of full length with its comma in a CSV file.
const NUMBER: f64 = 23.0;
/// Bytes of the time at the beginning of a line.
const TIME: f64 = 14.0;
/// Bytes of a line of a spectrum's CSV file.
const SPECTRUM_LINE: f64 = 90.0;
/// Bytes for pictures and manifest.
const REST: f64 = 16e6;

/// What is to be computed, by its numbers.
#[derive(Clone, Copy, Debug)]
pub struct Planned {
    duration: f64,
    rate: f64,
    inputs: usize,
    /// Outputs times recorded quantities.
    rows: usize,
    outputs: usize,
    positions: usize,
    /// Joints with friction or backlash.
    contacts: usize,
    along_path: bool,
    /// Lines of a spectrum; 0 for none.
    lines: f64,
}

impl Planned {
    pub fn new(
        arguments: &Arguments,
        machine: &Machine,
        along_path: bool,
        positions: usize,
        inputs: usize,
        duration: f64,
    ) -> Self {
        let outputs: usize = machine.ports.iter().filter(|p| p.output).map(|p| p.directions.len()).sum();
        let recording = arguments.recording();
        let contacts = machine.joints.iter().filter(|j| j.contact.is_some()).count();
        let highest = arguments.highest(machine).min(0.45 * arguments.rate);
        Self {
            duration,
            rate: arguments.rate,
            inputs,
            rows: outputs * (1 + usize::from(recording.velocity) + usize::from(recording.acceleration)),
            outputs,
            positions: if along_path { 1 } else { positions },
            contacts: if arguments.linear || along_path { 0 } else { contacts },
            along_path,
            lines: if arguments.impulse.is_some() { highest * duration } else { 0.0 },
        }
    }

    fn samples(&self) -> f64 {
        (self.duration * self.rate).floor()
    }

    /// Variables of `time_history.mat` and `spectra.mat` that grow, with their bytes.
    fn variables(&self) -> [(&'static str, f64); 5] {
        let (samples, positions) = (self.samples(), self.positions as f64);
        [
            ("displacement", 8.0 * samples * self.outputs as f64 * positions),
            ("force", 8.0 * samples * self.inputs as f64),
            ("contact_force", 8.0 * samples * self.contacts as f64 * positions),
            ("energy", if self.along_path { 8.0 * samples * 5.0 } else { 0.0 }),
            ("receptance", 16.0 * self.lines * self.outputs as f64 * positions),
        ]
    }

    /// Bytes of all files, at most.
    fn disk(&self) -> f64 {
        let (samples, positions) = (self.samples(), self.positions as f64);
        let columns = (self.inputs + self.rows + 3 * self.contacts + usize::from(self.along_path)) as f64;
        let text = samples * (TIME + NUMBER * columns);
        let energies = if self.along_path { 6.0 } else { 0.0 };
        let of_positions = (self.rows + 3 * self.contacts) as f64 * positions;
        let binary = 8.0 * samples * (1.0 + self.inputs as f64 + of_positions + energies);
        let spectra = self.lines * self.outputs as f64 * positions * (16.0 + SPECTRUM_LINE);
        text + binary + spectra + REST
    }

    /// Bytes of memory, at least: forces and histories lie there twice while the files are written.
    fn memory(&self) -> f64 {
        let rows = (self.rows + 3 * self.contacts) as f64 * self.positions as f64;
        let energies = if self.along_path { 16.0 } else { 0.0 };
        8.0 * self.samples() * (1.0 + 2.0 * self.inputs as f64 + 2.0 * rows + energies)
    }
}

fn size(bytes: f64) -> String {
    if bytes < 1e9 { format!("{:.0} MB", bytes / 1e6) } else { format!("{:.1} GB", bytes / 1e9) }
}

/// Refuses what no file, disk or memory holds.
pub fn check(planned: &Planned, out: &Path) -> Result<()> {
    let exists = out.ancestors().find(|f| f.exists()).unwrap_or(Path::new("."));
    let free = fs4::available_space(exists).with_context(|| format!("free room of {}", exists.display()))?;
    fits(planned, out, free as f64, room().map(|room| room.bytes as f64))?;
    Ok(())
}

fn fits(planned: &Planned, out: &Path, free: f64, memory: Option<f64>) -> Result<(), UsageError> {
    // A rate or duration that is no number is refused where it is read.
    if !planned.samples().is_finite() || planned.samples() <= 0.0 {
        return Ok(());
    }
    let refuse = |what: String, share: f64| {
        let longest = rounded_down(planned.duration * share);
        let remedy = if longest > 0.0 {
            format!("shorten --duration {} to {longest} s, or lower --rate {}", planned.duration, planned.rate)
        } else {
            "make room there, or take another --out".to_owned()
        };
        let positions = if planned.positions > 1 { ", or take fewer --positions" } else { "" };
        Err(UsageError(format!(
            "{:.0} samples of {} inputs and {} outputs at {} positions: {what}; {remedy}{positions}",
            planned.samples(),
            planned.inputs,
            planned.rows,
            planned.positions
        )))
    };
    // A variable's head takes less than this.
    let limit = mat5::LIMIT as f64 - 1024.0;
    let largest = planned.variables().into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((name, bytes)) = largest.filter(|(_, bytes)| *bytes > limit) {
        let file = if name == "receptance" { "spectra.mat" } else { "time_history.mat" };
        let what = format!(
            "the variable `{name}` of {file} would take {}, and a MAT-file's variable takes {} at most",
            size(bytes),
            size(limit)
        );
        return refuse(what, limit / bytes);
    }
    let disk = planned.disk();
    if disk > free {
        let what = format!("the files would take {}, and {} has {} free", size(disk), out.display(), size(free));
        return refuse(what, (free - REST).max(0.0) / disk);
    }
    if let Some(memory) = memory.filter(|m| planned.memory() > *m) {
        let needed = planned.memory();
        let what = format!("they take {} of memory, and {} are available", size(needed), size(memory));
        return refuse(what, memory / needed);
    }
    Ok(())
}

/// Three digits, not above the number.
fn rounded_down(x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let unit = 10f64.powf(x.log10().floor() - 2.0);
    ((x / unit).floor() * unit * 1e9).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    const NINE_INPUTS: Planned = Planned {
        duration: 1500.0,
        rate: 20e3,
        inputs: 9,
        rows: 9,
        outputs: 9,
        positions: 1,
        contacts: 0,
        along_path: false,
        lines: 0.0,
    };

    #[test]
    fn a_history_past_a_mat_files_variable_is_refused_with_its_size() {
        // 1500 s at 20 kHz are 3e7 samples; nine columns of eight bytes are 2.16e9, past 2^31.
        let text = |p: Planned, free: f64, memory: f64| fits(&p, Path::new("out"), free, Some(memory)).map_err(|e| e.0);
        let refused = text(NINE_INPUTS, 1e13, 1e13).unwrap_err();
        assert!(refused.contains("30000000 samples") && refused.contains("2.2 GB"), "{refused}");
        assert!(refused.contains("to 1490 s"), "{refused}");
        let shorter = Planned { duration: 1490.0, ..NINE_INPUTS };
        assert_eq!(text(shorter, 1e13, 1e13), Ok(()), "control: what the message asks for fits");
        // Its CSV file: 19 numbers in each of 2.98e7 lines.
        let refused = text(shorter, 1e10, 1e13).unwrap_err();
        assert!(refused.contains("out has 10.0 GB free"), "{refused}");
        let full = text(shorter, 0.0, 1e13).unwrap_err();
        assert!(full.contains("make room there") && !full.contains("to 0 s"), "{full}");
        let refused = text(shorter, 1e13, 4e9).unwrap_err();
        assert!(refused.contains("of memory, and 4.0 GB are available"), "{refused}");
        let many = Planned { positions: 121, duration: 30.0, ..NINE_INPUTS };
        assert!(text(many, 1e13, 1e13).unwrap_err().contains("take fewer --positions"));
    }
}

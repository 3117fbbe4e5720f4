//! The forces of `stiffmap simulate`: how long they last, their samples, and what they are in the manifest.

use super::UsageError;
use super::simulate::Arguments;
use super::simulate_size::{self, Planned};
use anyhow::Result;
use serde_json::{Value, json};
use stiffmap::files::Inputs;
use stiffmap::machine::Machine;
use stiffmap::response::{CutterPort, ForceFile, Forces, Milling, Path, PulseShape, Shape, parse_force, parse_milling};

/// Sampled forces, what the samples lose of them, and what they are.
pub struct Sampled {
    pub forces: Forces,
    pub warnings: Vec<String>,
    pub described: Vec<Value>,
    /// The file of forces as it was read.
    pub inputs: Inputs,
}

/// Length of a history where nothing says one, s.
const DURATION: f64 = 1.0;

/// Samples all forces that the command line names, once it is known that the files they make have room.
pub fn sample(
    arguments: &Arguments,
    machine: &Machine,
    path: Option<&Path>,
    positions: usize,
    out: &std::path::Path,
) -> Result<Sampled> {
    let given = arguments.impulse.is_some() || !arguments.forces.is_empty();
    if !given && arguments.force_file.is_none() && arguments.milling.is_none() {
        let needed = "give one of --impulse, --force, --force-file, --milling";
        return Err(UsageError(format!("no force: {needed}")).into());
    }
    let ports = CutterPort::of(machine);
    let inputs: Vec<String> = ports.iter().flat_map(|p| p.inputs.iter().map(|(name, _)| name.clone())).collect();
    let file = arguments.force_file.as_deref().map(ForceFile::read).transpose()?;
    let at_least = file.as_ref().map_or(DURATION, |f| f.end().max(DURATION));
    let duration = arguments.duration.or(path.map(Path::duration)).unwrap_or(at_least);
    let planned = Planned::new(arguments, machine, path.is_some(), positions, inputs.len(), duration);
    simulate_size::check(&planned, out)?;
    let forces = Forces::none(&inputs, duration, arguments.rate)?;
    let read = file.as_ref().map(|f| f.inputs.clone()).unwrap_or_default();
    let mut sampled = Sampled { forces, warnings: Vec::new(), described: Vec::new(), inputs: read };
    let highest = arguments.highest(machine);
    if highest > 0.5 * arguments.rate {
        sampled.warnings.push(format!(
            "--rate {}: motions above {} Hz, half the rate, cannot be seen in the samples; the machine file's frequencies \
             go to {highest} Hz; --rate {} or more shows them",
            arguments.rate,
            0.5 * arguments.rate,
            (10.0 * highest).ceil()
        ));
    }
    let mut unseeded = 0;
    if let Some(keys) = &arguments.impulse {
        let text = if keys.is_empty() { "impulse".to_owned() } else { format!("impulse,{keys}") };
        sampled.everywhere("--impulse", &parse_force(&text)?, &mut unseeded)?;
    }
    for text in &arguments.forces {
        let Some((input, shape)) = text.split_once(':') else {
            let inputs = inputs.join(", ");
            let problem = format!("--force: {text:?} is not INPUT:KIND,key=value,..; inputs: {inputs}, all");
            return Err(UsageError(problem).into());
        };
        let shape = parse_force(shape)?;
        let what = format!("--force {text}");
        match input.trim() {
            "all" => sampled.everywhere(&what, &shape, &mut unseeded)?,
            name => {
                let input = sampled.forces.find(name)?;
                let seeded = matches!(shape, Shape::Random { seed: Some(_), .. });
                let own = if seeded { shape } else { shape.at_input(input, unseeded) };
                unseeded += u64::from(is_unseeded(&shape));
                sampled.warnings.extend(own.check(&what, &sampled.forces)?);
                sampled.add(input, &own);
            }
        }
    }
    if let Some(file) = &file {
        sampled.warnings.extend(file.add_to(&mut sampled.forces)?);
        let name = arguments.force_file.as_ref().map(|f| f.display().to_string());
        sampled.described.push(json!({ "kind": "file", "file": name }));
    }
    if let Some(text) = &arguments.milling {
        sampled.mill(&parse_milling(text, &ports)?, &ports)?;
    }
    Ok(sampled)
}

fn is_unseeded(shape: &Shape) -> bool {
    matches!(shape, Shape::Random { seed: None, .. })
}

impl Sampled {
    fn everywhere(&mut self, what: &str, shape: &Shape, unseeded: &mut u64) -> Result<()> {
        self.warnings.extend(shape.check(what, &self.forces)?);
        for input in 0..self.forces.inputs.len() {
            self.add(input, &shape.at_input(input, *unseeded));
        }
        *unseeded += u64::from(is_unseeded(shape));
        Ok(())
    }

    fn add(&mut self, input: usize, shape: &Shape) {
        self.forces.add(input, shape);
        let mut described = describe(shape);
        described["input"] = json!(self.forces.inputs[input]);
        self.described.push(described);
    }

    fn mill(&mut self, cut: &Milling, ports: &[CutterPort]) -> Result<()> {
        self.warnings.extend(cut.check(&self.forces)?);
        for (name, key) in [(&cut.feed_input, "along"), (&cut.normal_input, "across")] {
            if ports.iter().any(|p| p.is_along_spindle(name)) {
                self.warnings.push(format!(
                    "--milling: {key}={name} lies along the spindle; feed and normal direction lie across it"
                ));
            }
        }
        self.forces.add_milling(cut)?;
        let signed = |name: &str, sign: f64| if sign < 0.0 { format!("-{name}") } else { name.to_owned() };
        self.described.push(json!({
            "kind": "milling",
            "teeth": cut.teeth,
            "speed_per_min": 60.0 * cut.speed,
            "feed_mm_a_tooth": 1e3 * cut.feed,
            "depth_mm": 1e3 * cut.depth,
            "kt_n_per_mm2": 1e-6 * cut.kt,
            "kr": cut.kr,
            "entry_degrees": degrees(cut.entry),
            "exit_degrees": degrees(cut.exit),
            "along": signed(&cut.feed_input, cut.signs[0]),
            "across": signed(&cut.normal_input, cut.signs[1]),
            "tooth_passing_hz": cut.tooth_passing(),
            "teeth_engaged": cut.engaged(),
        }));
        Ok(())
    }
}

/// An angle as the user wrote it, without the last digits of a conversion.
fn degrees(angle: f64) -> f64 {
    (1e9 * angle.to_degrees()).round() / 1e9
}

/// Every parameter of a force.
fn describe(shape: &Shape) -> Value {
    match *shape {
        Shape::Impulse(pulse) => json!({
            "kind": "impulse",
            "amplitude_n": pulse.amplitude,
            "length_s": pulse.length,
            "start_s": pulse.start,
            "shape": match pulse.shape {
                PulseShape::HalfSine => "half-sine",
                PulseShape::Rectangle => "rectangle",
                PulseShape::Triangle => "triangle",
            },
        }),
        Shape::Step { amplitude, start } => json!({ "kind": "step", "amplitude_n": amplitude, "start_s": start }),
        Shape::Sine { amplitude, frequency, phase } => {
            json!({ "kind": "sine", "amplitude_n": amplitude, "frequency_hz": frequency, "phase_degrees": phase })
        }
        Shape::Chirp { amplitude, from, to } => {
            json!({ "kind": "chirp", "amplitude_n": amplitude, "from_hz": from, "to_hz": to })
        }
        Shape::Random { rms, seed } => json!({ "kind": "random", "rms_n": rms, "seed": seed.unwrap_or_default() }),
    }
}

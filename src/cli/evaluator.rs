//! What answers the designs of a study: its machine reduced and coupled, and the route.

use super::progress::Progress;
use super::run::mesh_warnings;
use super::{UsageError, cache_folder};
use anyhow::Result;
use clap::ValueEnum;
use stiffmap::files::Inputs;
use stiffmap::gpu::{Backend, Precision};
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::Machine;
use stiffmap::mesh::{MeshFile, inputs_of};
use stiffmap::pipeline;
use stiffmap::reduction::{Cache, Superelement};
use stiffmap::sweep::{
    CouplingRoute, Design, Evaluator, ModesRoute, PartScale, Request, SpringBackend, Study, varied_springs,
};

/// The route asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Route {
    /// By cost
    Auto,
    /// An eigenproblem for each design and position
    Modes,
    /// Structural modification of the nominal machine's receptances
    Coupling,
}

/// The parts of a study's machine, reduced.
pub struct Reduced {
    pub superelements: Vec<Superelement>,
    pub warnings: Vec<String>,
    pub parts_from_cache: usize,
}

/// The parts of a study's machine as their files have them, and all files that were read: study, machine, parts.
pub struct Read {
    meshes: Vec<MeshFile>,
    pub inputs: Inputs,
}

/// Reads the parts of a study's machine.
pub fn read(study: &Study, progress: &mut Progress) -> Result<Read> {
    let meshes = progress.stage("read meshes", 0, |_| pipeline::read_meshes(&study.machine))?;
    let mut inputs = study.inputs.clone();
    inputs.extend(&inputs_of(&meshes)?)?;
    Ok(Read { meshes, inputs })
}

/// Reduces the parts of a study's machine.
pub fn reduce(
    study: &Study,
    read: Read,
    no_cache: bool,
    progress: &mut Progress,
    interrupt: &Interrupt,
) -> Result<Reduced> {
    let (machine, meshes) = (&study.machine, read.meshes);
    let mut warnings = pipeline::study_plausibility(machine, &study.probes(), &meshes);
    progress.warn(&warnings);
    warnings.extend(mesh_warnings(machine, &meshes));
    let cache = if no_cache { None } else { cache_folder().map(Cache::in_folder) };
    let cached = progress.stage("reduce parts", machine.parts.len(), |step| {
        pipeline::reduce_parts(machine, &meshes, cache.as_ref(), interrupt, step)
    })?;
    warnings.extend(pipeline::cache_warnings(&cached));
    let parts_from_cache = cached.iter().filter(|c| c.hit).count();
    let superelements: Vec<_> = cached.into_iter().map(|c| c.superelement).collect();
    Ok(Reduced { superelements, warnings, parts_from_cache })
}

/// Opens the back end that is asked for; a device has nothing to do on the modes route.
///
/// With `auto` it is looked for only where the coupling route may be taken.
pub fn open_backend(study: &Study, route: Route, backend: Backend) -> Result<SpringBackend> {
    let obstacle = match route {
        Route::Modes => Some("the modes route solves eigenproblems on the processor".to_owned()),
        Route::Coupling => None,
        Route::Auto => only_by_modes(&study.machine, &study.probes(), &study.families),
    };
    match (backend, obstacle) {
        (Backend::Gpu, Some(obstacle)) => {
            let said = format!("--backend gpu: {obstacle}; use --backend auto or cpu, or --route coupling");
            Err(UsageError(said).into())
        }
        (Backend::Auto, Some(obstacle)) => Ok(SpringBackend::cpu(obstacle)),
        _ => Ok(SpringBackend::open(backend, Precision::F32)?),
    }
}

/// The evaluator of a route.
pub struct Chosen<'a> {
    pub evaluator: Box<dyn Evaluator + 'a>,
    /// Why this route.
    pub why: String,
    /// What a reader of the table must know of it.
    pub warnings: Vec<String>,
}

/// The evaluator of a route, and why it was chosen.
pub fn choose<'a>(
    study: &'a Study,
    superelements: &'a [Superelement],
    route: Route,
    backend: SpringBackend,
    interrupt: &'a Interrupt,
) -> Result<Chosen<'a>> {
    let machine = &study.machine;
    let request = Request::of(study);
    let probes = study.probes();
    let (coupling, why) = match route {
        Route::Modes => (false, "asked for".to_owned()),
        Route::Coupling => (true, format!("asked for; {}", meaning_of_damping(&probes))),
        Route::Auto if backend.is_asked_for() => (true, "a device is asked for; damping is exact".to_owned()),
        Route::Auto => by_cost(machine, &probes, &request),
    };
    if !coupling {
        let evaluator = Box::new(ModesRoute::new(machine, superelements, request, &probes, interrupt)?);
        return Ok(Chosen { evaluator, why, warnings: Vec::new() });
    }
    let on_cpu = CouplingRoute::new(machine, superelements, request.clone(), &probes, interrupt)?;
    let mut warnings = Vec::new();
    if let Some(reason) = not_exact_by_coupling(&probes) {
        let modes = ModesRoute::new(machine, superelements, request, &probes, interrupt)?;
        warnings.push(apart(study, reason, &on_cpu, &modes));
    }
    Ok(Chosen { evaluator: Box::new(on_cpu.on(backend)?), why, warnings })
}

/// Designs of the study's own sample among those that measure how far the coupling route is off.
const MEASURED: u64 = 13;

/// How far the coupling route is from the modes route, in words: measured at the nominal design, at both ends of all
/// variables and at designs spread over the sample.
fn apart(study: &Study, reason: &str, coupling: &dyn Evaluator, modes: &dyn Evaluator) -> String {
    let ends = |high: f64| study.design(&study.variables.iter().map(|v| v.at(high)).collect::<Vec<_>>());
    let mut designs = vec![
        (Design::nominal(&study.machine), "the nominal design".to_owned()),
        (ends(0.0), "all variables at their first value".to_owned()),
        (ends(1.0), "all variables at their last value".to_owned()),
    ];
    let all = study.sampling.designs;
    let spread = all.min(MEASURED);
    designs.extend(
        (0..spread).map(|k| (k * all) / spread).map(|k| (study.design(&study.values(k)), format!("design {k}"))),
    );
    let (designs, names): (Vec<Design>, Vec<String>) = designs.into_iter().unzip();
    let begin = format!("--route coupling: {reason}, which the coupling route leaves with the nominal machine's modes");
    let mut worst = (0.0, "", "");
    let (mut compared, mut alone) = (0, None);
    for ((a, b), name) in coupling.evaluate(&designs).iter().zip(modes.evaluate(&designs)).zip(&names) {
        let (Ok(a), Ok(b)) = (a, b) else {
            alone.get_or_insert(name);
            continue;
        };
        compared += 1;
        for (a, b) in a.iter().zip(&b) {
            for (a, b) in a.pairs.iter().zip(&b.pairs) {
                for (what, a, b) in [
                    ("a largest response", a.peak, b.peak),
                    ("a most negative real part", a.most_negative_real, b.most_negative_real),
                ] {
                    let off = (a.value / b.value - 1.0).abs();
                    if off > worst.0 {
                        worst = (off, what, name);
                    }
                }
            }
        }
    }
    let (off, what, name) = worst;
    let unanswered = alone.map_or(String::new(), |name| format!("; {name} is not answered by both routes"));
    if compared == 0 {
        return format!("{begin}{unanswered}, so the size of the error is not known; use --route modes");
    }
    format!(
        "{begin}; of {compared} designs {what} is off by up to {:.2} % from the modes route ({name}){unanswered}; use \
         --route modes",
        100.0 * off
    )
}

/// Springs that vary up to which the coupling route costs less than an eigenproblem.
///
/// Measured on the bundled mill, 0 to 900 Hz at 2 %: a design and position cost 0.05 ms with one
/// spring, 2 ms with 21, and 3 ms by modes.
const FEW_SPRINGS: usize = 12;

/// Loss factor of the machine from which a grid holds every design's peaks, whatever joints dissipate beside it.
const SHARP: f64 = 1e-3;

fn by_cost(machine: &Machine, probes: &[Design], request: &Request) -> (bool, String) {
    if let Some(reason) = only_by_modes(machine, probes, &request.families) {
        return (false, reason);
    }
    let springs = varied_springs(machine, probes).len();
    let few = springs <= FEW_SPRINGS;
    let cost = if few { "less" } else { "more" };
    (few, format!("{springs} springs vary, which cost {cost} than an eigenproblem"))
}

/// Why designs are answered by their modes, whatever that costs.
fn only_by_modes(machine: &Machine, probes: &[Design], families: &[usize]) -> Option<String> {
    if !families.is_empty() {
        return Some("eigenfrequencies are asked for".into());
    }
    if let Some(reason) = not_exact_by_coupling(probes) {
        return Some(format!("{reason}, which only the modes route follows"));
    }
    let least = probes.iter().map(|p| p.machine.analysis.damping.loss_factor).fold(f64::INFINITY, f64::min);
    if least < SHARP {
        return Some(format!(
            "the machine's loss factor, {least}, is below {SHARP}: designs may have peaks that a grid steps over"
        ));
    }
    changes_the_base(machine, probes).map(|what| format!("{what}, so each design needs receptances of its own base"))
}

/// Damping that belongs to the modes of each design.
fn not_exact_by_coupling(probes: &[Design]) -> Option<&'static str> {
    let any = |of: fn(&Machine) -> bool| probes.iter().any(|p| of(&p.machine));
    if any(|m| m.analysis.damping.ratios.iter().any(|r| *r > 0.0) || m.analysis.damping.rayleigh.is_some()) {
        return Some("damping is a viscous ratio of the modes");
    }
    any(|m| m.parts.iter().any(|p| p.loss_factor > Some(0.0))).then_some("parts have loss factors of their own")
}

fn meaning_of_damping(probes: &[Design]) -> &'static str {
    match not_exact_by_coupling(probes) {
        Some(_) => "viscous ratios and loss factors of parts stay with the nominal machine's modes",
        None => "damping is exact",
    }
}

fn changes_the_base(machine: &Machine, probes: &[Design]) -> Option<&'static str> {
    if probes.iter().any(|p| p.parts.iter().any(|s| *s != PartScale::NOMINAL)) {
        return Some("parts change");
    }
    probes
        .iter()
        .any(|p| p.machine.analysis.damping != machine.analysis.damping)
        .then_some("the machine's damping changes")
}

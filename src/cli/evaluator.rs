//! What answers the designs of a study: its machine reduced and coupled, and the route.

use super::cache_folder;
use super::progress::Progress;
use super::run::mesh_warnings;
use anyhow::Result;
use clap::ValueEnum;
use stiffmap::interrupt::Interrupt;
use stiffmap::pipeline;
use stiffmap::reduction::{Cache, Superelement};
use stiffmap::sweep::{CouplingRoute, Evaluator, ModesRoute, Request, Study};

/// The route asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Route {
    /// By cost
    Auto,
    /// An eigenproblem for each design and position
    Modes,
    /// The nominal machine's receptances changed by each design's springs
    Coupling,
}

/// The parts of a study's machine, reduced.
pub struct Reduced {
    pub superelements: Vec<Superelement>,
    pub warnings: Vec<String>,
    pub parts_from_cache: usize,
}

/// Reduces the parts of a study's machine.
pub fn reduce(study: &Study, no_cache: bool, progress: &mut Progress, interrupt: &Interrupt) -> Result<Reduced> {
    let machine = &study.machine;
    let meshes = progress.stage("read meshes", 0, |_| pipeline::read_meshes(machine))?;
    let mut warnings = mesh_warnings(machine, &meshes);
    let cache = if no_cache { None } else { cache_folder().map(Cache::in_folder) };
    let cached = progress.stage("reduce parts", machine.parts.len(), |step| {
        pipeline::reduce_parts(machine, &meshes, cache.as_ref(), interrupt, step)
    })?;
    warnings.extend(pipeline::cache_warnings(&cached));
    let parts_from_cache = cached.iter().filter(|c| c.hit).count();
    let superelements: Vec<_> = cached.into_iter().map(|c| c.superelement).collect();
    Ok(Reduced { superelements, warnings, parts_from_cache })
}

/// Designs from which on the coupling route is worth its base.
const MANY: u64 = 2000;

/// The evaluator of a route, and why it was chosen.
pub fn choose<'a>(
    study: &'a Study,
    superelements: &'a [Superelement],
    route: Route,
    interrupt: &'a Interrupt,
) -> Result<(Box<dyn Evaluator + 'a>, String)> {
    let designs = study.sampling.designs;
    let (coupling, why) = match route {
        Route::Modes => (false, "asked for".to_owned()),
        Route::Coupling => (true, "asked for".to_owned()),
        Route::Auto if !study.families.is_empty() => (false, "eigenfrequencies are asked for".to_owned()),
        Route::Auto if designs < MANY => (false, format!("{designs} designs, fewer than {MANY}")),
        Route::Auto => (true, format!("{designs} designs, at least {MANY}")),
    };
    let (machine, probes) = (&study.machine, study.probes());
    let evaluator: Box<dyn Evaluator + 'a> = if coupling {
        Box::new(CouplingRoute::new(machine, superelements, request(study), &probes, interrupt)?)
    } else {
        Box::new(ModesRoute::new(machine, superelements, request(study), &probes, interrupt)?)
    };
    Ok((evaluator, why))
}

/// What a study asks of each design.
pub fn request(study: &Study) -> Request {
    Request {
        positions: study.positions.clone(),
        frequencies: study.frequencies(),
        families: study.families.clone(),
        highest: study.band[1],
        whole_basis: false,
        tracked: study.families.iter().copied().max().unwrap_or(0),
    }
}

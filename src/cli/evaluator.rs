//! What answers the designs of a study: its machine reduced and coupled, and the route.

use super::cache_folder;
use super::progress::Progress;
use super::run::mesh_warnings;
use anyhow::Result;
use clap::ValueEnum;
use stiffmap::coupling::CoupledModel;
use stiffmap::interrupt::Interrupt;
use stiffmap::pipeline;
use stiffmap::reduction::{Cache, Superelement};
use stiffmap::sweep::direct::ModesDirect;
use stiffmap::sweep::{Evaluator, Study};

/// The route asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Route {
    /// By cost
    Auto,
    /// An eigenproblem for each design and position
    Modes,
}

/// The nominal machine, reduced and coupled.
pub struct Prepared {
    pub superelements: Vec<Superelement>,
    pub model: CoupledModel,
    pub warnings: Vec<String>,
    pub parts_from_cache: usize,
}

/// Reduces the parts of a study's machine and couples them for its band and families.
pub fn prepare(study: &Study, no_cache: bool, progress: &mut Progress, interrupt: &Interrupt) -> Result<Prepared> {
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
    let reported = study.families.iter().copied().max().unwrap_or(1);
    let (model, _) =
        progress.stage("couple", 0, |_| pipeline::build_model(machine, &superelements, reported, study.band[1]))?;
    warnings.extend(model.side_by_side.overhangs());
    Ok(Prepared { superelements, model, warnings, parts_from_cache })
}

/// The evaluator of a route, and why it was chosen.
pub fn choose(study: &Study, prepared: &Prepared, route: Route) -> Result<(Box<dyn Evaluator>, String)> {
    let why = match route {
        Route::Auto => "the only route",
        Route::Modes => "asked for",
    };
    let evaluator = ModesDirect::new(prepared.model.clone(), &study.positions, &study.frequencies(), &study.families)?;
    Ok((Box::new(evaluator), why.to_owned()))
}

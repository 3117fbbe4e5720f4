//! `stiffmap optimise`: the best design of a study under its bounds.

use super::evaluator::{Chosen, Route, choose, read, reduce};
use super::progress::Progress;
use super::record;
use super::run::{relative, slug};
use super::streams;
use super::sweep::{begin_record, refuse_other};
use super::sweep_figures::{Best, draw_best};
use super::sweep_progress::Rate;
use super::{UsageError, begin, finish, open_folder};
use anyhow::{Context, Result, bail};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};
use stiffmap::export::atomic::write_bytes;
use stiffmap::export::manifest::Manifest;
use stiffmap::figures::sweep::{Convergence, draw_convergence};
use stiffmap::files::{FolderError, MANIFEST};
use stiffmap::interrupt::Interrupt;
use stiffmap::sweep::goals::Objective;
use stiffmap::sweep::machine_values::machine_values;
use stiffmap::sweep::optimise::{Found, optimise as search};
use stiffmap::sweep::runner::RunError;
use stiffmap::sweep::shards::{RECORD, Record, Shard, TABLE};
use stiffmap::sweep::table::{Row, Store};
use stiffmap::sweep::{SpringBackend, Study, TableError, read_study};

/// Name of the log of evaluations.
pub(super) const LOG: &str = "evaluations.csv";

#[derive(Args, Debug)]
pub struct Arguments {
    /// Study file; its [optimise] section says how to look
    study: PathBuf,
    /// Output folder; results/<study>_optimum without it
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Continue the search in the output folder where it ended
    #[arg(long, conflicts_with = "overwrite")]
    resume: bool,
    /// Begin anew, even where an unfinished search is in the output folder
    #[arg(long)]
    overwrite: bool,
    /// How designs are answered
    #[arg(long, value_enum, default_value = "auto")]
    route: Route,
    /// Draw no pictures
    #[arg(long)]
    no_figures: bool,
    /// Neither read nor write the cache of superelements
    #[arg(long)]
    no_cache: bool,
    /// Print the manifest to stdout and nothing else
    #[arg(long)]
    json: bool,
}

/// Runs the search.
pub fn optimise(arguments: &Arguments, interrupt: &Interrupt) -> Result<()> {
    let mut progress = Progress::new(arguments.json);
    let study = read_study(&arguments.study)?;
    let Some(objective) = &study.search.objective else {
        let said = format!(
            "{}: nothing to improve; add NAME = \"maximise\" or \"minimise\" to [objectives], or `objective` to [optimise]",
            arguments.study.display()
        );
        return Err(UsageError(said).into());
    };
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join(slug(&study.name) + "_optimum"));
    let mut folder = open_folder(&out, "optimise")?;
    let log = out.join(LOG);
    let before = Record::read(&out)?;
    let read = read(&study, &mut progress)?;
    let inputs = read.inputs.clone();
    arguments.refuse(&out, before.as_ref(), &|route| Record::new(&study, &inputs, route, Shard::WHOLE))?;
    let reduced = reduce(&study, read, arguments.no_cache, &mut progress, interrupt)?;
    let backend = SpringBackend::cpu("a search asks for one design at a time");
    let Chosen { evaluator, why, warnings } = progress.stage("prepare positions", 0, |_| {
        choose(&study, &reduced.superelements, arguments.route, backend, interrupt)
    })?;
    let record = Record::new(&study, &inputs, evaluator.route(), Shard::WHOLE);
    let mut known: Vec<Row> = Vec::new();
    let mut store = match before.filter(|_| arguments.resume) {
        Some(before) => {
            record.check_same(&before, &out, true)?;
            begin(&mut folder, &[LOG, RECORD], interrupt)?;
            Store::open(&log, &study, &(0..u64::MAX), &|_| None, &mut |row| known.push(row))?.0
        }
        None => {
            begin(&mut folder, &[], interrupt)?;
            begin_record(&record, &out, LOG)?;
            Store::create(&log, &study)?
        }
    };
    let total = study.search.evaluations as u64;
    let mut rate = Rate::new("evaluations", total, known.len() as u64, study.positions.len(), arguments.json);
    let found = search(&study, evaluator.as_ref(), &known, interrupt, &mut |row| {
        rate.step();
        Ok(store.append(&row.line(&study))?)
    });
    rate.finish();
    let found = match found {
        Err(RunError::Table(error)) => return Err(error.into()),
        found => found?,
    };
    drop(store);

    let mut files = vec![LOG.to_owned(), RECORD.to_owned()];
    let best = found.best.map(|at| &found.rows[at]);
    if let Some(best) = best {
        let origin = format!("Evaluation {}", best.index);
        write_bytes(&out.join("best.toml"), machine_values(&study, &best.values, &origin).as_bytes())?;
        files.push("best.toml".into());
    }
    if !arguments.no_figures {
        let folder = out.join("figures");
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let mut drawn =
            vec![draw_convergence(&convergence(&study, objective, &found), &folder.join("convergence.png"))?];
        if let Some(row) = best {
            drawn.extend(draw_best(&Best { study: &study, evaluator: evaluator.as_ref(), row }, &folder)?);
        }
        files.extend(drawn.iter().map(|path| relative(path, &out)));
    }
    let mut manifest = Manifest {
        name: study.name.clone(),
        command: "optimise".into(),
        machine_file: study.machine.file.display().to_string(),
        warnings: reduced.warnings,
        ..Manifest::default()
    };
    super::sweep::describe(&study, &record, &mut manifest);
    let settings = &mut manifest.settings;
    settings.push("route", json!(evaluator.route()));
    settings.push("route_why", json!(why));
    progress.warn(&warnings);
    manifest.warnings.extend(warnings);
    settings.push("objective", json!(objective.name));
    settings.push("search_seed", json!(study.search.seed));
    settings.push("population", json!(found.population));
    settings.push("ended", json!(found.ended));
    if let Some(best) = best {
        settings.push("best_evaluation", json!(best.index));
        settings.push("best_keeps_bounds", json!(best.bounds_met == Some(true)));
    }
    manifest.counts.push("evaluations", found.rows.len() as u64);
    manifest.counts.push("evaluations_done_before", known.len() as u64);
    manifest.seconds.push("evaluations", record::round(rate.seconds()));
    record::seconds(&mut manifest, &progress);
    files.push("manifest.json".into());
    manifest.files = files;
    manifest.warnings.extend(record::edited(&inputs));
    finish(folder, &manifest)?;
    if arguments.json {
        streams::print_json(&manifest)?;
    } else {
        summarise(&study, &found, &out, &progress);
    }
    match (found.best, found.rows.first().and_then(|row| row.error.as_deref())) {
        (None, Some(first)) => {
            bail!("no design was answered; the first: {first}; {} has the reason of each", log.display())
        }
        _ => Ok(()),
    }
}

fn summarise(study: &Study, found: &Found, out: &Path, progress: &Progress) {
    let mut lines = vec![format!("\n{}: {} evaluations, ended by {}", study.name, found.rows.len(), found.ended)];
    if let Some(best) = found.best.map(|at| &found.rows[at]) {
        lines.extend(super::sweep_files::design_in_words(study, "evaluation", best));
        if best.bounds_met != Some(true) {
            lines.push("warning: no design keeps every bound; this one misses them least".to_owned());
        }
    }
    lines.push(format!("files in {}", out.display()));
    progress.say(&lines.join("\n"));
}

impl Arguments {
    /// Refuses to continue, or to replace unasked, the search of other inputs, and what has not finished; `here` is this
    /// search's record by a route.
    fn refuse(&self, out: &Path, before: Option<&Record>, here: &dyn Fn(&str) -> Record) -> Result<()> {
        let (log, table) = (out.join(LOG), out.join(TABLE));
        if table.exists() {
            let holds = "the table of a sweep is there".to_owned();
            return Err(FolderError::Taken { path: table, holds }.into());
        }
        if self.overwrite || !log.exists() {
            return Ok(());
        }
        let Some(before) = before else { return Err(TableError::NoRecord { path: log }.into()) };
        if !self.resume && !out.join(MANIFEST).exists() {
            return Err(TableError::Unfinished { path: log }.into());
        }
        Ok(refuse_other(&log, self.resume, &here(&before.route), before)?)
    }
}

/// The objective over the evaluations, with the best so far that keeps every bound.
fn convergence(study: &Study, objective: &Objective, found: &Found) -> Convergence {
    let at = study.result_place(objective.figure);
    Convergence {
        study: study.name.clone(),
        objective: objective.name.clone(),
        unit: study.unit(objective.figure),
        maximise: objective.maximise,
        points: found
            .rows
            .iter()
            .map(|row| row.results[at].map(|value| (value, row.bounds_met == Some(true))))
            .collect(),
    }
}

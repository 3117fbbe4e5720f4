//! `stiffmap sweep`: the designs of a study, one row each.

use super::evaluator::{Chosen, Reduced, Route, choose, open_backend, read, reduce};
use super::optimise::LOG;
use super::progress::Progress;
use super::record::{edited, round};
use super::run::{parse_backend, slug, without_nulls};
use super::sweep_files::{Finished, write_results};
use super::sweep_progress::Rate;
use super::{UsageError, begin, open_folder};
use anyhow::{Context, Result};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};
use stiffmap::export::atomic::write_bytes;
use stiffmap::export::manifest::Manifest;
use stiffmap::files::{FolderError, Inputs, ResultFolder};
use stiffmap::gpu::Backend;
use stiffmap::interrupt::Interrupt;
use stiffmap::sweep::room::check_room;
use stiffmap::sweep::runner::{RunError, run};
use stiffmap::sweep::shards::{RECORD, Record, Shard, TABLE, merge};
use stiffmap::sweep::table::{Row, Store, read_rows};
use stiffmap::sweep::{Study, TableError, read_study};

#[derive(Args, Debug)]
pub struct Arguments {
    /// Study file
    study: PathBuf,
    /// Output folder; results/<study> without it
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Continue the sweep in the output folder where it ended
    #[arg(long, conflicts_with_all = ["overwrite", "merge"])]
    resume: bool,
    /// Begin anew, even where an unfinished sweep is in the output folder
    #[arg(long)]
    overwrite: bool,
    /// Compute only the I-th of N shares of the sample, I from 1
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Join the tables of shards in these folders instead of computing
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["shard", "maps"])]
    merge: Vec<PathBuf>,
    /// Write the whole maps of these designs
    #[arg(long, value_name = "DESIGN,...", value_delimiter = ',')]
    pub(super) maps: Vec<u64>,
    /// How designs are answered
    #[arg(long, value_enum, default_value = "auto")]
    route: Route,
    /// Where the coupling route looks for extrema; gpu without an adapter is an error
    #[arg(long, default_value = "auto", value_name = "auto|cpu|gpu", value_parser = parse_backend)]
    backend: Backend,
    /// Write the sensitivities of a design's metrics to its variables; of the best design without a number
    #[arg(long, value_name = "DESIGN", num_args = 0..=1, require_equals = true)]
    pub(super) sensitivities: Option<Option<u64>>,
    /// Write the table as designs.parquet too (in builds with the feature `parquet`)
    #[arg(long)]
    pub(super) parquet: bool,
    /// Draw no pictures
    #[arg(long)]
    pub(super) no_figures: bool,
    /// Neither read nor write the cache of superelements
    #[arg(long)]
    no_cache: bool,
    /// Print the manifest to stdout and nothing else
    #[arg(long)]
    pub(super) json: bool,
}

/// Runs a sweep, or joins its shards.
pub fn sweep(arguments: &Arguments, interrupt: &Interrupt) -> Result<()> {
    if arguments.parquet && !cfg!(feature = "parquet") {
        let said =
            "--parquet: this stiffmap was built without it; build it with `cargo build --release --features parquet`";
        return Err(UsageError(said.into()).into());
    }
    let mut progress = Progress::new(arguments.json);
    let study = read_study(&arguments.study)?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("results").join(slug(&study.name)));
    check_designs(&study, "--maps", &arguments.maps)?;
    check_designs(&study, "--sensitivities", arguments.sensitivities.flatten().as_slice())?;
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let range = shard.range(study.sampling.designs);
    check_room(&study, range.end - range.start, arguments.maps.len(), &out)?;
    let mut folder = open_folder(&out, "sweep")?;
    if !arguments.merge.is_empty() {
        return join(arguments, &study, folder, progress, interrupt);
    }
    let before = Record::read(&out)?;
    refuse_unfinished(arguments, &out, before.as_ref())?;
    let read = read(&study, &mut progress)?;
    let inputs = read.inputs.clone();
    if let Some(before) = before.as_ref().filter(|_| !arguments.overwrite && out.join(TABLE).exists()) {
        let here = Record::new(&study, &inputs, &before.route, shard);
        refuse_other(&out.join(TABLE), arguments.resume, &here, before)?;
    }

    let backend = open_backend(&study, arguments.route, arguments.backend)?;
    let reduced = reduce(&study, read, arguments.no_cache, &mut progress, interrupt)?;
    let Chosen { evaluator, why, warnings } = progress.stage("prepare positions", 0, |_| {
        choose(&study, &reduced.superelements, arguments.route, backend, interrupt)
    })?;
    progress.warn(&warnings);
    let record = Record::new(&study, &inputs, evaluator.route(), shard);
    let table = out.join(TABLE);
    let mut rows: Vec<Row> = Vec::new();
    let (mut store, done) = match before.filter(|_| arguments.resume) {
        Some(before) => {
            record.check_same(&before, &out, true)?;
            begin(&mut folder, &[TABLE, RECORD], interrupt)?;
            Store::open(&table, &study, &range, &|i| Some(study.values(i)), &mut |row| rows.push(row))?
        }
        None => {
            begin(&mut folder, &[], interrupt)?;
            begin_record(&record, &out, TABLE)?;
            (Store::create(&table, &study)?, 0)
        }
    };
    if done > 0 {
        progress.say(&format!("{done} of {} designs are there already", range.end - range.start));
    }
    let mut rate = Rate::new("designs", range.end - range.start, done, study.positions.len(), arguments.json);
    let ran = run(&study, evaluator.as_ref(), range.start + done..range.end, &mut store, interrupt, &mut |row| {
        rate.step();
        rows.push(row);
    });
    rate.finish();
    match ran {
        Err(RunError::Table(error)) => return Err(error.into()),
        ran => ran?,
    }
    drop(store);

    let mut manifest = begin_manifest(&study, &record, &reduced);
    manifest.warnings.extend(edited(&inputs));
    manifest.settings.push("route", json!(evaluator.route()));
    manifest.settings.push("route_why", json!(why));
    manifest.warnings.extend(warnings);
    manifest.backend = without_nulls(serde_json::to_value(evaluator.backend())?);
    let counts = &mut manifest.counts;
    counts.push("designs_done_before", done);
    counts.push("designs_done_now", rate.designs());
    let pairs = rate.designs() * study.positions.len() as u64;
    counts.push("pairs_done_now", pairs);
    manifest.seconds.push("designs", round(rate.seconds()));
    if rate.designs() > 0 {
        manifest.settings.push("pairs_per_second", json!(round(rate.rate() * study.positions.len() as f64)));
    }
    let finished = Finished {
        study: &study,
        rows: &rows,
        whole: shard == Shard::WHOLE,
        evaluator: Some(evaluator.as_ref()),
        superelements: &reduced.superelements,
        out: &out,
    };
    write_results(&finished, folder, arguments, manifest, &mut progress, interrupt)
}

fn begin_manifest(study: &Study, record: &Record, reduced: &Reduced) -> Manifest {
    let mut manifest = Manifest {
        name: study.name.clone(),
        command: "sweep".into(),
        machine_file: study.machine.file.display().to_string(),
        warnings: reduced.warnings.clone(),
        ..Manifest::default()
    };
    describe(study, record, &mut manifest);
    manifest.counts.push("parts_from_cache", reduced.parts_from_cache as u64);
    manifest
}

/// What every manifest of a sweep says.
pub(super) fn describe(study: &Study, record: &Record, manifest: &mut Manifest) {
    for (name, hash) in &record.inputs {
        manifest.input_hashes.push(name.clone(), hash.clone());
    }
    let settings = &mut manifest.settings;
    settings.push("study_file", json!(study.file.display().to_string()));
    settings.push("sampling", json!(study.sampling.name()));
    if let Some(seed) = study.sampling.seed {
        settings.push("seed", json!(seed));
    }
    settings.push("shard", json!(format!("{}/{}", record.shard, record.shards)));
    settings.push("band_hz", json!(study.band));
    manifest.warnings.extend(study.remarks());
    let counts = &mut manifest.counts;
    counts.push("designs", study.sampling.designs);
    counts.push("variables", study.variables.len() as u64);
    counts.push("positions", study.positions.len() as u64);
    counts.push("frequencies", study.frequencies().len() as u64);
}

/// Joins shards into one table, which the pictures are then drawn from.
fn join(
    arguments: &Arguments,
    study: &Study,
    mut folder: ResultFolder,
    mut progress: Progress,
    interrupt: &Interrupt,
) -> Result<()> {
    let out = &folder.path().to_path_buf();
    let read = read(study, &mut progress)?;
    let inputs: Inputs = read.inputs.clone();
    let (record, text) = merge(study, &inputs, &arguments.merge)?;
    let table = out.join(TABLE);
    if arguments.merge.iter().any(|folder| same_folder(folder, out)) {
        let said = format!("--out {}: it is one of the shards; choose another folder", out.display());
        return Err(UsageError(said).into());
    }
    let before = Record::read(out)?;
    refuse_unfinished(arguments, out, before.as_ref())?;
    if let Some(before) = before.as_ref().filter(|_| !arguments.overwrite && table.exists()) {
        refuse_other(&table, false, &record, before)?;
    }
    let mut rows: Vec<Row> = Vec::new();
    read_rows(&table, study, &text, &(0..study.sampling.designs), &|_| None, &mut |row| rows.push(row))?;
    begin(&mut folder, &[], interrupt)?;
    begin_record(&record, out, TABLE)?;
    write_bytes(&table, &text)?;
    // The best design beside the nominal one, and sensitivities, need the machine; the table does not.
    let needs_machine = !arguments.no_figures || arguments.sensitivities.is_some();
    let reduced = if needs_machine {
        reduce(study, read, arguments.no_cache, &mut progress, interrupt)?
    } else {
        Reduced { superelements: Vec::new(), warnings: Vec::new(), parts_from_cache: 0 }
    };
    let evaluator = if needs_machine {
        let route = if record.route == "coupling" { Route::Coupling } else { Route::Modes };
        let backend = open_backend(study, route, arguments.backend)?;
        Some(choose(study, &reduced.superelements, route, backend, interrupt)?.evaluator)
    } else {
        None
    };
    let mut manifest = begin_manifest(study, &record, &reduced);
    manifest.warnings.extend(edited(&inputs));
    manifest.settings.push("route", json!(record.route));
    manifest.counts.push("shards_joined", arguments.merge.len() as u64);
    let superelements = &reduced.superelements;
    let finished = Finished { study, rows: &rows, whole: true, evaluator: evaluator.as_deref(), superelements, out };
    write_results(&finished, folder, arguments, manifest, &mut progress, interrupt)
}

fn same_folder(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => a == b,
    }
}

fn check_designs(study: &Study, option: &str, asked: &[u64]) -> Result<(), UsageError> {
    let designs = study.sampling.designs;
    match asked.iter().find(|design| **design >= designs) {
        Some(design) => {
            Err(UsageError(format!("{option}: there is no design {design}; allowed: 0 to {}", designs - 1)))
        }
        None => Ok(()),
    }
}

/// Hours of work are not overwritten by a forgotten --resume, nor a search by a sweep.
fn refuse_unfinished(arguments: &Arguments, out: &Path, record: Option<&Record>) -> Result<()> {
    let (table, log) = (out.join(TABLE), out.join(LOG));
    if log.exists() {
        let holds = "the evaluations of a search are there".to_owned();
        return Err(FolderError::Taken { path: log, holds }.into());
    }
    if arguments.overwrite || !table.exists() {
        return Ok(());
    }
    let Some(record) = record else { return Err(TableError::NoRecord { path: table }.into()) };
    if arguments.resume {
        return Ok(());
    }
    let range = record.range();
    let text = std::fs::read(&table).with_context(|| table.display().to_string())?;
    // Rows have no line breaks within: the header and one line a design.
    let complete = text.iter().filter(|b| **b == b'\n').count() as u64 > range.end - range.start;
    if complete { Ok(()) } else { Err(TableError::Unfinished { path: table }.into()) }
}

/// Refuses to continue, or to replace unasked, the table of other inputs than `here`.
pub(super) fn refuse_other(table: &Path, resume: bool, here: &Record, before: &Record) -> Result<(), TableError> {
    match here.check_same(before, table.parent().unwrap_or(Path::new("")), true) {
        Err(TableError::Differs { what, seen, expected, .. }) if !resume => {
            let difference = format!("{what} is {seen} there and {expected} here");
            Err(TableError::Other { path: table.to_path_buf(), difference })
        }
        checked => checked,
    }
}

/// Puts a new record in place of an old one and its table; never is a record beside the table of another.
pub(super) fn begin_record(record: &Record, out: &Path, table: &str) -> Result<()> {
    for name in [RECORD, table] {
        let path = out.join(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(error).with_context(|| path.display().to_string());
            }
            _ => {}
        }
    }
    let mut text = serde_json::to_vec_pretty(record)?;
    text.push(b'\n');
    Ok(write_bytes(&out.join(RECORD), &text)?)
}

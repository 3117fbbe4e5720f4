//! What a finished sweep leaves beside its table: front, maps, pictures, manifest.

use super::progress::Progress;
use super::record;
use super::run::relative;
use super::streams;
use super::sweep::Arguments;
use super::sweep_figures::{Best, draw_best, draw_rows};
use super::sweep_rates::rates;
use anyhow::{Context, Result, bail};
use serde_json::json;
use std::path::{Path, PathBuf};
use stiffmap::export::atomic::write_bytes;
use stiffmap::export::manifest::Manifest;
use stiffmap::export::mat;
use stiffmap::files::ResultFolder;
use stiffmap::frf::{ComplianceMap, FrfRequest, Quantity, Selection, modal_sum, modal_systems};
use stiffmap::interrupt::Interrupt;
use stiffmap::modal::modes_at;
use stiffmap::pipeline::{self, PipelineError};
use stiffmap::reduction::Superelement;
use stiffmap::sweep::pareto::{best, front};
use stiffmap::sweep::shards::{RECORD, TABLE};
use stiffmap::sweep::table::{Row, header};
use stiffmap::sweep::{Evaluator, Study};

/// A table that is complete, and what its pictures may be made from.
pub struct Finished<'a> {
    pub study: &'a Study,
    pub rows: &'a [Row],
    /// Whether the rows are the whole sample and not a shard.
    pub whole: bool,
    /// What answers designs; none where shards are joined and nothing but the table is wanted.
    pub evaluator: Option<&'a dyn Evaluator>,
    pub superelements: &'a [Superelement],
    pub out: &'a Path,
}

/// Writes everything beside the table, the manifest last.
pub fn write_results(
    finished: &Finished<'_>,
    folder: ResultFolder,
    arguments: &Arguments,
    mut manifest: Manifest,
    progress: &mut Progress,
    interrupt: &Interrupt,
) -> Result<()> {
    let Finished { study, rows, whole, out, .. } = *finished;
    let mut files = vec![TABLE.to_owned(), RECORD.to_owned()];
    #[cfg(feature = "parquet")]
    if arguments.parquet {
        stiffmap::export::parquet::write_designs(&out.join("designs.parquet"), study, rows)?;
        files.push("designs.parquet".into());
    }
    let failed = rows.iter().filter(|row| row.error.is_some()).count();
    manifest.counts.push("rows", rows.len() as u64);
    manifest.counts.push("rows_with_errors", failed as u64);
    if let Some(row) = rows.iter().find(|row| row.error.is_some()) {
        let words = row.error.as_deref().unwrap_or_default();
        manifest.warnings.push(format!("{failed} rows lack values; the first, design {}: {words}", row.index));
    }
    if whole && study.objectives.len() >= 2 {
        let text: Vec<u8> = std::iter::once(header(study))
            .chain(front(study, rows).iter().map(|row| row.line(study)))
            .flatten()
            .collect();
        write_bytes(&out.join("pareto.csv"), &text)?;
        files.push("pareto.csv".into());
    }
    if !arguments.maps.is_empty() {
        let written = progress.stage("maps", arguments.maps.len(), |step| -> Result<Vec<String>> {
            let mut written = Vec::new();
            for &index in &arguments.maps {
                if interrupt.requested() {
                    return Err(PipelineError::Interrupted.into());
                }
                let path = out.join(format!("maps/{index:04}/compliance.mat"));
                mat::write_compliance(&path, &design_map(study, finished.superelements, index)?)?;
                written.push(relative(&path, out));
                step();
            }
            Ok(written)
        })?;
        files.extend(written);
    }
    let best = best(study, rows);
    let of = arguments.sensitivities.map(|asked| match asked {
        Some(index) => rows.iter().find(|row| row.index == index),
        None => best,
    });
    if let Some(row) = of.flatten() {
        let text = progress.stage("sensitivities", 0, |_| rates(study, finished.superelements, row, interrupt))?;
        write_bytes(&out.join("sensitivities.csv"), &text)?;
        files.push("sensitivities.csv".into());
    }
    if !arguments.no_figures && whole {
        let folder = out.join("figures");
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let drawn = progress.stage("draw pictures", 0, |_| -> Result<Vec<PathBuf>> {
            let mut drawn = draw_rows(study, rows, best, &folder)?;
            if let (Some(row), Some(evaluator)) = (best, finished.evaluator) {
                drawn.extend(draw_best(&Best { study, evaluator, row }, &folder)?);
            }
            Ok(drawn)
        })?;
        files.extend(drawn.iter().map(|path| relative(path, out)));
    }
    if let Some(best) = best {
        manifest.settings.push("best_design", json!(best.index));
    }
    files.push("manifest.json".into());
    manifest.files = files;
    record::seconds(&mut manifest, progress);
    super::finish(folder, &manifest)?;
    if arguments.json {
        streams::print_json(&manifest)?;
    } else {
        summarise(finished, best, &manifest, progress);
    }
    match rows.first().and_then(|row| row.error.as_deref()) {
        Some(first) if failed == rows.len() => bail!(
            "no design was answered; the first, design {}: {first}; the table in {} has the reason of each",
            rows[0].index,
            out.display()
        ),
        _ => Ok(()),
    }
}

/// The whole map of a design: its machine coupled from its parts, on the machine's frequency grid.
fn design_map(study: &Study, superelements: &[Superelement], index: u64) -> Result<ComplianceMap> {
    let design = study.design(&study.values(index));
    let parts: Vec<Superelement> =
        superelements.iter().zip(&design.parts).map(|(s, scale)| s.scaled(scale.young, scale.density)).collect();
    let machine = &design.machine;
    let frequencies = &machine.analysis.frequencies;
    let highest = frequencies.iter().copied().fold(0.0, f64::max);
    let reported = machine.analysis.modes;
    let model = pipeline::build_model(machine, &parts, reported, highest)?.model;
    let modes = study.positions.iter().map(|p| modes_at(&model, &machine.analysis.damping, *p));
    let modes = modes.collect::<Result<Vec<_>, _>>().with_context(|| format!("design {index}"))?;
    let (systems, _) = modal_systems(&modes, highest, Selection::Controlled { tolerance: 1e-4 })?;
    let (outputs, inputs) = (model.output_names(), model.input_names());
    let request = FrfRequest {
        positions: &study.positions,
        systems: &systems,
        frequencies,
        outputs: &outputs,
        inputs: &inputs,
        quantity: Quantity::Receptance,
    };
    Ok(modal_sum(&request)?)
}

fn summarise(finished: &Finished<'_>, best: Option<&Row>, manifest: &Manifest, progress: &Progress) {
    let Finished { study, rows, out, .. } = *finished;
    let mut lines = vec![format!(
        "\n{}: {} designs of {} variables, {} positions, {} to {} Hz",
        study.name,
        rows.len(),
        study.variables.len(),
        study.positions.len(),
        study.band[0],
        study.band[1]
    )];
    if let Some(best) = best {
        lines.extend(design_in_words(study, "design", best));
    } else {
        lines.push("no design keeps every bound".to_owned());
    }
    lines.extend(manifest.warnings.iter().map(|warning| format!("warning: {warning}")));
    lines.push(format!("files in {}", out.display()));
    progress.say(&lines.join("\n"));
}

/// A row in words: its variables, then its values.
pub(super) fn design_in_words(study: &Study, what: &str, row: &Row) -> Vec<String> {
    let variables = study.variables.iter().zip(&row.values);
    let shown: Vec<String> = variables.map(|(v, x)| format!("{} {} {}", v.name, v.text(*x), v.unit())).collect();
    let mut lines = vec![format!("best {what}: {}: {}", row.index, shown.join(", "))];
    for (column, value) in study.result_columns().iter().zip(&row.results) {
        lines.extend(value.map(|value| format!("  {:<28} {value:.6e} {}", column.name, column.unit)));
    }
    lines
}

//! The compliance map of a run: in memory, or streamed to its files where it is too large.

use anyhow::Result;
use std::path::Path;
use stiffmap::export::stream::{MAP_FILE, MapStream, Streamed};
use stiffmap::export::{mat, surface};
use stiffmap::files::ResultFolder;
use stiffmap::frf::metrics::{PairMetrics, direct_pairs, metrics, refine};
use stiffmap::frf::{ComplianceMap, FrfRequest, ModalSystem, Quantity, Tile};
use stiffmap::gpu::{BackendOptions, BackendReport, compute, compute_tiles};
use stiffmap::interrupt::Interrupt;
use stiffmap::pipeline::{PipelineError, Step};

/// What a map lies over; it owns what a request borrows.
#[derive(Clone, Debug)]
pub struct Axes {
    pub positions: Vec<f64>,
    pub frequencies: Vec<f64>,
    pub outputs: Vec<String>,
    pub inputs: Vec<String>,
    pub quantity: Quantity,
}

impl Axes {
    /// The request for a map over these axes.
    pub fn request<'a>(&'a self, systems: &'a [ModalSystem]) -> FrfRequest<'a> {
        FrfRequest {
            positions: &self.positions,
            systems,
            frequencies: &self.frequencies,
            outputs: &self.outputs,
            inputs: &self.inputs,
            quantity: self.quantity,
        }
    }

    /// Bytes of the map.
    pub fn bytes(&self) -> u64 {
        let counts = [self.positions.len(), self.frequencies.len(), self.outputs.len(), self.inputs.len()];
        counts.iter().map(|n| *n as u64).product::<u64>() * size_of::<nalgebra::Complex<f64>>() as u64
    }
}

/// Where a map is.
pub enum Map {
    Whole(ComplianceMap),
    Streamed(Streamed),
}

impl Map {
    /// The map, where it is in memory.
    pub fn whole(&self) -> Option<&ComplianceMap> {
        match self {
            Map::Whole(map) => Some(map),
            Map::Streamed(_) => None,
        }
    }

    /// Metrics of the direct responses, `[position][pair]`.
    pub fn metrics(&self, request: &FrfRequest) -> Result<Vec<Vec<PairMetrics>>> {
        let pairs = direct_pairs(request);
        Ok(match self {
            Map::Whole(map) => metrics(request, map, &pairs)?,
            Map::Streamed(streamed) => refine(request, &pairs, &streamed.extrema)?,
        })
    }

    /// Writes what streaming has not; names of the map's files in the folder.
    pub fn write(&self, folder: &Path) -> Result<Vec<String>> {
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        match self {
            Map::Streamed(streamed) => Ok(streamed.files.iter().map(|p| name(p)).collect()),
            Map::Whole(map) => {
                mat::write_compliance(&folder.join("compliance.mat"), map)?;
                let mut files = vec!["compliance.mat".to_string()];
                files.extend(surface::write_direct_surfaces(folder, map)?.iter().map(|p| name(p)));
                // An earlier run's streamed map would pass as this one's.
                match std::fs::remove_file(folder.join(MAP_FILE)) {
                    Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(e.into()),
                    _ => Ok(files),
                }
            }
        }
    }
}

/// Computes the map: in memory, or tile by tile into files in `folder`, from which the old result then goes.
pub fn compute_map(
    request: &FrfRequest,
    options: &BackendOptions,
    streams: bool,
    folder: &mut ResultFolder,
    interrupt: &Interrupt,
    step: Step<'_>,
) -> Result<(Map, BackendReport)> {
    if !streams {
        let (map, report) = compute(request, options)?;
        request.positions.iter().for_each(|_| step());
        return Ok((Map::Whole(map), report));
    }
    let mut stream = MapStream::create(folder.path(), request, &direct_pairs(request))?;
    let mut failed: Option<anyhow::Error> = None;
    let mut sink = |tile: Tile<'_>| {
        let taken = if interrupt.requested() {
            Err(PipelineError::Interrupted.into())
        } else {
            stream.append(&tile).map_err(anyhow::Error::from)
        };
        if tile.range.frequencies.end == request.frequencies.len() {
            tile.range.positions.for_each(|_| step());
        }
        taken.map_err(|error| {
            let said = error.to_string();
            failed = Some(error);
            said.into()
        })
    };
    let report = compute_tiles(request, options, &mut sink);
    // What stopped the receiver says more than that it stopped.
    match failed {
        Some(error) => Err(error),
        None => {
            let report = report?;
            super::begin(folder, &[], interrupt)?;
            Ok((Map::Streamed(stream.commit()?), report))
        }
    }
}

//! `modal_database.bin`: what the report page and the pictures are made from.
//!
//! Sixteen bytes `stiffmap-modal-2`, the BLAKE3 hash of all that follows (32 bytes), the length of the header (64-bit,
//! little-endian), the header as JSON, zeros up to a multiple of eight bytes, the arrays that the header lists.
//! `docs/report.md` describes each. A file that does not match its hash is refused.

use super::ReportError;
use super::arrays::Arrays;
use super::header::{Header, SpringList, VeeringEntry, springs, table_entry, veering_entry};
use super::local::{Local, LocalInput};
use super::pack::{push_families, push_local, push_systems, read_coupled, read_sums};
use super::shapes::push_shapes;
use crate::coupling::CoupledModel;
use crate::export::atomic;
use crate::frf::ModalSystem;
use crate::frf::metrics::PairMetrics;
use crate::machine::{Machine, Quantity};
use crate::modal::{ModeFamilies, ModeTableRow, Modes, TrackedMode, Veering, modes_at};
use crate::reduction::Superelement;
use rayon::prelude::*;
use std::borrow::Cow;
use std::path::Path;

const MAGIC: &[u8; 16] = b"stiffmap-modal-2";
/// Bytes of the hash behind it.
const HASH: usize = 32;

/// The results of a run that a database is made of.
#[derive(Clone, Copy, Debug)]
pub struct DatabaseInput<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Its coupled model.
    pub model: &'a CoupledModel,
    /// Its reduced parts, with their skins.
    pub superelements: &'a [Superelement],
    /// Modes, one a position; those without shapes are solved again where they are needed.
    pub modes: &'a [Modes],
    /// What the map is summed from, one a position.
    pub systems: &'a [ModalSystem],
    /// Frequencies of the map, Hz.
    pub frequencies: &'a [f64],
    /// What the map holds.
    pub quantity: Quantity,
    /// Families over the positions.
    pub families: &'a ModeFamilies,
    /// Range of each family.
    pub table: &'a [ModeTableRow],
    /// Free motions in words.
    pub free_motions: &'a [String],
    /// Refined metrics of the direct responses in the map's quantity, `[position][direction]`; may be empty.
    pub metrics: &'a [Vec<PairMetrics>],
}

/// A modal database.
#[derive(Clone, Debug)]
pub struct Database {
    /// Names and settings.
    pub header: Header,
    arrays: Arrays,
}

/// Bytes that the positions' share of a page's modal data takes, about; the parts' surfaces come on top.
pub(super) const BUDGET: usize = 5_000_000;
/// Directions that the shapes of all positions take, about.
const SHAPE_DIRECTIONS: usize = 100;
/// Positions of a page at most, and at least.
pub(super) const POSITIONS: [usize; 2] = [11, 241];

/// The positions that a page has room for, from what one takes; of the ports only the outputs are stored where inputs are
/// the same.
fn most_positions(systems: &[ModalSystem], springs: usize, symmetric: bool, listed: usize) -> usize {
    let sums = |s: &ModalSystem, symmetric: bool| {
        let (o, i) = (s.outputs.nrows(), s.inputs.nrows());
        let rows = if symmetric { o } else { o + i };
        8 * (s.frequencies.len() * (3 + rows) + 2 * s.residual.len() * o * i)
    };
    let of = |s: &ModalSystem| {
        let coupled = |e: &ModalSystem| sums(e, e.outputs.nrows() == e.inputs.nrows());
        let modes = s.frequencies.len().max(listed);
        let rows = springs + if symmetric { s.outputs.nrows() } else { s.outputs.nrows() + s.inputs.nrows() };
        let local = 4 * rows * (modes + 2 * rows);
        sums(s, symmetric) + s.exact.as_ref().map_or(0, |e| coupled(&e.system)) + local
    };
    let bytes = systems.iter().map(of).max().unwrap_or(0) + 2 * listed * SHAPE_DIRECTIONS;
    (BUDGET / bytes.max(1)).clamp(POSITIONS[0], POSITIONS[1])
}

/// At most `most` of `n` indices, evenly spread, both ends among them.
fn spread(n: usize, most: usize) -> Vec<usize> {
    if n <= most { (0..n).collect() } else { (0..most).map(|i| i * (n - 1) / (most - 1)).collect() }
}

/// The modes of a position with their shapes.
fn whole_modes<'a>(input: &DatabaseInput<'a>, p: usize) -> Result<Cow<'a, Modes>, ReportError> {
    let modes = &input.modes[p];
    if modes.shapes.ncols() == modes.eigenvalues.len() {
        return Ok(Cow::Borrowed(modes));
    }
    let analysis = &input.machine.analysis;
    Ok(Cow::Owned(modes_at(input.model, &analysis.damping, modes.position)?))
}

impl Database {
    /// Collects a run's results, at so many of its positions that a page stays small.
    ///
    /// # Errors
    /// [`ReportError`] if the local coordinates of a position or the space of the shapes cannot be formed.
    pub fn new(input: &DatabaseInput<'_>) -> Result<Self, ReportError> {
        let DatabaseInput { machine, model, systems, families, .. } = *input;
        let (outputs, inputs) = (model.output_names(), model.input_names());
        let symmetric = outputs == inputs && systems.iter().all(|s| s.outputs == s.inputs);
        let (springs, groups, selected) = springs(machine);
        let listed = families.modes.iter().map(Vec::len).max().unwrap_or(0);
        let chosen = spread(systems.len(), most_positions(systems, springs.len(), symmetric, listed));
        let whole = |p: &usize| whole_modes(input, *p);
        let modes = chosen.par_iter().map(whole).collect::<Result<Vec<Cow<'_, Modes>>, _>>()?;
        let systems: Vec<&ModalSystem> = chosen.iter().map(|&p| &systems[p]).collect();
        let families = &ModeFamilies {
            positions: chosen.iter().map(|&p| families.positions[p]).collect(),
            modes: chosen.iter().map(|&p| families.modes[p].clone()).collect(),
            veerings: families.veerings.clone(),
        };

        let mut arrays = Arrays::default();
        let grid = input.frequencies;
        let highest = machine.analysis.frequencies.iter().chain(grid).copied().fold(1.0, f64::max);
        arrays.push_f64("position", &[modes.len()], modes.iter().map(|m| m.position));
        arrays.push_f64("frequency", &[grid.len()], grid.iter().copied());
        let coupled = push_systems(&mut arrays, &systems, symmetric);
        let damping = &machine.analysis.damping;
        let last = families.modes.iter().flatten().map(|m| m.frequency).fold(highest, f64::max);
        let wanted = LocalInput { model, modes: &modes, symmetric, damping, highest, last };
        let list = SpringList { entries: &springs, places: &selected, groups: &groups };
        let (local, accuracy) = Local::all(&wanted, list)?;
        push_local(&mut arrays, &local);
        let listed = push_families(&mut arrays, families);
        if let Some(first) = input.metrics.first() {
            let shape = [modes.len(), first.len()];
            let all = || chosen.iter().flat_map(|&p| &input.metrics[p]);
            arrays.push_f64("peak", &shape, all().map(|m| m.peak.value));
            arrays.push_f64("peak_frequency", &shape, all().map(|m| m.peak.frequency));
        }
        let moves = &machine.axis.moves;
        let parts =
            push_shapes(&mut arrays, model, input.superelements, moves, &modes, listed).map_err(ReportError::Shapes)?;
        let header = Header {
            machine: machine.name.clone(),
            axis: machine.axis.name.clone(),
            direction: machine.axis.direction,
            outputs,
            inputs,
            symmetric,
            quantity: input.quantity.name().into(),
            positions_of_run: input.systems.len(),
            highest_hz: highest,
            damping_ratios: damping.ratios.clone(),
            rayleigh: damping.rayleigh,
            loss_factor: damping.loss_factor,
            lossy_parts: model.parts.iter().filter(|p| p.loss_factor.is_some()).map(|p| p.name.clone()).collect(),
            projected: damping.projected,
            coupled,
            accuracy: Some(accuracy),
            groups,
            springs,
            table: input.table.iter().map(table_entry).collect(),
            veerings: families.veerings.iter().map(veering_entry).collect(),
            free_motions: input.free_motions.to_vec(),
            input_hashes: Vec::new(),
            parts,
            arrays: arrays.entries.clone(),
        };
        Ok(Self { header, arrays })
    }

    /// The database as a file in memory.
    pub fn bytes(&self) -> Vec<u8> {
        let header = serde_json::to_vec(&self.header).expect("names and finite numbers are JSON");
        let mut bytes = MAGIC.to_vec();
        bytes.extend_from_slice(&[0; HASH]);
        bytes.extend_from_slice(&(header.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&header);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes.extend_from_slice(&self.arrays.bytes);
        let (head, content) = bytes.split_at_mut(MAGIC.len() + HASH);
        head[MAGIC.len()..].copy_from_slice(blake3::hash(content).as_bytes());
        bytes
    }

    /// Writes the database; returns the hash of its content, by which a manifest knows its own.
    ///
    /// # Errors
    /// [`ReportError::Export`].
    pub fn write(&self, path: &Path) -> Result<String, ReportError> {
        let bytes = self.bytes();
        atomic::write_bytes(path, &bytes)?;
        Ok(blake3::hash(&bytes[MAGIC.len() + HASH..]).to_hex().to_string())
    }

    /// Reads a database, with the hash of its content.
    ///
    /// # Errors
    /// [`ReportError::Missing`] if it cannot be read, [`ReportError::NoDatabase`] if it is none or is damaged.
    pub fn read(path: &Path) -> Result<(Self, String), ReportError> {
        let file = std::fs::read(path).map_err(|source| ReportError::Missing { path: path.into(), source })?;
        let wrong = |reason: &str| ReportError::NoDatabase { path: path.into(), reason: reason.into() };
        let rest = file
            .strip_prefix(MAGIC)
            .ok_or_else(|| wrong("its first bytes are not those of one that this version wrote; run again"))?;
        let (hash, content) = rest.split_first_chunk::<HASH>().ok_or_else(|| wrong("it ends early"))?;
        let found = blake3::hash(content);
        if found.as_bytes() != hash {
            return Err(wrong("it is damaged: its content does not match its hash; run again"));
        }
        let (length, rest) = content.split_first_chunk::<8>().ok_or_else(|| wrong("it ends early"))?;
        let length = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
        let header = rest.get(..length).ok_or_else(|| wrong("its header ends early"))?;
        let header: Header = serde_json::from_slice(header).map_err(|e| wrong(&e.to_string()))?;
        let start = (MAGIC.len() + HASH + 8 + length).next_multiple_of(8);
        let bytes = file.get(start..).ok_or_else(|| wrong("its arrays are missing"))?.to_vec();
        Ok((Self { arrays: Arrays { entries: header.arrays.clone(), bytes }, header }, found.to_hex().to_string()))
    }

    fn floats(&self, name: &str) -> Option<Vec<f64>> {
        self.arrays.f64(name).map(|(_, values)| values)
    }

    /// What the run's map holds; nothing if the header names no quantity.
    pub fn quantity(&self) -> Option<Quantity> {
        [Quantity::Receptance, Quantity::Mobility, Quantity::Accelerance]
            .into_iter()
            .find(|q| q.name() == self.header.quantity)
    }

    /// Positions (m) and the frequencies (Hz) of the run.
    pub fn axes(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        Some((self.floats("position")?, self.floats("frequency")?))
    }

    /// What the map was summed from, one a position, to the last bit; nothing if an array is missing.
    pub fn systems(&self) -> Option<Vec<ModalSystem>> {
        let ports = [self.header.outputs.len(), self.header.inputs.len()];
        let mut systems = read_sums(&self.arrays, "nominal", ports, self.header.symmetric)?;
        if let Some(entry) = &self.header.coupled {
            for (system, exact) in systems.iter_mut().zip(read_coupled(&self.arrays, entry, ports)?) {
                system.exact = Some(exact);
            }
        }
        Some(systems)
    }

    /// Families over the positions; nothing if an array is missing.
    pub fn families(&self) -> Option<ModeFamilies> {
        let positions = self.floats("position")?;
        let (shape, family) = self.arrays.u32("family")?;
        let listed = *shape.get(1)?;
        let (frequency, ratio) = (self.floats("family_frequency")?, self.floats("family_ratio")?);
        if [frequency.len(), ratio.len(), positions.len() * listed].iter().any(|n| *n != family.len()) {
            return None;
        }
        let mode = |at: usize, rank: usize| TrackedMode {
            family: family[at],
            rank,
            frequency: frequency[at],
            damping_ratio: ratio[at],
        };
        let modes = (0..positions.len())
            .map(|p| (0..listed).map(|r| mode(p * listed + r, r + 1)).filter(|m| m.family > 0).collect())
            .collect();
        let veering = |v: &VeeringEntry| Veering { from: v.from_m, to: v.to_m, families: v.families, mac: v.mac };
        Some(ModeFamilies { positions, modes, veerings: self.header.veerings.iter().map(veering).collect() })
    }
}

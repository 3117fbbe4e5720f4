//! The superelement: what is left of a part.

use super::basis::rayleigh_ritz;
use super::beyond::Beyond;
use super::component_modes::{ComponentModes, Vectors};
use super::flexibility::Flexibility;
use super::skin::{ReducedSkin, reduced_skin};
use super::{ReductionError, craig_bampton, free_interface};
use crate::interrupt::Interrupt;
use crate::linalg::{LinalgError, go_on, multiply, multiply_transposed};
use crate::machine::{ComponentAnalysis, Part, ReductionMethod};
use crate::mesh::Mesh;
use crate::solid::{InterfaceMotion, SecondOrder, Surface, assemble};
use nalgebra::{DMatrix, Matrix3};

/// What to reduce and which interfaces move along it.
#[derive(Clone, Debug)]
pub struct ReductionRequest {
    /// The part.
    pub part: Part,
    /// Method and number of modes.
    pub component: ComponentAnalysis,
    /// Component modes are kept at least up to this frequency, Hz; 0 where their number is given.
    pub reach: f64,
    /// Rails on this part.
    pub rails: Vec<RailTraining>,
}

/// A rail and the footprints that its basis has to know in advance.
#[derive(Clone, Debug, PartialEq)]
pub struct RailTraining {
    /// Interface of the part.
    pub interface: usize,
    /// Unit vector of travel.
    pub direction: [f64; 3],
    /// Length of the footprint, m.
    pub footprint: f64,
    /// Centres of the footprints along the direction, m.
    pub centres: Vec<f64>,
    /// For each centre, rows over the six motions of the footprint at its centroid are formed by a
    /// point (m, at that centre) and a spring direction; see `solid::rotation_arm`.
    pub springs: Vec<RailSpring>,
}

/// A spring that travels along a rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RailSpring {
    /// Where it acts when its centre is at 0 along the direction of travel, m.
    pub point: [f64; 3],
    /// Its direction.
    pub direction: [f64; 3],
    /// Whether it resists a rotation.
    pub rotation: bool,
}

/// A footprint of which less than this share lies on its rail has left it.
pub const LEAST_SHARE: f64 = 0.25;

/// A part in reduced coordinates: M = I, K = diag(eigenvalues).
#[derive(Clone, Debug, PartialEq)]
pub struct Superelement {
    /// Name of the part.
    pub part: String,
    /// Ritz values, (rad/s)^2, ascending; exactly 0 for the rigid motions of a free part.
    pub eigenvalues: Vec<f64>,
    /// Interfaces, in the order of the part.
    pub interfaces: Vec<ReducedInterface>,
    /// Rails.
    pub rails: Vec<ReducedRail>,
    /// The thinned outer surface, to be looked at.
    pub skin: ReducedSkin,
    /// R^T M V: impulses (translations and rotations about the centre of mass) of the reduced
    /// coordinates, 6 x n; for naming free motions.
    pub impulses: DMatrix<f64>,
    /// Centre of mass, m.
    pub centre_of_mass: [f64; 3],
    /// Mass, kg.
    pub mass: f64,
    /// Inertia tensor about the centre of mass, kg m^2.
    pub inertia: Matrix3<f64>,
    /// Frequencies of the component modes kept, Hz.
    pub component_frequencies: Vec<f64>,
    /// Motions above those, for the estimate of the error; none if the part is kept whole.
    pub beyond: Beyond,
    /// Nodes of the mesh.
    pub n_nodes: usize,
    /// Elements of the mesh.
    pub n_elements: usize,
    /// Unknowns before the reduction.
    pub n_dof: usize,
}

/// An interface in reduced coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct ReducedInterface {
    /// Area centroid, m.
    pub centroid: [f64; 3],
    /// Area, m^2.
    pub area: f64,
    /// Three translations and three rotations at the centroid, 6 x n.
    pub rows: DMatrix<f64>,
}

/// A rail in reduced coordinates: the basis at its surface's nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct ReducedRail {
    /// Interface of the part.
    pub interface: usize,
    /// Node coordinates, m.
    pub nodes: Vec<[f64; 3]>,
    /// The surface, its faces by local node number.
    pub surface: Surface,
    /// Displacements of the nodes, 3 n_nodes x n.
    pub basis: DMatrix<f64>,
}

impl Superelement {
    /// The part with its Young's modulus and density multiplied by factors, if it is of one material: its shapes
    /// stay, its eigenvalues follow E/rho and its mass-normalised rows rho^(-1/2).
    pub fn scaled(&self, young: f64, density: f64) -> Self {
        let mut scaled = self.clone();
        let row = density.sqrt().recip();
        scaled.eigenvalues.iter_mut().for_each(|l| *l *= young / density);
        scaled.interfaces.iter_mut().for_each(|i| i.rows *= row);
        scaled.rails.iter_mut().for_each(|r| r.basis *= row);
        scaled.skin.basis *= row;
        scaled.component_frequencies.iter_mut().for_each(|f| *f *= (young / density).sqrt());
        scaled.beyond.scale(young / density);
        scaled.impulses *= density.sqrt();
        scaled.mass *= density;
        scaled.inertia *= density;
        scaled
    }
}

impl ReductionRequest {
    /// Interface motions at most; `surfaces` are those of its interfaces.
    pub fn most_motions(&self, surfaces: &[Surface]) -> usize {
        let rails: std::collections::BTreeSet<usize> = self.rails.iter().map(|r| r.interface).collect();
        let motions = 6 * (self.part.interfaces.len() - rails.len());
        let trained: usize =
            self.rails.iter().map(|r| r.footprints(&surfaces[r.interface]).len() * r.springs.len()).sum();
        motions + trained
    }

    /// Coordinates that the reduced part has at most; `surfaces` are those of its interfaces.
    pub fn most_coordinates(&self, surfaces: &[Surface]) -> usize {
        let free = self.part.clamped.is_empty() && self.component.method == ReductionMethod::FreeInterface;
        let rigid = if free { 6 } else { 0 };
        rigid + self.component.modes + self.most_motions(surfaces) * if self.component.second_moment { 2 } else { 1 }
    }
}

impl RailTraining {
    /// Centres of the training footprints on a rail: where a footprint hangs over the rail's end, the
    /// part on it changes its length as it moves, and centres lie four times as close.
    ///
    /// Measured on the bundled mill 7.5 mm before the end of its travel, where 50 % of a footprint lies
    /// on the rail: 1.1e-5 of a frequency without the closer centres.
    pub fn footprints(&self, surface: &Surface) -> Vec<f64> {
        let (from, to) = surface.extent(self.direction);
        let half = 0.5 * self.footprint;
        let whole = |c: f64| c - half >= from && c + half <= to;
        let mut centres = Vec::new();
        for pair in self.centres.windows(2) {
            centres.push(pair[0]);
            // Two separate ranges of centres are not filled between.
            if !(whole(pair[0]) && whole(pair[1])) && (pair[1] - pair[0]).abs() <= half {
                centres.extend([0.25, 0.5, 0.75].map(|t| pair[0] + t * (pair[1] - pair[0])));
            }
        }
        centres.extend(self.centres.last());
        centres
    }
}

impl Superelement {
    /// Reduced coordinates.
    pub fn n(&self) -> usize {
        self.eigenvalues.len()
    }
}

impl ReducedRail {
    /// Share of a footprint that lies on the rail, 0 to 1.
    pub fn share_on_rail(&self, direction: [f64; 3], centre: f64, length: f64) -> f64 {
        let (from, to) = self.surface.extent(direction);
        (((centre + 0.5 * length).min(to) - (centre - 0.5 * length).max(from)) / length).max(0.0)
    }

    /// The rigid motion of a footprint, of the part of it that lies on the rail: its area centroid (m)
    /// and 6 x n rows there.
    ///
    /// `None` if less than [`LEAST_SHARE`] of it lies on the rail.
    pub fn footprint(&self, direction: [f64; 3], centre: f64, length: f64) -> Option<ReducedInterface> {
        if self.share_on_rail(direction, centre, length) < LEAST_SHARE {
            return None;
        }
        let weights = self.surface.weights_in_slab(direction, centre, length);
        let motion = InterfaceMotion::from_weights(&weights, |n| self.nodes[n])?;
        let touched = &motion.rows.nodes;
        let local =
            DMatrix::from_fn(3 * touched.len(), self.basis.ncols(), |i, k| self.basis[(3 * touched[i / 3] + i % 3, k)]);
        Some(ReducedInterface { centroid: motion.centroid, area: motion.area, rows: &motion.rows.rows * local })
    }
}

/// Assembles and reduces one part.
///
/// # Errors
/// [`ReductionError`], with the part's name.
pub fn reduce(
    request: &ReductionRequest,
    mesh: &Mesh,
    interrupt: Option<&Interrupt>,
) -> Result<Superelement, ReductionError> {
    let part = &request.part;
    let failed = |source: LinalgError| ReductionError::Linalg { part: part.name.clone(), source };
    super::memory::admit_assembly(&part.name, mesh)?;
    let system = assemble(part, mesh)?;
    let stop = || go_on(interrupt).map_err(failed);
    stop()?;
    let ordering = system.ordering().map_err(failed)?;
    stop()?;
    let sizes = super::memory::columns_and_modes(request, &system);
    let _share = super::memory::share(&part.name, &system, &ordering, sizes, interrupt)?;
    let flexibility = Flexibility::new(&system, &ordering).map_err(failed)?;
    let motions = interface_motions(&system, request, interrupt).map_err(failed)?;
    let modes = ComponentModes {
        modes: request.component.modes,
        band: request.component.band,
        reach: request.reach,
        second_moment: request.component.second_moment,
        interrupt,
    };
    let method = match request.component.method {
        ReductionMethod::CraigBampton => craig_bampton::vectors,
        ReductionMethod::FreeInterface => free_interface::vectors,
    };
    // Given matrices may be a superelement already: what a reduction would not make smaller is kept whole.
    let whole = mesh.matrices.is_some() && system.n_dof() <= modes.modes + 2 * motions.ncols();
    let n = system.n_dof();
    let Vectors { frequencies: component_frequencies, blocks, beyond } = if whole {
        let blocks = vec![flexibility.apply(&motions), DMatrix::identity(n, n)];
        Vectors { frequencies: Vec::new(), blocks, beyond: DMatrix::zeros(n, 0) }
    } else {
        method(&part.name, &system, &ordering, &flexibility, &motions, modes)?
    };
    stop()?;
    let (eigenvalues, vectors) = rayleigh_ritz(&part.name, &system, &flexibility.rigid, blocks)?;
    stop()?;
    let beyond = Beyond::new(&part.name, &system, &vectors, beyond)?;

    let interfaces = system
        .interfaces
        .iter()
        .map(|motion| ReducedInterface {
            centroid: motion.centroid,
            area: motion.area,
            rows: multiply_transposed(&system.columns(&motion.rows), &vectors),
        })
        .collect();
    let rails = request.rails.iter().map(|r| r.interface).collect::<std::collections::BTreeSet<_>>();
    let rails = rails.into_iter().map(|interface| reduced_rail(&system, interface, &vectors)).collect();
    let impulses = multiply_transposed(&system.rigid, &system.mass.multiply(&vectors));
    Ok(Superelement {
        part: part.name.clone(),
        eigenvalues,
        interfaces,
        rails,
        skin: reduced_skin(&system, mesh, &vectors),
        impulses,
        centre_of_mass: system.centre_of_mass,
        mass: system.total_mass,
        inertia: system.inertia,
        component_frequencies,
        beyond,
        n_nodes: mesh.nodes.len(),
        n_elements: mesh.cells.len(),
        n_dof: system.n_dof(),
    })
}

fn reduced_rail(system: &SecondOrder, interface: usize, vectors: &DMatrix<f64>) -> ReducedRail {
    let surface = &system.surfaces[interface];
    let mut nodes: Vec<usize> = surface.faces.iter().flat_map(|f| f.nodes.iter().copied()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut local = surface.clone();
    for face in &mut local.faces {
        for node in &mut face.nodes {
            *node = nodes.binary_search(node).unwrap_or_else(|_| unreachable!("nodes lists all of them"));
        }
    }
    ReducedRail {
        interface,
        nodes: nodes.iter().map(|&n| system.nodes[n]).collect(),
        surface: local,
        basis: system.displacements(&nodes, vectors),
    }
}

/// Interface motions as columns, n x m: six for every interface that is not a rail, the springs of
/// the training footprints for the rails.
fn interface_motions(
    system: &SecondOrder,
    request: &ReductionRequest,
    interrupt: Option<&Interrupt>,
) -> Result<DMatrix<f64>, LinalgError> {
    let mut columns: Vec<DMatrix<f64>> = Vec::new();
    for (i, motion) in system.interfaces.iter().enumerate() {
        if !request.rails.iter().any(|r| r.interface == i) {
            columns.push(system.columns(&motion.rows));
        }
    }
    for rail in &request.rails {
        let surface = &system.surfaces[rail.interface];
        for centre in rail.footprints(surface) {
            go_on(interrupt)?;
            let weights = surface.weights_in_slab(rail.direction, centre, rail.footprint);
            let Some(motion) = InterfaceMotion::from_weights(&weights, |n| system.nodes[n]) else { continue };
            let rows = rail.springs.iter().map(|s| s.coefficients(rail.direction, centre, motion.centroid));
            let select =
                DMatrix::from_columns(&rows.map(|c| nalgebra::DVector::from_row_slice(&c)).collect::<Vec<_>>());
            columns.push(multiply(&system.columns(&motion.rows), &select));
        }
    }
    let total = columns.iter().map(|c| c.ncols()).sum();
    let mut all = DMatrix::zeros(system.n_dof(), total);
    let mut at = 0;
    for block in &columns {
        all.columns_mut(at, block.ncols()).copy_from(block);
        at += block.ncols();
    }
    Ok(all)
}

impl RailSpring {
    /// Coefficients over the six motions of a footprint at its centroid.
    pub fn coefficients(&self, travel: [f64; 3], centre: f64, centroid: [f64; 3]) -> [f64; 6] {
        if self.rotation {
            let d = self.direction;
            return [0.0, 0.0, 0.0, d[0], d[1], d[2]];
        }
        let arm = [0, 1, 2].map(|c| self.point[c] + travel[c] * centre - centroid[c]);
        crate::solid::rotation_arm(self.direction, arm)
    }
}

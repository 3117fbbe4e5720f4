//! The types of a machine, in SI units.

use super::analysis_model::Analysis;
use super::matrices::MatrixFiles;
use crate::files::Inputs;
use std::path::PathBuf;

/// A machine: parts, the joints between them, the axis that moves some of them, and what to analyse.
#[derive(Clone, Debug)]
pub struct Machine {
    /// Name, for titles and the default output folder.
    pub name: String,
    /// The machine file itself, for messages.
    pub file: PathBuf,
    /// Finite-element parts.
    pub parts: Vec<Part>,
    /// Joints between interfaces of two parts.
    pub joints: Vec<Joint>,
    /// The axis of travel.
    pub axis: Axis,
    /// Where forces enter and motions are read.
    pub ports: Vec<Port>,
    /// What to compute.
    pub analysis: Analysis,
    /// The machine file as it was read; the files of the parts are recorded by their readers.
    pub inputs: Inputs,
}

/// One finite-element part.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name, unique in the machine.
    pub name: String,
    /// Mesh file, resolved against the machine file's folder.
    pub mesh: PathBuf,
    /// Material of the whole part; `None` takes the mesh file's own.
    pub material: Option<Material>,
    /// Node sets whose three translations are fixed to ground.
    pub clamped: Vec<String>,
    /// Interfaces, in the file's order.
    pub interfaces: Vec<Interface>,
    /// Structural loss factor of the part, if it has its own.
    pub loss_factor: Option<f64>,
    /// Length, mass and time unit of the mesh file, as factors to m, kg, s.
    pub mesh_units: MeshUnits,
    /// Stiffness and mass as another program wrote them, in place of the mesh's elements; `mesh` is then
    /// the stiffness file unless the part names a mesh for its nodes and surfaces.
    pub matrices: Option<MatrixFiles>,
    /// Node sets of which single displacements are fixed to ground.
    pub supported: Vec<Support>,
    /// Whether C3D8 elements stay plain; otherwise they get incompatible modes (C3D8I).
    pub plain_bricks: bool,
    /// Where the mesh stands in the machine.
    pub placement: Placement,
}

/// A node set some of whose displacements are fixed to ground.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Support {
    /// Node set of the mesh.
    pub nodes: String,
    /// Which of x, y, z (of the machine) are fixed.
    pub directions: [bool; 3],
}

/// How the mesh file's coordinates lie in the machine: x = origin + R x_mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// R, by rows; its columns are the mesh's axes in the machine.
    pub rotation: [[f64; 3]; 3],
    /// The mesh's origin in the machine, m.
    pub origin: [f64; 3],
}

impl Placement {
    /// The mesh stands as it is drawn.
    pub const IDENTITY: Self = Self { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], origin: [0.0; 3] };

    /// A point of the mesh (m) in the machine.
    pub fn apply(&self, x: [f64; 3]) -> [f64; 3] {
        let r = &self.rotation;
        std::array::from_fn(|i| self.origin[i] + r[i][0] * x[0] + r[i][1] * x[1] + r[i][2] * x[2])
    }
}

impl Part {
    /// Every file that the part is made from.
    pub fn files(&self) -> Vec<&std::path::Path> {
        let mut files = vec![self.mesh.as_path()];
        if let Some(given) = &self.matrices {
            let optional = [&given.dofs, &given.nodes, &given.sets];
            let own = [&given.stiffness, &given.mass].into_iter().chain(optional.into_iter().flatten());
            files.extend(own.map(PathBuf::as_path).filter(|f| *f != self.mesh));
            files.dedup();
        }
        files
    }
}

/// Factors from a mesh file's units to m, kg and s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshUnits {
    /// Metres per length unit.
    pub length: f64,
    /// Kilograms per mass unit.
    pub mass: f64,
    /// Seconds per time unit.
    pub time: f64,
}

impl MeshUnits {
    /// Metre, kilogram, second: N, Pa, kg/m^3.
    pub const METRE_KILOGRAM_SECOND: Self = Self { length: 1.0, mass: 1.0, time: 1.0 };
    /// Millimetre, tonne, second: N, MPa, t/mm^3.
    pub const MILLIMETRE_TONNE_SECOND: Self = Self { length: 1e-3, mass: 1e3, time: 1.0 };

    /// Pascals per stress unit of the mesh file.
    pub fn stress(self) -> f64 {
        self.mass / (self.length * self.time * self.time)
    }

    /// kg/m^3 per density unit of the mesh file.
    pub fn density(self) -> f64 {
        self.mass / self.length.powi(3)
    }
}

/// Isotropic linear elastic material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name.
    pub name: String,
    /// Young's modulus, Pa.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density, kg/m^3.
    pub density: f64,
}

/// A surface of a part, made of the element faces whose nodes all lie in a node set.
#[derive(Clone, Debug)]
pub struct Interface {
    /// Name, unique in its part.
    pub name: String,
    /// Node set of the mesh.
    pub nodes: String,
    /// Region that clips the surface, in the machine's coordinates as the meshes are drawn (m); `None` takes all of it.
    pub within: Option<Region>,
    /// How the surface's motion follows from its nodes.
    pub coupling: SurfaceCoupling,
}

/// Axis-aligned box; a missing bound is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Lower bounds, m.
    pub min: [f64; 3],
    /// Upper bounds, m.
    pub max: [f64; 3],
}

/// How an interface's rigid motion is tied to the nodes of its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SurfaceCoupling {
    /// Area-weighted least-squares motion; the surface stays deformable.
    Distributing,
    /// The surface moves as a rigid body.
    Rigid,
}

/// An interface of a part, by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct InterfaceRef {
    /// Index into [`Machine::parts`].
    pub part: usize,
    /// Index into [`Part::interfaces`].
    pub interface: usize,
}

/// What kind of joint the machine file named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Carriage on a rail; side 0 is the rail, side 1 the carriage.
    LinearGuide,
    /// Radial and axial stiffness at a point of an axis.
    Bearing,
    /// Axial stiffness of a screw whose free length follows the position; side 1 is the nut.
    BallScrew,
    /// Three translational and three rotational stiffnesses.
    Bolted,
    /// One or more single springs with dampers.
    SpringDamper,
}

/// A joint: springs between the motions of two interfaces, taken at one common point.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name, unique in the machine.
    pub name: String,
    /// Kind.
    pub kind: JointKind,
    /// The two sides. For a guide the rail, then the carriage; for a ball screw the mount, then the nut.
    pub between: [InterfaceRef; 2],
    /// Length of rail (m, along the axis of travel) that side 0 sees, centred on the common point.
    pub footprint: Option<f64>,
    /// The common point, in the pose in which the meshes are drawn; it travels with side 1.
    pub at: JointPoint,
    /// The springs.
    pub springs: Vec<Spring>,
    /// Structural loss factor of the joint, if it has its own.
    pub loss_factor: Option<f64>,
    /// What the time response adds to the springs; everything linear leaves it out.
    pub contact: Option<Contact>,
}

/// A nonlinear law of a joint, which acts in the time response alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contact {
    /// Friction along the travel, on the joint's spring of no stiffness labelled `travel`.
    Friction(Friction),
    /// Play of a screw: its spring is free over this length, m, symmetric about its rest.
    Backlash(f64),
}

/// Friction force F(v) = coulomb + (breakaway - coulomb) exp(-(v / stribeck)^2) against sliding; up to
/// `breakaway` it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Force at high speed, N.
    pub coulomb: f64,
    /// Force that makes it slide, N, at least `coulomb`.
    pub breakaway: f64,
    /// Speed over which the one falls to the other, m/s.
    pub stribeck: f64,
}

/// Where a joint's springs act.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointPoint {
    /// A point, m, in the pose in which the meshes are drawn.
    Point([f64; 3]),
    /// The area centroid of side 0 or side 1.
    Centroid(usize),
}

/// One spring with its damper, along or about a direction.
#[derive(Clone, Debug)]
pub struct Spring {
    /// What it resists.
    pub motion: Motion,
    /// Unit vector.
    pub direction: [f64; 3],
    /// How stiff.
    pub stiffness: SpringStiffness,
    /// Viscous damping, N s/m or N m s/rad.
    pub damping: f64,
    /// Short name within its joint, such as `x`, `radial 1`, `axial`.
    pub label: String,
}

/// What a spring resists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Motion {
    /// Relative translation along the direction.
    Translation,
    /// Relative rotation about the direction.
    Rotation,
}

/// Stiffness of a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpringStiffness {
    /// N/m or N m/rad.
    Constant(f64),
    /// A ball screw of free length L, which follows the position; see [`ScrewSupport::stiffness`].
    BallScrew {
        /// Young's modulus, Pa.
        young: f64,
        /// Diameter, m.
        diameter: f64,
        /// Free length at position 0, m; `None` takes the distance between the two sides' centroids along the axis.
        free_length: Option<f64>,
        /// Which ends are held axially.
        support: ScrewSupport,
    },
}

/// Which ends of a ball screw are held axially.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScrewSupport {
    /// The end at the mount; the other floats.
    OneEnd,
    /// Both ends.
    BothEnds {
        /// Distance between the two supports, m.
        span: f64,
    },
}

impl ScrewSupport {
    /// Axial stiffness at the nut of a screw with free length `length` (m) from mount to nut, N/m.
    ///
    /// ```text
    /// one end:    k = E A / L                          A = pi D^2 / 4
    /// both ends:  k = E A (1 / L + 1 / (span - L))
    /// ```
    pub fn stiffness(self, young: f64, diameter: f64, length: f64) -> f64 {
        let area = std::f64::consts::PI * diameter * diameter / 4.0;
        match self {
            Self::OneEnd => young * area / length,
            Self::BothEnds { span } => young * area * (1.0 / length + 1.0 / (span - length)),
        }
    }
}

/// The axis of travel.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Name.
    pub name: String,
    /// Unit vector of positive travel.
    pub direction: [f64; 3],
    /// First and last position, m, in the order of the file; the meshes are drawn at position 0.
    pub travel: [f64; 2],
    /// Distance between stations, m, positive.
    pub step: f64,
    /// For each part, whether it moves with this axis.
    pub moves: Vec<bool>,
}

impl Axis {
    /// The stations of the travel, from its first to its last position, m.
    pub fn stations(&self) -> Vec<f64> {
        let [from, to] = self.travel;
        let intervals = ((to - from).abs() / self.step * (1.0 + 1e-9)).floor().max(0.0) as usize;
        let sign = if to < from { -1.0 } else { 1.0 };
        // A station is rounded to a picometre so that 0.1 + 0.2 reads as 0.3 in every file.
        let mut stations: Vec<f64> =
            (0..=intervals).map(|i| ((from + sign * self.step * i as f64) * 1e12).round() / 1e12).collect();
        if stations.last().is_some_and(|last| (last - to).abs() > 1e-9) {
            stations.push(to);
        }
        stations
    }
}

/// Where forces enter and motions are read.
#[derive(Clone, Debug)]
pub struct Port {
    /// Name, unique in the machine.
    pub name: String,
    /// The interface whose motion it is, read at that interface's area centroid.
    pub interface: InterfaceRef,
    /// Directions, each with its name (`x`, `y`, `z`).
    pub directions: Vec<(String, [f64; 3])>,
    /// Whether forces act here.
    pub input: bool,
    /// Whether motion is read here.
    pub output: bool,
}

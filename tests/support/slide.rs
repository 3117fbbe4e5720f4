//! A bed with a rail and a carriage that moves along it in z, driven by a ball screw.

use super::{box_mesh, craig_bampton, on, part};
use stiffmap::coupling::reduction_requests;
use stiffmap::machine::*;
use stiffmap::mesh::Mesh;
use stiffmap::reduction::{Superelement, reduce};
use stiffmap::solid::interface_motions;

/// Footprint of the carriage on the rail, m.
pub const FOOTPRINT: f64 = 0.12;
/// Ends of the travel, m.
pub const TRAVEL: [f64; 2] = [0.3, -0.3];

/// The machine with its superelements.
pub struct Slide {
    pub machine: Machine,
    pub meshes: Vec<Mesh>,
    pub parts: Vec<Superelement>,
}

impl Slide {
    /// Reduces the parts of a machine as the program does.
    pub fn of(machine: Machine, meshes: Vec<Mesh>) -> Self {
        let interfaces: Vec<_> = machine
            .parts
            .iter()
            .zip(&meshes)
            .map(|(part, mesh)| interface_motions(part, mesh).expect("the interfaces have surfaces"))
            .collect();
        let requests = reduction_requests(&machine, &interfaces);
        let reduced = requests.iter().zip(&meshes);
        let parts =
            reduced.map(|(request, mesh)| reduce(request, mesh, None).expect("the part can be reduced")).collect();
        Self { machine, meshes, parts }
    }

    /// Bed and carriage, the bed clamped underneath or floating.
    pub fn new(clamped: bool) -> Self {
        let (machine, meshes) = machine(clamped);
        Self::of(machine, meshes)
    }
}

/// A spring along an axis of space.
pub fn spring(motion: Motion, axis: usize, stiffness: f64) -> Spring {
    let mut direction = [0.0; 3];
    direction[axis] = 1.0;
    let kind = match motion {
        Motion::Translation => "",
        Motion::Rotation => "r",
    };
    Spring {
        motion,
        direction,
        stiffness: SpringStiffness::Constant(stiffness),
        damping: 0.0,
        label: format!("{kind}{}", ["x", "y", "z"][axis]),
    }
}

/// The interface of a part by their places.
pub fn side(part: usize, interface: usize) -> InterfaceRef {
    InterfaceRef { part, interface }
}

/// Viscous damping ratio of all modes.
pub fn ratio(zeta: f64) -> Damping {
    Damping { ratios: vec![zeta], rayleigh: None, loss_factor: 0.0, projected: false }
}

/// A machine of some parts that stand still.
pub fn fixed_machine(parts: Vec<Part>, joints: Vec<Joint>, port: InterfaceRef) -> Machine {
    Machine {
        name: "test".into(),
        inputs: Default::default(),
        file: "machine.toml".into(),
        axis: Axis {
            name: "z".into(),
            direction: [0.0, 0.0, 1.0],
            travel: [0.0, 0.1],
            step: 0.1,
            moves: vec![false; parts.len()],
        },
        parts,
        joints,
        ports: vec![Port {
            name: "tool".into(),
            interface: port,
            directions: (0..3)
                .map(|c| {
                    let label = ["x", "y", "z"][c].to_string();
                    (label, std::array::from_fn(|i| f64::from(u8::from(i == c))))
                })
                .collect(),
            input: true,
            output: true,
        }],
        analysis: Analysis {
            component: craig_bampton(20),
            modes: 10,
            frequencies: vec![0.0, 100.0],
            grid: Grid::Listed,
            quantity: Quantity::Receptance,
            damping: ratio(0.02),
        },
    }
}

/// A joint of plain springs at the centroid of side 1.
pub fn springs(name: &str, between: [InterfaceRef; 2], springs: Vec<Spring>) -> Joint {
    Joint {
        name: name.into(),
        kind: JointKind::SpringDamper,
        between,
        footprint: None,
        at: JointPoint::Centroid(1),
        springs,
        loss_factor: None,
        contact: None,
    }
}

/// Bed 0.1 x 0.1 x 1 m with its rail on YMAX, carriage 0.1 x 0.05 x 0.1 m on top of it.
pub fn machine(clamped: bool) -> (Machine, Vec<Mesh>) {
    let bed = box_mesh([0.0; 3], [0.1, 0.1, 1.0], [1, 1, 12]);
    let carriage = box_mesh([0.0, 0.11, 0.45], [0.1, 0.05, 0.1], [2, 1, 2]);
    let held: &[&str] = if clamped { &["YMIN"] } else { &[] };
    let parts = vec![
        part("bed", held, vec![on("YMAX"), on("ZMAX")]),
        part("carriage", &[], vec![on("YMIN"), on("ZMAX"), on("YMAX")]),
    ];
    let guide = Joint {
        kind: JointKind::LinearGuide,
        footprint: Some(FOOTPRINT),
        ..springs(
            "guide",
            [side(0, 0), side(1, 0)],
            vec![
                spring(Motion::Translation, 0, 5e7),
                spring(Motion::Translation, 1, 9e7),
                spring(Motion::Rotation, 0, 2e5),
                spring(Motion::Rotation, 1, 3e5),
                spring(Motion::Rotation, 2, 1e5),
            ],
        )
    };
    let mut thread = spring(Motion::Translation, 2, 0.0);
    thread.stiffness =
        SpringStiffness::BallScrew { young: 210e9, diameter: 0.016, free_length: None, support: ScrewSupport::OneEnd };
    let screw = Joint { kind: JointKind::BallScrew, ..springs("screw", [side(0, 1), side(1, 1)], vec![thread]) };
    let mut machine = fixed_machine(parts, vec![guide, screw], side(1, 2));
    machine.axis.travel = TRAVEL;
    machine.axis.step = 0.05;
    machine.axis.moves = vec![false, true];
    (machine, vec![bed, carriage])
}

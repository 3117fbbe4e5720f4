//! The assembled machine at one position as one CalculiX deck, for an independent solver.
//!
//! Every interface that a spring or port uses gets two reference nodes: degrees of freedom 1 to 3 of
//! the first are its translations at its centroid, those of the second its rotations. They follow
//! from the surface by `*EQUATION` with the same area weights as here. A spring is an equation for
//! its elongation and a `*SPRING` to ground on that. Nodes of a rigid interface follow two free
//! nodes. Damping is left out: it does not enter undamped frequencies.
//!
//! Some of CalculiX's elements are not quite those of this program. [`element_differences`] says which, so that
//! nobody takes such a difference of the frequencies for an error of the assembly; the deck repeats it.

use super::{ExportError, atomic, finite};
use crate::coupling::{PlacedInterface, Unreduced};
use crate::element::det_variation;
use crate::machine::{Machine, Material, Part};
use crate::mesh::{Cell, CellKind, Mesh};
use crate::solid::{held_displacements, rigid_nodes};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

/// Terms of an equation on one line.
const TERMS: usize = 4;

/// Coefficients of an equation below this share of its largest are rounding.
const ROUNDING: f64 = 1e-14;

/// Variation of the Jacobian's determinant above which an eight-node brick counts as no parallelepiped.
const PARALLELEPIPED: f64 = 1e-6;

/// Characters of a comment line.
const COMMENT: usize = 100;

/// (node, degree of freedom 1 to 3, coefficient).
type Term = (usize, usize, f64);

/// Writes a machine at a position as a CalculiX deck that asks for `modes` frequencies.
///
/// # Errors
/// [`ExportError::Format`] for a part that has no mesh (matrices have no form in a deck) or no
/// material, [`ExportError::NotFinite`], [`ExportError::Io`].
pub fn write_deck(
    path: &Path,
    machine: &Machine,
    meshes: &[&Mesh],
    springs: &Unreduced,
    modes: usize,
) -> Result<(), ExportError> {
    let mut deck = Deck { path, text: String::new(), next_node: 1, first_node: Vec::new(), springs: 0 };
    deck.header(machine, springs.position);
    for difference in element_differences(machine, meshes) {
        deck.comment(&difference);
    }
    let mut first_element = 1;
    for ((part, mesh), moved) in machine.parts.iter().zip(meshes).zip(&springs.moved) {
        deck.part(part, mesh, *moved, first_element)?;
        first_element += mesh.cells.len();
    }
    let used: BTreeSet<usize> = springs.springs.iter().flat_map(|s| s.sides.map(|(i, _)| i)).collect();
    let ports = machine.ports.iter().map(|p| springs.first_interface[p.interface.part] + p.interface.interface);
    let used: BTreeSet<usize> = used.into_iter().chain(ports).collect();
    let mut reference = vec![0; springs.interfaces.len()];
    for (i, interface) in springs.interfaces.iter().enumerate() {
        if interface.rigid {
            let own = i - springs.first_interface[interface.part];
            let nodes =
                rigid_nodes(&machine.parts[interface.part].interfaces[own], &interface.motion, meshes[interface.part]);
            deck.rigid_surface(interface, &nodes, meshes[interface.part], springs.moved[interface.part])?;
        }
        if used.contains(&i) {
            reference[i] = deck.reference_nodes(interface, springs.moved[interface.part])?;
        }
    }
    for spring in &springs.springs {
        let mut terms = Vec::new();
        for (interface, coefficients) in spring.sides {
            let first = reference[interface];
            terms.extend((0..6).map(|q| (first + q / 3, 1 + q % 3, coefficients[q])));
        }
        deck.spring(&spring.name, spring.stiffness, terms, first_element)?;
        first_element += 1;
    }
    for port in &machine.ports {
        let first = reference[springs.first_interface[port.interface.part] + port.interface.interface];
        deck.line(format_args!("** port {}: translations of node {first}", port.name));
    }
    for (p, (part, mesh)) in machine.parts.iter().zip(meshes).enumerate() {
        deck.held(p, &held_displacements(part, mesh).map_err(|e| deck.refused(e.to_string()))?);
    }
    deck.line(format_args!("*STEP\n*FREQUENCY\n{modes}\n*NODE FILE\nU\n*END STEP"));
    atomic::write_bytes(path, deck.text.as_bytes())
}

/// Where CalculiX's elements differ from this program's on these meshes, a text a type of element; nothing where
/// both compute the same.
///
/// `docs/elements.md` has the reasons and the measured sizes.
pub fn element_differences(machine: &Machine, meshes: &[&Mesh]) -> Vec<String> {
    let of_kind = |kind: CellKind| -> (usize, Vec<&str>) {
        let count = |mesh: &Mesh| mesh.cells.iter().filter(|cell| cell.kind == kind).count();
        let with = machine.parts.iter().zip(meshes).map(|(part, mesh)| (part.name.as_str(), count(mesh)));
        let with: Vec<(&str, usize)> = with.filter(|(_, n)| *n > 0).collect();
        (with.iter().map(|(_, n)| n).sum(), with.into_iter().map(|(name, _)| name).collect())
    };
    let mut texts = Vec::new();
    for (kind, points) in [(CellKind::Tet4, 1), (CellKind::Tet10, 4), (CellKind::Wedge6, 2)] {
        let (count, parts) = of_kind(kind);
        if count > 0 {
            texts.push(format!(
                "CalculiX integrates the mass of {} with {points} points, too few for the inertia of the element about \
                 itself; stiffmap takes enough. The mass as a whole is the same, frequencies whose waves are a few \
                 elements long differ by up to 1e-3 ({count} elements of {})",
                kind.name(),
                parts.join(", ")
            ));
        }
    }
    let mut skewed: Vec<&str> = Vec::new();
    let (mut count, mut largest) = (0, 0.0_f64);
    for (part, mesh) in machine.parts.iter().zip(meshes) {
        for cell in mesh.cells.iter().filter(|cell| cell.kind == CellKind::Hex8Incompatible) {
            let x: Vec<[f64; 3]> = cell.nodes.iter().map(|&node| mesh.nodes[node]).collect();
            let variation = det_variation(&x);
            if variation > PARALLELEPIPED {
                count += 1;
                largest = largest.max(variation);
                if skewed.last() != Some(&part.name.as_str()) {
                    skewed.push(&part.name);
                }
            }
        }
    }
    if count > 0 {
        texts.push(format!(
            "{count} C3D8I elements of {} are no parallelepipeds. On these CalculiX's element fails the patch test and \
             stiffmap's passes it: the determinant of the Jacobian varies by up to {largest:.1e} within an element, and \
             frequencies differ by up to about {:.0e} for that",
            skewed.join(", "),
            0.5 * largest * largest
        ));
    }
    texts
}

/// Elements of one type and material, with their numbers.
type Group<'a> = (CellKind, &'a Material, Vec<(usize, &'a Cell)>);

struct Deck<'a> {
    path: &'a Path,
    text: String,
    next_node: usize,
    /// Number of each part's first node.
    first_node: Vec<usize>,
    springs: usize,
}

impl Deck<'_> {
    fn line(&mut self, text: std::fmt::Arguments<'_>) {
        self.text.write_fmt(text).expect("a String takes all text");
        self.text.push('\n');
    }

    fn header(&mut self, machine: &Machine, position: f64) {
        self.line(format_args!(
            "** {} at {} = {position} m, written by stiffmap {}",
            machine.name,
            machine.axis.name,
            env!("CARGO_PKG_VERSION")
        ));
        self.line(format_args!("** Units: m, kg, s. Damping is left out."));
    }

    /// Comment lines that hold a text.
    fn comment(&mut self, text: &str) {
        let mut line = String::from("**");
        for word in text.split_whitespace() {
            if line.len() + word.len() > COMMENT {
                self.line(format_args!("{line}"));
                line = String::from("**  ");
            }
            line += " ";
            line += word;
        }
        self.line(format_args!("{line}"));
    }

    fn point(&mut self, at: [f64; 3]) -> Result<usize, ExportError> {
        let node = self.next_node;
        let [x, y, z] = [0, 1, 2].map(|c| finite(self.path, at[c], || format!("coordinate {} of node {node}", c + 1)));
        self.line(format_args!("{node}, {:.12e}, {:.12e}, {:.12e}", x?, y?, z?));
        self.next_node += 1;
        Ok(node)
    }

    fn part(&mut self, part: &Part, mesh: &Mesh, moved: [f64; 3], first_element: usize) -> Result<(), ExportError> {
        if mesh.cells.is_empty() {
            return Err(self.refused(format!(
                "part \"{}\" is given by matrices, which a CalculiX deck cannot hold; export it with --format mtx",
                part.name
            )));
        }
        let mut groups: Vec<Group<'_>> = Vec::new();
        for (i, cell) in mesh.cells.iter().enumerate() {
            let material = part.material.as_ref().or_else(|| cell.material.map(|m| &mesh.materials[m]));
            let material = material.ok_or_else(|| {
                self.refused(format!("part \"{}\": element {} has no material", part.name, cell.label))
            })?;
            match groups.iter_mut().find(|(kind, m, _)| *kind == cell.kind && std::ptr::eq(*m, material)) {
                Some((.., cells)) => cells.push((first_element + i, cell)),
                None => groups.push((cell.kind, material, vec![(first_element + i, cell)])),
            }
        }
        self.line(format_args!("** part {}", part.name));
        self.line(format_args!("*NODE, NSET={}", set_name("NODES", &part.name)));
        let first = self.next_node;
        self.first_node.push(first);
        for x in &mesh.nodes {
            self.point([0, 1, 2].map(|c| x[c] + moved[c]))?;
        }
        for (g, (kind, material, cells)) in groups.iter().enumerate() {
            let name = set_name(&format!("ELEMENTS_{}", g + 1), &part.name);
            self.line(format_args!("*ELEMENT, TYPE={}, ELSET={name}", kind.name()));
            for (number, cell) in cells {
                self.element(*number, cell, first);
            }
            let material_name = set_name(&format!("MATERIAL_{}", g + 1), &part.name);
            self.line(format_args!("*MATERIAL, NAME={material_name}\n*ELASTIC"));
            self.line(format_args!("{:.12e}, {:.12e}", material.young, material.poisson));
            self.line(format_args!("*DENSITY\n{:.12e}", material.density));
            self.line(format_args!("*SOLID SECTION, ELSET={name}, MATERIAL={material_name}"));
        }
        Ok(())
    }

    fn refused(&self, reason: String) -> ExportError {
        ExportError::Format { path: self.path.to_path_buf(), reason }
    }

    fn held(&mut self, part: usize, nodes: &[(usize, [bool; 3])]) {
        if !nodes.is_empty() {
            self.line(format_args!("*BOUNDARY"));
        }
        for (node, directions) in nodes {
            for c in (0..3).filter(|&c| directions[c]) {
                self.line(format_args!("{}, {}, {}", self.first_node[part] + node, c + 1, c + 1));
            }
        }
    }

    fn element(&mut self, number: usize, cell: &Cell, first: usize) {
        let mut line = format!("{number}");
        for (i, node) in cell.nodes.iter().enumerate() {
            line += if i == 14 { ",\n" } else { ", " };
            line += &(first + node).to_string();
        }
        self.line(format_args!("{line}"));
    }

    /// first term = minus the sum of the others, with the first coefficient 1.
    fn equation(&mut self, what: &str, dependent: (usize, usize), others: &[Term]) -> Result<(), ExportError> {
        let largest = others.iter().map(|t| t.2.abs()).fold(0.0, f64::max);
        let others: Vec<&Term> = others.iter().filter(|t| t.2.abs() > ROUNDING * largest).collect();
        self.line(format_args!("*EQUATION\n{}", others.len() + 1));
        let mut line = format!("{}, {}, 1.", dependent.0, dependent.1);
        for (k, (node, dof, coefficient)) in others.into_iter().enumerate() {
            line += if (k + 1) % TERMS == 0 { ",\n" } else { ", " };
            let coefficient = finite(self.path, *coefficient, || format!("coefficient of node {node} in {what}"))?;
            line += &format!("{node}, {dof}, {:.12e}", -coefficient);
        }
        self.line(format_args!("{line}"));
        Ok(())
    }

    /// Two nodes at an interface's centroid that follow its motion; returns the first.
    fn reference_nodes(&mut self, interface: &PlacedInterface, moved: [f64; 3]) -> Result<usize, ExportError> {
        let motion = &interface.motion;
        self.line(format_args!("** interface {}: translations, rotations\n*NODE", interface.name));
        let at = [0, 1, 2].map(|c| motion.centroid[c] + moved[c]);
        let first = self.point(at)?;
        self.point(at)?;
        let mesh_first = self.first_node[interface.part];
        for q in 0..6 {
            let mut terms = Vec::with_capacity(3 * motion.rows.nodes.len());
            for (k, node) in motion.rows.nodes.iter().enumerate() {
                terms.extend((0..3).map(|c| (mesh_first + node, c + 1, motion.rows.rows[(q, 3 * k + c)])));
            }
            self.equation(&interface.name, (first + q / 3, 1 + q % 3), &terms)?;
        }
        Ok(first)
    }

    /// Nodes that follow two free ones: u = t + theta x arm.
    fn rigid_surface(
        &mut self,
        interface: &PlacedInterface,
        nodes: &[usize],
        mesh: &Mesh,
        moved: [f64; 3],
    ) -> Result<(), ExportError> {
        self.line(format_args!("** rigid surface {}\n*NODE", interface.name));
        let centre = interface.motion.centroid;
        let at = [0, 1, 2].map(|c| centre[c] + moved[c]);
        let t = self.point(at)?;
        let theta = self.point(at)?;
        for &node in nodes {
            let [x, y, z] = [0, 1, 2].map(|c| mesh.nodes[node][c] - centre[c]);
            for (c, turns) in [[(2, z), (3, -y)], [(3, x), (1, -z)], [(1, y), (2, -x)]].into_iter().enumerate() {
                let terms = [(t, c + 1, 1.0)].into_iter().chain(turns.map(|(d, arm)| (theta, d, arm)));
                let dependent = (self.first_node[interface.part] + node, c + 1);
                self.equation(&interface.name, dependent, &terms.collect::<Vec<Term>>())?;
            }
        }
        Ok(())
    }

    fn spring(&mut self, name: &str, stiffness: f64, terms: Vec<Term>, element: usize) -> Result<(), ExportError> {
        self.springs += 1;
        let set = format!("SPRING_{}", self.springs);
        self.line(format_args!("** spring {name}\n*NODE"));
        let node = self.point([0.0; 3])?;
        self.equation(name, (node, 1), &terms)?;
        let stiffness = finite(self.path, stiffness, || format!("stiffness of {name}"))?;
        self.line(format_args!("*ELEMENT, TYPE=SPRING1, ELSET={set}\n{element}, {node}"));
        self.line(format_args!("*SPRING, ELSET={set}\n1\n{stiffness:.12e}"));
        // The spring's node would carry two unknowns without any stiffness.
        self.line(format_args!("*BOUNDARY\n{node}, 2, 3"));
        Ok(())
    }
}

/// A set's name: capitals, digits and underscores.
fn set_name(what: &str, part: &str) -> String {
    let name: String =
        part.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() } else { '_' }).collect();
    format!("{what}_{name}")
}

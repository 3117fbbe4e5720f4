//! A part's matrices, labels, nodes and interfaces brought together.

use super::coordinates::{Coordinates, symmetric};
use super::labels::{DofLabel, DofTable, NodeSet, parse_node_table, parse_set_table};
use super::source::{Raw, bytes, read_dofs, read_matrix};
use super::{MatrixError, abaqus};
use crate::files::Inputs;
use crate::linalg::SparseSymmetric;
use crate::machine::{InterfaceNodes, InterfaceWeights, MatrixFiles, MeshUnits, Part};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

/// Nodes of a part, in SI, with their sets.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    /// Coordinates, m.
    pub nodes: Vec<[f64; 3]>,
    /// Labels.
    pub labels: Vec<u64>,
    /// Node sets: indices into `nodes`, ascending.
    pub sets: BTreeMap<String, Vec<usize>>,
    /// Names of surfaces whose faces the mesh gives.
    pub faces: BTreeSet<String>,
    /// Sets that both the mesh and the table `sets` have, with different nodes: those of the mesh, of the table.
    pub clashes: BTreeMap<String, [Vec<usize>; 2]>,
}

/// How an interface's nodes make its motion.
#[derive(Clone, Debug, PartialEq)]
pub enum GivenNodes {
    /// Faces of the mesh, by their area.
    Faces,
    /// Nodes with weights.
    Weighted(Vec<(usize, f64)>),
    /// One node's own motion.
    Point(usize),
}

/// Stiffness and mass of a part in SI units.
#[derive(Clone, Debug)]
pub struct GivenMatrices {
    /// The stiffness file, for messages.
    pub file: PathBuf,
    /// Stiffness; N/m between translations.
    pub stiffness: SparseSymmetric,
    /// Mass; kg between translations.
    pub mass: SparseSymmetric,
    /// One a row.
    pub labels: Vec<DofLabel>,
    /// Node of each row, as an index into the mesh's nodes; `None` for a modal coordinate.
    pub node_of: Vec<Option<usize>>,
    /// Nodes and directions that the files fix to ground.
    pub fixed: Vec<(usize, usize)>,
    /// One an interface of the part.
    pub interfaces: Vec<GivenNodes>,
    /// Whether the machine file says that the part is free, or held.
    pub free: Option<bool>,
}

/// A part given by matrices.
#[derive(Clone, Debug)]
pub struct MatrixPart {
    /// Its nodes.
    pub geometry: Geometry,
    /// Its matrices.
    pub matrices: GivenMatrices,
    /// What was passed over.
    pub warnings: Vec<String>,
    /// The files as they were read.
    pub inputs: Inputs,
}

/// Reads a part's matrices; `mesh` are the nodes of its mesh file, if it names one.
///
/// # Errors
/// [`MatrixError`] for what cannot be read, is missing, not symmetric, or does not fit together.
pub fn read_part_matrices(part: &Part, files: &MatrixFiles, mesh: Option<Geometry>) -> Result<MatrixPart, MatrixError> {
    let (mut warnings, mut inputs) = (Vec::new(), Inputs::default());
    two_matrices(files)?;
    let stiffness_name = files.stiffness_name.as_deref();
    let stiffness = read_matrix(&files.stiffness, stiffness_name, "stiffness", &mut warnings, &mut inputs)?;
    let mass = read_matrix(&files.mass, files.mass_name.as_deref(), "mass", &mut warnings, &mut inputs)?;
    let table = files.dofs.as_deref().map(|file| read_dofs(file, &mut inputs)).transpose()?;
    let (stiffness, mass, labels, fixed) = one_numbering(files, stiffness, mass, table.as_ref(), &mut warnings)?;

    let sets = match &files.sets {
        Some(file) => parse_set_table(&bytes(file, &mut inputs)?, file)?,
        None => BTreeMap::new(),
    };
    let places = match (&files.nodes, table) {
        (Some(file), _) => parse_node_table(&bytes(file, &mut inputs)?, file)?,
        (None, Some(table)) => table.nodes,
        (None, None) => BTreeMap::new(),
    };
    let with_mesh = mesh.is_some();
    let mut geometry = mesh.unwrap_or_else(|| of_places(&places, part.mesh_units));
    let index: HashMap<u64, usize> = geometry.labels.iter().enumerate().map(|(i, label)| (*label, i)).collect();
    let misfit = |reason: String| MatrixError::Dofs { file: files.label_file().to_path_buf(), reason };
    let node_of = labels.iter().enumerate().map(|(row, label)| match label {
        DofLabel::Modal(_) => Ok(None),
        DofLabel::Node { node, .. } => index.get(node).copied().map(Some).ok_or_else(|| {
            misfit(format!(
                "row {} is {label}, and node {node} has no coordinates; give them in the part's `mesh`, in the columns x,y,z of `dofs`, or in `nodes`",
                row + 1
            ))
        }),
    });
    let node_of = node_of.collect::<Result<Vec<_>, _>>()?;
    let fixed = fixed.iter().filter_map(|label| match label {
        DofLabel::Node { node, direction } => index.get(node).map(|&n| (n, *direction)),
        DofLabel::Modal(_) => None,
    });
    let fixed = fixed.collect();
    for (name, set) in &sets {
        let mut nodes = set.nodes.keys().map(|label| {
            index
                .get(label)
                .copied()
                .ok_or_else(|| misfit(format!("set {name} names node {label}, which has no coordinates")))
        });
        let nodes = sorted(nodes.by_ref().collect::<Result<Vec<_>, _>>()?);
        let of_mesh = geometry.sets.iter().find(|(other, _)| other.eq_ignore_ascii_case(name));
        if let Some((_, other)) = of_mesh.filter(|(_, other)| **other != nodes) {
            geometry.clashes.insert(name.clone(), [other.clone(), nodes.clone()]);
        }
        geometry.sets.insert(name.clone(), nodes);
    }
    let chosen = part.interfaces.iter().zip(&files.interfaces).map(|(interface, nodes)| {
        let refused = |reason: String| MatrixError::Interface {
            part: part.name.clone(),
            interface: interface.name.clone(),
            reason,
        };
        choose(&interface.nodes, nodes, &sets, &geometry, &index, with_mesh).map_err(refused)
    });
    let interfaces = chosen.collect::<Result<Vec<_>, _>>()?;
    for (interface, nodes) in part.interfaces.iter().zip(&files.interfaces) {
        if let Some(list) = &nodes.labels {
            let nodes = list.iter().filter_map(|label| index.get(label).copied());
            geometry.sets.insert(interface.nodes.clone(), sorted(nodes.collect()));
        }
    }

    let place = |row: usize| format!("{} ({})", row + 1, labels[row]);
    let stiffness = symmetric(stiffness, "stiffness", &place)?;
    let mass = symmetric(mass, "mass", &place)?;
    let (stiffness, mass) = in_si(stiffness, mass, &labels, part.mesh_units);
    let matrices = GivenMatrices {
        file: files.stiffness.clone(),
        stiffness,
        mass,
        labels,
        node_of,
        fixed,
        interfaces,
        free: files.free,
    };
    Ok(MatrixPart { geometry, matrices, warnings, inputs })
}

/// Refuses one matrix for stiffness and mass: the same file and name, in a file that holds one matrix a name.
fn two_matrices(files: &MatrixFiles) -> Result<(), MatrixError> {
    let full = files.stiffness.extension().is_some_and(|e| e.eq_ignore_ascii_case("full"));
    let name = |name: &Option<String>| name.as_deref().map(str::to_ascii_lowercase);
    if files.stiffness == files.mass && !full && name(&files.stiffness_name) == name(&files.mass_name) {
        let found = files.stiffness_name.as_ref().map_or_else(|| "one matrix".into(), |n| format!("the matrix {n}"));
        return Err(MatrixError::Missing {
            file: files.stiffness.clone(),
            what: "second matrix is named".into(),
            found: format!("{found} for both stiffness and mass"),
            advice: "name another file, or another matrix by stiffness_name and mass_name",
        });
    }
    Ok(())
}

/// Both matrices in one numbering, with its labels and the directions that the files fix.
fn one_numbering(
    files: &MatrixFiles,
    stiffness: Raw,
    mut mass: Raw,
    table: Option<&DofTable>,
    warnings: &mut Vec<String>,
) -> Result<(Coordinates, Coordinates, Vec<DofLabel>, Vec<DofLabel>), MatrixError> {
    let misfit = |file: &Path, reason: String| MatrixError::Dofs { file: file.to_path_buf(), reason };
    let mut matrix = stiffness.matrix;
    let mut fixed = stiffness.fixed;
    let mut labels = match (stiffness.labels, table) {
        (Some(labels), None) => labels,
        (None, Some(table)) => table.labels.clone(),
        (Some(_), Some(_)) => {
            return Err(misfit(
                files.label_file(),
                format!("{} carries its own labels; remove `dofs`", matrix.file.display()),
            ));
        }
        (None, None) => {
            return Err(misfit(
                &matrix.file,
                "its rows carry no labels; give a table node,direction[,x,y,z] as `dofs`".into(),
            ));
        }
    };
    if labels.len() != matrix.n {
        return Err(misfit(
            files.label_file(),
            format!(
                "it labels {} rows, but the stiffness matrix of {} has {}",
                labels.len(),
                matrix.file.display(),
                matrix.n
            ),
        ));
    }
    let mut rows: HashMap<DofLabel, u32> = HashMap::with_capacity(labels.len());
    for (row, label) in labels.iter().enumerate() {
        if let Some(first) = rows.insert(*label, row as u32) {
            return Err(misfit(files.label_file(), format!("rows {} and {} are both {label}", first + 1, row + 1)));
        }
    }
    if let Some(own) = &mass.labels {
        let place = own.iter().map(|label| {
            rows.get(label)
                .copied()
                .ok_or_else(|| misfit(&mass.matrix.file, format!("its {label} is no row of the stiffness matrix")))
        });
        let place = place.collect::<Result<Vec<u32>, _>>()?;
        for (i, j, _) in &mut mass.matrix.entries {
            (*i, *j) = (place[*i as usize], place[*j as usize]);
        }
    } else if mass.matrix.n > matrix.n || mass.matrix.n < matrix.n && mass.sized {
        return Err(misfit(
            &mass.matrix.file,
            format!("the mass matrix has {} rows, the stiffness matrix {}", mass.matrix.n, matrix.n),
        ));
    }
    mass.matrix.n = matrix.n;
    let mut kept = vec![true; matrix.n];
    for &(i, j, value) in &matrix.entries {
        kept[i as usize] &= !(i == j && abaqus::is_fixed(value));
    }
    if kept.contains(&false) {
        let count = kept.iter().filter(|k| !**k).count();
        warnings.push(format!(
            "{}: {count} rows with a diagonal of 1e35 and more are taken as fixed to ground",
            matrix.file.display()
        ));
        fixed.extend(labels.iter().zip(&kept).filter(|(_, kept)| !**kept).map(|(label, _)| *label));
        let mut next = 0;
        let place: Vec<u32> = kept
            .iter()
            .map(|kept| {
                next += u32::from(*kept);
                next.wrapping_sub(1)
            })
            .collect();
        for m in [&mut matrix, &mut mass.matrix] {
            m.entries.retain(|(i, j, _)| kept[*i as usize] && kept[*j as usize]);
            m.entries.iter_mut().for_each(|(i, j, _)| (*i, *j) = (place[*i as usize], place[*j as usize]));
            m.n = next as usize;
        }
        let mut keep = kept.iter();
        labels.retain(|_| keep.next().copied().unwrap_or(false));
    }
    Ok((matrix, mass.matrix, labels, fixed))
}

fn of_places(places: &BTreeMap<u64, [f64; 3]>, units: MeshUnits) -> Geometry {
    let nodes = places.values().map(|x| x.map(|c| c * units.length)).collect();
    Geometry { nodes, labels: places.keys().copied().collect(), ..Geometry::default() }
}

fn sorted(mut nodes: Vec<usize>) -> Vec<usize> {
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The nodes and weights of an interface.
fn choose(
    name: &str,
    asked: &InterfaceNodes,
    sets: &BTreeMap<String, NodeSet>,
    geometry: &Geometry,
    index: &HashMap<u64, usize>,
    with_mesh: bool,
) -> Result<GivenNodes, String> {
    let find = |label: &u64| index.get(label).copied().ok_or_else(|| format!("node {label} has no coordinates"));
    let table = sets.iter().find(|(set, _)| set.eq_ignore_ascii_case(name)).map(|(_, set)| set);
    let mesh_set = geometry.sets.iter().find(|(set, _)| set.eq_ignore_ascii_case(name)).map(|(_, nodes)| nodes);
    // A surface whose faces the mesh gives is weighed by them, be it also a node set or not.
    let faces = geometry.faces.iter().any(|surface| surface.eq_ignore_ascii_case(name));
    let by_area = matches!(asked.weights, InterfaceWeights::Unsaid | InterfaceWeights::Area);
    if faces && by_area && asked.labels.is_none() && table.is_none() {
        return Ok(GivenNodes::Faces);
    }
    let (nodes, weights): (Vec<usize>, Option<Vec<f64>>) = match (&asked.labels, table, mesh_set) {
        (Some(labels), ..) => (labels.iter().map(find).collect::<Result<_, _>>()?, None),
        (None, Some(set), _) => {
            let nodes = set.nodes.keys().map(find).collect::<Result<_, _>>()?;
            (nodes, set.weighted.then(|| set.nodes.values().copied().collect()))
        }
        (None, None, Some(nodes)) => (nodes.clone(), None),
        (None, None, None) => {
            let known: BTreeSet<&String> = sets.keys().chain(geometry.sets.keys()).chain(&geometry.faces).collect();
            let known: Vec<&str> = known.into_iter().map(String::as_str).collect();
            let known = if known.is_empty() { "none".into() } else { known.join(", ") };
            return Err(format!(
                "no node set \"{name}\"; there are {known}; give a table set,node[,weight] as `sets`, or node labels"
            ));
        }
    };
    if let [node] = nodes[..] {
        return Ok(GivenNodes::Point(node));
    }
    let equal = || vec![1.0 / nodes.len() as f64; nodes.len()];
    let weights = match (&asked.weights, weights) {
        (InterfaceWeights::Equal, _) => equal(),
        (InterfaceWeights::Given(given), _) if given.len() == nodes.len() => given.clone(),
        (InterfaceWeights::Given(given), _) => {
            return Err(format!("{} weights for {} nodes; give one a node", given.len(), nodes.len()));
        }
        (InterfaceWeights::Unsaid, Some(weights)) => weights,
        (InterfaceWeights::Unsaid | InterfaceWeights::Area, _)
            if with_mesh && asked.labels.is_none() && table.is_none() =>
        {
            return Ok(GivenNodes::Faces);
        }
        (InterfaceWeights::Area, _) => {
            return Err("weights = \"area\" needs a node set of the part's `mesh`, whose faces have areas; give the mesh, or weights".into());
        }
        (InterfaceWeights::Unsaid, None) => {
            return Err("its nodes carry no weights; write weights = \"equal\", a list of weights, or a column weight in `sets`".into());
        }
    };
    let mut pairs: Vec<(usize, f64)> = nodes.into_iter().zip(weights).collect();
    pairs.sort_unstable_by_key(|(node, _)| *node);
    if pairs.windows(2).any(|w| w[0].0 == w[1].0) {
        return Err("a node is given twice; name each node once".into());
    }
    Ok(GivenNodes::Weighted(pairs))
}

/// Both matrices in SI: displacements in m, rotations in rad, modal coordinates as they are.
fn in_si(
    stiffness: SparseSymmetric,
    mass: SparseSymmetric,
    labels: &[DofLabel],
    units: MeshUnits,
) -> (SparseSymmetric, SparseSymmetric) {
    let scale: Vec<f64> = labels
        .iter()
        .map(|label| match label {
            DofLabel::Node { direction: 0..=2, .. } => 1.0 / units.length,
            _ => 1.0,
        })
        .collect();
    let of_mass = units.mass * units.length * units.length;
    let of_stiffness = of_mass / (units.time * units.time);
    (stiffness.scaled(of_stiffness, &scale), mass.scaled(of_mass, &scale))
}

//! What is read from a `.msh` file, and what is refused.

use super::{MeshFile, SI};
use proptest::prelude::*;
use std::path::Path;
use stiffmap::machine::MeshUnits;
use stiffmap::mesh::CellKind;
use stiffmap::mesh::msh::parse_msh;

/// A tetrahedron with one of its faces, version 2.2; nodes 9 and 10 in Gmsh's order.
const TWO: &str = "$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 7 \"floor plate\"
3 8 \"BODY\"
$EndPhysicalNames
$Nodes
10
1 0 0 0
2 2 0 0
3 0 2 0
4 0 0 2
5 1 0 0
6 1 1 0
7 0 1 0
8 0 0 1
9 0 1 1
20 1 0 1
$EndNodes
$Elements
2
1 9 2 7 1 1 3 2 7 6 5
2 11 2 8 1 1 2 3 4 5 6 7 8 9 20
$EndElements
";

/// The same, version 4.1, with a section that does not matter.
const FOUR: &str = "$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
2 7 \"floor plate\"
3 8 \"BODY\"
$EndPhysicalNames
$Entities
0 0 1 1
5 0 0 0 2 2 0 1 7 0
6 0 0 0 2 2 2 1 8 1 5
$EndEntities
$Nodes
2 10 1 20
2 5 0 6
1
2
3
5
6
7
0 0 0
2 0 0
0 2 0
1 0 0
1 1 0
0 1 0
3 6 0 4
4
8
9
20
0 0 2
0 0 1
0 1 1
1 0 1
$EndNodes
$Periodic
0
$EndPeriodic
$Elements
2 2 1 2
2 5 9 1
1 1 3 2 7 6 5
3 6 11 1
2 1 2 3 4 5 6 7 8 9 20
$EndElements
";

fn parse(text: &str) -> Result<MeshFile, String> {
    parse_msh(text.as_bytes(), Path::new("part.msh"), SI, false).map_err(|error| error.to_string())
}

#[test]
fn both_versions_give_the_mesh_with_physical_names_as_sets() {
    for text in [TWO, FOUR] {
        let MeshFile { mesh, warnings } = parse(text).unwrap();
        assert_eq!(warnings, []);
        assert_eq!((mesh.cells.len(), mesh.cells[0].kind, mesh.nodes.len()), (1, CellKind::Tet10, 10));
        // Abaqus's last two midsides lie between 2, 4 and between 3, 4.
        let at = |k: usize| mesh.nodes[mesh.cells[0].nodes[k]];
        assert_eq!((at(8), at(9)), ([1.0, 0.0, 1.0], [0.0, 1.0, 1.0]));
        let floor = mesh.node_set("FLOOR PLATE").unwrap();
        assert!(floor.len() == 6 && floor.iter().all(|&n| mesh.nodes[n][2] == 0.0));
        assert_eq!(mesh.element_set("body"), Some([0].as_slice()));
        assert_eq!(mesh.node_set("BODY").map(<[usize]>::len), Some(10));
        assert!(mesh.cells[0].material.is_none());
    }
    let unnamed = TWO.replace("2 7 \"floor plate\"", "2 9 \"other\"");
    assert!(parse(&unnamed).unwrap().mesh.node_set("PhysicalSurface7").is_some());
    let units = MeshUnits { length: 1e-3, ..SI };
    assert_eq!(parse_msh(TWO.as_bytes(), Path::new("a.msh"), units, false).unwrap().mesh.nodes[1], [0.002, 0.0, 0.0]);
    // A volume in two groups stands twice in version 2.2.
    let twice = TWO
        .replace("$Elements\n2", "$Elements\n3")
        .replace("$EndElements", "3 11 2 9 1 1 2 3 4 5 6 7 8 9 20\n$EndElements");
    let mesh = parse(&twice).unwrap().mesh;
    assert_eq!((mesh.cells.len(), mesh.element_set("PhysicalVolume9")), (1, Some([0].as_slice())));
}

/// As Gmsh writes a mesh that it has partitioned: elements belong to pieces of the entities.
#[test]
fn a_partitioned_mesh_keeps_its_groups() {
    let pieces = "$EndEntities\n$PartitionedEntities\n2\n1\n99 1\n1 0 2 1\n9 0 1 2 1 2 0 0 0 0\n\
        15 2 5 1 1 0 0 0 2 2 0 1 7 0\n17 3 6 2 1 2 0 0 0 2 2 2 0 0\n16 3 6 1 1 0 0 0 2 2 2 1 8 1 15\n$EndPartitionedEntities";
    let text = FOUR
        .replace("$EndEntities", pieces)
        .replace("2 5 9 1", "2 15 9 1")
        .replace("3 6 11 1", "3 16 11 1")
        .replace("2 5 0 6", "2 15 0 6")
        .replace("3 6 0 4", "3 16 0 4");
    let (seen, whole) = (parse(&text).unwrap(), parse(FOUR).unwrap());
    assert_eq!(format!("{seen:?}"), format!("{whole:?}"));
    let other = parse(&text.replace("2 2 0 1 7 0", "2 2 0 1 9 0")).unwrap();
    assert!(other.mesh.node_set("floor plate").is_none(), "control: another group");
    let message = parse(&text.replace("15 2 5 1 1 0", "15 2 5 9 1 0")).unwrap_err();
    assert!(message.contains("part.msh:20: $PartitionedEntities"), "{message}");
}

#[test]
fn nodes_with_parameters_are_read_in_version_2() {
    let parametric: String = TWO
        .lines()
        .map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
            _ if line.contains('"') => format!("{line}\n"),
            ["1", x, y, z] => format!("1 {x} {y} {z} 0 1\n"),
            ["2", x, y, z] => format!("2 {x} {y} {z} 2 5 0.5 -1e-3\n"),
            [label, x, y, z] => format!("{label} {x} {y} {z} 3 6\n"),
            _ => format!("{}\n", line.replace("Nodes", "ParametricNodes")),
        })
        .collect();
    assert_ne!(parametric, TWO);
    assert_eq!(format!("{:?}", parse(&parametric).unwrap()), format!("{:?}", parse(TWO).unwrap()));
    let message = parse(&parametric.replace(" 3 6\n", "\n")).unwrap_err();
    assert!(message.contains("$ParametricNodes") && message.contains("dimension, entity"), "{message}");
    let message = parse(&TWO.replace("4 0 0 2", "4 0 0 2 3 6")).unwrap_err();
    assert!(message.contains("$Nodes") && message.contains("nothing behind"), "{message}");
}

#[test]
fn a_file_of_another_format_is_told_what_it_is() {
    let message = parse(super::TET).unwrap_err();
    assert!(message.contains("found \"** a comment\"") && message.contains("rename it to end in .inp"), "{message}");
    let message = parse("$NOD\n1\n1 0 0 0\n$ENDNOD\n").unwrap_err();
    assert!(message.contains("MshFileVersion = 4.1"), "{message}");
    super::refused(TWO, &["tet.inp:1", "a Gmsh mesh", ".msh"]);
}

/// Every node of a solid from Gmsh must stand where Abaqus's order wants it: midsides halfway.
#[test]
fn the_order_of_nodes_is_turned_into_abaquss() {
    // Edges of Gmsh's elements in the order of its midside nodes (reference manual, node ordering).
    type Edges = &'static [[usize; 2]];
    let brick: Edges =
        &[[0, 1], [0, 3], [0, 4], [1, 2], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 7], [5, 6], [6, 7]];
    let wedge: Edges = &[[0, 1], [0, 2], [0, 3], [1, 2], [1, 4], [2, 5], [3, 4], [3, 5], [4, 5]];
    let tet: Edges = &[[0, 1], [1, 2], [2, 0], [0, 3], [2, 3], [1, 3]];
    for (number, kind, edges) in
        [(17, CellKind::Hex20, brick), (18, CellKind::Wedge15, wedge), (11, CellKind::Tet10, tet)]
    {
        let reference = stiffmap::element::reference_nodes(kind);
        let corners = &reference[..kind.corner_count()];
        let middle =
            |e: &[usize; 2]| -> [f64; 3] { std::array::from_fn(|c| 0.5 * (corners[e[0]][c] + corners[e[1]][c])) };
        let gmsh: Vec<[f64; 3]> = corners.iter().copied().chain(edges.iter().map(middle)).collect();
        let nodes: String = (1..).zip(&gmsh).map(|(n, [x, y, z])| format!("{n} {x} {y} {z}\n")).collect();
        let labels: String = (1..=gmsh.len()).map(|n| format!(" {n}")).collect();
        let text = format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n{nodes}$EndNodes\n$Elements\n1\n1 {number} 0{labels}\n$EndElements\n",
            gmsh.len()
        );
        let mesh = parse(&text).unwrap().mesh;
        let found: Vec<[f64; 3]> = mesh.cells[0].nodes.iter().map(|&n| mesh.nodes[n]).collect();
        assert_eq!(found, reference, "{kind:?}");
    }
}

#[test]
fn what_is_not_understood_is_refused_with_its_line() {
    let two = |from: &str, to: &str, fragments: &[&str]| {
        assert!(TWO.contains(from), "{from:?}");
        let message = parse(&TWO.replacen(from, to, 1)).expect_err("refused");
        assert!(
            fragments.iter().all(|f| message.contains(f)) && message.contains("part.msh"),
            "{fragments:?} in {message}"
        );
    };
    two("2.2 0 8", "2.2 1 8", &["part.msh:2", "binary", "Mesh.Binary = 0"]);
    two("2.2 0 8", "3.0 0 8", &["part.msh:2", "2.2 or 4.1"]);
    two("2 2 0 0", "2 2 nan 0", &["part.msh:12: $Nodes", "finite"]);
    two("2 2 0 0", "2 2 0", &["part.msh:12"]);
    two("2 2 0 0", "1 2 0 0", &["part.msh:12", "node 1 is given twice"]);
    two("2 11 2 8", "2 12 2 8", &["part.msh:25", "SecondOrderIncomplete"]);
    two("2 11 2 8", "2 7 2 8", &["part.msh:25", "pyramid"]);
    two("2 11 2 8", "2 29 2 8", &["part.msh:25", "ElementOrder"]);
    two("7 8 9 20", "7 8 9", &["part.msh:25", "10 node labels"]);
    two("7 8 9 20", "7 8 9 21", &["part.msh:25", "node 21"]);
    two("7 8 9 20", "7 8 9 9", &["part.msh:25", "node 9 twice"]);
    two("$EndElements\n", "", &["no $EndElements"]);
    two("$Elements\n2", "$Elements\n18446744073709551615", &["part.msh:26", "$EndElements"]);
    two("2 11 2 8 1 1 2 3 4 5 6 7 8 9 20\n", "", &["$EndElements"]);
    two("$MeshFormat\n", "", &["part.msh:1", "$MeshFormat"]);
    let surface = TWO.replace("$Elements\n2", "$Elements\n1").replace("2 11 2 8 1 1 2 3 4 5 6 7 8 9 20\n", "");
    assert!(parse(&surface).unwrap_err().contains("no elements"));
    let many = FOUR.replace("2 5 0 6", "2 5 0 18446744073709551615");
    assert!(parse(&many).is_err());
    let message = parse(&FOUR.replace("3 6 11 1", "3 6 11 9")).unwrap_err();
    assert!(message.contains("$Elements"), "{message}");
}

proptest! {
    #[test]
    fn any_mutation_is_read_or_refused(
        four in any::<bool>(),
        edits in prop::collection::vec((0..FOUR.len(), any::<u8>(), 0usize..4), 1..6)
    ) {
        let mut bytes = if four { FOUR } else { TWO }.as_bytes().to_vec();
        for (at, byte, action) in edits {
            let at = at.min(bytes.len().saturating_sub(1));
            match action {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, b"$ \n0-E19"[byte as usize % 8]),
                2 => bytes.truncate(at + 1),
                _ => { bytes.remove(at); if bytes.is_empty() { bytes.push(byte) } }
            }
        }
        if let Ok(MeshFile { mesh, .. }) = parse_msh(&bytes, Path::new("part.msh"), SI, false) {
            prop_assert!(!mesh.cells.is_empty() && mesh.nodes.iter().flatten().all(|x| x.is_finite()));
            for cell in &mesh.cells {
                prop_assert!(cell.nodes.len() == cell.kind.node_count());
                prop_assert!(cell.nodes.iter().all(|&node| node < mesh.nodes.len()));
            }
            for set in mesh.node_sets.values() {
                prop_assert!(set.windows(2).all(|pair| pair[0] < pair[1]) && set.last().is_none_or(|n| *n < mesh.nodes.len()));
            }
        }
    }
}

//! The reader of `.inp` files.

use std::path::Path;
use stiffmap::machine::MeshUnits;
use stiffmap::mesh::read_mesh_file;

#[test]
fn the_bundled_meshes_are_read_whole_and_without_a_warning() {
    // Node counts from the meshes' own README; elements counted with `grep`.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/vertical_mill");
    for (name, nodes, cells, sets) in [
        ("column", 13_039, 6_629, 6),
        ("headstock", 6_629, 3_450, 8),
        ("spindle", 7_338, 3_991, 4),
        ("drive", 1_744, 862, 2),
        ("magazine", 1_882, 941, 2),
    ] {
        let t = std::time::Instant::now();
        let file = read_mesh_file(
            &folder.join(format!("{name}.inp")),
            MeshUnits::METRE_KILOGRAM_SECOND,
        )
        .unwrap();
        eprintln!("{name} {:?}", t.elapsed());
        assert_eq!(file.warnings, [], "{name}");
        let mesh = file.mesh;
        assert_eq!(
            (mesh.nodes.len(), mesh.cells.len(), mesh.node_sets.len()),
            (nodes, cells, sets),
            "{name}"
        );
        assert!(
            mesh.cells.iter().all(|cell| cell.material == Some(0)),
            "{name}"
        );
    }
}

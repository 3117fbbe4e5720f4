//! Skins: few nodes, the part's own places and motions.

use crate::support::{box_mesh, craig_bampton, on, part, superelement};
use nalgebra::Vector3;
use stiffmap::mesh::Mesh;
use stiffmap::reduction::{Skin, skin};

fn area(mesh: &Mesh, skin: &Skin) -> f64 {
    let corner = |n: usize| Vector3::from(mesh.nodes[skin.nodes[n]]);
    skin.triangles
        .iter()
        .map(|t| (corner(t[1]) - corner(t[0])).cross(&(corner(t[2]) - corner(t[0]))).norm() / 2.0)
        .sum()
}

/// Volume inside, by the divergence theorem; right only if all triangles face outward.
fn volume(mesh: &Mesh, skin: &Skin) -> f64 {
    let corner = |n: usize| Vector3::from(mesh.nodes[skin.nodes[n]]);
    skin.triangles.iter().map(|t| corner(t[0]).dot(&corner(t[1]).cross(&corner(t[2]))) / 6.0).sum()
}

#[test]
fn a_small_part_keeps_its_whole_surface_and_a_large_one_its_form() {
    let mesh = box_mesh([0.1, 0.2, 0.3], [0.4, 0.3, 0.5], [8, 6, 10]);
    let (exact_area, exact_volume) = (2.0 * (0.4 * 0.3 + 0.3 * 0.5 + 0.5 * 0.4), 0.4 * 0.3 * 0.5);
    let whole = skin(&mesh, 10_000);
    assert!((area(&mesh, &whole) / exact_area - 1.0).abs() < 1e-12);
    assert!((volume(&mesh, &whole) / exact_volume - 1.0).abs() < 1e-12);
    assert_eq!(whole.nodes.len(), 9 * 7 * 11 - 7 * 5 * 9, "the outer corner nodes");
    let thin = skin(&mesh, 120);
    println!("{} of {} nodes, {} triangles", thin.nodes.len(), whole.nodes.len(), thin.triangles.len());
    assert!(thin.nodes.len() <= 120 && thin.nodes.len() >= 40);
    assert!((area(&mesh, &thin) / exact_area - 1.0).abs() < 0.3, "{}", area(&mesh, &thin));
    assert!((volume(&mesh, &thin) / exact_volume - 1.0).abs() < 0.3, "{}", volume(&mesh, &thin));
    assert!(thin.nodes.iter().all(|n| whole.nodes.contains(n)));
}

#[test]
fn the_skin_of_a_superelement_moves_with_its_interfaces() {
    let mesh = box_mesh([0.0; 3], [0.1, 0.1, 0.3], [2, 2, 4]);
    let reduced = superelement(&part("post", &["ZMIN"], vec![on("ZMAX")]), &mesh, craig_bampton(6));
    let top: Vec<usize> =
        (0..reduced.skin.nodes.len()).filter(|&n| (reduced.skin.nodes[n][2] - 0.3).abs() < 1e-12).collect();
    let bottom: Vec<usize> =
        (0..reduced.skin.nodes.len()).filter(|&n| reduced.skin.nodes[n][2].abs() < 1e-12).collect();
    // First bending: the mean of the top's nodes is the interface's translation, the clamp stands still.
    let mean = |c: usize| top.iter().map(|n| reduced.skin.basis[(3 * n + c, 0)]).sum::<f64>() / top.len() as f64;
    let motion = |c: usize| reduced.interfaces[0].rows[(c, 0)];
    let size = motion(0).hypot(motion(1));
    assert!((mean(0) - motion(0)).hypot(mean(1) - motion(1)) < 0.02 * size);
    assert!(bottom.iter().all(|n| (0..3).all(|c| reduced.skin.basis[(3 * n + c, 0)].abs() < 1e-12 * size)));
    assert!(!top.is_empty() && !bottom.is_empty() && size > 0.0);
    assert!(
        (mean(0) - motion(1)).hypot(mean(1) - motion(0)) > 0.02 * size || motion(0) == motion(1),
        "control: x for y"
    );
}

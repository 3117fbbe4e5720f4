//! The slide without its clamp: what is finite at 0 Hz, and how the rest is refused.

use super::*;
use nalgebra::{DMatrix, Matrix3, Matrix3x6, Vector3};

/// The slide with a bed that nothing holds.
fn free_slide(study: &str) -> TempDir {
    let folder = folder_with(study);
    let machine = MACHINE.replace("clamped = [\"YMIN\"]\n", "");
    std::fs::write(folder.path().join("machine.toml"), machine).unwrap();
    folder
}

fn run(folder: &TempDir, arguments: &[&str]) -> Output {
    let mut command = stiffmap();
    command.current_dir(folder.path()).args(["run", ".", "--no-figures", "--positions", "0", "--out", "out"]);
    command.args(arguments).output().unwrap()
}

/// Accelerance of two rigid steel boxes in one piece at a point: P (sum of their inertias)^-1 P^T.
fn rigid_accelerance(at: [f64; 3]) -> Matrix3<f64> {
    let cross = |r: Vector3<f64>| r.cross_matrix();
    let mut inertia = DMatrix::<f64>::zeros(6, 6);
    for (from, size) in [([0.0, 0.0, 0.0], [0.1, 0.1, 1.0]), ([0.0, 0.11, 0.45], [0.1, 0.05, 0.1])] {
        let (from, size) = (Vector3::from(from), Vector3::<f64>::from(size));
        let mass = 7850.0 * size.product();
        let centre = cross(from + 0.5 * size);
        let own = Matrix3::from_diagonal(&size.map(|a| size.norm_squared() - a * a)) * (mass / 12.0);
        let mut add = |row: usize, column: usize, block: Matrix3<f64>| {
            let mut view = inertia.view_mut((row, column), (3, 3));
            view += block;
        };
        add(0, 0, Matrix3::identity() * mass);
        add(0, 3, -centre * mass);
        add(3, 0, centre * mass);
        add(3, 3, own - centre * centre * mass);
    }
    let mut port = Matrix3x6::zeros();
    port.fixed_columns_mut::<3>(0).copy_from(&Matrix3::identity());
    port.fixed_columns_mut::<3>(3).copy_from(&-cross(at.into()));
    let port = DMatrix::from_fn(3, 6, |i, j| port[(i, j)]);
    let found = &port * inertia.try_inverse().unwrap() * port.transpose();
    Matrix3::from_fn(|i, j| found[(i, j)])
}

#[test]
fn accelerance_at_0_hz_is_that_of_the_rigid_machine() {
    let folder = free_slide(STUDY);
    done(&run(&folder, &["--quantity", "accelerance", "--frequencies", "0:100:10"]));
    let exact = rigid_accelerance([0.05, 0.16, 0.5]);
    for (axis, name) in ["xx", "yy", "zz"].into_iter().enumerate() {
        let text = std::fs::read_to_string(out_of(&folder).join(format!("surface_{name}.csv"))).unwrap();
        let first: Vec<f64> = text.lines().nth(1).unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(first[1], 0.0, "the first row is at 0 Hz");
        assert!((first[2] / exact[(axis, axis)] - 1.0).abs() < 1e-6, "{name}: {first:?}, exact {exact}");
        assert!(
            (first[2] * 7850.0 * (0.01 + 0.0005) - 1.0).abs() > 1e-2 || axis == 1,
            "control: off its centre it turns too"
        );
    }
}

#[test]
fn receptance_and_mobility_at_0_hz_are_refused_with_the_parts_that_move() {
    let folder = free_slide(STUDY);
    for quantity in ["receptance", "mobility"] {
        let refused = run(&folder, &["--quantity", quantity]);
        assert_ne!(refused.status.code(), Some(0));
        let said = stderr(&refused);
        for words in
            ["bed, carriage move together", quantity, "at 0 Hz is infinite", "begin the frequencies above 0 Hz"]
        {
            assert!(said.contains(words), "{words:?} is not in {said}");
        }
        assert!(!said.contains("damping"), "{said}");
        done(&run(&folder, &["--quantity", quantity, "--frequencies", "1:100:10"]));
    }
}

#[test]
fn a_sweep_of_a_free_machine_from_0_hz_says_in_each_row_why_it_is_empty_and_one_above_does_not() {
    let folder = free_slide(STUDY);
    let refused = sweep(folder.path(), "out", &[]);
    assert_eq!(refused.status.code(), Some(1), "no design is answered: {}", stderr(&refused));
    let errors = column(&table(folder.path(), "out"), "error");
    assert!(
        errors.iter().all(|e| e.contains("rigid motions that the ports feel") && !e.contains("damping")),
        "{errors:?}"
    );
    let above = changed("[objectives]", "[band]\nfrom = \"5 Hz\"\nto = \"1500 Hz\"\n[objectives]");
    let folder = free_slide(&above);
    done(&sweep(folder.path(), "out", &[]));
    assert!(column(&table(folder.path(), "out"), "error").iter().all(String::is_empty));
}

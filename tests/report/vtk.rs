//! The files for ParaView as VTK reads them.

use crate::mill;
use std::process::Command;

const SCRIPT: &str = r#"
import sys, numpy as np, pyvista
from scipy.io import loadmat
folder = sys.argv[1]
surface = pyvista.read(folder + "/surface_xx.vts")
for name in ("position_m", "frequency_hz", "magnitude", "phase_deg", "log10_magnitude"):
    assert surface.point_data[name].size == 121 * 901, name
grid = pyvista.read(folder + "/mode_shapes_z_-300_mm.vtu")
assert grid.n_cells == grid.cells_dict[5].shape[0] and grid.n_cells > 1000
states = loadmat(folder + "/state_space.mat")["states"][0]
state = next(s for s in states if abs(float(s["position"].squeeze()) + 0.3) < 1e-9)
frequency = grid.field_data["frequency_hz"]
assert frequency.size == 31 and frequency[0] == 0.0
elastic = np.sqrt(state["eigenvalues"].ravel()) / (2 * np.pi)
assert np.allclose(frequency[1:], elastic[-30:], rtol=1e-9), (frequency[1:4], elastic[-30:-27])
assert float(grid.field_data["position_m"][0]) == -0.3
# The nose moves as the port says: the lowest ring of the spindle's nodes, rigid within a few per cent.
spindle = np.unique(grid.cells_dict[5][np.asarray(grid.cell_data["part"]) == 2])
z = grid.points[spindle, 2]
nose = spindle[z < z.min() + 1e-3]
worst = 0.0
for rank in (2, 3, 4, 5):
    shape = grid.point_data[f"shape_{rank:02d}"]
    assert shape.shape == (grid.n_points, 3)
    port = state["eigenvectors"][-30:][rank - 2]
    mean = shape[nose].mean(axis=0)
    sign = np.sign(mean @ port)
    worst = max(worst, np.linalg.norm(mean * sign - port) / np.linalg.norm(port))
print("nose against port", worst, "nodes", nose.size)
assert worst < 0.05, worst
"#;

#[test]
fn vtk_finds_the_arrays_by_name_and_the_nose_moves_as_the_port() {
    if std::env::var("STIFFMAP_PYTHON_TESTS").is_ok_and(|v| v == "skip") {
        eprintln!("skipped: STIFFMAP_PYTHON_TESTS=skip");
        return;
    }
    let python = std::env::var("STIFFMAP_PYTHON")
        .expect("STIFFMAP_PYTHON names no Python; set it to one that has scipy and pyvista");
    let run = Command::new(python).args(["-c", SCRIPT]).arg(mill()).output().unwrap();
    print!("{}", String::from_utf8_lossy(&run.stdout));
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
}

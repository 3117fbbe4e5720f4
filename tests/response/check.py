"""Compare time histories and state spaces with SciPy and python-control; prints one figure.

    check.py lsim SYSTEM HISTORY       scipy.signal.lsim (straight lines between samples), share of the peak
    check.py expm SYSTEM HISTORY       the matrix exponential of the augmented system, share of the peak
    check.py discrete SYSTEM HISTORY   scipy.signal.dlsim of the discretised system, share of the peak
    check.py control SYSTEM MAP        python-control's frequency response, relative Frobenius norm
    check.py shapes DATABASE DATABASE  names, shapes and types of `stiffmap run`'s database; 0 or an error
    check.py aligned DATABASE SYSTEM   cubic interpolation of the file's aligned matrices, share of the peak

Files are MAT-files of the program. SYSTEM is a state-space database, of which the first struct counts.
"""

import sys

import numpy as np
from scipy.io import loadmat
from scipy.linalg import expm


def system(path):
    s = loadmat(path)["states"][0, 0]
    return [s[name] for name in "ABCD"]


def history(path):
    h = loadmat(path)
    rows = [h[name] for name in ("displacement", "velocity", "acceleration") if name in h]
    return h["time_s"].ravel(), h["force"], np.hstack([r.reshape(r.shape[0], r.shape[1], -1)[:, :, 0] for r in rows])


def share(seen, expected):
    return np.abs(seen - expected).max() / np.abs(expected).max()


def shares(seen, expected, blocks):
    """The largest of the shares of displacement, velocity and acceleration, each of its own peak."""
    width = expected.shape[1] // blocks
    return max(share(seen[:, i : i + width], expected[:, i : i + width]) for i in range(0, expected.shape[1], width))


def lsim(system_path, history_path):
    from scipy.signal import lsim

    a, b, c, d = system(system_path)
    t, u, y = history(history_path)
    seen = lsim((a, b, c, d), u, t, interp=True)[1]
    return shares(y, seen, c.shape[0] // 3)


def by_expm(system_path, history_path):
    a, b, c, d = system(system_path)
    t, u, y = history(history_path)
    h = t[1] - t[0]
    n, m = b.shape
    big = np.zeros((n + 2 * m, n + 2 * m))
    big[:n, :n] = a * h
    big[:n, n : n + m] = b * h
    big[n : n + m, n + m :] = np.eye(m)
    e = expm(big)
    phi, hold, ramp = e[:n, :n], e[:n, n : n + m], e[:n, n + m :]
    x = np.zeros(n)
    out = np.empty((len(t), c.shape[0]))
    for k in range(len(t)):
        out[k] = c @ x + d @ u[k]
        if k + 1 < len(t):
            x = phi @ x + hold @ u[k] + ramp @ (u[k + 1] - u[k])
    return shares(y, out, c.shape[0] // 3)


def discrete(system_path, history_path):
    from scipy.signal import dlsim

    file = loadmat(system_path)
    t, u, y = history(history_path)
    h = float(file["sample_time"].item())
    assert abs(h - (t[1] - t[0])) < 1e-15 and str(file["hold"][0]) == "first"
    a, b, c, d = system(system_path)
    # The states are shifted by P u, so that rest is x = -P u(0), which is zero for a force from zero.
    assert np.all(u[0] == 0)
    seen = dlsim((a, b, c, d, h), u)[1]
    return shares(y, seen, c.shape[0] // 3)


def control(system_path, map_path):
    import control as ct

    a, b, c, d = system(system_path)
    m = loadmat(map_path)
    expected = m["receptance"][0]
    response = ct.ss(a, b, c, d).frequency_response(2 * np.pi * m["frequency_hz"].ravel())
    seen = np.moveaxis(np.asarray(response.frdata), 2, 0)[:, : expected.shape[1], :]
    norm = lambda x: np.sqrt((np.abs(x) ** 2).sum(axis=(1, 2)))
    return (norm(seen - expected) / norm(expected)).max()


def aligned(database_path, system_path):
    """What a user does who has the file alone."""
    from scipy.interpolate import CubicSpline

    file = loadmat(database_path)
    exact = loadmat(system_path)["states"][0, 0]
    p = exact["position"].item()
    w = file["aligned"][0, 0]
    order = np.argsort(w["position"].ravel())
    at = lambda name: CubicSpline(w["position"].ravel()[order], w[name][order])(p)
    k, c, b, l, h0 = (at(name) for name in ("stiffness", "damping", "inputs", "outputs", "compliance"))
    h0 = h0 - l @ np.linalg.solve(k, b)
    n = k.shape[0]
    largest = peak = 0.0
    a, bb, cc, dd = (exact[name] for name in "ABCD")
    for f in np.linspace(2, 600, 300):
        s = 2j * np.pi * f
        seen = l @ np.linalg.solve(k + s * c + s * s * np.eye(n), b) + h0
        wanted = cc @ np.linalg.solve(s * np.eye(len(a)) - a, bb) + dd
        largest = max(largest, np.linalg.norm(seen - wanted))
        peak = max(peak, np.linalg.norm(wanted))
    return largest / peak


def shapes(path, _):
    """Eleven positions, thirty modes, three outputs with velocities and accelerations, discretised."""
    file = loadmat(path)
    assert file["states"].shape == (1, 11) and file["states"].dtype.names == (
        "position", "A", "B", "C", "D", "eigenvalues", "eigenvectors", "damping",
    )
    expected = [(1, 1), (60, 60), (60, 3), (9, 60), (9, 3), (30, 1), (30, 3), (30, 1)]
    for s in file["states"][0]:
        assert [s[name].shape for name in file["states"].dtype.names] == expected
        assert all(s[name].dtype == np.float64 for name in file["states"].dtype.names)
        assert np.abs(np.linalg.eigvals(s["A"])).max() < 1
    assert file["sample_time"].item() == 5e-5 and str(file["hold"][0]) == "first"
    rows = [str(r[0]) for r in file["rows"].ravel()]
    assert rows == [f"{q} {o}" for q in ("displacement", "velocity", "acceleration") for o in "xyz"]
    a = file["aligned"][0, 0]
    n = a["stiffness"].shape[1]
    assert a["stiffness"].shape == (11, n, n) and a["inputs"].shape == (11, n, 3) and a["outputs"].shape == (11, 3, n)
    loo = file["leave_one_out"].ravel()
    assert np.isnan(loo[[0, -1]]).all() and (loo[1:-1] > 0).all() and (loo[1:-1] < 1e-2).all()
    return 0.0


CHECKS = {
    "shapes": shapes,
    "lsim": lsim,
    "expm": by_expm,
    "discrete": discrete,
    "control": control,
    "aligned": aligned,
}

if __name__ == "__main__":
    if len(sys.argv) != 4 or sys.argv[1] not in CHECKS:
        sys.exit(__doc__)
    print(f"{CHECKS[sys.argv[1]](sys.argv[2], sys.argv[3]):.17e}")

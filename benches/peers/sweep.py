#!/usr/bin/env python3
"""Rate of a sweep in (design, position) pairs per second beside SciPy's on the same reduced machine.

    cargo build --release
    python benches/peers/sweep.py

SciPy does for each pair what a script does today: scipy.linalg.eigh of the machine in its fixed basis (exported by
`stiffmap export --format mtx`), then the modal sum of the direct receptances over the study's grid, the modes up to
twice the band one by one and the rest as a constant. Its peaks are those of the grid; stiffmap's are refined. The
stiffness of a real sweep changes from pair to pair; here its diagonal is scaled a little, which costs nothing.
Needs numpy and scipy (benches/peers/requirements.txt).
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import scipy.io
import scipy.linalg

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target" / "release" / "stiffmap"
STUDY = ROOT / "machines" / "vertical_mill" / "study.toml"
POSITIONS = [0.0, -0.3, -0.6]
PAIRS = 12
DAMPING = 0.02


def metrics(stiffness, outputs, direct, frequencies):
    values, shapes = scipy.linalg.eigh(stiffness, driver="evd", check_finite=False)
    ports = outputs @ shapes
    omega = 2 * np.pi * frequencies
    felt = np.abs(ports).max(axis=0) > 1e-6 * np.abs(ports).max()
    low = felt & (values <= (2 * omega[-1]) ** 2)
    rest = np.diag(direct) + (ports[:, felt & ~low] ** 2 / values[felt & ~low]).sum(axis=1)
    natural = np.sqrt(np.maximum(values[low], 0))
    weights = 1 / (natural**2 - omega[:, None] ** 2 + 2j * DAMPING * natural * omega[:, None])
    receptance = weights @ (ports[:, low] ** 2).T + rest
    largest = np.abs(receptance).max(axis=0)
    return 1 / largest, receptance.real.min(axis=0), 1 / receptance[0].real


def scipy_rate(folder):
    frequencies = np.arange(0.0, 901.0)
    machines = []
    for k, position in enumerate(POSITIONS):
        out = folder / f"position{k}"
        command = [PROGRAM, "export", STUDY.parent, "--format", "mtx", "--position", str(position), "--out", out]
        subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
        machines.append([np.asarray(scipy.io.mmread(out / f"{name}.mtx")) for name in ("stiffness", "outputs", "direct")])
    metrics(*machines[0], frequencies)
    seconds = []
    for pair in range(PAIRS):
        stiffness, outputs, direct = machines[pair % len(machines)]
        stiffness = stiffness * (1 + 0.01 * pair)
        start = time.perf_counter()
        metrics(stiffness, outputs, direct, frequencies)
        seconds.append(time.perf_counter() - start)
    return machines[0][0].shape[0], 1 / float(np.median(seconds))


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        n, before = scipy_rate(folder)
        command = [PROGRAM, "sweep", STUDY, "--out", folder / "sweep", "--no-figures", "--json", "--route", "modes"]
        start = time.perf_counter()
        ran = subprocess.run(command, check=True, capture_output=True, text=True)
        seconds = time.perf_counter() - start
        manifest = json.loads(ran.stdout)
        _, after = scipy_rate(folder)
    ours, theirs = manifest["settings"]["pairs_per_second"], max(before, after)
    print(f"SciPy, n = {n}: {before:.1f} and {after:.1f} pairs/s before and after")
    print(f"stiffmap sweep, whole process {seconds:.1f} s: {ours:.0f} pairs/s")
    print(f"ratio to SciPy's better figure: {ours / theirs:.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

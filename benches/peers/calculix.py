"""The bundled mill at three positions by CalculiX, beside stiffmap: 20 elastic frequencies at each.

    apt-get install calculix-ccx
    cargo build --release
    python3 benches/peers/calculix.py [POSITION ...]

Exports one deck a position (30,632 nodes, distributing couplings and springs as equations), solves it with ccx, which
takes about a minute each, and prints the largest relative difference. Exits with 1 if one is above 0.1 %.
"""

import csv
import subprocess
import sys
import tempfile
import time
from pathlib import Path

MODES = 20
STIFFMAP = Path("target/release/stiffmap").resolve()


def calculix(deck):
    """Elastic frequencies (Hz) of a solved deck; the spindle's free rotation is left out."""
    rows = [line.split() for line in deck.with_suffix(".dat").read_text().split("P A R T I C I P A T I O N")[0].splitlines()]
    return [f for f in (float(r[3]) for r in rows if len(r) == 5 and r[0].isdigit()) if f > 1.0][:MODES]


def main():
    positions = sys.argv[1:] or ["0", "-0.3025", "-0.6"]
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        run = [STIFFMAP, "run", "--no-figures", "--positions", ",".join(positions), "--out", folder / "run"]
        subprocess.run(run, check=True, capture_output=True)
        ours = {}
        for row in csv.DictReader((folder / "run/eigenfrequencies.csv").open()):
            if float(row["frequency_hz"]) > 1.0:
                ours.setdefault(float(row["position_m"]), []).append(float(row["frequency_hz"]))
        for position in positions:
            deck = folder / f"at{position}.inp"
            export = [STIFFMAP, "export", "--format", "inp", "--position", position, "--modes", str(MODES + 1), "--out", deck]
            subprocess.run(export, check=True, capture_output=True)
            start = time.monotonic()
            subprocess.run(["ccx", deck.stem], cwd=folder, check=True, capture_output=True)
            seconds = time.monotonic() - start
            theirs = calculix(deck)
            assert len(theirs) == MODES, f"ccx found {len(theirs)} elastic frequencies of {MODES}"
            worst = max(abs(a / b - 1.0) for a, b in zip(ours[float(position)], theirs))
            failed |= worst > 1e-3
            print(f"z = {position} m: {theirs[0]:.3f} to {theirs[-1]:.3f} Hz, largest difference {worst:.1e}, ccx {seconds:.0f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

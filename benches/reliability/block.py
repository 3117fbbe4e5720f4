"""A block of steel on a soft guide, small enough to be run hundreds of times; its lowest frequency is sqrt(k / m) / 2 pi,
so a result shows by itself which mass it was made from. Standard library only."""

import csv
import hashlib
import json
import math
import os
import pathlib
import subprocess

MACHINE = """
name = "block"

[axes.z]
direction = [0, 0, 1]
travel = ["0 mm", "200 mm"]
step = "100 mm"
moves = ["block"]

[parts.bed]
mesh = "bed/part.inp"
clamped = ["YMIN"]
interfaces = { rail = { nodes = "YMAX" }, mount = { nodes = "ZMAX" } }

[parts.block]
PART
interfaces = { shoe = { nodes = "SHOE" }, nut = { nodes = "NUT" }, top = { nodes = "TOP" } }

[[joints]]
name = "guide"
type = "linear-guide"
rail = "bed.rail"
carriage = "block.shoe"
footprint = "120 mm"
stiffness = { x = "STIFFNESS N/um", y = "1000 N/um", rx = "1e9 N m/rad", ry = "1e9 N m/rad", rz = "1e9 N m/rad" }

[[joints]]
name = "screw"
type = "ball-screw"
between = ["bed.mount", "block.nut"]
axis = "z"
young = "210 GPa"
diameter = "16 mm"

[ports.tool]
interface = "block.top"
directions = ["x", "y", "z"]

[analysis]
component = { modes = 6 }
modes = 2
frequencies = { from = "0 Hz", to = "300 Hz", step = "1 Hz" }
damping = { ratio = 0.02 }
"""

STUDY = """
name = "block study"
machine = "machine.toml"
[variables.guide]
path = "joints.guide.stiffness.y"
range = ["500 N/um", "2000 N/um"]
[sampling]
method = "latin-hypercube"
designs = 400
seed = SEED
[metrics.stiffness]
kind = "static-stiffness"
directions = ["x"]
[metrics.dynamic]
kind = "dynamic-stiffness"
directions = ["x", "z"]
[objectives]
dynamic_x = "maximise"
[optimise]
evaluations = 60
seed = SEED
"""

BY_MESH = 'mesh = "block/part.inp"'
BY_MATRICES = (
    'matrices = { stiffness = "given/stiffness.mtx", mass = "given/mass.mtx", dofs = "given/dofs.csv", '
    'sets = "given/sets.csv", free = true }\nunits = "m-kg-s"'
)
DENSITY, VOLUME = 7850.0, 0.12 * 0.1 * 0.12


def truth(density, stiffness=1.0):
    """The lowest frequency, Hz, of the block of a density on a guide of so many N/um."""
    return math.sqrt(1e6 * stiffness / (density * VOLUME)) / (2 * math.pi)


def box(corner, size, cells, sets):
    """A box of bricks as an input file; `sets` names some of its faces, and its material is included."""
    n = [c + 1 for c in cells]
    label = lambda i, j, k: 1 + i + n[0] * (j + n[1] * k)
    points = [(i, j, k) for k in range(n[2]) for j in range(n[1]) for i in range(n[0])]
    lines = ["*NODE"]
    lines += [f"{label(*p)}, " + ", ".join(repr(corner[c] + size[c] * p[c] / cells[c]) for c in range(3)) for p in points]
    lines.append("*ELEMENT, TYPE=C3D8, ELSET=ALL")
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    bricks = [(i, j, k) for k in range(cells[2]) for j in range(cells[1]) for i in range(cells[0])]
    for number, (i, j, k) in enumerate(bricks, 1):
        lines.append(f"{number}, " + ", ".join(str(label(i + a, j + b, k + c)) for a, b, c in corners))
    for name, axis, end in sets:
        lines.append(f"*NSET, NSET={name}")
        lines += [f"{label(*p)}," for p in points if p[axis] == (cells[axis] if end else 0)]
    return "\n".join(lines + ["*INCLUDE, INPUT=more/steel.inp", "*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL", ""])


def material(density):
    return f"*MATERIAL, NAME=STEEL\n*ELASTIC\n210e9, 0.3\n*DENSITY\n{density}\n"


class Room:
    """The machine in a folder, with a cache of its own."""

    def __init__(self, folder, program):
        self.folder, self.program = pathlib.Path(folder), program
        bed = box((-0.1, -0.1, -0.2), (0.2, 0.1, 0.6), (2, 2, 6), [("YMIN", 1, 0), ("YMAX", 1, 1), ("ZMAX", 2, 1)])
        block = box((-0.06, 0, -0.06), (0.12, 0.1, 0.12), (2, 2, 2), [("SHOE", 1, 0), ("NUT", 2, 1), ("TOP", 1, 1)])
        self.block = block
        for part, text in [("bed", bed), ("block", block)]:
            self.write(f"{part}/part.inp", text)
            self.write(f"{part}/more/steel.inp", material(DENSITY))
        self.machine()
        self.write("study.toml", STUDY.replace("SEED", "1"))
        self.write("other.toml", STUDY.replace("SEED", "2"))

    def machine(self, part=BY_MESH, stiffness=1.0):
        text = MACHINE.replace("PART", part).replace("STIFFNESS", repr(stiffness))
        if part == BY_MATRICES:
            for name in ("SHOE", "NUT", "TOP"):
                text = text.replace(f'"{name}"', f'"{name.lower()}"')
        self.write("machine.toml", text)

    def path(self, name):
        return self.folder / name

    def write(self, name, text):
        """Writes a file aside and renames it, as editors do."""
        path = self.path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        aside = path.with_name(path.name + "~")
        aside.write_text(text)
        os.replace(aside, path)

    def start(self, *words):
        environment = dict(os.environ, STIFFMAP_CACHE=str(self.path("cache")))
        return subprocess.Popen(
            [self.program, *words], cwd=self.folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
        )

    def run(self, *words):
        """Exit code and what was said."""
        process = self.start(*words)
        said = process.communicate()[1].decode()
        return process.returncode, said

    def done(self, *words):
        code, said = self.run(*words)
        assert code == 0, (words, said)

    def manifest(self, out):
        path = self.path(out) / "manifest.json"
        return json.loads(path.read_text()) if path.exists() else None

    def frequency(self, out):
        with open(self.path(out) / "eigenfrequencies.csv") as file:
            return float(next(csv.DictReader(file))["frequency_hz"])

    def content(self, out):
        """Hashes of the files of a result; manifest and page hold the seconds of their run and are left out."""
        files = sorted(p for p in self.path(out).rglob("*") if p.is_file())
        names = [p.relative_to(self.path(out)).as_posix() for p in files]
        kept = [n for n in names if not n.startswith(".") and n not in ("manifest.json", "report.html")]
        return {n: hashlib.sha256((self.path(out) / n).read_bytes()).hexdigest() for n in kept}

"""Edits at random moments of runs and sweeps: a mesh, a file that it includes, a mass matrix, the machine file.

    python3 benches/reliability/edits.py target/release/stiffmap [runs] [sweeps] [seed]

Every result must have the frequency of the files whose hashes its manifest names, every next run that of the files as
they are, and a continued sweep must refuse other inputs than those its rows were made from.
"""

import csv
import random
import shutil
import sys
import tempfile
import time

from block import BY_MATRICES, BY_MESH, DENSITY, Room, material, truth


def close(a, b):
    return abs(a / b - 1) < 2e-3


class Edited:
    """A file with two contents, and the lowest frequency that the machine has with each."""

    def __init__(self, room, name, texts, frequencies, part=BY_MESH):
        self.room, self.name, self.texts, self.frequencies, self.part = room, name, texts, frequencies, part
        self.hashes = []
        for k in (0, 1):
            self.put(k)
            room.done("run", ".", "--no-figures", "--no-cache", "--out", "reference")
            assert close(room.frequency("reference"), frequencies[k]), (name, room.frequency("reference"))
            self.hashes.append(room.manifest("reference")["input_hashes"][name])
        assert self.hashes[0] != self.hashes[1] and not close(*frequencies), "control: the contents differ"

    def put(self, k):
        if self.name != "machine.toml":
            self.room.machine(self.part)
        self.room.write(self.name, self.texts[k])

    def of(self, hashes):
        return self.hashes.index(hashes[self.name])


def contents(room):
    light, heavy = truth(DENSITY), truth(2 * DENSITY)
    yield Edited(room, "block/more/steel.inp", [material(DENSITY), material(2 * DENSITY)], [light, heavy])
    room.write("block/more/steel.inp", material(DENSITY))
    room.write("block/more/heavy.inp", material(2 * DENSITY))
    yield Edited(room, "block/part.inp", [room.block, room.block.replace("steel.inp", "heavy.inp")], [light, heavy])
    room.write("block/part.inp", room.block)
    for stiffness in (4.0, 1.0):
        room.machine(stiffness=stiffness)
        text = room.path("machine.toml").read_text()
        texts = [text] if stiffness == 4.0 else texts + [text]
    yield Edited(room, "machine.toml", texts, [truth(DENSITY, 4.0), light])
    room.machine()
    room.done("export", ".", "--format", "mtx", "--part", "block", "--out", "given")
    mass = room.path("given/mass.mtx").read_text().splitlines()
    head = next(k for k, line in enumerate(mass) if not line.startswith("%")) + 1
    doubled = [" ".join([i, j, repr(2 * float(v))]) for i, j, v in (line.split() for line in mass[head:])]
    texts = ["\n".join(mass) + "\n", "\n".join(mass[:head] + doubled) + "\n"]
    yield Edited(room, "given/mass.mtx", texts, [light, heavy], BY_MATRICES)


def run(room, edited, seconds):
    """One run with an edit at a random moment, more often an early one; which content its result is of."""
    edited.put(0)
    for folder in ("out", "next", "cache"):
        shutil.rmtree(room.path(folder), ignore_errors=True)
    job = room.start("run", ".", "--no-figures", "--out", "out")
    time.sleep(random.random() ** 3 * seconds)
    edited.put(1)
    said = job.communicate()[1].decode()
    assert job.returncode == 0, said
    was = edited.of(room.manifest("out")["input_hashes"])
    assert close(room.frequency("out"), edited.frequencies[was]), "the manifest names other files than were used"
    room.done("run", ".", "--no-figures", "--out", "next")
    assert close(room.frequency("next"), edited.frequencies[1]), "the next run took the old part from the cache"
    return was


def sweep(room, edited, tables):
    """One sweep that is killed, whose inputs are edited, and that is continued; whether that was refused."""
    edited.put(0)
    shutil.rmtree(room.path("out"), ignore_errors=True)
    words = ["sweep", "study.toml", "--no-figures", "--out", "out"]
    job = room.start(*words)
    time.sleep(random.random() * 0.6)
    first = random.random() < 0.5
    if first:
        edited.put(1)
        time.sleep(random.random() * 0.2)
    job.kill()
    job.communicate()
    edited.put(1)
    code, said = room.run(*words, "--resume")
    if code == 0:
        table = room.path("out/designs.csv").read_bytes()
        assert table == tables[1], "rows of two machines"
        return "continued"
    assert code == 2 and f"the hash of {edited.name}" in said, said
    with open(room.path("out/designs.csv")) as file:
        rows = list(csv.reader(file))[1:]
    whole = [row for row in rows if len(row) > 3]
    reference = list(csv.reader(tables[0].decode().splitlines()))[1:]
    assert whole[:-1] == reference[: len(whole[:-1])], "rows of another machine"
    edited.put(0)
    room.done(*words, "--resume")
    assert room.path("out/designs.csv").read_bytes() == tables[0], "the rightful continuation is another table"
    return "refused"


def main():
    runs, sweeps = [int(a) for a in sys.argv[2:4]] or [50, 50]
    random.seed(int(sys.argv[4]) if len(sys.argv) > 4 else 1)
    with tempfile.TemporaryDirectory() as folder:
        room = Room(folder, sys.argv[1])
        for edited in contents(room):
            tables = []
            for k in (0, 1):
                edited.put(k)
                room.done("sweep", "study.toml", "--no-figures", "--overwrite", "--out", "table")
                tables.append(room.path("table/designs.csv").read_bytes())
            assert tables[0] != tables[1], "control: the tables differ"
            shutil.rmtree(room.path("cache"))
            start = time.monotonic()
            room.done("run", ".", "--no-figures", "--out", "timed")
            seconds = time.monotonic() - start
            seen = [run(room, edited, seconds) for _ in range(runs // 4)]
            ways = [sweep(room, edited, tables) for _ in range(sweeps // 4)]
            print(
                f"{edited.name:22} {len(seen)} runs: {seen.count(0)} of the old file, {seen.count(1)} of the new; "
                f"{len(ways)} sweeps: {ways.count('refused')} refused, {ways.count('continued')} of the new alone"
            )
        print("no result, cache entry or table of two machines")


main()

"""Kills and interrupts at random moments of every command that writes a folder, each into a used folder.

    python3 benches/reliability/kills.py target/release/stiffmap [kills] [interrupts] [seed]

After each, the folder holds the whole old result, the whole new one, or no manifest; a sweep or search that is then
continued ends with the same table byte for byte; what a next job leaves is whole, without a lock or a temporary.
"""

import random
import shutil
import signal
import sys
import tempfile
import time

from block import Room

PLAIN = ["--no-figures"]
COMMANDS = {
    "run": lambda v, out: ["run", ".", "--damping", ["0.02", "0.05"][v], "--out", out],
    "simulate": lambda v, out: ["simulate", ".", "--impulse", "--damping", ["0.02", "0.05"][v], "--duration", "0.5", "--out", out],
    "export": lambda v, out: ["export", ".", "--format", "mtx", "--position", ["0", "0.1"][v], "--out", out],
    "sweep": lambda v, out: ["sweep", ["study.toml", "other.toml"][v], *PLAIN, "--overwrite", "--out", out],
    "optimise": lambda v, out: ["optimise", ["study.toml", "other.toml"][v], *PLAIN, "--overwrite", "--out", out],
    "figures": lambda v, out: ["figures", out, *[[], ["--logarithmic"]][v]],
}
TABLES = {"sweep": "designs.csv", "optimise": "evaluations.csv"}


def attack(room, command, whole, seconds, how, at):
    """Ends a command into a used folder; what the folder then is."""
    shutil.rmtree(room.path("out"), ignore_errors=True)
    shutil.copytree(room.path(f"{command}_0"), room.path("out"))
    process = room.start(*COMMANDS[command](1, "out"))
    time.sleep(seconds * at)
    process.send_signal(how)
    process.communicate()
    code = process.returncode
    found, manifest = room.content("out"), room.manifest("out")
    if command == "figures":
        assert manifest is not None, "the manifest of a redrawn result is lost"
        pairs = zip(whole[0].items(), whole[1].values())
        assert all(found[name] in (old, new) for (name, old), new in pairs), "a picture or a result is torn"
        kind = "ended by itself" if code == 0 else "whole"
    elif manifest is None:
        kind = "unfinished"
    else:
        assert found in whole, f"a mixture that looks whole: {sorted(set(found.items()) - set(whole[0].items()))}"
        kind = "old" if found == whole[0] else "new"
    if command in TABLES and kind == "unfinished":
        words = COMMANDS[command](1, "out")
        words.remove("--overwrite")
        code, said = room.run(*words, "--resume")
        assert code == 0 or "the hash of" in said or "no sweep.json" in said, said
        if code == 0:
            assert room.content("out") == whole[1], "the continued table is another"
    room.done(*COMMANDS[command](1, "out"))
    assert room.content("out") == whole[1], "the next job's result is not whole"
    left = [p.name for p in room.path("out").rglob(".*")]
    assert not left, f"left behind: {left}"
    return kind


def main():
    program = sys.argv[1]
    counts = [int(a) for a in sys.argv[2:4]] or [200, 100]
    random.seed(int(sys.argv[4]) if len(sys.argv) > 4 else 1)
    with tempfile.TemporaryDirectory() as folder:
        room = Room(folder, program)
        room.done("run", ".", *PLAIN, "--out", "warm")
        whole, seconds = {}, {}
        for command, words in COMMANDS.items():
            for variant in (0, 1):
                out = f"{command}_{variant}"
                if command == "figures":
                    shutil.copytree(room.path("run_0"), room.path(out))
                start = time.monotonic()
                room.done(*words(variant, out))
                seconds[command] = time.monotonic() - start
            whole[command] = [room.content(f"{command}_{v}") for v in (0, 1)]
            assert whole[command][0] != whole[command][1], f"control: both results of {command} are the same"
        print("seconds of a command:", {c: round(s, 2) for c, s in seconds.items()})
        table = {}
        for how, count in zip((signal.SIGKILL, signal.SIGINT), counts):
            for k in range(count):
                command = list(COMMANDS)[k % len(COMMANDS)]
                kind = attack(room, command, whole[command], seconds[command], how, random.random() * 1.05)
                key = (how.name, command)
                table.setdefault(key, {}).setdefault(kind, 0)
                table[key][kind] += 1
        for (how, command), kinds in table.items():
            print(f"{how:8} {command:9}", ", ".join(f"{n} {kind}" for kind, n in sorted(kinds.items())))
        print(f"{counts[0]} kills, {counts[1]} interrupts: no mixture, no table lost")


main()

"""Runs mutated machine files through the program: no panic, no hang, no memory beyond a bound.

    python benches/fuzz/machine_files.py target/release/stiffmap tests/limits/input --count 2000 --seed 1

The folder holds `machine.toml` and its meshes. Each mutant is the text with one to three changes: a number by an
extreme one, a value by another value of the file, a line left out or doubled, characters changed. A mutant may run,
or be refused (exit code 1 or 2); every other end is printed with the mutant, and the script ends with 1.
"""

import argparse
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading

SECONDS = 10
BYTES = 1 << 30
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
EXTREME = ["0", "-1", "1e-300", "1e300", "-1e300", "1e30", "1e12", "1e-12", "1e-5", "nan", "inf", "7", "1e5", "0.5"]
COMMANDS = [
    ["run", "--no-figures", "--no-cache"],
    ["check"],
    ["simulate", "--impulse", "--duration", "0.01", "--no-figures", "--no-cache"],
    ["export", "--format", "mtx"],
]


def change(text, chance):
    """The text with one change."""
    kind = chance.randrange(6)
    numbers = list(NUMBER.finditer(text))
    lines = text.split("\n")
    if kind <= 2 and numbers:
        at = chance.choice(numbers)
        new = chance.choice(EXTREME) if kind else chance.choice(numbers).group()
        if kind == 2:
            new = repr(float(at.group()) * 10.0 ** chance.randint(-12, 12))
        return text[: at.start()] + new + text[at.end() :]
    if kind == 3:
        del lines[chance.randrange(len(lines))]
    elif kind == 4:
        lines.insert(chance.randrange(len(lines)), chance.choice(lines))
    else:
        place = chance.randrange(len(text))
        return text[:place] + chance.choice('"[]{}=.,\n\t -0e\u00fc\x00') + text[place + chance.randrange(2) :]
    return "\n".join(lines)


def limit():
    resource.setrlimit(resource.RLIMIT_DATA, (4 * BYTES, 4 * BYTES))


def end_of(run):
    """Exit code and resources of a child, its own alone, and whether it was killed for its time."""
    late = threading.Event()

    def kill():
        late.set()
        os.kill(run.pid, signal.SIGKILL)

    clock = threading.Timer(SECONDS, kill)
    clock.start()
    # wait4 says what this child took; RUSAGE_CHILDREN is the largest of all children so far.
    _, status, usage = os.wait4(run.pid, 0)
    clock.cancel()
    run.returncode = os.waitstatus_to_exitcode(status)
    return run.returncode, usage, late.is_set()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    ends, bad = {}, 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for file in arguments.folder.iterdir():
            shutil.copy(file, folder)
        original = (folder / "machine.toml").read_text()
        for number in range(arguments.count):
            chance = random.Random(f"{arguments.seed} {number}")
            text = original
            for _ in range(chance.randint(1, 3)):
                text = change(text, chance)
            (folder / "mutant.toml").write_text(text)
            command = list(chance.choices(COMMANDS, weights=[5, 1, 2, 1])[0])
            command[1:1] = [str(folder / "mutant.toml")]
            if command[0] != "check":
                command += ["--out", str(folder / "out")]
            shutil.rmtree(folder / "out", ignore_errors=True)
            why = None
            errors = open(folder / "stderr", "wb")
            run = subprocess.Popen(
                [arguments.program, *command], stdout=subprocess.DEVNULL, stderr=errors, cwd=folder, preexec_fn=limit
            )
            status, usage, late = end_of(run)
            if late:
                why = f"longer than {SECONDS} s"
            errors.close()
            said = (folder / "stderr").read_text(errors="replace")
            ends[status] = ends.get(status, 0) + 1
            if why is None and (status not in (0, 1, 2) or "fault of stiffmap" in said or "panicked" in said):
                why = f"exit {status}"
            if why is None and usage.ru_maxrss * 1024 > BYTES:
                why = f"{usage.ru_maxrss * 1024} bytes"
            if why:
                bad += 1
                kept = pathlib.Path(tempfile.gettempdir()) / f"mutant-{arguments.seed}-{number}.toml"
                kept.write_text(text)
                print(f"{number}: {why}: {' '.join(command[:1] + command[2:])}: {kept}\n  {said[-600:]}", flush=True)
    print(f"{arguments.count} mutants, ends by exit code {ends}, {bad} bad")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()

"""Interrupts jobs at random moments and measures how long each takes to end.

    python benches/fuzz/interrupts.py target/release/stiffmap machines/vertical_mill --rounds 20 --seconds 15

Each job runs cold (`--no-cache`) and is sent SIGINT or SIGTERM after a random time up to `--seconds`. Printed are the
job, the last line that it said before, and the seconds from the signal to its end; jobs that had ended already are
left out. The script ends with 1 where one took longer than `--bound` seconds or left a temporary file.
"""

import argparse
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

JOBS = {
    "run": ["run", "MACHINE", "--no-cache", "--out", "OUT"],
    "run2": ["run", "MACHINE", "--no-cache", "--no-figures", "--map-memory", "0", "--out", "OUT"],
    "simulate": ["simulate", "MACHINE", "--impulse", "--no-cache", "--out", "OUT"],
    "path": ["simulate", "MACHINE", "--force", "x:sine,amplitude=100,frequency=200", "--path", "0:-0.02",
             "--feed-rate", "30", "--no-cache", "--out", "OUT"],
    "sweep": ["sweep", "MACHINE/study.toml", "--no-cache", "--out", "OUT"],
    "optimise": ["optimise", "MACHINE/study.toml", "--no-cache", "--out", "OUT"],
    "export": ["export", "MACHINE", "--format", "mtx", "--full", "--out", "OUT"],
    "check": ["check", "MACHINE"],
    "modes": ["modes", "MACHINE/column.inp", "--modes", "40"],
    "band": ["band", "MACHINE", "--no-cache"],
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("machine")
    parser.add_argument("--jobs", default=",".join(JOBS))
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=15.0)
    parser.add_argument("--bound", type=float, default=0.5)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    chance = random.Random(arguments.seed)
    worst, left = 0.0, []
    for name in arguments.jobs.split(","):
        for _ in range(arguments.rounds):
            with tempfile.TemporaryDirectory() as out:
                log = pathlib.Path(out) / "log"
                folder = pathlib.Path(out) / "out"
                words = [w.replace("MACHINE", arguments.machine).replace("OUT", str(folder)) for w in JOBS[name]]
                with open(log, "wb") as errors:
                    job = subprocess.Popen([arguments.program, *words], stdout=subprocess.DEVNULL, stderr=errors)
                    wait = chance.uniform(0.0, arguments.seconds)
                    which = chance.choice([signal.SIGINT, signal.SIGTERM])
                    try:
                        job.wait(wait)
                        continue
                    except subprocess.TimeoutExpired:
                        pass
                    said = [line for line in log.read_text().splitlines() if line.endswith(" s")]
                    start = time.monotonic()
                    job.send_signal(which)
                    job.wait(120)
                    seconds = time.monotonic() - start
                left += [str(p) for p in folder.rglob(".*.tmp")]
                worst = max(worst, seconds)
                mark = "  <--" if seconds > arguments.bound else ""
                print(f"{name:9} {wait:6.2f} s, exit {job.returncode:4}, {seconds:6.3f} s, after "
                      f"{said[-1].split('  ')[0] if said else 'the start'}{mark}", flush=True)
    print(f"longest {worst:.3f} s; temporaries left: {left or 'none'}")
    sys.exit(1 if worst > arguments.bound or left else 0)


if __name__ == "__main__":
    main()

"""Interrupts jobs at random moments and measures how long each takes to end.

    python benches/fuzz/interrupts.py target/release/stiffmap machines/vertical_mill --rounds 6

Each job runs cold and is sent SIGINT or SIGTERM after a random time within what it takes on a quiet
machine (`--longer` scales it). Printed are the job, the last line that it said before, the seconds from the signal to
its end, and beside them what the machine has to do otherwise: its load, and the seconds that `true` takes to start and
end. `--second` is the machine on another mesh, for `converge`. Jobs that had ended already are left out; the last line
is the distribution. The script ends with 1 where one took longer than `--bound` seconds, left a temporary file, or
ended with another code than 130.
"""

import argparse
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

# What each job is, and about how long it takes cold, s.
JOBS = {
    "run": (20, ["run", "MACHINE", "--no-cache", "--out", "OUT"]),
    "run2": (16, ["run", "MACHINE", "--no-cache", "--no-figures", "--map-memory", "0", "--out", "OUT"]),
    "simulate": (18, ["simulate", "MACHINE", "--impulse", "--no-cache", "--out", "OUT"]),
    "path": (20, ["simulate", "MACHINE", "--force", "x:sine,amplitude=100,frequency=200", "--path", "0:-0.02",
                  "--feed-rate", "30", "--no-cache", "--out", "OUT"]),
    "sweep": (30, ["sweep", "MACHINE/study.toml", "--no-cache", "--out", "OUT"]),
    "optimise": (30, ["optimise", "MACHINE/study.toml", "--no-cache", "--out", "OUT"]),
    "export": (16, ["export", "MACHINE", "--format", "mtx", "--out", "OUT"]),
    "full": (3, ["export", "MACHINE", "--format", "mtx", "--full", "--out", "OUT"]),
    "deck": (0.1, ["export", "MACHINE", "--format", "inp", "--out", "OUT/deck.inp"]),
    "check": (1.2, ["check", "MACHINE"]),
    "modes": (8, ["modes", "MACHINE/column.inp", "--modes", "40"]),
    "band": (20, ["band", "MACHINE"]),
    "converge": (25, ["converge", "MACHINE", "SECOND"]),
    "figures": (0.6, ["figures", "RESULT"]),
    "bench": (1.2, ["bench"]),
}


def seconds_of_true():
    """What a process that does nothing takes to start and to end now."""
    start = time.monotonic()
    subprocess.run(["true"], check=True)
    return time.monotonic() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("machine")
    parser.add_argument("--second", default="")
    parser.add_argument("--jobs", default=",".join(JOBS))
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--longer", type=float, default=1.0)
    parser.add_argument("--bound", type=float, default=0.5)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    chance = random.Random(arguments.seed)
    taken, left, wrong = [], [], []
    with tempfile.TemporaryDirectory() as result:
        names = [name for name in arguments.jobs.split(",") if name != "converge" or arguments.second]
        if "figures" in names:
            words = [arguments.program, "run", arguments.machine, "--out", result]
            subprocess.run(words, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for name in [name for _ in range(arguments.rounds) for name in names]:
            typical, words = JOBS[name]
            with tempfile.TemporaryDirectory() as out:
                log = pathlib.Path(out) / "log"
                folder = pathlib.Path(out) / "out"
                places = {"MACHINE": arguments.machine, "SECOND": arguments.second, "RESULT": result}
                places["OUT"] = str(folder)
                for placeholder, path in places.items():
                    words = [word.replace(placeholder, path) for word in words]
                # An empty cache, for the commands that have no --no-cache.
                environment = dict(os.environ, STIFFMAP_CACHE=str(pathlib.Path(out) / "cache"))
                with open(log, "wb") as errors:
                    job = subprocess.Popen(
                        [arguments.program, *words], stdout=subprocess.DEVNULL, stderr=errors, env=environment
                    )
                    wait = chance.uniform(0.0, typical * arguments.longer)
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
                where = folder if name != "figures" else pathlib.Path(result)
                # 0 where the job came to its end meanwhile.
                if job.returncode not in (0, 130):
                    wrong.append(f"{name}: exit {job.returncode}")
                left += [str(p) for p in where.rglob(".*.tmp")]
                taken.append(seconds)
                mark = "  <--" if seconds > arguments.bound else ""
                print(f"{name:9} {wait:6.2f} s, exit {job.returncode:4}, {seconds:6.3f} s, after "
                      f"{said[-1].split('  ')[0] if said else 'the start'}; load {os.getloadavg()[0]:.1f}, "
                      f"true {seconds_of_true():.3f} s{mark}", flush=True)
    taken.sort()
    at = lambda share: taken[min(len(taken) - 1, int(share * len(taken)))]
    print(f"{len(taken)} interrupts: median {at(0.5):.3f} s, 95 % {at(0.95):.3f} s, longest {taken[-1]:.3f} s; "
          f"temporaries left: {left or 'none'}; ends other than by the interrupt: {wrong or 'none'}")
    sys.exit(1 if taken[-1] > arguments.bound or left or wrong else 0)


if __name__ == "__main__":
    main()

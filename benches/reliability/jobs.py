"""Four jobs at once into one folder, again and again: one runs, the others are told.

    python3 benches/reliability/jobs.py target/release/stiffmap [times]
"""

import sys
import tempfile

from block import Room

with tempfile.TemporaryDirectory() as folder:
    room = Room(folder, sys.argv[1])
    times = int(sys.argv[2]) if len(sys.argv) > 2 else 20
    damping = ["0.01", "0.02", "0.03", "0.04"]
    words = lambda d, out: ["run", ".", "--damping", d, "--out", out]
    whole = {}
    for d in damping:
        room.done(*words(d, f"alone_{d}"))
        whole[d] = room.content(f"alone_{d}")
    won = told = 0
    for _ in range(times):
        jobs = [(d, room.start(*words(d, "out"))) for d in damping]
        ends = [(d, job.communicate()[1].decode(), job.returncode) for d, job in jobs]
        winners = [d for d, said, code in ends if code == 0]
        losers = [said for d, said, code in ends if code == 2 and "another job writes this folder: process" in said]
        assert winners and len(winners) + len(losers) == 4, ends
        assert room.content("out") in [whole[d] for d in winners], "a mixture"
        won, told = won + len(winners), told + len(losers)
    print(f"{times} times four jobs: {won} ran, {told} were told who holds the folder, no mixture")

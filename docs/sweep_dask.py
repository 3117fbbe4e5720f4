"""A sweep on a Dask cluster: each task computes one shard with `stiffmap sweep --shard I/N`, then the shards are joined.

    python sweep_dask.py study.toml --shards 16 --out results/study --scheduler tcp://head:8786

Without --scheduler, two worker processes on this machine. The output folder must be seen by every worker.
"""

import argparse
import pathlib
import subprocess
import time

from distributed import Client, LocalCluster, as_completed


def run_shard(stiffmap, study, folder, number, of):
    """Computes a shard; one that a lost worker began is continued. Returns its folder."""
    command = [stiffmap, "sweep", study, "--out", folder, "--shard", f"{number}/{of}", "--resume", "--no-figures"]
    while True:
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode == 0:
            return folder
        # The process of a lost worker may outlive it; it holds the table until it ends.
        if "another process writes this table" not in done.stderr:
            raise RuntimeError(f"shard {number}/{of}: {done.stderr.strip()}")
        time.sleep(0.5)


def submit(client, stiffmap, study, out, of):
    """Submits every shard; Dask gives the shards of a lost worker to another."""
    shards = [(i, str(pathlib.Path(out) / f"shard_{i:04}")) for i in range(1, of + 1)]
    return [client.submit(run_shard, stiffmap, study, folder, i, of, pure=False) for i, folder in shards]


def merge(stiffmap, study, out, folders):
    """Joins the shards; gaps, overlaps and shards of other inputs are refused."""
    whole = str(pathlib.Path(out) / "whole")
    subprocess.run([stiffmap, "sweep", study, "--out", whole, "--overwrite", "--no-figures", "--merge", *folders], check=True)
    return whole


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("study")
    parser.add_argument("--shards", type=int, default=8)
    parser.add_argument("--out", default="results/distributed")
    parser.add_argument("--stiffmap", default="stiffmap")
    parser.add_argument("--scheduler")
    given = parser.parse_args()
    cluster = given.scheduler or LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with Client(cluster) as client:
        futures = submit(client, given.stiffmap, given.study, given.out, given.shards)
        for future in as_completed(futures):
            print(future.result(), "is done", flush=True)
        print("joined in", merge(given.stiffmap, given.study, given.out, [f.result() for f in futures]))


if __name__ == "__main__":
    main()

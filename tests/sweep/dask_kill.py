"""Runs docs/sweep_dask.py's shards on two worker processes and kills one of them on the way.

Arguments: docs folder, stiffmap, study, output folder, number of shards. Prints how many workers were killed.
"""

import os
import signal
import sys
import time


def main():
    docs, stiffmap, study, out, of = sys.argv[1:]
    sys.path.insert(0, docs)
    os.environ["PYTHONPATH"] = docs  # for the worker processes
    import sweep_dask
    from distributed import Client, LocalCluster

    cluster = LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
    with cluster, Client(cluster) as client:
        pids = client.run(os.getpid)
        assert len(set(pids.values())) == 2 and os.getpid() not in pids.values(), pids
        futures = sweep_dask.submit(client, stiffmap, study, out, int(of))
        killed = 0
        while not killed and not all(f.done() for f in futures):
            busy = [worker for worker, tasks in client.processing().items() if tasks]
            if busy:
                os.kill(pids[busy[0]], signal.SIGKILL)
                killed += 1
            time.sleep(0.02)
        folders = client.gather(futures)
        sweep_dask.merge(stiffmap, study, out, folders)
    print("killed", killed)


if __name__ == "__main__":
    main()

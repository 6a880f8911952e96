"""python_cluster.py FOLDER [--gib G] [--workers N] [--limit GIB] [--size N] [--kill]: an array larger than memory, by processes.

Waves [t, z, y, x] of float32, G GiB that exist nowhere (each chunk is made when it is asked for), are written by
dataset.bcc4.to_file on N processes of distributed that may hold --limit GiB each, and read back there chunk by chunk, which
compares them with the waves. --kill: a process is killed once a part is done. Prints a row of the table of
tests/bench/notes/python.md: seconds and MiB held at most by a process, of writing and of both, and chunks made of those there
are. Ends with an error where a process held more or the file is off. Needs xarray, dask and distributed.
"""
import argparse
import os
import re
import signal
import sys
import threading
import time

import dask
import dask.array as da
import numpy as np
import xarray as xr
from distributed import Client, LocalCluster

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples", "python")
sys.path.insert(0, PACKAGE)
os.environ["PYTHONPATH"] = os.pathsep.join([PACKAGE, os.environ.get("PYTHONPATH", "")])
import bccsplat.accessor  # noqa: E402, F401
from bccsplat.xarray_backend import BccsplatBackend  # noqa: E402

GIB = 1 << 30
# Frames in a chunk.
CHUNK = 8
# For what was read, in each process: as fast as playing the series forward, in less than half of its memory.
CACHE_BYTES = 1 << 28
# Of values from -2 to 2. More than the lattice loses of waves as long as these are, faces of small arrays included.
ACCEPTED_RMSE = 1e-2


def waves(location):
    """[t, z, y, x], float32, of waves of 16 samples and longer, at (begin, end) along each axis."""
    t, z, y, x = np.ogrid[tuple(slice(*ends) for ends in location)]
    plane = (np.sin(.3 * x + .2 * y - .13 * t)).astype(np.float32)
    return plane + np.cos(.25 * z - .1 * t).astype(np.float32) * np.sin(.2 * y).astype(np.float32)


def make(block_info=None, log=""):
    """A chunk, of which a line of `log` says who made it."""
    with open(log, "a", encoding="utf-8") as file:
        file.write("%d\n" % os.getpid())
    return waves(block_info[None]["array-location"])


def squares(block, block_info=None):
    """The sum of squared differences of a chunk from the waves, as [1, 1, 1, 1]."""
    apart = block - waves(block_info[0]["array-location"])
    return np.full((1, 1, 1, 1), np.square(apart, out=apart).sum(dtype=np.float64))


def peak_bytes():
    """What this process held at most."""
    with open("/proc/self/status", encoding="utf-8") as file:
        return int(re.search(r"VmHWM:\s*(\d+) kB", file.read())[1]) << 10


def kill_one(folder, log, killed):
    """Kills the process that made the last chunk as soon as a part is done."""
    while not killed:
        parts = [name for name in os.listdir(folder) if ".parts-" in name]
        if parts and any(name.endswith(".bcc4") for name in os.listdir(os.path.join(folder, parts[0]))):
            with open(log, encoding="utf-8") as file:
                killed.append(int(file.readlines()[-1]))
            os.kill(killed[0], signal.SIGKILL)
        time.sleep(.02)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--gib", type=float, default=8)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--limit", type=float, default=2, help="GiB a process")
    parser.add_argument("--size", type=int, default=160)
    parser.add_argument("--kill", action="store_true")
    given = parser.parse_args()
    os.makedirs(given.folder, exist_ok=True)
    target, log = os.path.join(given.folder, "cluster.bcc4"), os.path.join(given.folder, "made.txt")
    open(log, "w", encoding="utf-8").close()
    size, chunks = given.size, int(np.ceil(given.gib * GIB / (4 * CHUNK * given.size**3)))
    array = da.map_blocks(make, chunks=((CHUNK,) * chunks, (size,), (size,), (size,)), dtype=np.float32, log=log,
                          meta=np.empty((0,) * 4, np.float32))
    dataset = xr.Dataset({"f": (("time", "z", "y", "x"), array)}, {"time": .1 * np.arange(CHUNK * chunks)})
    dask.config.set({"distributed.worker.daemon": False, "distributed.comm.timeouts.connect": "60s"})
    killed = []
    with LocalCluster(n_workers=given.workers, threads_per_worker=1, memory_limit="%gGiB" % given.limit, dashboard_address=None,
                      local_directory=os.path.join(given.folder, "dask")) as cluster, Client(cluster) as client:
        if given.kill:
            threading.Thread(target=kill_one, args=(given.folder, log, killed), daemon=True).start()
        start = time.monotonic()
        dataset.bcc4.to_file(target, lattice="d4star", overwrite=True)
        written, held_writing = time.monotonic() - start, max(client.run(peak_bytes).values())
        start = time.monotonic()
        back = xr.open_dataset(target, engine=BccsplatBackend, chunks={}, cache_bytes=CACHE_BYTES)
        total = back.f.data.map_blocks(squares, chunks=(1, 1, 1, 1), dtype=np.float64).sum().compute()
        rmse = float(np.sqrt(total / array.size))
        read, held = time.monotonic() - start, max(client.run(peak_bytes).values())
    with open(log, encoding="utf-8") as file:
        made = len(file.readlines())
    print("| %.2f GiB, %d^3 x %d | %d of %g GiB%s | %.0f | %.0f | %d of %d | %.0f | %.0f | %.1f | %.2g |" %
          (array.nbytes / GIB, size, CHUNK * chunks, given.workers, given.limit, ", one killed" if killed else "", written,
           held_writing / (1 << 20), made, chunks, read, held / (1 << 20), os.path.getsize(target) / 1e6, rmse))
    if back.f.shape != array.shape or not rmse < ACCEPTED_RMSE:
        sys.exit("python_cluster.py: what was read back is off by an RMSE of %g" % rmse)
    if held > given.limit * GIB:
        sys.exit("python_cluster.py: a process held %d MiB, more than %g GiB" % (held >> 20, given.limit))


if __name__ == "__main__":
    main()

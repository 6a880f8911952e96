"""python_loader.py FOLDER [--size 64] [--frames 16] [--crops 200] [--workers 4] [--bound .01]: crops for training, by what files.

One run on one machine: a .bcc4 file by Volume.crops, and by places that have nothing to do with its slabs, indexed and by
Volume.read_frame into one array; zarr and h5py in
chunks of a crop, of whole numbers of steps that keep the same bound, deflated by what each has (zstd of Blosc with bits
shuffled, gzip with bytes shuffled); npz; and an array in memory. Broad-band values (noise whose power falls by the square of the wave
number) between -1 and 1, crops of 4 x 32^3. Each worker is a process. Prints the table of tests/bench/notes/python.md.
"""
import argparse
import multiprocessing
import os
import sys
import time

import h5py
import numcodecs
import numpy as np
import zarr

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples", "python"))
import bccsplat  # noqa: E402

CROP = (4, 32, 32, 32)


def broad_band(frames, n):
    """[t, z, y, x], float32, between -1 and 1."""
    shape = (frames, n, n, n)
    noise = np.fft.rfftn(np.random.default_rng(4).normal(size=shape).astype(np.float32))
    k = np.sqrt(sum(np.square(at) for at in np.ix_(*[np.fft.fftfreq(m) * m for m in shape[:3]], np.fft.rfftfreq(n) * n)))
    field = np.fft.irfftn(noise / np.maximum(k, 1)**2, shape).astype(np.float32)
    return field / np.abs(field).max()


def corners(shape, count, seed):
    random = np.random.default_rng(seed)
    return [tuple(int(random.integers(whole - n + 1)) for whole, n in zip(shape, CROP)) for _ in range(count)]


def cut(array, shape, count, seed, step=None):
    """step: of codes that are read, which become values."""
    total = 0.0
    for corner in corners(shape, count, seed):
        crop = np.asarray(array[tuple(slice(at, at + n) for at, n in zip(corner, CROP))])
        total += float((crop if step is None else crop * np.float32(step)).sum())
    return total


def by_slabs(file, count, seed, part):
    volume = bccsplat.open(file, device=bccsplat.Device(threads=1))
    return sum(float(crop.sum()) for _, crop in volume.crops(CROP, seed=seed, count=count * part[1], part=part))


def by_frames(file, shape, count, seed):
    """Crops that read_frame fills, a frame after another, in an array that is used again."""
    volume, crop, total = bccsplat.open(file, device=bccsplat.Device(threads=1)), np.empty(CROP, np.float32), 0.0
    for t, *corner in corners(shape, count, seed):
        begin, end = corner[::-1], [at + n for at, n in zip(corner[::-1], CROP[:0:-1])]
        for n, frame in enumerate(crop):
            volume.read_frame(t + n, begin, end, out=frame)
        total += float(crop.sum())
    return total


READERS = {
    "bccsplat, crops()": lambda file, shape, count, seed, part: by_slabs(file, count, seed, part),
    "bccsplat, any order": lambda file, shape, count, seed, part: cut(
        bccsplat.open(file, device=bccsplat.Device(threads=1)), shape, count, seed),
    "bccsplat, read_frame()": lambda file, shape, count, seed, part: by_frames(file, shape, count, seed),
    "zarr": lambda file, shape, count, seed, part: cut(zarr.open(file, mode="r"), shape, count, seed),
    "h5py": lambda file, shape, count, seed, part: cut(h5py.File(file, "r")["a"], shape, count, seed, .02),
    "npz": lambda file, shape, count, seed, part: cut(np.load(file)["a"], shape, count, seed, .02),
    "in memory": lambda file, shape, count, seed, part: cut(np.load(file, mmap_mode="r"), shape, count, seed)}


def work(name, file, shape, count, seed, part, start, done):
    start.wait()
    READERS[name](file, shape, count, seed, part)
    done.put((seed, time.process_time()))


def rate(name, file, shape, crops, workers):
    """Crops a second of all workers, of the wall, from the closed file on, and their CPU seconds."""
    context = multiprocessing.get_context("fork")
    start, done = context.Event(), context.Queue()
    processes = [context.Process(target=work, args=(name, file, shape, crops // workers, seed, (seed, workers), start, done))
                 for seed in range(workers)]
    for process in processes:
        process.start()
    time.sleep(.5)
    began = time.monotonic()
    start.set()
    seconds = sum(done.get()[1] for _ in processes)
    wall = time.monotonic() - began
    for process in processes:
        process.join()
    return crops // workers * workers / wall, crops // workers * workers / seconds


def size_of(file):
    if os.path.isfile(file):
        return os.path.getsize(file)
    return sum(os.path.getsize(os.path.join(folder, name)) for folder, _, names in os.walk(file) for name in names)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder")
    for name, value in (("size", 64), ("frames", 16), ("crops", 200), ("workers", 4)):
        parser.add_argument("--" + name, type=int, default=value)
    parser.add_argument("--bound", type=float, default=.01)
    args = parser.parse_args()
    os.makedirs(args.folder, exist_ok=True)
    os.chdir(args.folder)
    values = broad_band(args.frames, args.size)
    step = np.float32(2 * args.bound * (1 - 1e-4))
    codes = np.rint(values / step).astype(np.int16)
    rounded = codes * step
    bccsplat.save("a.bcc4", values, abs_error=args.bound, overwrite=True)
    zarr.array(values, store="a.zarr", overwrite=True, chunks=CROP, compressor=numcodecs.Blosc("zstd", 5, numcodecs.Blosc.BITSHUFFLE),
               filters=[numcodecs.FixedScaleOffset(0, 1 / step, "f4", "i2")])
    with h5py.File("a.h5", "w") as file:
        file.create_dataset("a", data=codes, chunks=CROP, compression="gzip", shuffle=True)
    np.savez_compressed("a.npz", a=codes)
    np.save("a.npy", values)
    files = [("bccsplat, crops()", "a.bcc4"), ("bccsplat, any order", "a.bcc4"), ("bccsplat, read_frame()", "a.bcc4"),
             ("zarr", "a.zarr"), ("h5py", "a.h5"), ("npz", "a.npz"), ("in memory", "a.npy")]
    print("| reader | file | MB | largest error | crops a second | crops a CPU second |\n|---|---|---|---|---|---|")
    for name, file in files:
        held = (np.asarray(bccsplat.open(file)) if file.endswith("bcc4") else zarr.open(file, mode="r")[:] if file.endswith("zarr") else
                values if file == "a.npy" else rounded)
        of_wall, of_cpu = rate(name, file, values.shape, args.crops, args.workers)
        print("| %s | %s | %.2f | %.4f | %.1f | %.1f |" % (name, file, size_of(file) / 1e6, np.abs(held - values).max(), of_wall, of_cpu),
              flush=True)


if __name__ == "__main__":
    main()

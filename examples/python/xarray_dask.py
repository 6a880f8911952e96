"""xarray_dask.py IN.bcc4 OUT.bcc4: an xarray dataset of any size, calculated by dask and written by parts."""
import sys

import xarray

import bccsplat.accessor  # noqa: F401  dataset.bcc4


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    series = xarray.open_dataset(sys.argv[1], engine="bccsplat", chunks={})  # chunks of the file; nothing is read
    middle = float(series.time[[0, -1]].mean())
    print(series.bcc4.at(middle).mean().compute())  # a moment between frames
    anomaly = series - series.mean("time")
    anomaly.bcc4.to_file(sys.argv[2], overwrite=True)  # on the scheduler that is active: threads, or a distributed Client


if __name__ == "__main__":
    main()

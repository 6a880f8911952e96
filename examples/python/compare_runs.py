"""compare_runs.py A.bcc4 B.bcc4: how far two runs are apart over time, at the moments of A and the samples of B in space."""
import sys

import numpy as np

import bccsplat

if len(sys.argv) < 3:
    sys.exit(__doc__)
first, second = (bccsplat.open(name) for name in sys.argv[1:3])
samples = np.linspace(0, 1, 101)[:, None] * (np.array(first.shape[:0:-1]) - 1)  # from corner to corner
(here, began), (there, begins) = ((v.index_to_world(samples), v.attributes().get("time_epoch")) for v in (first, second))
if first.shape[1:] != second.shape[1:] or not np.allclose(here, there) or began != begins:
    sys.exit("the two are not at the same places, or count time from other dates: %s and %s" % (began, begins))
low, high = max(first.info().time_first, second.info().time_first), min(first.info().time_last, second.info().time_last)
print("%12s %12s %12s  %s" % ("time", "RMS", "largest", "at [z, y, x]"))
for time in first.times()[(first.times() >= low) & (first.times() <= high)]:
    apart = np.abs(first.at(time) - second.at(time))
    place = np.unravel_index(np.nanargmax(apart), apart.shape)
    print("%12g %12.4g %12.4g  %s" % (time, np.sqrt(np.nanmean(apart**2)), np.nanmax(apart), [int(n) for n in place]))

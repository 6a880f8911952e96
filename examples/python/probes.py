"""probes.py FILE.bcc4 OUT.csv X,Y,Z ...: the value over time at places of the world, four moments to a frame, as a table."""
import sys

import numpy as np

import bccsplat

if len(sys.argv) < 4:
    sys.exit(__doc__)
volume = bccsplat.open(sys.argv[1])
places = [[float(number) for number in place.split(",")] for place in sys.argv[3:]]
times = [volume.index_to_time(frame) for frame in np.arange(0, len(volume) - .75, .25)]
points = [[[*place, time] for place in places] for time in times]  # [time, place, 4]
values, slopes = volume.evaluate_world(points)  # slopes along x, y, z and time; outside the samples NaN
header = "time," + ",".join(place.replace(",", " ") for place in sys.argv[3:])
np.savetxt(sys.argv[2], np.column_stack([times, values]), delimiter=",", header=header, comments="")
print("fastest change: %g a unit of time" % np.nanmax(np.abs(slopes[..., 3])))

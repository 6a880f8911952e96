"""insitu_simulation_test.py TOP EXAMPLES SCRATCH: the simulation's file holds its particles' mass at every moment, on
layers and between, and is the same from run to run."""
import math
import os
import subprocess
import sys

try:
    import numpy as np
except ImportError:
    print("skipped: this Python has no numpy")
    sys.exit(77)
from bccsplat import Device, Volume

_top, examples, scratch = sys.argv[1:]
os.makedirs(scratch, exist_ok=True)
paths = [os.path.join(scratch, name) for name in ("one.bcc4", "two.bcc4")]
picture = os.path.join(scratch, "picture.png")
program = os.path.join(examples, "insitu_simulation")
subprocess.run([program, paths[0], picture], check=True)
subprocess.run([program, paths[1]], check=True)
assert open(paths[0], "rb").read() == open(paths[1], "rb").read()
assert os.path.getsize(picture) > 10_000

particles, radius = 600, 4
mass = particles * 4 * math.pi * radius ** 3 * 16 / 315  # integral of (1 - r^2 / radius^2)^3
with Device() as device, Volume(device, paths[0]) as volume:
    assert volume.info().dims[:] == [64, 64, 64, 24]
    centres = []
    for frame in (0, 3.3, 10, 17.75, 23):
        box = volume.slice(frame=frame).sample_grid()
        assert abs(box.sum(dtype=float) / mass - 1) < 0.01, (frame, box.sum(), mass)
        z, y, x = (np.indices(box.shape) * box).reshape(3, -1).sum(1) / box.sum()
        centres.append((x, y, z))
    # No outer force: the centre of mass stays where it is.
    assert np.ptp(centres, axis=0).max() < 0.3, centres
    moving = volume.slice(frame=3.3).sample_grid() - volume.slice(frame=17.75).sample_grid()
    assert np.abs(moving).max() > 1
failed = subprocess.run([program, os.path.join(scratch, "no-such", "x.bcc4")], capture_output=True, text=True)
assert failed.returncode == 1 and "no-such" in failed.stderr

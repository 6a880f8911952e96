"""explore.py [FILE.bcc4 [FOLDER]]: from a file to slices and pictures, cell by cell (# %%), as in a notebook.

Without a file a small series is written first. Pictures go to FOLDER (the current one).
"""
# %% The series: any .bcc4, or two blobs that circle each other, written here.
import os
import sys

import numpy as np

from bccsplat import Channel, Device, Frame, Renderer, TransferFunction, Volume, Writer

path = sys.argv[1] if len(sys.argv) > 1 else "explore.bcc4"
folder = sys.argv[2] if len(sys.argv) > 2 else "."
device = Device()

if not os.path.exists(path):
    z, y, x = np.mgrid[0:48, 0:48, 0:48].astype(np.float32)
    with Writer(device, path, (48, 48, 48, 16), channels=[Channel("density", air_threshold=1e-3)]) as writer:
        for frame in range(16):
            u, v = 12 * np.cos(0.2 * frame), 12 * np.sin(0.2 * frame)
            blobs = [np.exp(-((x - 24 - s * u) ** 2 + (y - 24 - s * v) ** 2 + (z - 24) ** 2) / 50) for s in (1, -1)]
            writer.add_frame(blobs[0] + 0.6 * blobs[1], time=frame / 24)

# %% What is in it. Nothing but the index is read so far.
volume = Volume(device, path)
info, channel = volume.info(), volume.channel_info()
nx, ny, nz, nt = info.dims
first, last = info.time_first, info.time_last
print(f"{nx} x {ny} x {nz}, {nt} frames from {first:g} to {last:g} {info.time_unit}")
print(f"{channel.name}: {channel.range[0]:g} .. {channel.range[1]:g}, air {channel.air:g}")
print(f"{channel.sites_kept} of {info.sites_total} lattice sites kept; a grid has {info.cc_samples} samples")

# %% The field is continuous: a value and its slopes anywhere, here in the middle of the series.
half = (nt - 1) / 2
centre = [(nx - 1) / 2, (ny - 1) / 2, (nz - 1) / 2, half]
value, slope = volume.evaluate_with_gradients([centre])
print(f"centre: {value[0]:.4g}, d/dx d/dy d/dz d/dt {np.array2string(slope[0], precision=3)}")

# %% A time slice as a numpy array [z, y, x], between two frames as well as on one.
cut = volume.slice(frame=half)
box = cut.sample_grid()
peak = np.unravel_index(np.nanargmax(box), box.shape)
print(f"frame {half:g}: mean {np.nanmean(box):.4g}, largest {np.nanmax(box):.4g} at [z, y, x] = {peak}")

# %% How the mean changes over time: nine moments, most of them between frames.
frames = np.linspace(0, nt - 1, 9)
means = [float(np.nanmean(volume.slice(frame=f).sample_grid())) for f in frames]
print("mean over time:", np.array2string(np.array(means), precision=3))

# %% A picture: colours and opacities over the value, from the file's own percentiles.
low, high = max(channel.percentile_2, channel.air), channel.percentile_998
warm = TransferFunction([(low, 0.1, 0.1, 0.5), ((low + high) / 2, 0.9, 0.3, 0.1), (high, 1.0, 0.9, 0.5)],
                        [(low, 0.0), (high, 0.12)])
renderer = Renderer(device)
renderer.set_transfer_function(warm)
renderer.set_options(quality="fine")
renderer.set_slice(cut)
picture = Frame(device, 512, 512, Frame.RGBA | Frame.DEPTH)
renderer.render(picture)
picture.save_png(os.path.join(folder, "explore_time.png"), overwrite=True, background=(0, 0, 0))
stats = renderer.stats()
print(f"time slice: {stats.ms_total:.0f} ms, {stats.points_after_cull} of {stats.points_total} points drawn, "
      f"mean opacity {picture.rgba()[..., 3].mean():.3f}")

# %% The same with a trail: where it was over the last quarter of the series before.
renderer.set_trail((-nt / 4, 0), intervals=3)
renderer.render(picture)
picture.save_png(os.path.join(folder, "explore_trail.png"), overwrite=True, background=(0, 0, 0))
renderer.set_trail(None)

# %% Any hyperplane of space-time: here one that reaches later times towards larger x.
tilt = (nt - 1) / (nx - 1)
renderer.set_slice(volume.slice(plane=(-tilt, 0, 0, 1, 0)))
renderer.render(picture)
picture.save_png(os.path.join(folder, "explore_oblique.png"), overwrite=True, background=(0, 0, 0))
print("pictures: explore_time.png, explore_trail.png, explore_oblique.png")

"""numpy_to_picture.py [FOLDER]: an array becomes a file, and a moment between two of its frames a picture."""
import os
import sys

import numpy as np

import bccsplat

folder = sys.argv[1] if len(sys.argv) > 1 else "."
t, z, y, x = np.ogrid[0:20, 0:40, 0:40, 0:40]
blob = np.exp(-((x - 20 - 8 * np.cos(.2 * t)) ** 2 + (y - 20 - 8 * np.sin(.2 * t)) ** 2 + (z - 20) ** 2) / 40)
bccsplat.save(os.path.join(folder, "blob.bcc4"), blob.astype(np.float32), dt=.04, time_unit="s", air_threshold=1e-3,
              overwrite=True)
volume = bccsplat.open(os.path.join(folder, "blob.bcc4"))
print("between frames 12 and 13 the largest value is %.3f" % volume[12.5].max())
volume.show(.5).save(os.path.join(folder, "blob.png"), overwrite=True)

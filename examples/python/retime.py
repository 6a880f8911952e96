"""retime.py IN.bcc4 OUT.bcc4 FACTOR: the same series with FACTOR times as many frames, each evaluated at its own moment."""
import sys

import numpy as np

import bccsplat

if len(sys.argv) < 4:
    sys.exit(__doc__)
source, target, factor = sys.argv[1], sys.argv[2], float(sys.argv[3])
volume = bccsplat.open(source)
info, channel = volume.info(), volume.channel_info()
moments = np.linspace(0, len(volume) - 1, round((len(volume) - 1) * factor) + 1)
slow = bccsplat.FieldArray(volume, [moments, *volume.field().axes[1:]])  # nothing is read before it is written
bccsplat.save(target, slow, times=[volume.index_to_time(frame) for frame in moments], affine=info.affine[:],
              axes=[volume.axis(axis) for axis in range(3)],
              attributes={key: text for key, text in volume.attributes().items() if key.startswith(("axis", "time_"))},
              name=channel.name, unit=channel.unit or None, time_unit=info.time_unit or None,
              spatial_unit=info.spatial_unit or None, air=channel.air, nonfinite="hole", overwrite=True)
print("%d frames became %d" % (len(volume), len(moments)))

"""film.py FILE.bcc4 OUT.mp4 [FRAMES]: a film of the series while it is turned once around, by ffmpeg."""
import subprocess
import sys

import numpy as np

import bccsplat

if len(sys.argv) < 3:
    sys.exit(__doc__)
volume = bccsplat.open(sys.argv[1])
count = int(sys.argv[3]) if len(sys.argv) > 3 else 96
encoder = subprocess.Popen(["ffmpeg", "-loglevel", "error", "-y", "-f", "image2pipe", "-c:v", "png", "-r", "24", "-i", "-",
                            "-pix_fmt", "yuv420p", sys.argv[2]], stdin=subprocess.PIPE)
for n, frame in enumerate(np.linspace(0, len(volume) - 1, count)):
    encoder.stdin.write(volume.show(frame=frame, rotate_y=360 * n / count, width=480, height=360)._repr_png_())
encoder.stdin.close()
sys.exit(encoder.wait())

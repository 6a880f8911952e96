# SPDX-License-Identifier: Apache-2.0
"""Writes three drops that move, swell and fade: 24 frames of 48 x 40 x 32 floats."""
import sys

import numpy

x, y, z = numpy.meshgrid(numpy.arange(48), numpy.arange(40), numpy.arange(32), indexing="ij", sparse=True)
with open(sys.argv[1], "wb") as out:
    for frame in range(24):
        turn = 2 * numpy.pi * frame / 40
        field = numpy.zeros((48, 40, 32))
        for drop in range(3):
            phase = turn + drop * 2.1
            cx, cy, cz = 24 + 12 * numpy.cos(phase), 20 + 9 * numpy.sin(phase), 16 + 4 * (drop - 1)
            r2 = (x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2
            field += (0.6 + 0.3 * numpy.sin(phase)) * numpy.exp(-r2 / (2 * (4.0 + drop) ** 2))
        out.write(field.transpose(2, 1, 0).astype("<f4").tobytes())

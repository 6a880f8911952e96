# SPDX-License-Identifier: Apache-2.0
"""Writes series that the viewer is tried with: make_series.py FOLDER. drops.raw: three drops that move, swell and fade, 24 frames
of 48 x 40 x 32 floats. large.raw: shells that grow, 12 frames of 128^3 bytes."""
import sys

import numpy

folder = sys.argv[1]


def axes(*dims):
    return numpy.meshgrid(*(numpy.arange(n, dtype="f4") for n in dims), indexing="ij", sparse=True)


x, y, z = axes(48, 40, 32)
with open(f"{folder}/drops.raw", "wb") as out:
    for frame in range(24):
        turn = 2 * numpy.pi * frame / 40
        field = numpy.zeros((48, 40, 32))
        for drop in range(3):
            phase = turn + drop * 2.1
            cx, cy, cz = 24 + 12 * numpy.cos(phase), 20 + 9 * numpy.sin(phase), 16 + 4 * (drop - 1)
            r2 = (x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2
            field += (0.6 + 0.3 * numpy.sin(phase)) * numpy.exp(-r2 / (2 * (4.0 + drop) ** 2))
        out.write(field.transpose(2, 1, 0).astype("<f4").tobytes())

x, y, z = axes(128, 128, 128)
r = numpy.sqrt((x - 63) ** 2 + (y - 60) ** 2 + (z - 66) ** 2)
with open(f"{folder}/large.raw", "wb") as out:
    for frame in range(12):
        shell = numpy.exp(-(((r - 20 - 2.5 * frame) / 7) ** 2)) * (1 + 0.3 * numpy.cos(x / 9 + frame / 3) * numpy.cos(y / 11))
        out.write((190 * shell.transpose(2, 1, 0)).astype("u1").tobytes())

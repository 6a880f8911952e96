# SPDX-License-Identifier: Apache-2.0
"""Writes series that the viewer is tried with: make_series.py FOLDER. drops.raw: three drops that move, swell and fade, 24 frames
of 48 x 40 x 32 floats. large.raw: shells that grow, 12 frames of 128^3 bytes. classes.nrrd: blocks of labels, 5 frames of
24 x 16 x 12 bytes, unevenly spaced along x and z."""
import sys

import numpy

folder = sys.argv[1]


def axes(*dims):
    return numpy.meshgrid(*(numpy.arange(n, dtype="f4") for n in dims), indexing="ij", sparse=True)


def row(numbers):
    return " ".join(f"{n:.10g}" for n in numbers)


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

x, y, z = axes(24, 16, 12)
with open(f"{folder}/classes.nrrd", "wb") as out:
    out.write(f"""NRRD0005
type: uint8
dimension: 4
sizes: 24 16 12 5
kinds: space space space time
encoding: raw
axis 0 index values:={row(123.4 + 0.001 * numpy.arange(24) ** 2)}
axis 0 index unit:=degrees_east
axis 2 index values:=0 10 20 30 50 75 100 125 150 200 250 300
axis 2 index unit:=m
axis 2 index positive:=down
axis 3 index values:={row(100000 + 0.25 * numpy.arange(5))}

""".encode())
    for frame in range(5):
        block = (x // 6 + y // 4 + 2 * (z // 3) + frame).astype(int) % 3
        out.write(numpy.array([0, 2, 9], "u1")[block].transpose(2, 1, 0).tobytes())

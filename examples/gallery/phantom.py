#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A head that is made up, as a CT would have it, and what its parts are called.

    phantom.py FOLDER    writes ct.raw (i16, Hounsfield units) and labels.raw (u8), x fastest, 96 x 120 x 112, 2 mm apart

x to the right, y up, and the face towards z. Labels: 1 and 2 hemispheres (left in the picture, and right), 3 cerebellum,
4 brain stem, 5 ventricles, 6 a tumour, which is on the right."""
import array
import math
import sys

DIMS = (96, 120, 112)
STEP = 2  # mm

# What of (label, value, middle, radii, least y) in mm, each over those before it; half-axes are along x, y and z.
AIR, FAT, SKIN, BONE, BRAIN, FLUID = -1000, -80, 30, 900, 38, 5
PARTS = [
    (0, SKIN, (0, 0, -4), (80, 106, 96), -999), (0, SKIN, (0, -62, 30), (52, 46, 52), -999),
    (0, SKIN, (0, -22, 91), (11, 17, 14), -999), (0, SKIN, (-80, -14, -8), (7, 18, 11), -999),
    (0, SKIN, (80, -14, -8), (7, 18, 11), -999),
    (0, BONE, (0, 2, -4), (74, 99, 89), -999), (0, BONE, (0, -64, 34), (40, 34, 42), -999),
    (0, SKIN, (0, -66, 24), (31, 30, 40), -999), (0, BRAIN, (0, 4, -4), (67, 92, 82), -999),
    (0, BONE, (0, -58, 0), (58, 8, 62), -999),
    (0, FAT, (-28, -4, 74), (17, 15, 24), -999), (0, FAT, (28, -4, 74), (17, 15, 24), -999),
    (0, SKIN, (-28, -4, 78), (12, 12, 12), -999), (0, SKIN, (28, -4, 78), (12, 12, 12), -999),
    (1, BRAIN, (-32, 22, -4), (31, 62, 77), -22), (2, BRAIN, (32, 22, -4), (31, 62, 77), -22),
    (3, BRAIN, (0, -32, -46), (44, 19, 29), -999), (4, BRAIN, (0, -34, -10), (12, 28, 12), -999),
    (5, FLUID, (-14, 22, 4), (8, 12, 34), -999), (5, FLUID, (14, 22, 4), (8, 12, 34), -999),
    (6, 75, (38, 34, 30), (15, 14, 16), -999)]


def middle_of(axis, index):
    """mm from the middle of the volume."""
    return (index - (DIMS[axis] - 1) / 2) * STEP


def paint():
    """Row by row: an ellipsoid fills a span of each."""
    nx, ny, nz = DIMS
    ct, labels = array.array('h', [AIR] * (nx * ny * nz)), bytearray(nx * ny * nz)
    for label, value, middle, radii, least in PARTS:
        for k in range(nz):
            for j in range(ny):
                y, z = middle_of(1, j), middle_of(2, k)
                left = 1 - ((y - middle[1]) / radii[1]) ** 2 - ((z - middle[2]) / radii[2]) ** 2
                if left <= 0 or y < least:
                    continue
                half = radii[0] * math.sqrt(left)
                first = max(0, math.ceil((middle[0] - half) / STEP + (nx - 1) / 2))
                end = min(nx, math.floor((middle[0] + half) / STEP + (nx - 1) / 2) + 1)
                row = (k * ny + j) * nx
                if end > first:
                    ct[row + first:row + end] = array.array('h', [value] * (end - first))
                    labels[row + first:row + end] = bytes([label]) * (end - first)
    return ct, labels


def blurred(ct):
    """Quarters and halves along each axis, as a scanner's point spread."""
    for stride in (1, DIMS[0], DIMS[0] * DIMS[1]):
        before, after = ct[:stride] + ct[:-stride], ct[stride:] + ct[-stride:]
        ct = array.array('h', ((a + 2 * b + c) // 4 for a, b, c in zip(before, ct, after)))
    return ct


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    ct, labels = paint()
    with open(f'{sys.argv[1]}/ct.raw', 'wb') as f:
        blurred(ct).tofile(f)
    with open(f'{sys.argv[1]}/labels.raw', 'wb') as f:
        f.write(labels)


if __name__ == '__main__':
    main()

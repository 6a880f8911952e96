"""marschner_lobb.py FOLDER: the test signal of Marschner & Lobb (1994), section 5, on files of their 41^3 grid
(cc), of the BCC lattice with its band (bcc) and of one three times as fine (fine): as published, and limited to
the ball of frequencies that both hold. Sampled where the sites are; nothing is resampled."""
import sys
from pathlib import Path

import numpy as np

import bccsplat

EDGE = 41  # samples of [-1, 1]
NYQUIST = (EDGE - 1) / 4  # cycles per unit
BALL = 0.8 * NYQUIST


def ring(r):
    return np.cos(12 * np.pi * np.cos(np.pi * r / 2))


def limited(cut, n=512):
    """ring as a cosine series on [-2, 2]^2, mirrored at the ends, without the frequencies from `cut` on."""
    terms = np.arange(int(4 * cut) + 1)
    at = (np.arange(n) + 0.5) * 2 / n
    waves = np.where(terms[:, None] > 0, 2, 1) / n * np.cos(terms[:, None] * np.pi / 2 * at)
    series = waves @ ring(np.hypot(at[:, None], at)) @ waves.T
    series[np.hypot(terms[:, None], terms) > 4 * cut] = 0

    def at_points(x, y):
        along = [np.cos(terms[:, None] * np.pi / 2 * v) for v in (y, x)]
        return np.einsum("kn,kn->n", series @ along[1], along[0])

    return at_points


def write(device, path, in_plane, edge, lattice):
    def field(points):
        x, y, z = (points[:, a] * 2 / (edge - 1) - 1 for a in range(3))
        return (1 - np.sin(np.pi * z / 2) + 0.25 * (1 + in_plane(x, y))) / 2.5

    with bccsplat.Writer(device, path, (edge, edge, edge, 1), lattice=lattice, overwrite=True,
                         affine=np.diag([2 / (edge - 1)] * 3 + [1])) as writer:
        writer.add_field(field)


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    device = bccsplat.Device()
    for name, in_plane in (("published", lambda x, y: ring(np.hypot(x, y))), ("ball", limited(BALL))):
        write(device, folder / (name + "-cc.bcc4"), in_plane, EDGE, "cc")
        write(device, folder / (name + "-bcc.bcc4"), in_plane, EDGE, "bcc")
        write(device, folder / (name + "-fine.bcc4"), in_plane, 3 * (EDGE - 1) + 1, "bcc")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

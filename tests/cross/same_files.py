#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""same_files.py FOLDER HERE... -- THERE...: imports the same series by two tools, that of this machine and one for another
system under its emulator, and compares byte by byte the files and the frames that are read of them, and pictures as PNG, whose
pixels may differ by the rounding of other vectors. Each command runs in a folder of its own, with the same names, so that what a
file says of its making is the same."""
import gzip
import math
import os
import random
import struct
import subprocess
import sys
import zlib

DIMS = (22, 20, 18, 14)


def wave(x, y, z, t):
    return math.sin(.31 * x + .2 * t) * math.cos(.23 * y - .1 * t) + .4 * math.sin(.37 * z + .3 * t)


def puff(x, y, z, t):
    r = math.dist((x, y, z), (8 + .4 * t, 10, 9 - .2 * t))
    return max(0, 1 - r / 7) * (1 + .3 * math.sin(x + y))


NOISE = random.Random(3)


def noisy(*p):
    return wave(*p) + NOISE.gauss(0, .05)


def with_holes(x, y, z, t):
    return math.nan if 5 < x < 9 and y > 15 else wave(x, y, z, t)


def values(f, scale=1, dims=DIMS):
    nx, ny, nz, nt = dims
    return [scale * f(x, y, z, t) for t in range(nt) for z in range(nz) for y in range(ny) for x in range(nx)]


def packed(code, numbers):
    if code not in 'fd':
        numbers = [round(v) for v in numbers]
    return struct.pack(f'<{len(numbers)}{code}', *numbers)


def raw(name, dtype, dims=DIMS):
    return [name, '--dims', ','.join(map(str, dims)), '--dtype', dtype]


def write(folder, name, data):
    with open(os.path.join(folder, name), 'wb') as f:
        f.write(data)


def nrrd(code_name, data, dims=DIMS):
    head = f'NRRD0004\ntype: {code_name}\ndimension: 4\nsizes: {" ".join(map(str, dims))}\nendian: little\nencoding: gzip\n\n'
    return head.encode() + gzip.compress(data, mtime=0)


LARGE = (48, 44, 40, 5)


def make_inputs(folder):
    write(folder, 'u8.raw', packed('B', values(puff, 150)))
    write(folder, 'u16.raw', packed('H', [v + 30000 for v in values(wave, 9000)]))
    write(folder, 'f32.raw', packed('f', values(wave)))
    write(folder, 'noise.raw', packed('f', values(noisy)))
    write(folder, 'holes.raw', packed('f', values(with_holes)))
    write(folder, 'f64.raw', packed('d', values(puff, 1e3)))
    write(folder, 'large.raw', packed('H', [v + 30000 for v in values(wave, 9000, LARGE)]))
    write(folder, 'i16.nrrd', nrrd('short', packed('h', values(wave, 800))))


IMPORTS = {
    'samples of u8': raw('u8.raw', 'u8'),
    'samples of u16, low-pass': [*raw('u16.raw', 'u16'), '--lowpass', '--measure', 'all'],
    'samples of f32, exact': [*raw('f32.raw', 'f32'), '--exact', '--lattice', 'd4star', '--faces', 'mirror'],
    'samples of f32 as f16': [*raw('noise.raw', 'f32'), '--quantize', 'f16', '--lattice', 'd4star', '--ends', 'predict'],
    'a bound on every sample': [*raw('f32.raw', 'f32'), '--abs', '.02'],
    'a bound on doubles': [*raw('f64.raw', 'f64'), '--psnr', '55'],
    'wavelets': [*raw('noise.raw', 'f32'), '--store', 'wavelets', '--psnr', '40'],
    'coarser levels': [*raw('large.raw', 'u16', LARGE), '--levels', '2'],
    'missing data, one frame each': [*raw('holes.raw', 'f32'), '--on-nonfinite', 'hole', '--lattice', 'cc'],
    'periodic, gzip': ['i16.nrrd', '--axes', 'xyzt', '--ends', 'periodic', '--periodic', 'x'],
}


def read(path):
    with open(path, 'rb') as f:
        return f.read()


def run(command, folder, *words):
    done = subprocess.run([*command, *words], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f'FAILED: {" ".join(map(str, words))} in {folder}:\n{done.stdout}{done.stderr}')


def difference(here, there):
    if len(here) != len(there):
        return f'{len(here)} and {len(there)} bytes'
    apart = [i for i, (a, b) in enumerate(zip(here, there)) if a != b]
    return f'{len(apart)} of {len(here)} bytes differ, the first at {apart[0]}' if apart else ''


def pixels(png):
    """Width, height, channels and bytes of a PNG file of 8 bits."""
    place, packed_rows, shape = 8, b'', None
    while place < len(png):
        size, kind = struct.unpack_from('>I4s', png, place)
        body = png[place + 8:place + 8 + size]
        if kind == b'IHDR':
            shape = *struct.unpack_from('>II', body), {2: 3, 6: 4}[body[9]]
        elif kind == b'IDAT':
            packed_rows += body
        place += 12 + size
    width, height, channels = shape
    rows, row, above = zlib.decompress(packed_rows), bytearray(), bytearray(width * channels)
    out = bytearray()
    for y in range(height):
        begin = y * (width * channels + 1)
        rule, row = rows[begin], bytearray(rows[begin + 1:begin + 1 + width * channels])
        for i in range(len(row)):
            left, up, corner = (row[i - channels], above[i], above[i - channels]) if i >= channels else (0, above[i], 0)
            nearest = min((left, up, corner), key=lambda v, p=left + up - corner: abs(p - v))
            row[i] = (row[i] + (0, left, up, (left + up) // 2, nearest)[rule]) & 255
        out += row
        above = row
    return shape, bytes(out)


def picture_difference(here, there):
    (shape, a), (other, b) = pixels(here), pixels(there)
    if shape != other or len(set(a)) < 8:
        return f'pictures of {shape} and {other}, with {len(set(a))} values'
    most = max(abs(i - j) for i, j in zip(a, b))
    return f'pixels differ by {most} of 255' if most > 1 else ''


def main():
    split = sys.argv.index('--')
    top, commands = sys.argv[1], (sys.argv[2:split], sys.argv[split + 1:])
    folders = [os.path.join(top, name) for name in ('here', 'there')]
    for folder in folders:
        os.makedirs(folder, exist_ok=True)
    make_inputs(folders[0])
    for name in os.listdir(folders[0]):
        write(folders[1], name, read(os.path.join(folders[0], name)))
    bad = 0
    for i, (what, words) in enumerate(IMPORTS.items()):
        name = f'{i}.bcc4'
        for command, folder in zip(commands, folders):
            run(command, folder, 'import', *words, '-o', name, '--overwrite', '--quiet')
            run(command, folder, 'export', name, '--all', '-o', f'{i}.%04d.raw', '--overwrite', '--quiet')
            run(command, folder, 'export', name, '--index', '--time', '2.3', '-o', f'{i}.between.raw', '--overwrite', '--quiet')
            run(command, folder, 'render', name, '--time', '1.3', '--size', '96x80', '-o', f'{i}.png', '--overwrite', '--quiet')
        parts = [name, *sorted(n for n in os.listdir(folders[0]) if n.startswith(f'{i}.') and n.endswith('.raw'))]
        wrong = {n: d for n in parts if (d := difference(*(read(os.path.join(f, n)) for f in folders)))}
        pictures = [read(os.path.join(f, f'{i}.png')) for f in folders]
        if d := picture_difference(*pictures):
            wrong['picture'] = d
        same = 'the same' if pictures[0] == pictures[1] else 'rounded otherwise'
        print(f'{what}: {wrong or f"the same file, and {len(parts) - 1} frames read of it; a picture, {same}"}', flush=True)
        bad += bool(wrong) or len(parts) < 2
    if bad:
        sys.exit(f'FAILED: {bad} of {len(IMPORTS)} imports differ')
    print(f'{len(IMPORTS)} imports: the same bytes')


if __name__ == '__main__':
    main()

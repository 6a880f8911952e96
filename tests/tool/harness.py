"""What the end-to-end tests of bcc4 share. A test file is called with the path of bcc4, a scratch folder and the top of
the sources. Standard library only."""
import array
import functools
import gzip
import itertools
import json
import os
import resource
import shutil
import signal
import struct
import subprocess
import sys
import unittest
import zlib

BCC4, SCRATCH, TOP = sys.argv[1:4]
DATA = os.environ.get('BCCSPLAT_DATA') or os.path.join(TOP, '..', 'shared', 'data')
LONG = os.environ.get('BCCSPLAT_LONG')  # all cases, twice the sizes: .ci/nightly long
CODES = {'u8': 'B', 'i8': 'b', 'u16': 'H', 'i16': 'h', 'i32': 'i', 'u32': 'I', 'f32': 'f', 'f64': 'd'}
NRRD_CODES = {'float': 'f', 'uint8': 'B', 'uint16': 'H', 'int16': 'h', 'int8': 'b', 'int32': 'i', 'uint32': 'I'}


def main():
    sys.argv[1:] = []
    unittest.main(verbosity=0)


@functools.cache
def turn():
    """The next number with every commit, 0 where there is no git."""
    try:
        return int(subprocess.run(['git', '-C', TOP, 'rev-list', '--count', 'HEAD'], capture_output=True, text=True, check=True).stdout)
    except (OSError, subprocess.CalledProcessError):
        return 0


def some(cases, count=1):
    """All of a list of cases in a long run, else so many in turn: those of one commit are the same in every run."""
    first = turn() % len(cases)
    return cases if LONG else [case for k, case in enumerate(cases) if (k - first) % len(cases) < count]


def has_reader(name):
    return name in subprocess.run([BCC4, '--version'], capture_output=True, text=True, check=True).stdout.split('absent')[0]


def has_openvdb():
    return has_reader('openvdb')


def field(dims, f, code):
    """Values f(x, y, z, t), x fastest; integers rounded. Functions of a file are asked once for all of its tests."""
    return values_of(tuple(dims), f, code)[:]


@functools.lru_cache(16)
def values_of(dims, f, code):
    nx, ny, nz, nt = dims
    values = (f(x, y, z, t) for t in range(nt) for z in range(nz) for y in range(ny) for x in range(nx))
    return array.array(code, values if code in 'fd' else (round(v) for v in values))


class Nrrd:
    """An attached raw NRRD with little-endian data."""

    def __init__(self, path):
        with open(path, 'rb') as f:
            head, data = f.read().split(b'\n\n', 1)
        lines = head.decode().split('\n')
        assert lines[0].startswith('NRRD000'), lines[0]
        self.fields, self.keys = {}, {}
        for line in lines[1:]:
            if line.startswith('#'):
                continue
            if ':=' in line:
                key, value = line.split(':=', 1)
                self.keys[key] = value
            else:
                key, value = line.split(': ', 1)
                self.fields[key] = value
        self.sizes = [int(n) for n in self.fields['sizes'].split()]
        self.values = array.array(NRRD_CODES[self.fields['type']], data)
        assert self.fields['encoding'] == 'raw'
        product = 1
        for n in self.sizes:
            product *= n
        assert len(self.values) == product, (len(self.values), self.sizes)


def exr_attributes(path):
    """Name -> bytes of an OpenEXR header: magic, version, then name, type, length, value up to an empty name."""
    with open(path, 'rb') as f:
        data = f.read()
    assert data[:4] == b'\x76\x2f\x31\x01'
    attributes, at = {}, 8
    while data[at]:
        name, kind, rest = data[at:].split(b'\0', 2)
        at += len(name) + len(kind) + 2
        length = struct.unpack_from('<i', data, at)[0]
        attributes[name.decode()] = data[at + 4:at + 4 + length]
        at += 4 + length
    return attributes


class ToolTest(unittest.TestCase):
    store = None  # of imports that name none: tests of lattices and of searches ask for samples

    def setUp(self):
        self.folder = os.path.join(SCRATCH, self.id().split('.', 1)[1])
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder)

    def tearDown(self):
        leftovers = [n for n in os.listdir(self.folder) if 'partial' in n]
        self.assertEqual(leftovers, [], 'half-written files stay behind')
        shutil.rmtree(self.folder, ignore_errors=True)

    def path(self, name):
        return os.path.join(self.folder, name)

    def bcc4(self, *args, expect=0, env=None, overwrite=True):
        """Runs the tool in the scratch folder; returns (stdout, stderr) after checking the exit code. Pictures and
        slices may replace those of before."""
        if args and args[0] in ('render', 'slice') and overwrite and '--overwrite' not in args:
            args = (*args, '--overwrite')
        if self.store and args and args[0] == 'import' and '--store' not in args and ('--plan' not in args or '--dry-run' in args):
            args = (*args, '--store', self.store)
        p = subprocess.run([BCC4, *map(str, args)], capture_output=True, text=True, cwd=self.folder, env=env, timeout=300)
        self.assertEqual(p.returncode, expect, f'bcc4 {" ".join(map(str, args))}\n{p.stdout}\n{p.stderr}')
        return p.stdout, p.stderr

    def full_disk(self, limit, *args):
        """Runs the tool where no file may have more bytes; returns what it said, after checking that it failed for that."""
        p = subprocess.run([BCC4, *map(str, args)], capture_output=True, text=True, cwd=self.folder, timeout=300,
                           preexec_fn=lambda: (signal.signal(signal.SIGXFSZ, signal.SIG_DFL),  # as a shell starts it
                                               resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))))
        self.assertEqual(p.returncode, 4, p.stderr)
        return p.stderr

    def json(self, *args, expect=0):
        return json.loads(self.bcc4(*args, '--json', expect=expect)[0])

    def refused(self, code, text, *args, output=None):
        """The command fails with that exit code and text, and leaves no output."""
        _, err = self.bcc4(*args, expect=code)
        self.assertIn(text, err)
        if output:
            self.assertFalse(os.path.exists(self.path(output)), f'{output} was written all the same')

    def read(self, name):
        with open(self.path(name), 'rb') as f:
            return f.read()

    def write(self, name, data):
        with open(self.path(name), 'wb') as f:
            f.write(data if isinstance(data, bytes) else data.tobytes())
        return self.path(name)

    def raw(self, name, dims, f, dtype='f32'):
        """Writes a raw series; returns the arguments to import it."""
        self.write(name, field(dims, f, CODES[dtype]))
        return [name, '--dims', ','.join(map(str, dims)), '--dtype', dtype]

    def volume(self, dims, f, *more, name='v.bcc4', dtype='f32'):
        self.bcc4('import', *self.raw(name + '.raw', dims, f, dtype), '-o', name, *more)
        return name


def write_gzip(path, data):
    with gzip.open(path, 'wb') as f:
        f.write(data)


def png_size(path):
    with open(path, 'rb') as f:
        head = f.read(24)
    assert head[:8] == b'\x89PNG\r\n\x1a\n'
    return struct.unpack('>II', head[16:24])


def read_png(path):
    """Rows of (red, green, blue, alpha) of an 8-bit picture, with or without alpha."""
    with open(path, 'rb') as f:
        data = f.read()
    width, height = struct.unpack('>II', data[16:24])
    n = {2: 3, 6: 4}[data[25]]  # bytes of a pixel
    at, packed = 8, b''
    while at < len(data):
        length, kind = struct.unpack_from('>I4s', data, at)
        packed += data[at + 8:at + 8 + length] if kind == b'IDAT' else b''
        at += 12 + length
    raw, rows, before = zlib.decompress(packed), [], bytes(n * width)
    for y in range(height):
        start = y * (n * width + 1)
        before = unfiltered(raw[start], raw[start + 1:start + 1 + n * width], before, n)
        alpha = before[3::n] if n == 4 else itertools.repeat(255)
        rows.append(list(zip(before[0::n], before[1::n], before[2::n], alpha)))
    return rows


def unfiltered(kind, row, above, n):
    """The bytes of a row of a PNG with n bytes in a pixel; 'above' are those of the row before."""
    if kind == 0:
        return row
    if kind == 2:
        return bytes((a + b) & 255 for a, b in zip(row, above))
    out = bytearray(len(row))
    for c in range(n):
        if kind == 1:
            out[c::n] = bytes(v & 255 for v in itertools.accumulate(row[c::n]))
            continue
        values, left, corner = [], 0, 0
        for value, up in zip(row[c::n], above[c::n]):
            if kind == 3:
                left = (value + (left + up) // 2) & 255
            else:
                to_left, to_up, to_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
                nearest = left if to_left <= to_up and to_left <= to_corner else up if to_up <= to_corner else corner
                left, corner = (value + nearest) & 255, up
            values.append(left)
        out[c::n] = bytes(values)
    return bytes(out)

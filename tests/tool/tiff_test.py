"""TIFF read by import: stacks, numbered files, hyperstacks of ImageJ, OME-TIFF; what the tool exports comes back as it was;
what is not read says why and a way out. Files are written here, and by tifffile where it is installed."""
import os
import struct
import unittest
import zlib

from harness import Nrrd, ToolTest, field, has_reader, main

SHORT, LONG, ASCII, RATIONAL = 3, 4, 2, 5
FORMATS = {'B': (8, 1), 'H': (16, 1), 'h': (16, 2), 'f': (32, 3), 'I': (32, 1)}


def value(x, y, z, t, c=0):
    return 1000 * c + 100 * t + 40 * z + 6 * y + x


def tiff(pages, nx, ny, code='H', order='<', description='', deflate=False, tile=0, samples=1, photometric=1, bits=None, resolution=None, planar=1):
    """A TIFF file of pages, each a list of nx * ny * samples numbers, one strip or tiles of an edge."""
    out = bytearray(struct.pack(order + '2sHI', b'II' if order == '<' else b'MM', 42, 0))
    link = 4
    for n, page in enumerate(pages):
        parts = []
        if tile:
            for y0 in range(0, ny, tile):
                for x0 in range(0, nx, tile):
                    parts.append([page[min(y, ny - 1) * nx + min(x, nx - 1)] for y in range(y0, y0 + tile) for x in range(x0, x0 + tile)])
        else:
            parts = [page]
        places, sizes = [], []
        for part in parts:
            data = struct.pack(f'{order}{len(part)}{code}', *part)
            data = zlib.compress(data) if deflate else data
            places.append(len(out))
            sizes.append(len(data))
            out += data
        tags = [(256, LONG, [nx]), (257, LONG, [ny]), (258, SHORT, [bits or FORMATS[code][0]] * samples), (259, SHORT, [8 if deflate else 1]),
                (262, SHORT, [photometric]), (277, SHORT, [samples]), (284, SHORT, [planar]), (339, SHORT, [FORMATS[code][1]] * samples)]
        tags += [(322, LONG, [tile]), (323, LONG, [tile]), (324, LONG, places), (325, LONG, sizes)] if tile else \
            [(273, LONG, places), (278, LONG, [ny]), (279, LONG, sizes)]
        if description and n == 0:
            text = description.encode() + b'\0'
            tags.append((270, ASCII, text))
        if resolution:
            tags += [(282, RATIONAL, resolution), (283, RATIONAL, resolution)]
        entries = bytearray()
        for tag, kind, values in sorted(tags):
            if kind == ASCII:
                data, count = values, len(values)
            elif kind == RATIONAL:
                data, count = struct.pack(order + '2I', *values), 1
            else:
                data, count = struct.pack(f'{order}{len(values)}{"H" if kind == SHORT else "I"}', *values), len(values)
            if len(data) > 4:
                out += b'\0' * (len(out) % 2)
                at = struct.pack(order + 'I', len(out))
                out += data
            else:
                at = data.ljust(4, b'\0')
            entries += struct.pack(order + 'HHI', tag, kind, count) + at
        out += b'\0' * (len(out) % 2)
        struct.pack_into(order + 'I', out, link, len(out))
        out += struct.pack(order + 'H', len(tags)) + entries
        link = len(out)
        out += bytes(4)
    return bytes(out)


def page(nx, ny, z, t=0, c=0):
    return [value(x, y, z, t, c) for y in range(ny) for x in range(nx)]


@unittest.skipUnless(has_reader('tiff'), 'this build reads no TIFF')
class Tiff(ToolTest):
    NX, NY, NZ, NT = 6, 5, 4, 3

    def read(self, *args, channel=0):
        """The values that come back, [t][z][y][x] in a flat list, and what info says."""
        self.bcc4('import', *args, '-o', 'a.bcc4', '--lattice', 'cc', '--exact', '--quiet', '--overwrite')
        self.bcc4('export', 'a.bcc4', '--all', '--channel', channel, '-o', 'a.raw', '--quiet', '--overwrite')
        info = self.json('info', 'a.bcc4')
        with open(self.path('a.raw'), 'rb') as f:
            data = f.read()
        n = 1
        for size in info['dims']:
            n *= size
        code = {1: 'B', 2: 'H', 4: 'f'}[len(data) // n]
        return list(struct.unpack(f'<{n}{code}', data)), info

    def stack(self, **more):
        return tiff([page(self.NX, self.NY, z) for z in range(self.NZ)], self.NX, self.NY, **more)

    def expected(self, nz=NZ, nt=1, c=0):
        return [value(x, y, z, t, c) for t in range(nt) for z in range(nz) for y in range(self.NY) for x in range(self.NX)]

    def test_pages_are_planes_however_they_are_stored(self):
        for more in (dict(), dict(order='>'), dict(deflate=True), dict(tile=16), dict(order='>', deflate=True, tile=16), dict(code='f')):
            self.write('s.tif', self.stack(**more))
            values, info = self.read('s.tif')
            for got, want in zip(values, self.expected(), strict=True):
                self.assertAlmostEqual(got, want, delta=.001 if more.get('code') == 'f' else 0, msg=more)
            self.assertEqual(info['dims'], [self.NX, self.NY, self.NZ, 1])
        _, said = self.bcc4('import', 's.tif', '--dry-run')
        out, _ = self.bcc4('import', 's.tif', '--dry-run')
        self.assertIn('read as planes', out + said)

    def test_signed_values(self):
        self.write('s.tif', tiff([[-5 * x + y for y in range(3) for x in range(4)] for _ in range(2)], 4, 3, code='h'))
        values, _ = self.read('s.tif', '--air', -32768)
        self.assertEqual([v - 65536 if v > 32767 else v for v in values], [-5 * x + y for _ in range(2) for y in range(3) for x in range(4)])

    def test_pages_as_moments_and_files_as_moments(self):
        self.write('s.tif', self.stack())
        values, info = self.read('s.tif', '--axes', 'xyt')
        self.assertEqual((values, info['dims']), (self.expected(), [self.NX, self.NY, 1, self.NZ]))
        for t in range(self.NT):
            self.write(f'f.{t}.tif', tiff([page(self.NX, self.NY, z, t) for z in range(self.NZ)], self.NX, self.NY))
        values, info = self.read('f.*.tif')
        self.assertEqual((values, info['dims']), (self.expected(nt=self.NT), [self.NX, self.NY, self.NZ, self.NT]))

    def test_files_of_one_page(self):
        for z in range(self.NZ):
            self.write(f'p{z:02}.tif', tiff([page(self.NX, self.NY, z)], self.NX, self.NY))
        self.refused(2, '--axes xyz reads them as the planes', 'import', 'p*.tif', '-o', 'a.bcc4', output='a.bcc4')
        values, info = self.read('p*.tif', '--axes', 'xyz')
        self.assertEqual((values, info['dims']), (self.expected(), [self.NX, self.NY, self.NZ, 1]))
        values, info = self.read('p*.tif', '--axes', 'xyt')
        self.assertEqual((values, info['dims']), (self.expected(), [self.NX, self.NY, 1, self.NZ]))
        os.remove(self.path('p02.tif'))
        self.refused(3, 'planes 2 are missing', 'import', 'p*.tif', '--axes', 'xyz', '-o', 'b.bcc4', output='b.bcc4')

    def test_hyperstacks_of_image_j(self):
        words = ('ImageJ=1.53t\nimages=24\nchannels=2\nslices=4\nframes=3\nhyperstack=true\nspacing=4.0\nunit=micron\n'
                 'finterval=0.5\ntunit=sec\n')
        pages = [page(self.NX, self.NY, z, t, c) for t in range(3) for z in range(4) for c in range(2)]
        self.write('h.tif', tiff(pages, self.NX, self.NY, description=words, resolution=(1, 2)))
        for c in range(2):
            values, info = self.read('h.tif', channel=c)
            self.assertEqual(values, self.expected(nt=3, c=c))
        self.assertEqual(info['dims'], [self.NX, self.NY, 4, 3])
        self.assertEqual((info['times']['last'], info['times']['unit']), (1, 's'))
        self.assertEqual(info['spatial_unit'], '\u00b5m')
        self.assertEqual([info['affine'][i][i] for i in range(3)], [2, 2, 4])
        self.write('h.tif', tiff(pages[:1], self.NX, self.NY, description=words))
        self.refused(3, 'tells of 24 pages, the file has 1', 'import', 'h.tif', '-o', 'b.bcc4', output='b.bcc4')

    def test_axes_of_tifffile(self):
        sizes = {'t': 3, 'z': 4, 'c': 2}
        def write(axes, words):
            """Pages in the order of the axes, slowest first."""
            places = [{}]
            for a in axes:
                places = [{**p, a: i} for p in places for i in range(sizes[a])]
            self.write('s.tif', tiff([page(self.NX, self.NY, p.get('z', 0), p.get('t', 0), p.get('c', 0)) for p in places], self.NX, self.NY, description=words))

        def shape(axes):
            return str([*(sizes[a] for a in axes), self.NY, self.NX])
        for axes in ('tz', 'zt', 'tcz', 'cz', 't'):
            write(axes, f'{{"axes": "{axes.upper()}YX", "shape": {shape(axes)}}}')
            values, info = self.read('s.tif', channel=int('c' in axes))
            nz, nt = (sizes[a] if a in axes else 1 for a in 'zt')
            self.assertEqual(values, [v for t in range(nt) for z in range(nz) for v in page(self.NX, self.NY, z, t, int('c' in axes))], axes)
            self.assertEqual(info['dims'], [self.NX, self.NY, nz, nt])
        write('tz', f'{{"shape": {shape("tz")}}}')
        values, info = self.read('s.tif')
        self.assertEqual((values, info['dims']), (self.expected(nt=3), [self.NX, self.NY, 4, 3]))
        said, _ = self.bcc4('import', 's.tif', '-o', 'a.bcc4', '--overwrite')
        self.assertIn('the file tells the sizes of its axes, 6 x 5 x 4 x 3, and not what they are', said)
        write('zt', f'{{"shape": {shape("zt")}}}')
        self.assertEqual(self.read('s.tif', '--axes', 'xytz')[0], self.expected(nt=3))
        write('ctz', f'{{"shape": {shape("ctz")}}}')
        self.assertEqual(self.read('s.tif', '--axes', 'xyztc', channel=1)[0], self.expected(nt=3, c=1))
        write('tz', '{"shape": [6, 4, 5, 6]}')
        self.refused(3, 'tifffile tells of 24 pages, the file has 12', 'import', 's.tif', '-o', 'b.bcc4', output='b.bcc4')

    def test_pages_that_tifffile_writes_one_by_one(self):
        self.write('s.tif', tiff([page(self.NX, self.NY, z) for z in range(4)], self.NX, self.NY, description=f'{{"shape": [{self.NY}, {self.NX}]}}'))
        values, info = self.read('s.tif')
        self.assertEqual((values, info['dims']), (self.expected(), [self.NX, self.NY, 4, 1]))
        self.assertEqual(self.read('s.tif', '--axes', 'xyt')[1]['dims'], [self.NX, self.NY, 1, 4])

    def test_order_and_spacing_of_image_j(self):
        for order in ('czt', 'zct', 'tzc'):
            count = {'c': 2, 'z': 4, 't': 3}
            first, second, third = order
            pages = [page(self.NX, self.NY, **{first: a, second: b, third: c}) for c in range(count[third]) for b in range(count[second])
                     for a in range(count[first])]
            self.write('h.tif', tiff(pages, self.NX, self.NY, description=f'ImageJ=1.53t\nimages=24\nchannels=2\nslices=4\nframes=3\n'
                                     f'hyperstack=true\norder={order}\nspacing=-1.5\n'))
            values, info = self.read('h.tif', channel=1)
            self.assertEqual((values, info['affine'][2][2]), (self.expected(nt=3, c=1), 1.5), order)

    def test_moments_of_ome(self):
        def write(times, unit='', more=''):
            planes = ''.join(f'<Plane TheC="0" TheZ="{z}" TheT="{t}" DeltaT="{time + .01 * z}"{unit}/>'
                             for t, time in enumerate(times) if time is not None for z in (1, 0, 2, 3))
            self.write('o.ome.tif', tiff([page(6, 5, z, t) for t in range(3) for z in range(4)], 6, 5, description='<?xml version="1.0"?><OME><Image>'
                       f'<Pixels DimensionOrder="XYZCT" SizeX="6" SizeY="5" SizeZ="4" SizeC="1" SizeT="3" {more}>{planes}</Pixels></Image></OME>'))
            said, _ = self.bcc4('import', 'o.ome.tif', '-o', 'a.bcc4', '--overwrite')
            self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.nrrd', '--overwrite', '--quiet')
            times = Nrrd(self.path('a.nrrd')).keys['axis 3 index values']
            return said, [float(t) for t in times.split()], self.json('info', 'a.bcc4')['times']['unit']
        said, times, unit = write([.5, 2.1, 4])
        self.assertEqual((times, unit), ([.5, 2.1, 4], 's'))
        self.assertIn('(DeltaT of OME-XML)', said)
        self.assertEqual(write([0, 2, 5], ' DeltaTUnit="ms"', 'TimeIncrement="3"')[1:], ([0, 2, 5], 'ms'))
        said, times, unit = write([0, None, 5], more='TimeIncrement="3"')
        self.assertEqual((times, unit), ([0, 3, 6], 's'))
        self.assertIn('"DeltaT" is told by 2 of 3 only', said)

    def test_ome(self):
        words = ('<?xml version="1.0"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06"><Image ID="Image:0"><Pixels '
                 'DimensionOrder="XYZTC" SizeX="6" SizeY="5" SizeZ="4" SizeC="2" SizeT="3" PhysicalSizeX="0.5" PhysicalSizeY="0.5" '
                 'PhysicalSizeZ="2" TimeIncrement="3" Type="uint16"><Channel Name="GFP"/><Channel Name="DAPI"/><TiffData/></Pixels></Image></OME>')
        pages = [page(self.NX, self.NY, z, t, c) for c in range(2) for t in range(3) for z in range(4)]
        self.write('o.ome.tif', tiff(pages, self.NX, self.NY, description=words))
        for c, name in enumerate(('GFP', 'DAPI')):
            values, info = self.read('o.ome.tif', channel=name)
            self.assertEqual(values, self.expected(nt=3, c=c))
        self.assertEqual([info['affine'][i][i] for i in range(3)], [.5, .5, 2])
        self.assertEqual((info['times']['last'], info['spatial_unit']), (6, '\u00b5m'))
        self.write('o.ome.tif', tiff(pages[:12], self.NX, self.NY, description=words))
        self.refused(3, 'tells of 24 pages', 'import', 'o.ome.tif', '-o', 'b.bcc4', output='b.bcc4')

    def test_steps_of_ome_in_several_units(self):
        def write(sizes):
            self.write('o.ome.tif', tiff([page(6, 5, z) for z in range(4)], 6, 5, description='<?xml version="1.0" encoding="UTF-8"?><OME><Image>'
                       f'<Pixels DimensionOrder="XYZTC" SizeX="6" SizeY="5" SizeZ="4" SizeC="1" SizeT="1" {sizes}/></Image></OME>'))

        def steps(*args):
            info = self.read('o.ome.tif', *args)[1]
            return [info['affine'][i][i] for i in range(3)], info['spatial_unit']
        write('PhysicalSizeX="0.1" PhysicalSizeY="0.0002" PhysicalSizeYUnit="mm" PhysicalSizeZ="500" PhysicalSizeZUnit="nm"')
        self.assertEqual(steps(), ([.1, .2, .5], '\u00b5m'))
        write('PhysicalSizeY="2" PhysicalSizeYUnit="nm" PhysicalSizeZ="5" PhysicalSizeZUnit="nm"')
        self.assertEqual(steps(), ([1, 2, 5], 'nm'))
        write('PhysicalSizeX="0.1" PhysicalSizeY="0.1" PhysicalSizeZ="3" PhysicalSizeZUnit="reference frame"')
        self.refused(3, 'PhysicalSizeZ in "reference frame"', 'import', 'o.ome.tif', '-o', 'b.bcc4', output='b.bcc4')
        self.assertEqual(steps('--spacing', '1,1,3')[0], [1, 1, 3])

    def test_colours_are_channels(self):
        colours = [[z + 10 * c for _ in range(12) for c in range(3)] for z in range(2)]
        self.write('c.tif', tiff(colours, 4, 3, code='B', samples=3, photometric=2))
        values, _ = self.read('c.tif', channel='blue')
        self.assertEqual(values, [20] * 12 + [21] * 12)
        self.write('c.tif', tiff(colours, 4, 3, code='B', samples=3, photometric=2, planar=2))
        self.refused(3, 'tiffcp -p contig', 'import', 'c.tif', '-o', 'b.bcc4', output='b.bcc4')

    def test_what_is_not_read_says_so(self):
        self.write('a.tif', tiff([[0] * 8], 4, 2, code='B', bits=4))
        self.refused(3, 'convert it to 8, 16 or 32 bits', 'import', 'a.tif', '-o', 'b.bcc4', output='b.bcc4')
        self.write('a.tif', tiff([[0] * 8], 4, 2, code='B', photometric=8))
        self.refused(3, 'no grey values or RGB', 'import', 'a.tif', '-o', 'b.bcc4', output='b.bcc4')
        whole = self.stack()
        self.write('a.tif', whole[:120])
        self.refused(3, 'a.tif', 'import', 'a.tif', '-o', 'b.bcc4', output='b.bcc4')
        self.write('a.tif', b'II*\0' + b'\xff' * 100)
        self.refused(3, 'a.tif', 'import', 'a.tif', '-o', 'b.bcc4', output='b.bcc4')
        self.write('a.tif', whole)
        self.refused(2, '--dims', 'import', 'a.tif', '--dims', '6,5,4', '-o', 'b.bcc4', output='b.bcc4')
        self.refused(2, '--axes zyx', 'import', 'a.tif', '--axes', 'zyx', '-o', 'b.bcc4', output='b.bcc4')
        self.refused(2, 'hyperstack', 'import', 'a.tif', '--axes', 'xyzt', '-o', 'b.bcc4', output='b.bcc4')

    def test_sizes_that_wrap_at_64_bits(self):
        words = ('<?xml version="1.0"?><OME><Image><Pixels DimensionOrder="XYZCT" SizeX="6" SizeY="5" SizeZ="1" SizeC="67280421310721" '
                 'SizeT="274177"/></Image></OME>')  # 2^64 + 1 pages
        self.write('o.ome.tif', tiff([page(6, 5, 0)], 6, 5, description=words))
        self.refused(3, 'the file has 1', 'import', 'o.ome.tif', '--channel', '0', '--dry-run')

    def test_tiles_keep_to_the_memory_allowed(self):
        data = self.stack(tile=16)
        for tag in (322, 323):  # its tiles are 16384 x 16384 by name
            data = data.replace(struct.pack('<HHII', tag, LONG, 1, 16), struct.pack('<HHII', tag, LONG, 1, 16384))
        self.write('a.tif', data)
        self.refused(4, 'one tile takes 512 MiB', 'import', 'a.tif', '-o', 'b.bcc4', '--max-mem', '100M', output='b.bcc4')

    def test_exports_come_back(self):
        dims = (7, 6, 5, 4)
        self.raw('r.raw', dims, value, 'u16')
        self.bcc4('import', 'r.raw', '--dims', '7,6,5,4', '--dtype', 'u16', '--spacing', '2,3,4', '--dt', 2, '-o', 'r.bcc4', '--lattice', 'cc', '--exact', '--quiet')
        self.bcc4('export', 'r.bcc4', '--all', '-o', 'r.tif', '--quiet')
        values, info = self.read('r.tif')
        self.assertEqual(values, list(field(dims, value, 'H')))
        self.assertEqual((info['dims'], info['spatial_unit']), (list(dims), ''))
        for a, step in enumerate((2, 3, 4)):
            self.assertAlmostEqual(info['affine'][a][a], step, places=5)
        self.bcc4('export', 'r.bcc4', '--all', '-o', 'e.%02d.tif', '--quiet')
        self.assertEqual(self.read('e.*.tif')[0], values)

    def test_files_of_tifffile(self):
        try:
            import numpy
            import tifffile
        except ImportError:
            self.skipTest('SKIPPED: no tifffile here, so nothing of its files was read')
        stack = numpy.array(self.expected(nt=self.NT), 'uint16').reshape(self.NT, self.NZ, self.NY, self.NX)
        for name, more in (('i.tif', dict(imagej=True, metadata=dict(axes='TZYX', spacing=3, unit='um', finterval=2))),
                           ('o.ome.tif', dict(metadata=dict(axes='TZYX', PhysicalSizeX=1.5, PhysicalSizeXUnit='mm', TimeIncrement=2))),
                           ('b.ome.tif', dict(bigtiff=True, compression='zlib', tile=(16, 16), metadata=dict(axes='TZYX', TimeIncrement=2)))):
            tifffile.imwrite(self.path(name), stack, **more)
            values, info = self.read(name)
            self.assertEqual(values, stack.ravel().tolist(), name)
            self.assertEqual((info['dims'], info['times']['last']), ([self.NX, self.NY, self.NZ, self.NT], 4), name)


if __name__ == '__main__':
    main()

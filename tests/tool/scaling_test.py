"""Scaled integers: every reader that knows them, slopes, offsets and types, there and back."""
import array
import gzip
import math
import os
import struct

from harness import CODES, DATA, Nrrd, ToolTest, has_reader, main, some

DIMS = (11, 10, 9, 6)
NIFTI_TYPES = {'u8': 2, 'i8': 256, 'i16': 4, 'u16': 512, 'i32': 8}
NETCDF_TYPES = {'i8': 1, 'i16': 3, 'i32': 4}
METAIMAGE_TYPES = {'u8': 'MET_UCHAR', 'i8': 'MET_CHAR', 'i16': 'MET_SHORT', 'u16': 'MET_USHORT', 'i32': 'MET_INT'}
SLOPES = [(1, 273), (.01, 0), (.01, 273.15), (1e-5, 0), (-.25, -1000), (37.5, 12)]


def stored(dtype):
    """A smooth wave over most codes of 8 and many of 16 bits, within the band of every lattice."""
    middle, size = {'u8': (128, 100), 'i8': (0, 100), 'i16': (0, 9000), 'u16': (30000, 9000), 'i32': (100, 90000)}[dtype]
    nx, ny, nz, nt = DIMS
    return array.array(CODES[dtype], (
        round(middle + size * math.cos(.5 * x + .2 * t) * math.cos(.4 * y) * math.cos(.3 * z))
        for t in range(nt) for z in range(nz) for y in range(ny) for x in range(nx)))


def nifti(values, dtype, slope, offset):
    head = bytearray(352)
    struct.pack_into('<i', head, 0, 348)
    struct.pack_into('<8h', head, 40, 4, *DIMS, 1, 1, 1)
    struct.pack_into('<hh', head, 70, NIFTI_TYPES[dtype], 8 * values.itemsize)
    struct.pack_into('<8f', head, 76, 1, 1, 1, 1, 1, 0, 0, 0)
    struct.pack_into('<3f', head, 108, 352, slope, offset)
    head[344:348] = b'n+1\0'
    return bytes(head) + values.tobytes()


def netcdf(values, dtype, slope, offset):
    """NetCDF classic: dimensions t, z, y, x and one variable v."""
    def name(text):
        return struct.pack('>i', len(text)) + text.encode() + bytes(-len(text) % 4)

    def number(key, value):
        return name(key) + struct.pack('>iid', 6, 1, value)

    dims = struct.pack('>ii', 10, 4) + b''.join(name(n) + struct.pack('>i', s) for n, s in zip('tzyx', reversed(DIMS)))
    swapped = array.array(values.typecode, values)
    swapped.byteswap()
    variable = name('v') + struct.pack('>5i', 4, 0, 1, 2, 3) + struct.pack('>ii', 12, 2) + number('scale_factor', slope)
    variable += number('add_offset', offset)
    variable += struct.pack('>ii', NETCDF_TYPES[dtype], len(swapped.tobytes()))
    head = b'CDF\1' + struct.pack('>i', 0) + dims + bytes(8) + struct.pack('>ii', 11, 1) + variable
    return head + struct.pack('>i', len(head) + 4) + swapped.tobytes()


def metaimage(values, dtype, slope, offset):
    head = f'ObjectType = Image\nNDims = 4\nDimSize = {" ".join(map(str, DIMS))}\nElementType = {METAIMAGE_TYPES[dtype]}\n'
    head += f'ElementToIntensityFunctionSlope = {slope!r}\nElementToIntensityFunctionOffset = {offset!r}\n'
    return (head + 'ElementDataFile = LOCAL\n').encode() + values.tobytes()


FORMATS = {'nii': (nifti, NIFTI_TYPES), 'nc': (netcdf, NETCDF_TYPES), 'mha': (metaimage, METAIMAGE_TYPES)}


class Scaling(ToolTest):
    def steps_off(self, suffix, dtype, slope, offset):
        """Imports, exports and verifies; the largest error in steps of the stored integers and the size of the file."""
        values = stored(dtype)
        self.write('s.' + suffix, FORMATS[suffix][0](values, dtype, slope, offset))
        self.bcc4('import', 's.' + suffix, '--exact', '-o', 's.bcc4', '--overwrite', '--quiet')
        self.bcc4('export', 's.bcc4', '--all', '-o', 's.nrrd', '--overwrite', '--quiet')
        out = Nrrd(self.path('s.nrrd'))
        plain = (slope, offset) == (1, 0)
        narrow = dtype != 'i32'
        self.assertEqual(out.values.typecode, CODES[dtype] if plain else 'f')
        exact = (s * slope + offset for s in values)
        off = max(abs(a - b) for a, b in zip(out.values, exact, strict=True)) / abs(slope)
        report = self.json('verify', 's.bcc4', '--against', 's.' + suffix)
        self.assertAlmostEqual(report['exported']['max_abs'] / abs(slope), off, delta=.02 * off + .01)
        self.assertEqual(report['exported']['type'], dtype if plain else 'f32')
        info = self.json('info', 's.bcc4')
        self.assertEqual(info['value_type'], {'8': 'u8', '6': 'u16', '2': 'f32'}[dtype[-1]])
        if narrow:
            self.assertAlmostEqual(info['channels'][0]['value_scale'], abs(slope), delta=1e-6 * abs(slope))
        return off, os.path.getsize(self.path('s.bcc4'))

    def test_every_reader_slope_offset_and_type(self):
        for suffix, (_, types) in FORMATS.items():
            if suffix == 'nc' and not has_reader('netcdf'):
                continue
            for dtype in types:
                plain = self.steps_off(suffix, dtype, 1, 0)
                for slope, offset in some(SLOPES, 2):
                    with self.subTest(f'{suffix} {dtype} x {slope} + {offset}'):
                        off, size = self.steps_off(suffix, dtype, slope, offset)
                        # What scaling costs: air that is not 0, and what floats round.
                        self.assertLess(off, 2 * plain[0] + 2)
                        self.assertLess(size, 1.3 * plain[1] + 500)

    def test_air_is_a_value_of_the_source(self):
        # 0 lies between -.3 and .7: the empty half holds the value nearest to it and is not stored.
        values = array.array('h', (0 if i % 11 < 6 else 50 for i in range(math.prod(DIMS))))
        self.write('a.nii', nifti(values, 'i16', 1, -.3))
        self.bcc4('import', 'a.nii', '-o', 'a.bcc4', '--quiet')
        info = self.json('info', 'a.bcc4')
        self.assertAlmostEqual(info['channels'][0]['air'], -.3, delta=1e-6)
        self.assertLess(info['sites_kept'], .8 * info['sites_total'])
        # Air that the user gives stays theirs, and far from the values floats hold it.
        self.bcc4('import', 'a.nii', '--air', 1e6, '-o', 'b.bcc4', '--quiet')
        info = self.json('info', 'b.bcc4')
        self.assertEqual((info['value_type'], info['channels'][0]['air']), ('f32', 1e6))

    def test_options_of_the_writer_go_with_scaling(self):
        self.write('a.nii', nifti(stored('i16'), 'i16', .01, 50))
        for more in (['--abs', .05], ['--psnr', 60], ['--quantize', 'u8'], ['--quantize', 'u16'], ['--quantize', 'f32'],
                     ['--on-nonfinite', 'clamp'], ['--lattice', 'cc']):
            with self.subTest(more):
                self.bcc4('import', 'a.nii', *more, '-o', 'a.bcc4', '--overwrite', '--quiet')
                report = self.json('verify', 'a.bcc4', '--against', 'a.nii')
                self.assertGreater(report['psnr'], 40)
                if more[0] == '--abs':
                    self.assertLessEqual(report['max_abs'], .05)
                    self.assertTrue(report['bound']['held'])
        self.bcc4('import', 'a.nii', '--dry-run', '--plan', 'p.json', '--quiet')
        self.bcc4('import', '--plan', 'p.json', '-o', 'p.bcc4', '--quiet')
        self.bcc4('import', 'a.nii', '-o', 'q.bcc4', '--quiet')
        with open(self.path('p.bcc4'), 'rb') as p, open(self.path('q.bcc4'), 'rb') as q:
            self.assertEqual(len(p.read()), len(q.read()))

    def test_what_floats_cannot_hold_is_said(self):
        self.write('a.nii', nifti(stored('i16'), 'i16', 1e-5, 1000))
        self.assertIn('steps of the source', self.bcc4('import', 'a.nii', '-o', 'a.bcc4')[1])
        self.write('a.nii', nifti(stored('i16'), 'i16', 1e-5, 1))
        self.assertEqual('', self.bcc4('import', 'a.nii', '-o', 'b.bcc4', '--quiet')[1])

    def test_a_statistical_map_as_packages_write_it(self):
        """The real map of floats, scaled to 16 bits over its range, against the floats."""
        path = os.path.join(DATA, 'statmap_64x64x21_f32be.nii.gz')
        if not os.path.exists(path):
            self.skipTest('no such data')
        with gzip.open(path) as f:
            head = bytearray(f.read())
        floats = array.array('f', bytes(head[352:]))
        floats.byteswap()
        low, high = min(floats), max(floats)
        slope, offset = (high - low) / 65535, (high + low) / 2
        struct.pack_into('>hh', head, 70, 4, 16)
        struct.pack_into('>2f', head, 112, slope, offset)
        values = array.array('h', (max(-32768, min(32767, round((v - offset) / slope))) for v in floats))
        values.byteswap()
        self.write('m.nii', bytes(head[:352]) + values.tobytes())
        worst = {}
        for name in ('m.nii', path):
            self.bcc4('import', name, '-o', 'm.bcc4', '--overwrite', '--quiet')
            self.bcc4('export', 'm.bcc4', '--all', '-o', 'm.nrrd', '--overwrite', '--quiet')
            got = Nrrd(self.path('m.nrrd')).values
            worst[name] = (sum((a - b) ** 2 for a, b in zip(got, floats)) / len(floats)) ** .5
            self.assertGreater(len(set(got)), 20000)
        self.assertLess(worst['m.nii'], 1.02 * worst[path] + slope)


if __name__ == '__main__':
    main()

"""Several values in a voxel of NIfTI: dim[5], colours and complex numbers become channels; handedness is told."""
import cmath
import os
import struct
import unittest

from harness import DATA, Nrrd, ToolTest, main

SIZES = (4, 3, 2, 3)


def points():
    nx, ny, nz, nt = SIZES
    return [(x, y, z, t) for t in range(nt) for z in range(nz) for y in range(ny) for x in range(nx)]


def nifti(code, bits, values, parts=1, slope=0.0):
    """A file of SIZES and dim[5] = parts, values as bytes."""
    head = bytearray(352)
    struct.pack_into('<i', head, 0, 348)
    struct.pack_into('<8h', head, 40, 5 if parts > 1 else 4, *SIZES, parts, 1, 1)
    struct.pack_into('<hh', head, 70, code, bits)
    struct.pack_into('<8f', head, 76, 1, 2, 2, 2, 1.5, 0, 0, 0)
    struct.pack_into('<ff', head, 108, 352, slope)
    head[123] = 2 | 8
    head[344:347] = b'n+1'
    return bytes(head) + values


def number(x, y, z, t):
    return cmath.rect(1 + x + y * z, .3 * x - .2 * t)


class NiftiValues(ToolTest):
    def channels(self, name, *options):
        """The channels of an import and their values by name."""
        self.bcc4('import', name, *options, '-o', 'v.bcc4', '--lattice', 'cc', '--exact', '--quiet', '--overwrite')
        out = {}
        for c in self.json('info', 'v.bcc4')['channels']:
            self.bcc4('export', 'v.bcc4', '--all', '--channel', c['name'], '-o', 'v.nrrd', '--overwrite', '--quiet')
            out[c['name']] = list(Nrrd(self.path('v.nrrd')).values)
        return out

    def test_several_values(self):
        values = b''.join(struct.pack('<f', 100 * c + x + 10 * t) for c in range(3) for x, y, z, t in points())
        self.write('v.nii', nifti(16, 32, values, parts=3))
        got = self.channels('v.nii')
        self.assertEqual(list(got), ['c0', 'c1', 'c2'])
        for c in range(3):
            for v, (x, y, z, t) in zip(got[f'c{c}'], points()):
                self.assertAlmostEqual(v, 100 * c + x + 10 * t, places=3)
        self.assertEqual(list(self.channels('v.nii', '--channel', 'c2')), ['c2'])
        self.refused(2, 'has channels c0 to c2', 'import', 'v.nii', '--channel', 'c3', '-o', 'x.bcc4', output='x.bcc4')

    def test_colours(self):
        for code, names in ((128, ['red', 'green', 'blue']), (2304, ['red', 'green', 'blue', 'alpha'])):
            n = len(names)
            values = bytes(50 * c + 4 * x + 2 * y + t for x, y, z, t in points() for c in range(n))
            self.write('c.nii', nifti(code, 8 * n, values, slope=2))  # slopes are not for colours
            got = self.channels('c.nii')
            self.assertEqual(list(got), names)
            for c, name in enumerate(names):
                self.assertEqual(got[name], [50 * c + 4 * x + 2 * y + t for x, y, z, t in points()])
        self.assertEqual(list(self.channels('c.nii', '--channel', 'alpha,red')), ['alpha', 'red'])
        self.refused(2, 'has channels red, green, blue and alpha', 'import', 'c.nii', '--channel', 'pink', '-o', 'x.bcc4')

    def test_complex_numbers(self):
        for code, letter in ((32, 'f'), (1792, 'd')):
            values = b''.join(struct.pack('<2' + letter, number(*p).real, number(*p).imag) for p in points())
            self.write('z.nii', nifti(code, 64 if letter == 'f' else 128, values))
            got = self.channels('z.nii')
            self.assertEqual(list(got), ['real', 'imaginary'])
            got.update(self.channels('z.nii', '--channel', 'magnitude,phase'))
            for name, part in (('real', lambda c: c.real), ('imaginary', lambda c: c.imag), ('magnitude', abs), ('phase', cmath.phase)):
                for v, p in zip(got[name], points()):
                    self.assertAlmostEqual(v, part(number(*p)), places=4)
        self.assertEqual([c['unit'] for c in self.json('info', 'v.bcc4')['channels']], ['', 'rad'])
        self.refused(2, 'real, imaginary, magnitude or phase', 'import', 'z.nii', '--channel', 'angle', '-o', 'x.bcc4')

    @unittest.skipUnless(os.path.exists(os.path.join(DATA, 'cases')), 'no shared cases')
    def test_cases(self):
        for name, names in (('rgb24.nii', ['red', 'green', 'blue']), ('vector_dim5.nii', ['c0', 'c1', 'c2']),
                            ('complex64.nii', ['real', 'imaginary'])):
            self.bcc4('import', os.path.join(DATA, 'cases', name), '-o', 'v.bcc4', '--quiet', '--overwrite')
            self.assertEqual([c['name'] for c in self.json('info', 'v.bcc4')['channels']], names)
        out, _ = self.bcc4('import', os.path.join(DATA, 'cases', 'handedness_sform_qform.nii.gz'), '-o', 'h.bcc4')
        self.assertIn('qform has the other handedness than its sform', out)


if __name__ == '__main__':
    main()

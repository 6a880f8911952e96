"""Labels of any number and type: told at import by the source or by their blocks, kept in the file, and never blended."""
import math
import struct

from harness import CODES, Nrrd, ToolTest, field, main

DIMS = (24, 20, 16, 4)


def atlas(x, y, z, t):
    """A number below 100 for each block; blocks move with time."""
    return (x + t) // 4 * 11 % 10 * 10 + y // 5 * 3 + z // 8


def wide(x, y, z, t):
    """Numbers as of FreeSurfer, beside small ones."""
    return (0, 2, 4, 17, 1035, 2035)[((x + t) // 5 + y // 5 * 2 + z // 6) % 6]


def far(x, y, z, t):
    """Numbers that are as large as floats hold, and small ones beside them."""
    return {17: 16777215, 1035: 100001}.get(wide(x, y, z, t), wide(x, y, z, t))


def few(x, y, z, t):
    """Few whole numbers that are no labels: they rise by one."""
    return round(6 + 5 * math.sin(.13 * x + .2 * t) * math.cos(.11 * y - .12 * z))


def nifti(values, intent, code=4, bits=16):
    head = bytearray(352)
    struct.pack_into('<i', head, 0, 348)
    struct.pack_into('<8h', head, 40, 4, *DIMS, 1, 1, 1)
    struct.pack_into('<hhh', head, 68, intent, code, bits)
    struct.pack_into('<8f', head, 76, 1, 1, 1, 1, 1, 0, 0, 0)
    struct.pack_into('<ff', head, 108, 352, 0)
    head[344:347] = b'n+1'
    return bytes(head) + values.tobytes()


class Labels(ToolTest):
    def exported(self, *args):
        self.bcc4('export', 'v.bcc4', *args, '-o', 'e.nrrd', '--overwrite', '--quiet')
        return list(Nrrd(self.path('e.nrrd')).values)

    def check_kept(self, values):
        """The file has the values of the source, and those of the nearest sample anywhere else."""
        frame = len(values) // DIMS[3]
        third = list(values[2 * frame:3 * frame])
        self.assertEqual(self.exported('--all'), list(values))
        self.bcc4('slice', 'v.bcc4', '--index', '--time', 1.5, '-o', 's.nrrd')
        self.assertEqual(list(Nrrd(self.path('s.nrrd')).values), third)
        self.assertEqual(self.exported('--index', '--time', 1.5), third)
        probed = self.json('probe', 'v.bcc4', '--index', '--at', '7.5,9.4,7.6', '--time', 1.6)
        self.assertIn(str(third[(8 * DIMS[1] + 9) * DIMS[0] + 8]), str(probed))
        info = self.json('info', 'v.bcc4')
        self.assertTrue(info['channels'][0]['labels'])
        self.assertIn(', labels', self.bcc4('info', 'v.bcc4')[0])
        return info

    def test_of_any_number_and_type(self):
        for f, dtype in ((atlas, 'u8'), (atlas, 'f32'), (wide, 'i32'), (far, 'i32'), (far, 'f32'), (lambda *p: .25 + .5 * (wide(*p) > 10), 'f32')):
            for more in ((),) if f is not wide else ((), ('--lattice', 'cc')):
                with self.subTest(dtype=dtype, more=more):
                    report = self.json('import', *self.raw('a.raw', DIMS, f, dtype), *more, '-o', 'v.bcc4', '--overwrite')
                    self.assertEqual(report['error']['channels'][0]['max_abs'], 0)
                    self.check_kept(field(DIMS, f, CODES[dtype]))

    def test_the_source_says_it(self):
        values = field(DIMS, few, 'h')
        self.write('a.nii', nifti(values, 1002))
        self.bcc4('import', 'a.nii', '-o', 'v.bcc4', '--quiet')
        self.check_kept(values)
        head = f'NRRD0005\ntype: int16\ndimension: 4\nsizes: {" ".join(map(str, DIMS))}\nkinds: space space space time\nendian: little\nencoding: raw\n\n'
        self.write('a.seg.nrrd', head.encode() + values.tobytes())
        self.bcc4('import', 'a.seg.nrrd', '-o', 'v.bcc4', '--overwrite', '--quiet')
        self.check_kept(values)

    def test_what_has_few_values_and_is_smooth_is_none(self):
        self.bcc4('import', *self.raw('a.raw', DIMS, few, 'u8'), '--lattice', 'cc', '-o', 'v.bcc4', '--quiet')
        self.assertFalse(self.json('info', 'v.bcc4')['channels'][0]['labels'])
        self.assertNotIn(', labels', self.bcc4('info', 'v.bcc4')[0].split('attributes')[0])
        self.bcc4('slice', 'v.bcc4', '--index', '--time', 1.5, '-o', 's.nrrd')
        self.assertTrue(any(abs(v - round(v)) > .2 for v in Nrrd(self.path('s.nrrd')).values))

    def test_they_have_no_levels(self):
        source = self.raw('a.raw', DIMS, wide, 'i32')
        self.refused(2, "channel 'value' has labels, and coarser levels are means, which labels have none of: ask for no levels",
                     'import', *source, '--levels', 1, '-o', 'x.bcc4', output='x.bcc4')

    def test_appended_they_stay(self):
        short = (*DIMS[:3], 3)
        self.bcc4('import', *self.raw('a.raw', short, wide, 'i32'), '-o', 'v.bcc4', '--quiet')
        self.bcc4('import', *self.raw('a.raw', DIMS, wide, 'i32'), '--append', '-o', 'v.bcc4', '--quiet')
        self.check_kept(field(DIMS, wide, 'i'))

    def test_gaps_are_not_filled_by_means(self):
        for f in 0, 1, 3:
            self.write(f'l.{f}.raw', field((*DIMS[:3], 1), lambda x, y, z, t, f=f: wide(x, y, z, f), 'i'))
        args = ['import', 'l.%d.raw', '--dims', ','.join(map(str, DIMS[:3])), '--dtype', 'i32', '-o', 'v.bcc4', '--quiet']
        self.refused(2, '--gaps interpolate blends them: hold or skip', *args, '--gaps', 'interpolate', output='v.bcc4')
        self.bcc4(*args, '--gaps', 'hold')


if __name__ == '__main__':
    main()

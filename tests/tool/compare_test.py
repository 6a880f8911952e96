"""bcc4 compare: files and series, where both have values."""
import math

from harness import ToolTest, field, main

DIMS = (9, 8, 7, 5)


def value(x, y, z, t):
    return math.sin(.5 * x + t) + y * z


def nrrd(dims, f, origin=(0, 0, 0), times=None, unit='s', length='mm', space='right-anterior-superior', name='f', code='f', step=1, keys=''):
    times = times or list(range(dims[3]))
    head = (f'NRRD0005\ntype: float\ndimension: 4\nspace: {space}\nsizes: {" ".join(map(str, dims))}\n'
            f'space directions: ({step},0,0) (0,{step},0) (0,0,{step}) none\nspace origin: ({origin[0]},{origin[1]},{origin[2]})\n'
            f'kinds: domain domain domain time\nspace units: "{length}" "{length}" "{length}"\nunits: "" "" "" "{unit}"\n'
            f'content: {name}\nendian: little\nencoding: raw\naxis 3 index type:=numeric\n'
            f'axis 3 index values:={" ".join(map(str, times))}\n{keys}\n')
    return head.encode() + field(dims, f, code).tobytes()


class Compare(ToolTest):
    def make(self, name, dims=DIMS, f=value, **more):
        self.write('in.nrrd', nrrd(dims, f, **more))
        self.bcc4('import', 'in.nrrd', '-o', name, '--lattice', 'cc', '--exact', '--quiet', '--overwrite', '--on-nonfinite', 'hole')
        return name

    def test_equal_files(self):
        self.make('a.bcc4'), self.make('b.bcc4')
        j = self.json('compare', 'a.bcc4', 'b.bcc4')
        self.assertEqual((j['equal'], j['max_abs'], j['psnr'], j['samples_compared']), (True, 0, None, math.prod(DIMS)))
        out, _ = self.bcc4('compare', 'a.bcc4', 'b.bcc4')
        self.assertIn('equal', out)

    def test_where_and_when_they_differ_most(self):
        self.make('a.bcc4')
        self.make('b.bcc4', f=lambda x, y, z, t: value(x, y, z, t) + (.75 if (x, y, z, t) == (3, 2, 1, 4) else 0), times=None)
        j = self.json('compare', 'a.bcc4', 'b.bcc4', '--each-frame', expect=1)
        self.assertFalse(j['equal'])
        self.assertAlmostEqual(j['max_abs'], .75, places=5)
        self.assertEqual((j['worst']['frame'], j['worst']['time'], j['worst']['sample']), (4, 4, [3, 2, 1]))
        self.assertAlmostEqual(j['worst']['second'] - j['worst']['first'], .75, places=5)
        self.assertAlmostEqual(j['rmse'], .75 / math.sqrt(math.prod(DIMS)), places=5)
        self.assertAlmostEqual(j['psnr'], 20 * math.log10(j['peak'] / j['rmse']), places=6)
        self.assertEqual([f['max_abs'] > .5 for f in j['frames']], [False] * 4 + [True])
        self.refused(1, 'f differs by up to 0.75, more than --tolerance 0.5', 'compare', 'a.bcc4', 'b.bcc4', '--tolerance', .5)
        self.bcc4('compare', 'a.bcc4', 'b.bcc4', '--tolerance', .76)

    def test_a_series(self):
        self.make('a.bcc4')
        j = self.json('compare', 'a.bcc4', 'in.nrrd', '--tolerance', 1e-4)
        self.assertEqual((j['equal'], j['samples_compared']), (True, math.prod(DIMS)))
        # Raw values as they were read at import, at the place and times of the file.
        args = self.raw('r.raw', DIMS, value)
        self.bcc4('import', *args, '--spacing', '2,2,2', '--dt', .5, '-o', 'r.bcc4', '--lattice', 'cc', '--exact', '--quiet')
        j = self.json('compare', 'r.bcc4', 'r.raw', '--tolerance', 1e-4)
        self.assertEqual((j['samples_compared'], j['frames_outside']), (math.prod(DIMS), 0))

    def test_boxes_that_overlap(self):
        self.make('a.bcc4')
        # A box that begins at (4, 3, 2) and frame 3 of the same field and goes on beyond it.
        self.make('b.bcc4', f=lambda x, y, z, t: value(x + 4, y + 3, z + 2, t + 3), origin=(4, 3, 2), times=[3, 4, 5, 6, 7])
        j = self.json('compare', 'a.bcc4', 'b.bcc4', '--tolerance', 1e-4)
        self.assertEqual((j['equal'], j['samples_compared'], j['frames_outside']), (True, 2 * 5 * 5 * 5, 3))
        self.assertEqual(j['samples_outside'], 9 * 8 * 7 - 5 * 5 * 5)

    def test_spaces_are_turned(self):
        self.make('a.bcc4')
        mirrored = lambda x, y, z, t: value(8 - x, 7 - y, z, t)
        self.make('b.bcc4', f=mirrored, origin=(-8, -7, 0), space='left-posterior-superior')
        self.assertTrue(self.json('compare', 'a.bcc4', 'b.bcc4', '--tolerance', 1e-4)['equal'])

    def test_what_is_missing_in_one_is_a_difference(self):
        self.make('a.bcc4')
        self.make('b.bcc4', f=lambda x, y, z, t: float('nan') if x == 4 and t == 1 else value(x, y, z, t))
        j = self.json('compare', 'a.bcc4', 'b.bcc4', '--tolerance', 1e9, expect=1)
        self.assertEqual((j['equal'], j['missing']), (False, {'first': 0, 'second': 56}))
        self.refused(1, 'missing in one of them only', 'compare', 'a.bcc4', 'b.bcc4', '--tolerance', 1e9)

    def test_what_cannot_be_compared_is_named(self):
        self.make('a.bcc4')
        for text, more in (('no moment in common: one runs from 0 to 4 s, the other from 10 to 14 s', {'times': [10, 11, 12, 13, 14]}),
                           ('no place in common', {'origin': (100, 0, 0)}), ('the times of one are in s', {'unit': 'furlongs'}),
                           ('the lengths of one are in mm, of the other in hPa', {'length': 'hPa'})):
            self.make('b.bcc4', **more)
            self.refused(3, text, 'compare', 'a.bcc4', 'b.bcc4')
        self.refused(2, 'the first a .bcc4 file', 'compare', 'in.nrrd', 'a.bcc4')
        self.refused(2, '0 or more', 'compare', 'a.bcc4', 'a.bcc4', '--tolerance', '-1')

    def compared(self, *args, frames, **more):
        """Makes another file, or series, which is equal in so many frames."""
        self.make('b.bcc4', **more)
        for other in ('b.bcc4', 'in.nrrd'):
            j = self.json('compare', 'a.bcc4', other, '--tolerance', 1e-4, *args)
            self.assertEqual((j['equal'], j['samples_compared']), (True, frames * math.prod(DIMS[:3])), more)

    def test_moments_are_those_of_dates(self):
        since = 'time epoch:=2000-02-26\ntime calendar:={}\n'.format
        self.make('a.bcc4', unit='days', keys=since('standard'))
        for epoch in ('2000-04-23', '1999-02-26'):
            self.make('b.bcc4', unit='days', keys=f'time epoch:={epoch}\ntime calendar:=standard\n')
            self.refused(3, 'no moment in common', 'compare', 'a.bcc4', 'b.bcc4')
        later = lambda x, y, z, t: value(x, y, z, t + 1)
        self.compared(frames=4, unit='days', f=later, times=[2, 3, 4, 5, 6], keys='time epoch:=2000-02-25\n')
        self.compared(frames=5, unit='hours', times=[24 * t for t in range(5)], keys=since('gregorian'))
        self.compared(frames=5, unit='d')  # which tells no date
        # 29 February is a day of one calendar alone.
        leap = lambda x, y, z, t: value(x, y, z, t if t < 3 else t + 1)
        self.compared(frames=4, unit='days', f=leap, keys=since('noleap'))
        self.make('a.bcc4', unit='days', f=leap, keys=since('noleap'))
        self.make('b.bcc4', unit='days', keys=since('standard'))
        j = self.json('compare', 'a.bcc4', 'b.bcc4', '--tolerance', 1e-4)
        self.assertEqual((j['equal'], j['frames_outside']), (True, 1))
        self.make('b.bcc4', unit='days', keys='time epoch:=soon\n')
        self.refused(3, 'since soon', 'compare', 'a.bcc4', 'b.bcc4')

    def test_lengths_are_those_of_their_units(self):
        self.make('a.bcc4')
        self.compared(frames=5, length='m', step=.001)
        self.compared(frames=5, length='um', step=1000)
        self.make('b.bcc4', length='m')
        self.refused(1, 'differs', 'compare', 'a.bcc4', 'b.bcc4')

    def test_a_source_of_other_moments_or_places_is_another_one(self):
        days = {'unit': 'days', 'keys': 'time epoch:=2000-02-26\n'}
        self.make('a.bcc4', **days)
        for more, text in (({'keys': 'time epoch:=2000-02-27\n'}, 'is at 1, that of a.bcc4 at 0 days since 2000-02-26'), ({'unit': 'h'}, 'frame 1 of'),
                           ({'origin': (.5, 0, 0)}, 'stands where a.bcc4 has (0.5, 0, 0)'), ({'step': 1.01}, 'another source'),
                           ({'length': 'm'}, 'another source')):
            self.write('b.nrrd', nrrd(DIMS, value, **{**days, **more}))
            self.refused(3, text, 'verify', 'a.bcc4', '--against', 'b.nrrd')
        self.write('b.nrrd', nrrd(DIMS, value, **{**days, 'unit': 'hours', 'times': [24 * t for t in range(5)]}))
        self.bcc4('verify', 'a.bcc4', '--against', 'b.nrrd')


if __name__ == '__main__':
    main()

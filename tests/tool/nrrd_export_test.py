"""NRRD there and back: what export and slice write tells what import read."""
import math
import os

from harness import Nrrd, ToolTest, field, main

DIMS = (7, 6, 5, 4)


class NrrdExport(ToolTest):
    def setUp(self):
        super().setUp()
        head = ('NRRD0005\ntype: float\ndimension: 4\nspace: left-posterior-superior\nsizes: 7 6 5 4\n'
                'space directions: (0,2,0) (3,0,0) (0,0,4) none\nspace origin: (10,20,30)\nkinds: domain domain domain time\n'
                'space units: "mm" "mm" "mm"\nunits: "" "" "" "ms"\ncontent: wind speed\nsample units: "m/s"\nendian: little\n'
                'encoding: raw\naxis 3 index type:=numeric\naxis 3 index values:=3 3.5 5 9\n\n')
        values = field(DIMS, lambda x, y, z, t: 5 + math.sin(x + t) + y * z, 'f')
        self.write('a.nrrd', head.encode() + values.tobytes())
        self.bcc4('import', 'a.nrrd', '-o', 'a.bcc4', '--quiet')

    def known(self, name):
        j = self.json('info', name)
        return {'channels': [(c['name'], c['unit']) for c in j['channels']], 'affine': j['affine'], 'times': j['times'],
                'space': (j['attributes'].get('space'), j['spatial_unit'])}

    def frames(self, count, unit='K', time_unit='h', name='temp', value=lambda x, y, z, t: 250.5 + x + t, kind='float', code='f'):
        for t in range(count):
            head = (f'NRRD0005\ntype: {kind}\ndimension: 3\nsizes: 7 6 5\ncontent: {name}\nsample units: {unit}\nendian: little\n'
                    f'encoding: raw\ntime:={2 * t}\ntime unit:={time_unit}\n\n')
            self.write(f'f{t}.nrrd', head.encode() + field((7, 6, 5, 1), lambda x, y, z, _: value(x, y, z, t), code).tobytes())
        return [f'f{t}.nrrd' for t in range(count)]

    def test_append_keeps_the_name_and_refuses_other_units(self):
        self.bcc4('import', *self.frames(3), '-o', 's.bcc4', '--quiet')
        _, said = self.bcc4('import', *self.frames(4, name='temperature'), '-o', 's.bcc4', '--append', '--quiet')
        self.assertIn('"temperature" of the input goes on as "temp"', said)
        self.assertEqual(self.known('s.bcc4')['channels'], [('temp', 'K')])
        times = self.json('info', 's.bcc4')['times']
        self.assertEqual((times['count'], times['last'], times['unit']), (4, 6, 'h'))
        for text, other in (('its values are in K, those of the input in degC', {'unit': 'degC'}),
                            ('its times are in h, those of the input in min', {'time_unit': 'min'})):
            self.refused(2, text, 'import', *self.frames(5, **other), '-o', 's.bcc4', '--append')

    def test_units_that_differ_are_told(self):
        self.frames(4, unit='degC', time_unit='min')
        for name in self.frames(3):
            os.rename(self.path(name), self.path('g' + name))
        files = ['gf0.nrrd', 'gf1.nrrd', 'gf2.nrrd', 'f3.nrrd']
        out, said = self.bcc4('import', *files, '-o', 'm.bcc4', '--dry-run')
        self.assertIn('f3.nrrd: its values are in "degC", those of the first file in "K"', said)
        self.assertIn('in different units, and is not taken', out)

    def test_air_that_no_float_is_is_kept(self):
        value = lambda x, y, z, t: 273.15 + (x if 1 < x < 5 and 1 < y < 4 else 0)
        made = dict(value=value, kind='double', code='d')
        self.bcc4('import', *self.frames(3, **made), '-o', 's.bcc4', '--quiet')  # the smallest value of most samples
        info = self.json('info', 's.bcc4')
        self.assertEqual(info['attributes']['import.air.temp'], '273.15')
        self.bcc4('import', *self.frames(4, **made), '-o', 's.bcc4', '--append', '--quiet')
        self.bcc4('import', *self.frames(4, **made), '-o', 't.bcc4', '--quiet')
        grown, whole = (self.json('info', name) for name in ('s.bcc4', 't.bcc4'))
        self.assertEqual(grown['sites_kept'], whole['sites_kept'])
        self.assertLess(whole['sites_kept'], .8 * whole['sites_total'])

    def test_name_and_unit(self):
        self.assertEqual(self.known('a.bcc4')['channels'], [('wind speed', 'm/s')])
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'b.nrrd', '--quiet')
        header = Nrrd(self.path('b.nrrd')).fields
        self.assertEqual((header['content'], header['sample units']), ('wind speed', 'm/s'))
        self.bcc4('import', 'b.nrrd', '-o', 'b.bcc4', '--quiet')
        self.assertEqual(self.known('b.bcc4'), self.known('a.bcc4'))
        # Slices, but that a sum along the normal is in another unit.
        for options, unit in ((['--time', 4], 'm/s'), (['--plane', '1,0,0,0,-3'], 'm/s'),
                              (['--plane', '1,0,0,0,-3', '--thickness', 2, '--slab', 'max'], 'm/s'),
                              (['--plane', '1,0,0,0,-3', '--thickness', 2, '--slab', 'sum'], None)):
            self.bcc4('slice', 'a.bcc4', *options, '-o', 's.nrrd', '--quiet')
            header = Nrrd(self.path('s.nrrd')).fields
            self.assertEqual((header['content'], header.get('sample units')), ('wind speed', unit), options)

    def test_times_of_single_frames(self):
        known = self.known('a.bcc4')
        self.assertEqual(known['times'], self.json('info', 'a.bcc4')['times'])
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'f.%02d.nrrd', '--quiet')
        self.assertEqual(Nrrd(self.path('f.01.nrrd')).keys, {'time': '3.5', 'time unit': 'ms'})
        self.bcc4('import', 'f.*.nrrd', '-o', 'b.bcc4', '--quiet')
        self.assertEqual(self.known('b.bcc4'), known)
        self.assertEqual((known['times']['first'], known['times']['last'], known['times']['unit']), (3, 9, 'ms'))
        # Frames left out or filled in keep theirs; options have the last word, but for the first time.
        self.bcc4('import', 'f.*.nrrd', '--frames', '1-3x2', '-o', 'c.bcc4', '--quiet')
        self.assertEqual(self.json('info', 'c.bcc4')['times']['first'], 3.5)
        self.bcc4('import', 'f.*.nrrd', '--dt', 2, '-o', 'd.bcc4', '--quiet')
        self.assertEqual(self.json('info', 'd.bcc4')['times']['last'], 9)
        # Alone, exported or cut.
        for command in ('export', 'slice'):
            self.bcc4(command, 'a.bcc4', '--time', 4.25, '-o', 'one.nrrd', '--quiet')
            self.bcc4('import', 'one.nrrd', '-o', command + '.bcc4', '--quiet')
            times = self.json('info', command + '.bcc4')['times']
            self.assertEqual((times['count'], times['first'], times['unit']), (1, 4.25, 'ms'))
            os.remove(self.path('one.nrrd'))
        self.bcc4('slice', 'a.bcc4', '--plane', '1,0,0,0,-3', '-o', 'x.nrrd', '--quiet')
        self.assertNotIn('time', Nrrd(self.path('x.nrrd')).keys)


if __name__ == '__main__':
    main()

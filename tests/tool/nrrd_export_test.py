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
        # Frames left out or filled in keep theirs; options have the last word.
        self.bcc4('import', 'f.*.nrrd', '--frames', '1-3x2', '-o', 'c.bcc4', '--quiet')
        self.assertEqual(self.json('info', 'c.bcc4')['times']['first'], 3.5)
        self.bcc4('import', 'f.*.nrrd', '--dt', 2, '-o', 'd.bcc4', '--quiet')
        self.assertEqual(self.json('info', 'd.bcc4')['times']['last'], 6)
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

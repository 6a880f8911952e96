"""bcc4 probe --ray: values along lines, and where they meet a value, the largest value or an opacity."""
import csv
import json
import math
import unittest

from cases_netcdf_test import DIMS, axes, classic
from cases_netcdf_test import field as netcdf_field
from harness import ToolTest, field, has_reader, main

SIDE = 24
FRAMES = 3
# The middle of the ball in samples; it goes two samples along x a frame.
MIDDLE = (8, 11, 12)
RADIUS = math.sqrt(30 * math.log(2))  # where it has half of its peak
# The world is turned, stretched and moved.
AXES = ((0.8, 0.6, 0), (-0.6, 0.8, 0), (0, 0, 2))
ORIGIN = (5, 6, 7)


def ball(x, y, z, t):
    return 100 * math.exp(-((x - MIDDLE[0] - 2 * t) ** 2 + (y - MIDDLE[1]) ** 2 + (z - MIDDLE[2]) ** 2) / 30)


def world(sample):
    return [ORIGIN[a] + sum(sample[i] * AXES[i][a] for i in range(3)) for a in range(3)]


def text(place):
    return ','.join(repr(float(c)) for c in place)


def ray(begin, end):
    return f'{text(begin)}:{text(end)}'


class Ray(ToolTest):
    def setUp(self):
        super().setUp()
        vectors = ' '.join(f'({text(a)})' for a in AXES)
        head = (f'NRRD0004\ntype: float\ndimension: 4\nsizes: {SIDE} {SIDE} {SIDE} {FRAMES}\nspace dimension: 3\n'
                f'space directions: {vectors} none\nspace origin: ({text(ORIGIN)})\nkinds: domain domain domain time\n'
                'endian: little\nencoding: raw\n\n')
        self.write('w.nrrd', head.encode() + field((SIDE, SIDE, SIDE, FRAMES), ball, 'f').tobytes())
        self.bcc4('import', 'w.nrrd', '-o', 'w.bcc4', '--psnr', 90, '--quiet')

    def found(self, *args, name='w.bcc4', expect=0):
        self.bcc4('probe', name, *args, '-o', 'f.csv', '--overwrite', expect=expect)
        with open(self.path('f.csv'), newline='') as f:
            return [{k: float(v) for k, v in row.items() if k != 'date'} for row in csv.DictReader(f)]

    def test_the_first_place_of_a_value_in_every_frame(self):
        # Along x, y and z, and across, from outside of the volume and from its middle outwards.
        ways = [((-9, 11, 12), (30, 11, 12)), ((8, -3, 12), (8, 40, 12)), ((8, 11, 23), (8, 11, 0)),
                ((0, 3, 4), (16, 19, 20)), (MIDDLE, (8, 23, 12))]
        rays = [arg for begin, end in ways for arg in ('--ray', ray(world(begin), world(end)))]
        rows = self.found(*rays, '--first', 50)
        self.assertEqual([(r['time'], r['ray']) for r in rows], [(t, n + 1) for t in range(FRAMES) for n in range(len(ways))])
        met = 0
        for row in rows:
            begin, end = ways[int(row['ray']) - 1]
            centre = (MIDDLE[0] + 2 * row['time'], *MIDDLE[1:])
            along = [b - a for a, b in zip(begin, end)]
            length = math.hypot(*along)
            u = [c / length for c in along]
            towards = sum(c * (m - b) for c, m, b in zip(u, centre, begin))
            aside = sum((m - b) ** 2 for m, b in zip(centre, begin)) - towards ** 2
            if aside > RADIUS ** 2:
                self.assertTrue(math.isnan(row['value']) and math.isnan(row['distance']), row)
                continue
            met += 1
            half = math.sqrt(RADIUS ** 2 - aside)
            place = [b + c * (towards - half if towards - half > 0 else towards + half) for b, c in zip(begin, u)]
            want = world(place)
            self.assertLess(math.dist(want, [row[c] for c in 'xyz']), .3, row)
            self.assertAlmostEqual(row['distance'], math.dist(world(begin), want), delta=.3)
            self.assertAlmostEqual(row['value'], 50, delta=.05)
            # What is off of the place is what the field is off: by some hundredth of the ball's middle.
            met_at = [b + c * row['distance'] * length / math.dist(world(begin), world(end)) for b, c in zip(begin, u)]
            self.assertAlmostEqual(ball(*met_at, row['time']), 50, delta=1.5)
            # The gradient leads to the middle, per unit of the world.
            slope = [50 * (c - p) / 15 for c, p in zip(centre, place)]
            per_world = [sum(slope[i] * AXES[i][a] for i in range(3)) / sum(c * c for c in AXES[0 if a < 2 else 2])
                         for a in range(3)]
            for a, axis in enumerate('xyz'):
                self.assertAlmostEqual(row['gradient_' + axis], per_world[a], delta=1)
        self.assertGreater(met, 10)

    def test_the_largest_value(self):
        rows = self.found('--ray', ray(world((0, 10, 12)), world((23, 10, 12))), '--maximum')
        self.assertEqual(len(rows), FRAMES)
        for row in rows:
            t = row['time']
            self.assertLess(math.dist(world((8 + 2 * t, 10, 12)), [row[c] for c in 'xyz']), .15)
            self.assertAlmostEqual(row['value'], ball(8, 10, 12, 0), delta=1)

    def test_an_opacity_is_reached(self):
        # Of a value that is the same everywhere, a tenth is absorbed in each unit of the world.
        self.volume((16, 16, 16, 1), lambda x, y, z, t: 5, '--air', -1, '--spacing', '0.5,0.5,0.5', '--quiet', name='c.bcc4')
        self.write('tf.json', json.dumps([{'ColorSpace': 'RGB', 'Name': 'even', 'RGBPoints': [0, 1, 1, 1, 10, 1, 1, 1],
                                           'Points': [0, .1, .5, 0, 10, .1, .5, 0], 'ScalarOpacityUnitDistance': 1}]).encode())
        for q in (.2, .5):
            rows = self.found('--ray', '-3,4,4:9,4,4', '--opacity', q, '--tf', 'tf.json', name='c.bcc4')
            self.assertAlmostEqual(rows[0]['distance'], 3 + math.log(1 - q) / math.log(.9), delta=1e-3)
        self.found('--ray', '-3,4,4:9,4,4', '--opacity', .7, '--tf', 'tf.json', name='c.bcc4', expect=1)
        # By the file's look the ball is seen before its middle, and not before it begins.
        row = self.found('--ray', ray(world((0, 11, 12)), world((23, 11, 12))), '--opacity', .3, '--time', 0)[0]
        self.assertGreater(row['value'], 2)
        self.assertGreater(row['distance'], .5)

    def test_values_along_a_ray(self):
        ends = ((2, 11, 12), (14, 11, 12))
        rows = self.found('--ray', ray(*map(world, ends)))
        self.assertEqual(len(rows), 13 * FRAMES)
        for n, row in enumerate(rows):
            x, t = 2 + n % 13, n // 13
            self.assertEqual(row['time'], t)
            self.assertAlmostEqual(row['distance'], n % 13, delta=1e-9)
            self.assertLess(math.dist(world((x, 11, 12)), [row[c] for c in 'xyz']), 1e-9)
            self.assertAlmostEqual(row['value'], ball(x, 11, 12, t), delta=.05)
        self.assertNotIn('gradient_x', rows[0])
        by_samples = self.found('--ray', ray(*ends), '--index', '--samples', 5, '--time', 1)
        self.assertEqual(len(by_samples), 5)
        for n, row in enumerate(by_samples):
            self.assertLess(math.dist(world((2 + 3 * n, 11, 12)), [row[c] for c in 'xyz']), 1e-9)
            self.assertAlmostEqual(row['value'], ball(2 + 3 * n, 11, 12, 1), delta=.05)
        # The same as JSON and as lines.
        args = ('probe', 'w.bcc4', '--ray', ray(*ends), '--index', '--samples', 5, '--time', 1)
        listed = self.json(*args)
        self.assertEqual([p['distance'] for p in listed], [r['distance'] for r in by_samples])
        lines = [line.split('\t') for line in self.bcc4(*args)[0].splitlines()]
        self.assertEqual([float(line[-1]) for line in lines], [r['value'] for r in by_samples])
        # What is outside is not there.
        _, said = self.bcc4('probe', 'w.bcc4', '--index', '--time', 0, '--ray', '-1,5,5:4,5,5', '--samples', 6)
        self.assertIn('1 of 6 values', said)

    def test_what_is_not_met(self):
        out, said = self.bcc4('probe', 'w.bcc4', '--index', '--ray', '0,0,0:0,23,0', '--first', 50, expect=1)
        self.assertIn('3 of 3 rays meet nothing', said)
        self.assertEqual(out.count('nan'), 8 * FRAMES)
        self.assertIsNone(self.json('probe', 'w.bcc4', '--index', '--ray', '40,40,40:50,40,40', '--maximum', expect=1)[0]['value'])
        for args, words in ((('--ray', '1,2,3'), 'X0,Y0,Z0:X1,Y1,Z1'), (('--ray', '1,2,3:1,2,3'), 'ends where it begins'),
                            (('--ray', '1,2:3,4'), '3 numbers'), (('--at', '1,2,3', '--first', 1), 'go with --ray'),
                            (('--ray', '1,2,3:4,5,6', '--at', '1,2,3'), 'excludes'),
                            (('--ray', '1,2,3:4,5,6', '--first', 1, '--maximum'), 'exclude each other'),
                            (('--ray', '1,2,3:4,5,6', '--opacity', 1), 'below 1'),
                            (('--ray', '1,2,3:4,5,6', '--first', 1, '--tf', 'x.json'), 'goes with --opacity'),
                            (('--ray', '1,2,3:4,5,6', '--first', 1, '--samples', 5), 'without --first')):
            self.refused(2, words, 'probe', 'w.bcc4', *args)

    @unittest.skipUnless(has_reader('netcdf'), 'without NetCDF')
    def test_uneven_axes(self):
        depths = [0, 4, 10, 20, 34, 52]
        values = [100 * math.exp(-((d - 20) ** 2) / 800 - (x - 4) ** 2 / 40 - (y - 3) ** 2 / 40) for _ in range(4) for d in depths
                  for y in range(7) for x in range(8)]
        level = ('lev', 'double', ['lev'], {'units': 'm'}, depths)
        self.write('u.nc', classic(axes(lev=level) + [netcdf_field('float', values)]))
        self.bcc4('import', 'u.nc', '-o', 'u.bcc4', '--psnr', 70, '--quiet')
        # From the first depth to the last, through the middle of what is there.
        places = [p['world'] for p in self.json('probe', 'u.bcc4', '--index', '--ray', '4,3,0:4,3,5', '--samples', 6, '--time', 0)]
        self.assertAlmostEqual(math.dist(places[0], places[-1]), depths[-1], delta=1e-6)
        down = ('--ray', ray(places[0], places[-1]))
        row = self.found(*down, '--maximum', name='u.bcc4')[0]
        self.assertAlmostEqual(row['distance'], 20, delta=2.5)  # of samples 6 to 14 apart
        self.assertAlmostEqual(row['value'], 100, delta=2)
        self.assertAlmostEqual(self.found(*down, '--first', 80, name='u.bcc4')[0]['distance'],
                               20 - math.sqrt(-800 * math.log(.8)), delta=1)

    @unittest.skipUnless(has_reader('netcdf'), 'without NetCDF')
    def test_what_is_thin_is_met_from_anywhere(self):
        """One sample of a layer ten metres thick, in an axis whose samples are a kilometre apart elsewhere."""
        depths = [0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 300, 1000, 2000, 3500, 5000]
        sizes = [(name, len(depths) if name == 'lev' else size) for name, size in DIMS]
        values = [100 if d == 60 else 1 for _ in range(4) for d in depths for _ in range(7 * 8)]
        level = ('lev', 'double', ['lev'], {'units': 'm'}, depths)
        self.write('t.nc', classic(axes(lev=level) + [netcdf_field('float', values)], sizes))
        self.bcc4('import', 't.nc', '-o', 't.bcc4', '--lattice', 'cc', '--exact', '--quiet')
        a, b = (p['world'] for p in self.json('probe', 't.bcc4', '--index', '--ray', '3,3,0:3,3,15', '--samples', 2, '--time', 0))
        for begin in range(0, 10, 3):
            a = [*a[:2], b[2] / 5000 * begin]
            met = self.found('--ray', ray(a, b), '--first', 50, name='t.bcc4')[0]
            self.assertAlmostEqual(met['distance'] + begin, 55, delta=5, msg=str(begin))


if __name__ == '__main__':
    main()

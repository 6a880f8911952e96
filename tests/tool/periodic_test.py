"""Series whose last frame leads to the first, and axes whose last sample does: told by a dry run, written, told of, and
cut between last and first."""
import array
import math
import os

from harness import Nrrd, ToolTest, main

FIXED = ('--lattice', 'd4star', '--exact', '--faces', 'mirror')
DIMS = (22, 20, 14, 12)


def wave(x, y, z, t):
    """Goes round once in the series."""
    return 100 + 50 * math.cos(.3 * x + .2 * y - .25 * z - 2 * math.pi * t / DIMS[3])


def drift(x, y, z, t):
    """Goes on."""
    return 100 + 50 * math.cos(.3 * x + .2 * y - .25 * z - .11 * t)


def noise(x, y, z, t):
    """As far from the first frame as from any other."""
    return (12345 * (x + 31 * y + 977 * z + 7919 * t) ** 2 // 64) % 1009


ROUND = (32, 18, 12, 6)


def longitude(x, y, z, t):
    """Goes round along x."""
    turn = 2 * math.pi * x / ROUND[0]
    return 100 + 50 * math.cos(turn + .1 * y) + 20 * math.sin(3 * turn - .2 * z + .3 * t)


def region(x, y, z, t):
    """A part of the world."""
    return 100 + 50 * math.cos(.11 * x + .1 * y) + 20 * math.sin(.23 * x - .2 * z + .3 * t)


def island(x, y, z, t):
    """Nothing but air at the faces."""
    return 200 * math.exp(-((x - 15) ** 2 + (y - 9) ** 2) / 12)


class PeriodicAxisTest(ToolTest):
    def test_a_dry_run_tells(self):
        for field, told in (longitude, ['x']), (region, []), (island, []), (noise, []):
            args = self.raw('a.raw', ROUND, field)
            found = self.json('import', *args, '--dry-run', '-o', 'v.bcc4', *FIXED)['round']
            self.assertEqual([a for a in found if found[a]['periodic']], told, field)
            text = self.bcc4('import', *args, '--dry-run', '-o', 'v.bcc4', *FIXED)[0]
            self.assertEqual('--periodic x' in text, bool(told), field)
        args = self.raw('a.raw', ROUND, longitude)
        known = self.json('import', *args, '--dry-run', '-o', 'v.bcc4', *FIXED, '--periodic', 'x')
        self.assertNotIn('round', known, 'who knows needs no advice')

    def rmse(self, name, first, last):
        """Of samples first .. last along x at the frames."""
        squares, count = 0, 0
        for index in 1, 2.5:
            self.json('slice', name, '--time', index, '--index', '-o', 's.nrrd')
            cut = Nrrd(self.path('s.nrrd'))
            os.remove(self.path('s.nrrd'))
            nx, ny, nz = cut.sizes[-3:]
            self.assertGreaterEqual(nx, ROUND[0])
            for z in range(3, nz - 3):
                for y in range(3, ny - 3):
                    for x in range(first, last + 1):
                        squares += (cut.values[(z * ny + y) * nx + x] - longitude(x, y, z, index)) ** 2
                        count += 1
        return math.sqrt(squares / count)

    def test_the_seam(self):
        args = self.raw('a.raw', ROUND, longitude)
        for more in ((), ('--levels', '1')):
            self.json('import', *args, '-o', 'v.bcc4', '--overwrite', '--periodic', 'x', *FIXED, *more)
            info = self.json('info', 'v.bcc4')
            self.assertEqual(info['periodic_axes'], 'x')
            self.assertIn('periodic along x', self.bcc4('info', 'v.bcc4')[0])
            self.assertEqual(self.json('verify', 'v.bcc4')['chunks_damaged'], 0)
            inside = self.rmse('v.bcc4', 12, 20)
            self.assertLess(self.rmse('v.bcc4', 0, 1), 1.3 * inside + .05, more)
            self.assertLess(self.rmse('v.bcc4', 30, 31), 1.3 * inside + .05, more)
        # The source's own samples: the slice has sample 0 once more behind the last one.
        self.json('import', *args, '-o', 'e.bcc4', '--periodic', 'x', '--lattice', 'cc', '--exact')
        self.assertLess(self.json('verify', 'e.bcc4', '--against', 'a.raw')['max_abs'], 1e-3)
        self.bcc4('export', 'e.bcc4', '--all', '--format', 'raw', '-o', 'e.raw')
        values = []
        for name in 'e.raw', 'a.raw':
            with open(self.path(name), 'rb') as f:
                values.append(array.array('f', f.read()))
        exported, source = values
        self.assertEqual(len(exported), len(source))
        self.assertLess(max(abs(a - b) for a, b in zip(exported, source)), 1e-3)
        self.bcc4('slice', 'v.bcc4', '--plane', '1,0,0,0,-31.6', '-o', 'x.nrrd')
        self.bcc4('render', 'v.bcc4', '--time', '2', '--index', '--size', '64x48', '-o', 'v.png')
        self.json('import', *args, '-o', 'm.bcc4', *FIXED)
        self.assertEqual(self.json('info', 'm.bcc4')['periodic_axes'], '')

    def test_a_place_that_is_there_twice(self):
        """From 0 to 360 degrees the last sample is the first."""
        head = 'NRRD0005\ntype: float\ndimension: 3\nsizes: {} 4 3\nspacings: {} 1 1\nunits: "degrees" "degrees" "degrees"\nendian: little\nencoding: raw\n\n'
        for samples, last in ((13, 360), (12, 330)):
            values = array.array('f', (math.cos(math.pi * x / 6) + y for _ in range(3) for y in range(4) for x in range(samples)))
            self.write(f'{samples}.nrrd', head.format(samples, last / (samples - 1)).encode() + values.tobytes())
        self.refused(2, 'the last sample along x is 360 degrees from the first, and so the first once more: leave it out of the files (ncks -d '
                     'lon,0,11), or leave out --periodic', 'import', '13.nrrd', '--periodic', 'x', '-o', 'a.bcc4', output='a.bcc4')
        self.bcc4('import', '12.nrrd', '--periodic', 'x', '-o', 'a.bcc4')
        self.bcc4('import', '13.nrrd', '-o', 'b.bcc4')

    def test_parts_and_appended_files_are_the_same(self):
        args = self.raw('a.raw', ROUND, longitude)
        more = ('--periodic', 'x', *FIXED)
        self.json('import', *args, '-o', 'whole.bcc4', *more)
        self.json('import', *args, '--dry-run', '--plan', 'plan.json', *more)
        for part in 1, 2:
            self.json('import', '--plan', 'plan.json', '--part', f'{part}/2', '-o', f'p{part}.bcc4')
        self.json('concat', 'p1.bcc4', 'p2.bcc4', '-o', 'joined.bcc4')
        first = self.raw('f.raw', (*ROUND[:3], 4), longitude)
        self.json('import', *first, '-o', 'grown.bcc4', *more)
        self.json('import', *args, '-o', 'grown.bcc4', '--append', *more)
        for other in 'joined.bcc4', 'grown.bcc4':
            for index in 0, 2.5, 5:
                cuts = []
                for name in 'whole.bcc4', other:
                    self.json('slice', name, '--time', index, '--index', '-o', 's.nrrd')
                    cuts.append(Nrrd(self.path('s.nrrd')).values)
                    os.remove(self.path('s.nrrd'))
                self.assertEqual(*cuts, (other, index))

    def test_what_cannot_be(self):
        args = self.raw('a.raw', ROUND, longitude)
        self.refused(2, 'faces', 'import', *args, '-o', 'v.bcc4', '--periodic', 'x', '--lattice', 'd4star', '--exact',
                     '--faces', 'x')
        self.refused(2, 'periodic', 'import', *self.raw('c.raw', (9, 9, 1, 4), wave), '-o', 'w.bcc4', '--periodic', 'z',
                     *FIXED)


class PeriodicTest(ToolTest):
    def turn(self, args, *more):
        return self.json('import', *args, '--dry-run', '-o', 'v.bcc4', *FIXED, *more).get('turn')

    def test_a_dry_run_tells(self):
        args = self.raw('a.raw', DIMS, wave)
        turn = self.turn(args)
        self.assertTrue(turn['periodic'])
        self.assertLess(turn['last_to_first'], 1.25 * turn['to_next'])
        self.assertIn('--ends periodic', self.bcc4('import', *args, '--dry-run', '-o', 'v.bcc4', *FIXED)[0])
        self.assertIsNone(self.turn(args, '--ends', 'periodic'), 'who knows needs no advice')
        for other in drift, noise:
            args = self.raw('b.raw', DIMS, other)
            self.assertFalse(self.turn(args)['periodic'], other)
            self.assertNotIn('--ends periodic',
                             self.bcc4('import', *args, '--dry-run', '-o', 'v.bcc4', *FIXED)[0])
        self.assertIsNone(self.turn(self.raw('c.raw', (9, 9, 9, 4), wave)), 'too short to tell')

    def rmse(self, name, index):
        self.json('slice', name, '--time', index, '--index', '-o', 's.nrrd')
        cut = Nrrd(self.path('s.nrrd'))
        os.remove(self.path('s.nrrd'))
        nx, ny, nz = cut.sizes[-3:]
        squares, count = 0, 0
        for z in range(3, nz - 3):
            for y in range(3, ny - 3):
                for x in range(3, nx - 3):
                    squares += (cut.values[(z * ny + y) * nx + x] - wave(x, y, z, index)) ** 2
                    count += 1
        return math.sqrt(squares / count)

    def test_between_last_and_first(self):
        args = self.raw('a.raw', DIMS, wave)
        for more in ((), ('--lattice', 'cc')):
            fixed = [o for o in FIXED if more[:1] != ('--lattice',) or o not in ('--lattice', 'd4star')]
            self.json('import', *args, '-o', 'v.bcc4', '--overwrite', '--ends', 'periodic', *fixed, *more)
            info = self.json('info', 'v.bcc4')
            self.assertTrue(info['times']['periodic'])
            self.assertEqual((info['times']['last'], info['times']['end']), (DIMS[3] - 1, DIMS[3]))
            self.assertIn('periodic: 12 is the first frame again', self.bcc4('info', 'v.bcc4')[0])
            self.assertEqual(self.json('verify', 'v.bcc4')['chunks_damaged'], 0)
            inside = self.rmse('v.bcc4', 5.5)
            for index in (11.25, 11.5, 11.9, 0, 0.5, 12):
                self.assertLess(self.rmse('v.bcc4', index), 1.3 * inside + .05, (more, index))
        self.refused(2, '12', 'slice', 'v.bcc4', '--time', 12.5, '--index', '-o', 't.nrrd')
        self.json('import', *args, '-o', 'v.bcc4', '--overwrite', '--ends', 'periodic', '--dt', .5, *FIXED)
        pictures = {}
        for time in 0, 6:  # the same moment, whose trail goes round
            for trail in '.5', '1f', None:
                self.bcc4('render', 'v.bcc4', '--time', time, *(['--trail', trail] if trail else []), '--size', '40x40', '-o', 'p.png', '--quiet')
                pictures[time, trail] = self.read('p.png')
        self.assertEqual(pictures[0, '.5'], pictures[0, '1f'])
        self.assertEqual(pictures[6, '.5'], pictures[6, '1f'])
        self.assertNotEqual(pictures[0, '.5'], pictures[0, None])
        self.json('import', *args, '-o', 'm.bcc4', '--ends', 'mirror', *FIXED)
        self.assertFalse(self.json('info', 'm.bcc4')['times']['periodic'])
        self.assertGreater(self.rmse('m.bcc4', 0.5), 8 * inside)

    def test_what_cannot_be(self):
        args = self.raw('a.raw', DIMS, wave)
        more = ('--ends', 'periodic', *FIXED)
        self.json('import', *args, '-o', 'v.bcc4', *more)
        size = os.path.getsize(self.path('v.bcc4'))
        longer = self.raw('b.raw', (*DIMS[:3], 14), wave)
        self.refused(2, 'periodic', 'import', *longer, '-o', 'v.bcc4', '--append', *FIXED)
        self.json('import', *args, '--dry-run', '--plan', 'plan.json', *more)
        self.refused(2, 'parts', 'import', '--plan', 'plan.json', '--part', '1/2', '-o', 'p.bcc4')
        self.assertEqual(os.path.getsize(self.path('v.bcc4')), size)
        self.refused(2, 'periodic', 'import', *self.raw('c.raw', (9, 9, 9, 1), wave), '-o', 'w.bcc4', *more)


if __name__ == '__main__':
    main()

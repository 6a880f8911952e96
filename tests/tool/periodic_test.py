"""Series whose last frame leads to the first: told by a dry run, written, told of, and cut between last and first."""
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
            self.assertNotIn('periodic', self.bcc4('import', *args, '--dry-run', '-o', 'v.bcc4', *FIXED)[0])
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
        for more in ((), ('--store', 'coefficients'), ('--lattice', 'cc')):
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

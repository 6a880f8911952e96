"""A sea with a coast, and ice that comes and goes: of the source's samples none of the sea is lost and no land invented,
whatever the lattice's distance, and whatever way the file was made."""
import array
import math
import os

from harness import DATA, Nrrd, ToolTest, main

DIMS = (48, 32, 8, 6)
NAN = math.nan


def land(x, y, z):
    coast = 15 + 5 * math.sin(y / 4) + 3 * math.sin(1.3 * y) + 1.5 * z
    island = math.hypot(x - 36, y - 20) < 3.2 + .4 * z
    return x < coast or island or (x, y) == (44, 5)


def ice(x, y, z, t):
    return z == 7 and y < 5 + 3 * math.sin(math.pi * t / 3 + x / 8)


def temperature(x, y, z, t):
    return 12 + 6 * math.sin(x / 9 + .2 * t) * math.cos(y / 11) + 1.2 * z + .5 * math.sin(.8 * x + y)


def still_coast(x, y, z, t):
    return NAN if land(x, y, z) else temperature(x, y, z, t)


def icy_coast(x, y, z, t):
    return NAN if land(x, y, z) or ice(x, y, z, t) else temperature(x, y, z, t)


HOLE = ('--on-nonfinite', 'hole', '--quiet')
STORES = (['--scale', 1], ['--scale', 1.3], ['--scale', 1.3, '--time-scale', 1.3], ['--lowpass'], ['--lattice', 'cc'],
          ['--quantize', 'u8'], [])


class Coast(ToolTest):
    def frames(self, name, dims, *more):
        """All exported frames, one after the other."""
        values = array.array('f')
        for t in range(dims[3]):
            self.bcc4('export', name, '--index', '--time', t, '-o', 'f.nrrd', '--overwrite', '--quiet', *more)
            values += array.array('f', Nrrd(self.path('f.nrrd')).values)
        return values

    def assert_same_missing(self, name, source, dims=DIMS):
        values = self.frames(name, dims)
        self.assertEqual(len(values), len(source))
        lost = sum(v != v and s == s for v, s in zip(values, source))
        invented = sum(v == v and s != s for v, s in zip(values, source))
        self.assertEqual((lost, invented), (0, 0), 'sea lost, land invented')
        return values

    def source(self, name, code='f'):
        return array.array(code, self.read(name))

    def test_no_sea_is_lost_and_no_land_invented(self):
        for f in (still_coast, icy_coast):
            args = self.raw('sea.raw', DIMS, f)
            source = self.source('sea.raw')
            for more in STORES:
                with self.subTest(f=f.__name__, more=more):
                    self.bcc4('import', *args, '-o', 'v.bcc4', *HOLE, *more, '--overwrite')
                    values = self.assert_same_missing('v.bcc4', source)
                    # What fills the land pulls the sea beside it nowhere.
                    worst = max(abs(a - b) for a, b in zip(values, source) if b == b)
                    self.assertLess(worst, 2.5)
                    info = self.json('info', 'v.bcc4')
                    self.assertTrue(info['holes'])
                    self.assertEqual(info['channels'][0]['holes'], 0)
                    self.assertEqual(info['channels'][0]['missing'], sum(s != s for s in source))
                    verified = self.json('verify', 'v.bcc4', '--against', 'sea.raw', *args[1:])
                    self.assertEqual(verified['holes']['file'], 0)

    def test_frames_that_miss_the_same_share_a_mask(self):
        def index_bytes(f, name):
            self.bcc4('import', *self.raw('sea.raw', DIMS, f), '-o', name, *HOLE, '--overwrite')
            return self.json('info', name)['bytes']['index']
        full, still, icy = (index_bytes(f, f.__name__) for f in (temperature, still_coast, icy_coast))
        mask = still - full
        self.assertGreater(mask, 100)
        self.assertGreater(icy - full, 4 * mask)
        self.assertIn(' samples missing (', self.bcc4('info', 'still_coast')[0])

    def test_land_far_from_the_sea_is_not_kept(self):
        dims = (96, 32, 8, 4)
        kept = {}
        for width in (40, 80):
            self.bcc4('import', *self.raw('sea.raw', dims, lambda x, y, z, t, w=width: NAN if x < w else temperature(x, y, z, t)),
                      '-o', 'v.bcc4', *HOLE, '--overwrite', '--air', 0, '--air-threshold', 0)
            info = self.json('info', 'v.bcc4')
            kept[width] = info['sites_kept'] / info['sites_total']
            self.assert_same_missing('v.bcc4', self.source('sea.raw'), dims)
        # The rows of samples of the sea, and as far beside them as kernels reach.
        self.assertLess(kept[80], (96 - 80 + 16) / 96)
        self.assertLess(kept[40], (96 - 40 + 16) / 96)

    def test_slices_and_pictures_of_land_alone_show_nothing(self):
        args = self.raw('land.raw', DIMS, lambda *_: NAN)
        self.bcc4('import', *args, '-o', 'v.bcc4', *HOLE)
        self.assert_same_missing('v.bcc4', self.source('land.raw'))
        self.assertIn('no value', self.bcc4('slice', 'v.bcc4', '--plane', '1,0,0,0,-7', '-o', 's.nrrd')[0])

    def test_axis_slices(self):
        args = self.raw('sea.raw', DIMS, icy_coast)
        for more in ([], ['--scale', 1.3]):
            self.bcc4('import', *args, '-o', 'v.bcc4', *HOLE, *more, '--overwrite')
            for axis, at in (('x', 20), ('y', 4), ('z', 7)):
                normal = ','.join('1' if a == axis else '0' for a in 'xyzt')
                self.bcc4('slice', 'v.bcc4', '--plane', f'{normal},{-at}', '-o', 's.nrrd')
                s = Nrrd(self.path('s.nrrd'))
                others = [n for a, n in zip('xyzt', DIMS) if a != axis]
                self.assertEqual(s.sizes, others)
                for i, v in enumerate(s.values):
                    p = [i % others[0], i // others[0] % others[1], i // (others[0] * others[1])]
                    p.insert('xyz'.index(axis), at)
                    self.assertEqual(v != v, math.isnan(icy_coast(*p)), (axis, p))

    def test_parts_keep_the_masks(self):
        dims = (20, 14, 6, 30)

        def f(x, y, z, t):
            missing = x < 6 or (z == 5 and y < 3 + t % 4) or t == 11
            return NAN if missing else temperature(x, y, z, t)
        args = self.raw('sea.raw', dims, f)
        source = self.source('sea.raw')
        self.bcc4('import', *args, '-o', 'whole.bcc4', *HOLE)
        whole = self.read('whole.bcc4')
        self.assert_same_missing('whole.bcc4', source, dims)
        self.bcc4('verify', 'whole.bcc4')
        self.bcc4('import', *args, *HOLE[:2], '--dry-run', '--plan', 'plan.json')
        for part in (1, 2, 3):
            self.bcc4('import', '--plan', 'plan.json', '--part', f'{part}/3', '-o', f'p{part}.bcc4', '--quiet')
        self.bcc4('concat', 'p3.bcc4', 'p1.bcc4', 'p2.bcc4', '-o', 'joined.bcc4', '--quiet')
        self.assertEqual(self.read('joined.bcc4'), whole, 'joined')

    def test_a_damaged_mask(self):
        args = self.raw('sea.raw', DIMS, icy_coast)
        self.bcc4('import', *args, '-o', 'v.bcc4', *HOLE)
        whole = self.read('v.bcc4')
        before = self.frames('v.bcc4', DIMS)
        # Masks come before all else: that of frame 0 is the first block.
        self.write('v.bcc4', whole[:192 + 40] + bytes([whole[192 + 40] ^ 16]) + whole[192 + 41:])
        _, err = self.bcc4('verify', 'v.bcc4', expect=1)
        self.assertIn('mask at offset 192: bad checksum; lost: which samples of channel value are missing, from frame 0', err)
        _, err = self.bcc4('export', 'v.bcc4', '--index', '--time', 0, '-o', 'no.nrrd', expect=3)
        self.assertIn('bad checksum', err)
        # The mask of the nearest frame takes its place; the sea of all others is as it was.
        after = self.frames('v.bcc4', DIMS, '--salvage')
        n = DIMS[0] * DIMS[1] * DIMS[2]
        self.assertEqual(after[n:].tobytes(), before[n:].tobytes())
        self.assertEqual([v != v for v in after[:n]], [v != v for v in before[n:2 * n]])

    def test_static_volumes(self):
        name = os.path.join(DATA, 'nan_17x21x3_f32be.nii')
        if not os.path.exists(name):
            self.skipTest('no real data')
        with open(name, 'rb') as f:
            source = array.array('f', f.read()[352:])
        source.byteswap()
        self.assertGreater(sum(s != s for s in source), 0)
        for more in ([], ['--scale', 1.3], ['--lattice', 'cc']):
            self.bcc4('import', name, '-o', 'v.bcc4', *HOLE, *more, '--overwrite')
            self.assert_same_missing('v.bcc4', source, (17, 21, 3, 1))


if __name__ == '__main__':
    main()

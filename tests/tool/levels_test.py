"""Coarser levels of a file: written, told of, cut and drawn, by whatever way a file is made."""
import json
import math
import os

from harness import ToolTest, main

FIXED = ('--lattice', 'd4star', '--exact')


def waves(x, y, z, t):
    return 50 * math.cos(.3 * x + .2 * y - .25 * z) * math.cos(.4 * t) + 20 * math.sin(.3 * y + .3 * t)


class LevelsTest(ToolTest):
    store = 'samples'

    def without_sources(self, name):
        """What a file says but for the names of its source files, which are not the same here."""
        info = {k: v for k, v in self.json('info', name).items() if k not in ('sources', 'bytes')}
        for level in info['levels']:
            del level['relative_rmse']  # of a series that grew: of its first frames
        return info

    def test_planes_and_rows(self):
        """Axes of one sample have no coarser ones."""
        for lattice in ('d4star', 'cc'):
            for dims in ((1, 24, 46, 5), (24, 1, 46, 5), (46, 24, 1, 5), (1, 1, 46, 5), (46, 24, 1, 1)):
                self.bcc4('import', *self.raw('a.raw', dims, waves), '-o', 'v.bcc4', '--overwrite', '--quiet', '--levels', 2, '--exact',
                          *(() if dims[3] == 1 else ('--lattice', lattice)))
                self.assertEqual(len(self.json('info', 'v.bcc4')['levels']), 2)
                self.assertLess(self.json('verify', 'v.bcc4', '--against', 'a.raw')['max_abs'], 14, dims)
                self.bcc4('slice', 'v.bcc4', '--index', '--time', 0, '--level', 1, '-o', 's.nrrd')

    def test_info_slice_and_render(self):
        args = self.raw('a.raw', (40, 30, 26, 5), waves)
        self.json('import', *args, '-o', 'none.bcc4', *FIXED)
        self.assertEqual(self.json('info', 'none.bcc4')['levels'], [])
        self.json('import', *args, '-o', 'v.bcc4', '--levels', 2, *FIXED)
        info = self.json('info', 'v.bcc4')
        sites = info['sites_total']
        for level in info['levels']:
            self.assertLess(4 * level['sites_total'], sites)
            self.assertGreater(level['bytes'], 1000)
            sites = level['sites_total']
        self.assertEqual(len(info['levels']), 2)
        self.assertIn('2: distances 3.', self.bcc4('info', 'v.bcc4')[0])
        self.assertLess(os.path.getsize(self.path('v.bcc4')), 1.35 * os.path.getsize(self.path('none.bcc4')))
        cuts = [self.json('slice', 'v.bcc4', '--time', 2, '--index', '-o', f's{level}.nrrd', '--level', level)
                for level in range(3)]
        self.assertEqual([c['level'] for c in cuts], [0, 1, 2])
        for fine, coarse in zip(cuts, cuts[1:]):
            self.assertLess(4 * coarse['points'], fine['points'])
            self.assertEqual(coarse['dims'], fine['dims'])
            self.assertLess(coarse['bytes_read'], fine['bytes_read'])
        self.bcc4('render', 'v.bcc4', '--time', 2, '--index', '-o', 'p.png', '--size', '32x32', '--level', 1,
                  '--stats', 'stats.json')
        with open(self.path('stats.json')) as f:
            self.assertEqual(json.load(f)['level'], 1)
        self.refused(2, 'level 3 of a file whose last one is 2', 'slice', 'v.bcc4', '--time', 2, '--index', '-o', 's.nrrd',
                     '--level', 3)
        self.assertEqual(self.json('verify', 'v.bcc4')['chunks_damaged'], 0)

    def drawn(self, *options):
        """What the statistics of a picture say."""
        self.bcc4('render', 'v.bcc4', '--time', 2, '--index', '-o', 'p.png', '--stats', 'stats.json', '--fit', 'domain', *options)
        with open(self.path('stats.json')) as f:
            return json.load(f)

    def test_pictures_take_the_level_that_is_enough(self):
        args = self.raw('a.raw', (64, 60, 56, 5), waves)
        self.json('import', *args, '-o', 'v.bcc4', '--levels', 2, *FIXED)
        for size, quality, level in ((300, 'normal', 0), (40, 'normal', 1), (20, 'normal', 2), (40, 'fine', 0)):
            stats = self.drawn('--size', f'{size}x{size}', '--quality', quality)
            self.assertEqual(stats['level'], level, (size, quality))
        self.assertEqual(self.drawn('--size', '40x40', '--level', 0)['level'], 0)
        self.assertEqual(self.drawn('--size', '40x40', '--mode', 'mip')['level'], 0)

    def test_rounding_of_the_source_hides_no_level(self):
        """Codes of a small range, which any level is off by a few thousandths from; by no options but the levels."""
        args = self.raw('a.raw', (64, 60, 56, 4), lambda x, y, z, t: 120 + waves(x / 4, y / 4, z / 4, t / 4), 'u8')
        self.json('import', *args, '-o', 'v.bcc4', '--levels', 2)
        self.assertGreater(self.json('info', 'v.bcc4')['levels'][0]['relative_rmse'], .002)
        for size, quality, level in ((120, 'draft', 1), (100, 'normal', 1), (100, 'fine', 0)):
            stats = self.drawn('--size', f'{size}x{size}', '--quality', quality)
            self.assertEqual(stats['level'], level, (size, quality))

    def test_pictures_take_the_part_that_is_seen(self):
        args = self.raw('a.raw', (160, 24, 20, 3), waves)
        self.json('import', *args, '-o', 'v.bcc4', '--levels', 1, *FIXED)
        zoomed = ('--size', '200x200', '--view', 'front', '--zoom', 8)
        whole, part = (self.drawn(*zoomed, *o) for o in (('--level', 0), ()))
        self.assertEqual(part['level'], 0)
        self.assertLess(2 * part['points']['total'], whole['points']['total'])

    def test_how_many(self):
        args = self.raw('a.raw', (100, 98, 96, 2), lambda x, y, z, t: x % 7)
        for asked, count in (('auto', 0), ('none', 0), (3, 3)):
            self.json('import', *args, '-o', 'v.bcc4', '--overwrite', '--levels', asked, *FIXED)
            self.assertEqual(len(self.json('info', 'v.bcc4')['levels']), count, asked)
        self.refused(2, 'a number is expected', 'import', *args, '-o', 'w.bcc4', '--levels', 'some')
        self.refused(2, '16', 'import', *args, '-o', 'w.bcc4', '--levels', 16, *FIXED)

    def large(self, name, row, frames=2):
        """A series of 200 x 192 x 190 bytes whose rows are a row of numbers, moved from one to the next."""
        nx, ny, nz = 200, 192, 190
        rows = [bytes(int(row(x + move)) for x in range(nx)) for move in range(64)]
        plane = [b''.join(rows[(y + z) % 64] for y in range(ny)) for z in range(64)]
        self.write(name, b''.join(plane[(z + t) % 64] for t in range(frames) for z in range(nz)))
        return name, '--dims', f'{nx},{ny},{nz},{frames}', '--dtype', 'u8'

    def test_large_data_have_them_unasked(self):
        args = self.large('a.raw', lambda x: 128 + 60 * math.cos(math.pi * x / 32), 3)
        self.assertIn('2 coarser ones, at 2 to 4 times the distance, for small pictures (--levels none: without)',
                      self.bcc4('import', *args, '--dry-run', *FIXED)[0])
        plan = self.json('import', *args, '-o', 'v.bcc4', *FIXED)['plan']
        self.assertEqual(plan['levels'], 2)
        for level in self.json('info', 'v.bcc4')['levels']:
            self.assertLess(level['relative_rmse'], .02)
        self.assertGreater(self.drawn('--size', '48x48')['level'], 0)
        self.json('import', *args, '-o', 'none.bcc4', '--levels', 'none', *FIXED)
        self.assertEqual(self.json('info', 'none.bcc4')['levels'], [])
        # Who appends keeps what the file has.
        more = self.large('b.raw', lambda x: 128 + 60 * math.cos(math.pi * x / 32), 4)
        for name, count in (('none.bcc4', 0), ('v.bcc4', 2)):
            plan = self.json('import', *more, '-o', name, '--append', *FIXED)['plan']
            self.assertEqual((plan['levels'], len(self.json('info', name)['levels'])), (count, count))

    def test_labels_have_none_unasked(self):
        args = self.large('a.raw', lambda x: (0, 7, 2, 5)[x // 16 % 4])
        for lattice in (), FIXED:
            said = self.bcc4('import', *args, '-o', 'v.bcc4', '--overwrite', *lattice)[0]
            self.assertIn('none: labels have no means', said)
            self.assertEqual(self.json('info', 'v.bcc4')['levels'], [])
        self.json('import', *args, '-o', 'v.bcc4', '--overwrite', '--levels', 'auto', *FIXED)
        self.assertEqual(self.json('info', 'v.bcc4')['levels'], [])
        self.json('import', *args, '-o', 'v.bcc4', '--overwrite', '--levels', 1, *FIXED)
        self.assertEqual(len(self.json('info', 'v.bcc4')['levels']), 1)

    def test_parts_and_append_give_the_same_bytes(self):
        whole = self.raw('a.raw', (26, 24, 22, 24), waves)
        first = self.raw('b.raw', (26, 24, 22, 18), waves)
        more = ('--levels', 2, '--ends', 'mirror', '--faces', 'mirror', '--air', 0, *FIXED)
        self.json('import', *whole, '-o', 'v.bcc4', *more)
        self.json('import', *whole, '--dry-run', '--plan', 'plan.json', *more)
        for part in (1, 2):
            self.json('import', '--plan', 'plan.json', '--part', f'{part}/2', '-o', f'p{part}.bcc4')
        self.bcc4('concat', 'p1.bcc4', 'p2.bcc4', '-o', 'joined.bcc4')
        self.assertEqual(self.read('joined.bcc4'), self.read('v.bcc4'))
        self.json('import', *first, '-o', 'grown.bcc4', *more)
        self.json('import', *whole, '-o', 'grown.bcc4', '--append', *(o for o in more if o not in ('--levels', 2)))
        self.assertEqual(len(self.json('info', 'grown.bcc4')['levels']), 2)
        self.assertEqual(self.json('verify', 'grown.bcc4')['chunks_damaged'], 0)
        self.json('import', *whole, '-o', 'v.bcc4', '--overwrite', *more)
        self.assertEqual(*(self.without_sources(n) for n in ('grown.bcc4', 'v.bcc4')))


if __name__ == '__main__':
    main()

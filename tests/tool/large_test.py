"""A series of 512^3 samples a frame: imported within a memory limit, checked, cut and drawn. In long runs only."""
import math
import sys

from harness import LONG, Nrrd, ToolTest, main, read_png

N, FRAMES = 512, 4
LEVELS = 200


def along(x, t):
    """0 to 255: waves that move along x, air at both ends."""
    r = abs(x - N / 2 - 6 * t) / (.33 * N)
    return 0 if r > 1 else round((1 - r ** 4) * (170 + 80 * math.sin(.11 * x + .5 * t)))


def across(y, z):
    """0 to LEVELS, in y and z."""
    r = math.hypot(y - N / 2, z - N / 2) / (.36 * N)
    return 0 if r > 1 else round(LEVELS * (1 - r ** 2) * (.8 + .2 * math.sin(.13 * y) * math.cos(.09 * z)))


def value(x, y, z, t):
    return along(x, t) * across(y, z) // LEVELS


class Large(ToolTest):
    def setUp(self):
        super().setUp()
        tables = [bytes(v * level // LEVELS for v in range(256)) for level in range(LEVELS + 1)]
        levels = [[across(y, z) for y in range(N)] for z in range(N)]
        with open(self.path('a.raw'), 'wb') as f:
            for t in range(FRAMES):
                row = bytes(along(x, t) for x in range(N))
                rows = [row.translate(table) for table in tables]
                for plane in levels:
                    f.write(b''.join(rows[level] for level in plane))

    def test_import_verify_slice_render(self):
        series = ('a.raw', '--dims', f'{N},{N},{N},{FRAMES}', '--dtype', 'u8')
        report = self.json('import', *series, '-o', 'a.bcc4', '--max-mem', '8G')
        self.assertLess(report['bytes']['file'], N ** 3 * FRAMES / 2)
        verified = self.json('verify', 'a.bcc4', '--against', 'a.raw', '--frames', '0-3')
        self.assertGreater(verified['psnr'], 55)
        self.bcc4('slice', 'a.bcc4', '--index', '--time', 1, '-o', 't.nrrd', '--quiet')
        got = Nrrd(self.path('t.nrrd')).values
        off = [abs(got[(z * N + y) * N + x] - value(x, y, z, 1)) for z in range(100, 412, 13) for y in range(100, 412, 11)
               for x in range(140, 372, 7)]
        self.assertLess(sum(off) / len(off), .5)
        self.bcc4('slice', 'a.bcc4', '--plane', f'1,0,0,0,{-N // 2}', '-o', 'x.nrrd', '--quiet')
        self.assertEqual(Nrrd(self.path('x.nrrd')).sizes, [N, N, FRAMES])
        self.bcc4('render', 'a.bcc4', '--index', '--time', 1.5, '--size', '512x512', '-o', 'p.png', '--quiet')
        rows = read_png(self.path('p.png'))
        self.assertGreater(rows[256][256][3], 200)
        self.assertEqual(rows[8][8][3], 0)


if __name__ == '__main__':
    if not LONG:
        print('SKIPPED: BCCSPLAT_LONG is not set')
        sys.exit(77)
    main()

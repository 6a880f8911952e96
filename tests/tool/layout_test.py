"""bcc4 render --layout: planes through a moment, a sheet of them with the volume, maps that lie flat, and the moment that is
drawn where nobody chooses one."""
import itertools
import math
import os
import random
import re
import unittest

from harness import DATA, ToolTest, has_reader, main, png_size, read_png

DIMS = (13, 17, 21)
STEPS = (2.0, 1.5, 1.0)  # to the left, front and head
SPAN = [n * step for n, step in zip(DIMS, STEPS)]


def tissue(x, y, z):
    """Bytes by place of the patient: right to left, back to front, feet to head."""
    inside = math.dist((x / 12, y / 16, z / 20), (.5, .5, .5)) < .45
    return (40 + 9 * x + 4 * y + 2 * z) % 200 if inside else 0


class Layout(ToolTest):
    def scan(self, name='s', order=(0, 1, 2), flips=(0, 0, 0), lps=False, offset=0):
        """The patient, stored with his axes in some order and direction, imported as it is."""
        signs = (-1, 1, 1) if not lps else (1, -1, 1)  # of x, y, z of the world, towards left, front, head
        directions = []
        for axis in order:
            vector = [0, 0, 0]
            vector[axis] = signs[axis] * STEPS[axis] * (-1 if flips[axis] else 1)
            directions.append('({},{},{})'.format(*vector))
        origin = [signs[a] * STEPS[a] * (DIMS[a] - 1 if flips[a] else 0) + offset for a in range(3)]
        head = (f'NRRD0005\ntype: uint8\ndimension: 3\nspace: {"left-posterior-superior" if lps else "right-anterior-superior"}\n'
                f'sizes: {" ".join(str(DIMS[a]) for a in order)}\nspace directions: {" ".join(directions)}\n'
                f'space origin: ({origin[0]},{origin[1]},{origin[2]})\nspace units: "mm" "mm" "mm"\nencoding: raw\n\n')
        def at(place):
            real = [0, 0, 0]
            for axis, n in zip(order, place):
                real[axis] = DIMS[axis] - 1 - n if flips[axis] else n
            return tissue(*real)
        sizes = [DIMS[a] for a in order]
        values = bytes(at((i, j, k)) for k in range(sizes[2]) for j in range(sizes[1]) for i in range(sizes[0]))
        self.write(name + '.nrrd', head.encode() + values)
        self.bcc4('import', name + '.nrrd', '-o', name + '.bcc4', '--lattice', 'cc', '--scale', 1, '--exact', '--quiet', '--overwrite')
        return name + '.bcc4'

    def drawn(self, volume, *args, name='p.png', **more):
        self.said, self.told = self.bcc4('render', volume, '-o', name, *args, **more)
        return self.path(name)

    def places(self):
        """Axis and sample of the planes that the tool tells of."""
        return [(axis, int(n)) for axis, n in re.findall(r'([xyz]) = (\d+)', self.said)]

    def test_planes_have_the_values_of_the_samples(self):
        v = self.scan()
        rows = read_png(self.drawn(v, '--layout', 'planes', '--size', '604x200', '--range', '0,200'))
        self.assertEqual((len(rows[0]), len(rows)), (604, 200))
        self.bcc4('export', v, '-o', 'samples.raw', '--quiet')
        with open(self.path('samples.raw'), 'rb') as f:
            samples = f.read()
        self.assertEqual(len(samples), math.prod(DIMS))
        at = dict(self.places())
        self.assertEqual([axis for axis, _ in self.places()], ['y', 'x', 'z'])
        for axis, n in at.items():  # through the middle of what is seen
            self.assertLessEqual(abs(n - .5 * DIMS['xyz'.index(axis)]), 2)
        pane, gap = 200, 2
        length = max(SPAN) / (.96 * pane)
        # coronal: left to the right, head up; sagittal: back to the right; axial: front up
        planes = [((0, False), (2, False)), ((1, True), (2, False)), ((0, False), (1, False))]
        for n, ((u, back), (w, _)) in enumerate(planes):
            width, height = round(SPAN[u] / length), round(SPAN[w] / length)
            left, top = n * (pane + gap) + (pane - width) // 2, (pane - height) // 2
            across = 3 - u - w
            for y, x in itertools.product(range(40, height - 40, 7), range(30, width - 30, 5)):
                place = {across: float(at['xyz'[across]])}
                place[u] = (x + .5) / width * DIMS[u] - .5
                place[w] = (height - y - .5) / height * DIMS[w] - .5
                if back:
                    place[u] = DIMS[u] - 1 - place[u]
                low = [math.floor(place[a]) for a in range(3)]
                value = 0
                for corner in itertools.product((0, 1), repeat=2):
                    real, share = dict(place), 1
                    for a, c in zip((u, w), corner):
                        real[a] = min(max(low[a] + c, 0), DIMS[a] - 1)
                        share *= place[a] - low[a] if c else 1 - place[a] + low[a]
                    x0, y0, z0 = (int(real[a]) for a in range(3))
                    value += share * samples[x0 + DIMS[0] * (y0 + DIMS[1] * z0)]
                pixel = rows[top + y][left + x]
                self.assertEqual(pixel[3], 255)
                self.assertEqual(pixel[0], pixel[2])
                self.assertLessEqual(abs(pixel[0] - 255 * value / 200), 1.5, (n, x, y, place))

    def test_however_a_scan_is_stored_it_lies_as_radiologists_have_it(self):
        go = ('--layout', 'planes', '--size', '604x200', '--range', '0,200')
        first = read_png(self.drawn(self.scan(), *go))
        self.assertIn('(R to L, I to S)', self.said)
        self.assertIn('(A to P, I to S)', self.said)
        self.assertIn('(R to L, P to A)', self.said)
        for order, flips, lps in (((0, 1, 2), (0, 0, 0), True), ((0, 1, 2), (1, 0, 1), False), ((2, 0, 1), (0, 1, 0), False), ((1, 2, 0), (1, 1, 1), True)):
            rows = read_png(self.drawn(self.scan('o', order, flips, lps), *go))
            off = max(abs(a - b) for row, other in zip(rows, first) for p, q in zip(row, other) for a, b in zip(p, q))
            self.assertLessEqual(off, 1, (order, flips, lps))  # sums of four samples in another order
            self.assertEqual([axis for axis, _ in self.places()], ['xyz'[order.index(a)] for a in (1, 0, 2)])

    def test_sides_are_those_of_nibabel(self):
        try:
            from nibabel import aff2axcodes
        except ImportError:
            aff2axcodes = None
        seed = random.Random(3)
        for _ in range(4):
            # A turn about a random direction, by up to 40 degrees beside one of the orders of the axes.
            order = seed.sample(range(3), 3)
            signs = [seed.choice((-1, 1)) for _ in range(3)]
            axis = [seed.gauss(0, 1) for _ in range(3)]
            norm, angle = math.hypot(*axis), math.radians(seed.uniform(5, 40))
            ux, uy, uz = (a / norm for a in axis)
            c, s, k = math.cos(angle), math.sin(angle), 1 - math.cos(angle)
            turn = [[c + ux * ux * k, ux * uy * k - uz * s, ux * uz * k + uy * s], [uy * ux * k + uz * s, c + uy * uy * k, uy * uz * k - ux * s],
                    [uz * ux * k - uy * s, uz * uy * k + ux * s, c + uz * uz * k]]
            columns = [[turn[r][order[n]] * signs[n] * STEPS[n] for r in range(3)] for n in range(3)]
            directions = ' '.join('({:.9f},{:.9f},{:.9f})'.format(*column) for column in columns)
            self.write('t.nrrd', f'NRRD0005\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 12 16 20\nspace directions: {directions}\n'
                       'encoding: raw\n\n'.encode() + bytes(tissue(x, y, z) for z in range(20) for y in range(16) for x in range(12)))
            self.bcc4('import', 't.nrrd', '-o', 't.bcc4', '--lattice', 'cc', '--scale', 1, '--exact', '--quiet', '--overwrite')
            m = self.json('info', 't.bcc4')['affine']  # a left-handed one is turned at import
            self.drawn('t.bcc4', '--layout', 'planes', '--size', '604x200')
            if aff2axcodes:
                import numpy as np
                codes = aff2axcodes(np.array(m, float).reshape(-1, 4)[:3].tolist() + [[0, 0, 0, 1]])
                wanted = ['xyz'[next(n for n in range(3) if codes[n] in ends)] for ends in ('AP', 'LR', 'SI')]
            else:
                flat = [float(x) for row in m for x in row] if isinstance(m[0], list) else m
                def along(world):
                    return max(range(3), key=lambda n: abs(flat[4 * world + n]) / math.hypot(*(flat[4 * r + n] for r in range(3))))
                wanted = ['xyz'[along(world)] for world in (1, 0, 2)]
            self.assertEqual([axis for axis, _ in self.places()], wanted)

    def test_a_scan_is_seen_in_planes_and_as_a_volume(self):
        v = self.scan()
        self.assertEqual(png_size(self.drawn(v)), (1024, 1024))
        rows = read_png(self.drawn(v, '--size', '402x302'))
        self.assertEqual((len(rows[0]), len(rows)), (402, 302))
        with open(self.drawn(v, '--size', '402x302', '--layout', 'both', name='b.png'), 'rb') as f, open(self.path('p.png'), 'rb') as g:
            self.assertEqual(f.read(), g.read(), 'auto is both')
        # At the lower right the volume's own picture, above and beside it planes.
        gap = 3
        size = ((402 - gap) // 2, (302 - gap) // 2)
        alone = read_png(self.drawn(v, '--layout', 'volume', '--size', '{}x{}'.format(*size), name='v.png'))
        self.assertEqual([row[size[0] + gap:2 * size[0] + gap] for row in rows[size[1] + gap:2 * size[1] + gap]], alone)
        for left, top in ((0, 0), (size[0] + gap, 0), (0, size[1] + gap)):
            pane = [row[left:left + size[0]] for row in rows[top:top + size[1]]]
            self.assertEqual(pane[size[1] // 2][size[0] // 2][3], 255)
            filled = sum(any(pixel[3] for pixel in row) for row in pane) / size[1]
            self.assertGreater(filled, .6)

    def test_who_asks_for_a_volume_gets_it(self):
        v = self.scan()
        for more in (('--view', 'front'), ('--mode', 'mip'), ('--rotate-y', 10), ('--annotate',), ('--look', 'mr'), ('--layout', 'volume'),
                     ('--size', 120)):
            size = more if '--size' in more else (*more, '--size', 300)
            self.assertEqual(png_size(self.drawn(v, *size)), (120, 120) if '--size' in more else (300, 300))
            self.assertNotIn('planes', self.said)

    def test_what_is_no_scan_is_a_volume_and_a_map_lies_flat(self):
        self.volume((12, 11, 10, 1), lambda x, y, z, t: x * y * z, '--quiet', name='f.bcc4')
        self.assertEqual(png_size(self.drawn('f.bcc4', '--size', 300)), (300, 300))
        self.assertNotIn('planes', self.said)
        self.drawn('f.bcc4', '--size', '604x200', '--layout', 'planes')  # without sides: as x, y and z rise
        self.assertEqual([axis for axis, _ in self.places()], ['y', 'x', 'z'])
        values = bytes(10 * x + y for z in range(3) for y in range(8) for x in range(16))
        self.write('m.nrrd', b'NRRD0005\ntype: uint8\ndimension: 3\nsizes: 16 8 3\nspacings: 2 2 1\nunits: "degrees" "degrees" "m"\nencoding: raw\n\n' + values)
        self.bcc4('import', 'm.nrrd', '-o', 'm.bcc4', '--lattice', 'cc', '--scale', 1, '--exact', '--quiet')
        if self.json('info', 'm.bcc4')['channels'][0]['kind'] != 'map':
            self.skipTest('NRRD files keep no degrees')
        rows = read_png(self.drawn('m.bcc4', '--size', 200))
        self.assertEqual(self.places(), [('z', 0)])
        filled = [sum(pixel[3] > 0 for pixel in row) for row in rows]
        self.assertGreater(max(filled), 180, 'it fills the width')
        self.assertLess(sum(n > 100 for n in filled), 110, 'and is half as high, beside the scale bar')

    def test_refusals(self):
        v = self.scan()
        go = ('render', v, '-o', 'x.png')
        self.refused(2, '--view: planes have no use for it', *go, '--layout', 'planes', '--view', 'front', output='x.png')
        self.refused(2, '--stats: planes', *go, '--layout', 'flat', '--stats', 's.json', output='x.png')
        self.refused(2, 'no picture beside planes has it', 'render', v, '-o', 'x.exr', '--layout', 'both', output='x.exr')
        self.refused(2, 'is the least', *go, '--layout', 'both', '--size', 100, output='x.png')
        self.refused(2, 'did you mean planes?', *go, '--layout', 'plane', output='x.png')

    def test_the_moment_that_shows_most(self):
        # A puff that is thick from frame 4 to 6, and a bright corner at the end of the series that is not as bright.
        peak = (5, 10, 30, 80, 100, 99, 98, 40, 10)
        self.volume((10, 9, 8, 9), lambda x, y, z, t: peak[int(t)] * math.exp(-math.dist((x, y, z), (5, 4, 4)) ** 2 / 6), '--quiet')
        with open(self.drawn('v.bcc4', '--size', 64), 'rb') as f:
            chosen = f.read()
        self.assertIn('moment 4 of 0..8, which shows most; --time chooses another; they run 0 to 8', self.told)
        with open(self.drawn('v.bcc4', '--size', 64, '--time', 4), 'rb') as f:
            self.assertEqual(f.read(), chosen)
        self.assertNotIn('moment', self.told)

    def test_real_scans(self):
        wanted = {'cardiac_cine_256x256x19x20_i16.nii.gz': 'mr', 'pcasl_52x68x20x10_f32.nii.gz': 'mr', 'cranium.nhdr': 'ct', 'smoke.vdb': ''}
        here = [name for name in wanted if os.path.exists(os.path.join(DATA, name)) and (wanted[name] or has_reader('openvdb'))]
        if not here:
            raise unittest.SkipTest('SKIPPED: none of the real data sets is here')
        for name in here:
            with self.subTest(name):
                self.bcc4('import', os.path.join(DATA, name), '-o', 'r.bcc4', '--quiet', '--overwrite')
                self.drawn('r.bcc4', '--size', 400)
                self.assertEqual('planes at samples' in self.said, bool(wanted[name]))


if __name__ == '__main__':
    main()

"""Pictures nobody gave options for: air and noise are transparent, the object is seen. Of made-up volumes, and of real
ones where they are there."""
import json
import math
import os
import random
import re
import struct
import unittest

from harness import DATA, ToolTest, exr_attributes, has_reader, main, read_png

SIDE, CENTRE = 40, 19.5
PIXELS = 96


def radius(x, y, z):
    return math.dist((x, y, z), (CENTRE, CENTRE, CENTRE))


class Look(ToolTest):
    def picture(self, volume, *more, name='p.png'):
        _, err = self.bcc4('render', volume, '--index', '--time', 0, '-o', name, '--size', f'{PIXELS}x{PIXELS}', '--fit', 'domain',
                           *more)
        return read_png(self.path(name)), err

    def mask(self, volume, points):
        """Where a function of steps of opacity, [value, opacity, ...], is opaque."""
        function = {'ColorSpace': 'RGB', 'Name': 'm', 'RGBPoints': [points[0], 1, 1, 1, points[-2], 1, 1, 1],
                    'Points': [n for i in range(0, len(points), 2) for n in (points[i], points[i + 1], .5, 0)]}
        with open(self.path('mask.json'), 'w') as f:
            json.dump([function], f)
        rows, _ = self.picture(volume, '--tf', 'mask.json', '--no-shading', '--quiet', name='mask.png')
        return [[pixel[3] > 127 for pixel in row] for row in rows]

    def background(self, rows, mask):
        """Mean opacity, of 255, where no object is within four pixels."""
        far = [rows[y][x][3] for y in range(PIXELS) for x in range(PIXELS)
               if not any(mask[b][a] for b in range(max(0, y - 4), min(PIXELS, y + 5))
                          for a in range(max(0, x - 4), min(PIXELS, x + 5)))]
        return sum(far) / max(1, len(far))

    def overlap(self, rows, mask):
        pairs = [(rows[y][x][3] > 25, mask[y][x]) for y in range(PIXELS) for x in range(PIXELS)]
        return sum(a and b for a, b in pairs) / max(1, sum(a or b for a, b in pairs))

    def check(self, volume, points, *words, haze=1):
        rows, err = self.picture(volume)
        for word in words:
            self.assertIn(word, err)
        mask = self.mask(volume, points)
        self.assertTrue(any(any(row) for row in mask), 'the object is nowhere')
        found = self.overlap(rows, mask), self.background(rows, mask)
        self.assertGreaterEqual(found[0], .8, (volume, found))
        self.assertLessEqual(found[1], haze, (volume, found))
        return rows

    def made(self, f, dtype='f32', *more):
        return self.volume((SIDE, SIDE, SIDE, 1), lambda x, y, z, t: f(x, y, z), '--quiet', '--overwrite', *more,
                           dtype=dtype)

    def test_a_ball_in_noise(self):
        noise = random.Random(1)
        ball = (lambda x, y, z: 180 if radius(x, y, z) < 13 else 0)
        v = self.made(lambda x, y, z: min(255, int(ball(x, y, z) + abs(noise.gauss(0, 8)))), 'u8')
        self.check(v, [89, 0, 91, 1], 'below', haze=1.25)

    def test_hounsfield_units(self):
        noise = random.Random(2)

        def head(x, y, z):
            r = radius(x, y, z)
            return round((-1000 if r > 15 else 40 if r > 11 else 900) + noise.gauss(0, 15))

        v = self.made(head, 'i16')
        rows = self.check(v, [-501, 0, -499, 1], 'air and noise below')
        bone, _ = self.picture(v, '--look', 'ct-bone', '--quiet')
        soft, _ = self.picture(v, '--look', 'ct-soft', '--quiet')
        self.assertNotEqual(bone, rows)
        self.assertNotEqual(bone, soft)
        # Of soft tissue around it bone is bare.
        head, skull = self.mask(v, [-501, 0, -499, 1]), self.mask(v, [469, 0, 471, 1])
        tissue = [(x, y) for y in range(PIXELS) for x in range(PIXELS) if head[y][x] and not skull[y][x]]
        self.assertGreater(len(tissue), 200)
        bare, dressed = (sum(rows[y][x][3] for x, y in tissue) / len(tissue) for rows in (bone, soft))
        self.assertLess(bare, 40)
        self.assertGreater(dressed, 150)

    def test_a_range_of_hounsfield_units(self):
        # Air of the file is 0, which is water; that of the scan is -1000.
        v = self.made(lambda x, y, z: -1000 if radius(x, y, z) > 15 else 900 if radius(x, y, z) > 12 else 40, 'i16')
        for window in ('--range=-100,300', '--range=-1400,300'):
            for mode, least in (('composite', 40), ('mip', 255)):
                rows, _ = self.picture(v, window, '--mode', mode, '--quiet', '--view', 'front')
                beside, middle = rows[PIXELS // 4][PIXELS // 4], rows[PIXELS // 2][PIXELS // 2]
                self.assertEqual(beside[3], 0, (window, mode))  # a corner of the volume
                self.assertGreaterEqual(middle[3], least, (window, mode))

    def test_signed_waves(self):
        step = 2 * math.pi / 20
        v = self.made(lambda x, y, z: 3 * math.sin(step * x) * math.sin(step * y) * math.sin(step * z))
        rows = self.check(v, [-1.01, 1, -.99, 0, .99, 0, 1.01, 1], 'from -', 'transparent')
        colors = [p for row in rows for p in row if p[3] > 100]
        self.assertTrue(any(p[0] > 1.5 * p[2] for p in colors) and any(p[2] > 1.5 * p[0] for p in colors))

    def test_labels(self):
        v = self.made(lambda x, y, z: 0 if radius(x, y, z) > 16 else 1 if x < 18 else 2 if y < 18 else 5, 'u8')
        self.check(v, [.49, 0, .51, 1], 'labels')

    def test_labels_whose_numbers_are_twelve_apart(self):
        v = self.made(lambda x, y, z: 0 if radius(x, y, z) > 16 else 1 if x < 20 else 13, 'u8')
        rows, _ = self.picture(v, '--view', 'front', '--no-shading', '--quiet')
        left, right = rows[PIXELS // 2][PIXELS // 3], rows[PIXELS // 2][2 * PIXELS // 3]
        self.assertGreater(sum(abs(a - b) for a, b in zip(left[:3], right[:3])), 100)

    def test_distances(self):
        v = self.made(lambda x, y, z: max(-3, min(3, radius(x, y, z) - 12)))
        self.check(v, [-.01, 1, .01, 0], 'level set')

    def test_water_without_land(self):
        def water(x, y, z):
            ground = z < 8 + 4 * math.sin(x / 6) or math.hypot(x - 30, y - 28) < 8
            return math.nan if ground else 4 + (24 - .2 * abs(y - 20)) * math.exp((z - SIDE) / 15)

        v = self.made(water, 'f32', '--on-nonfinite', 'hole')
        self.check(v, [-100, 1, 100, 1], 'all values drawn')
        # The air of the file is a value like others, and opacity rises through it.
        v = self.made(water, 'f32', '--on-nonfinite', 'hole', '--air', 12)
        self.picture(v, '--range', '4,28', '--dump-tf', 'tf.json', '--quiet')
        with open(self.path('tf.json')) as f:
            points = json.load(f)[0]['Points']
        self.assertEqual(points[1::4], sorted(points[1::4]))
        self.assertLess(points[0], 5)
        self.assertEqual(points[1], 0)

    def test_one_value_and_nothing(self):
        self.check(self.made(lambda x, y, z: 7), [3.4, 0, 3.6, 1], 'one value')
        rows, err = self.picture(self.made(lambda x, y, z: 0))
        self.assertIn('nothing but air', err)
        self.assertFalse(any(p[3] for row in rows for p in row))

    def test_modes_fit_the_numbers(self):
        noise = random.Random(3)
        v = self.made(lambda x, y, z: round((-1000 if radius(x, y, z) > 13 else 200) + noise.gauss(0, 15)), 'i16')
        mask = self.mask(v, [-401, 0, -399, 1])
        most, _ = self.picture(v, '--mode', 'mip')
        self.assertLessEqual(self.background(most, mask), 1)
        self.assertEqual(most[PIXELS // 2][PIXELS // 2][3], 255)
        surface, err = self.picture(v, '--mode', 'iso')
        self.assertRegex(err, 'the surface at -(39|4[0-9])')
        self.assertGreaterEqual(self.overlap(surface, mask), .8)
        self.assertEqual(self.picture(v, '--mode', 'iso', '--iso', -400)[1], '')
        rays, err = self.picture(v, '--mode', 'xray')
        self.assertEqual(err, '')
        grey = [[p[0] * p[3] // 255 for p in row] for row in rays]
        self.assertGreater(grey[PIXELS // 2][PIXELS // 2], 200)
        inside = [g for row, m in zip(grey, mask) for g, hit in zip(row, m) if hit]
        outside = [g for row, m in zip(grey, mask) for g, hit in zip(row, m) if not hit]
        self.assertGreater(sum(inside) / len(inside), 4 * sum(outside) / len(outside))

    def test_nothing_is_seen_beside_a_sharp_edge(self):
        v = self.made(lambda x, y, z: 1 if radius(x, y, z) < 11 else 0)
        mask = self.mask(v, [.49, 0, .51, 1])
        near = 7  # pixels, three voxels and more
        far = [(x, y) for y in range(PIXELS) for x in range(PIXELS)
               if not any(mask[b][a] for b in range(max(0, y - near), min(PIXELS, y + near + 1))
                          for a in range(max(0, x - near), min(PIXELS, x + near + 1)))]
        self.assertGreater(len(far), PIXELS ** 2 // 4)
        for options in ((), ('--mode', 'mip'), ('--mode', 'iso'), ('--range', '0,1'), ('--range', '0,1', '--no-shading')):
            rows, _ = self.picture(v, *options)
            self.assertLessEqual(max(rows[y][x][3] for x, y in far), 1, options)
            self.assertGreater(rows[PIXELS // 2][PIXELS // 2][3], 60, options)
        rows, _ = self.picture(v, '--mode', 'xray')
        bright = [[pixel[0] * pixel[3] // 255 for pixel in row] for row in rows]
        self.assertLessEqual(max(bright[y][x] for x, y in far), 1)
        self.assertGreater(bright[PIXELS // 2][PIXELS // 2], 100)

    def test_looks_take_labels_for_quantities(self):
        """A look that is asked for is drawn, whatever the values are by default."""
        v = self.made(lambda x, y, z: (0, 3, 7, 12)[sum(radius(x, y, z) < r for r in (6, 10, 15))], 'u8')
        self.assertIn('labels, a colour for each', self.picture(v)[1])
        drawn = [self.picture(v, '--look', look)[0] for look in ('auto', 'labels', 'ct-soft', 'mr', 'fog', 'fire')]
        self.assertEqual(drawn[0], drawn[1])
        for i, one in enumerate(drawn[1:], 1):
            self.assertNotIn(one, drawn[1:i])

    def test_coarse_steps_make_no_labels(self):
        """Bytes that are stored in steps of eleven have few values, and are no labels."""
        noise = random.Random(7)
        v = self.made(lambda x, y, z: max(0, min(255, round(250 * math.exp(-radius(x, y, z) ** 2 / 90) + noise.gauss(0, 3)))),
                      'u8', '--psnr', 34, '--lattice', 'cc')
        self.assertRegex(self.bcc4('info', v)[0], r'in steps of ([5-9]|[1-9][0-9])')
        self.assertIn('air and noise', self.picture(v)[1])

    def test_a_function_that_shows_nothing_is_told(self):
        v = self.made(lambda x, y, z: 100 * math.exp(-radius(x, y, z) ** 2 / 50))
        _, err = self.picture(v, '--look', 'ct-bone')
        self.assertNotIn('nothing is shown', err)
        _, err = self.picture(v, '--range', '5000,6000')
        self.assertRegex(err, 'nothing is shown: the values run from .* to 1?[09].*, and what is visible is near [56]')
        self.assertNotIn('nothing', self.picture(v)[1])

    def test_an_object_fills_its_picture(self):
        """A small ball, in a corner of its domain: seen, in the middle and large; of the domain, small."""
        v = self.made(lambda x, y, z: 1 if math.dist((x, y, z), (9, 28, 12)) < 6 else 0)
        def box(*more):
            self.bcc4('render', v, '-o', 'f.png', '--size', f'{PIXELS}x{PIXELS}', '--quiet', *more)
            seen = [(x, y) for y, row in enumerate(read_png(self.path('f.png'))) for x, p in enumerate(row) if p[3] > 60]
            return [(min(a), max(a)) for a in zip(*seen)]
        for more in ((), ('--camera', 'persp'), ('--rotate-y', 200), ('--mode', 'iso')):
            for low, high in box(*more):
                self.assertGreater(high - low, .38 * PIXELS, more)
                self.assertLess(abs(low + high - PIXELS), 8, more)
        for low, high in box('--fit', 'domain'):
            self.assertLess(high - low, .3 * PIXELS)
        self.refused(2, '--fit', 'render', v, '--fit', 'all', '-o', 'x.png', output='x.png')

    def test_every_moment_has_the_same_camera(self):
        """A ball that moves: its pictures are those of a film, whichever moments are asked for."""
        v = self.volume((30, 24, 20, 5), lambda x, y, z, t: 1 if math.dist((x, y, z), (6 + 4 * t, 12, 10)) < 4 else 0,
                        '--quiet', '--overwrite')
        self.bcc4('render', v, '--frames', '0-4', '-o', 'm.%d.exr', '--size', '32x32', '--quiet')
        self.bcc4('render', v, '--index', '--time', 3, '-o', 'one.exr', '--size', '32x32', '--quiet')
        cameras = {bytes(exr_attributes(self.path(n))['worldToNDC']) for n in ('m.0.exr', 'm.4.exr', 'one.exr')}
        self.assertEqual(len(cameras), 1)

    def test_patients_look_at_us(self):
        """Head up and right hand left, in a world of right, anterior and superior."""
        for space, right, up in (('right-anterior-superior', (-1, 0, 0), (0, 0, 1)),
                                 ('left-posterior-superior', (1, 0, 0), (0, 0, 1)),
                                 ('3D-right-handed', (1, 0, 0), (0, 1, 0))):
            self.write('p.nrrd', b'NRRD0005\ntype: uint8\ndimension: 3\nspace: ' + space.encode() +
                       b'\nsizes: 8 8 8\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n' +
                       bytes((x * 30 + y + z) % 256 for z in range(8) for y in range(8) for x in range(8)))
            self.bcc4('import', 'p.nrrd', '-o', 'p.bcc4', '--quiet', '--overwrite')
            self.bcc4('render', 'p.bcc4', '--view', 'front', '-o', 'p.exr', '--size', '16x16', '--quiet')
            m = struct.unpack('<16f', exr_attributes(self.path('p.exr'))['worldToCamera'])
            os.remove(self.path('p.exr'))
            for r in range(3):
                self.assertAlmostEqual(m[4 * r], right[r], 6, (space, r))
                self.assertAlmostEqual(m[4 * r + 1], up[r], 6, (space, r))

    def scan(self, header, name='s.nrrd'):
        """A ball of bytes in noise in voxels of 2 x 2 x 3, with a bright rim at one face: its file, imported."""
        noise = random.Random(8)
        def value(x, y, z):
            rim = 250 if z == 23 and math.hypot(x - 11.5, y - 11.5) < 8 else 0
            return max(rim, abs(int(noise.gauss(0, 3))) + (max(0, 120 - 5 * int(math.dist((x, y, z), (11.5, 11.5, 11.5)))) if
                                                         math.dist((x, y, z), (11.5, 11.5, 11.5)) < 9 else 0))

        self.write(name, b'NRRD0005\ntype: uint8\ndimension: 3\n' + header + b'sizes: 24 24 24\nencoding: raw\n\n' +
                   bytes(value(x, y, z) for z in range(24) for y in range(24) for x in range(24)))
        self.bcc4('import', name, '-o', 's.bcc4', '--quiet', '--overwrite', '--exact')
        return 's.bcc4'

    def kind(self, volume):
        return self.json('info', volume)['channels'][0]['kind']

    def test_scans_are_grey(self):
        """What has sides and sizes is a patient's scan: grey, whatever look others of its values have."""
        world = b'space: right-anterior-superior\nspace directions: (2,0,0) (0,2,0) (0,0,3)\n'
        drawn = {}
        for header, kind in ((world, 'mr'), (b'spacings: 2 2 3\n', 'unknown')):
            v = self.scan(header)
            self.assertEqual(self.kind(v), kind)
            self.assertEqual('kind ' in self.bcc4('info', v)[0], kind != 'unknown')
            for more in ((), ('--range', '20,120'), ('--look', 'fire')):
                rows, _ = self.picture(v, *more, '--quiet')
                seen = [p for row in rows for p in row if p[3] > 60]
                self.assertGreater(len(seen), 300)
                grey = sum(max(p[:3]) - min(p[:3]) < 3 for p in seen) / len(seen)
                if kind == 'mr' and '--look' not in more:
                    self.assertEqual(grey, 1, more)
                else:
                    self.assertLess(grey, .5, (kind, more))
            self.picture(v, '--dump-tf', 'tf.json', '--look', 'auto', '--quiet')
            with open(self.path('tf.json')) as f:
                drawn[kind] = json.load(f)[0]['RGBPoints'][-4]
        self.assertLess(drawn['mr'], 130, 'the window ends before the rim')
        self.assertGreater(drawn['unknown'], 200)

    def test_codes_of_headers_are_kept(self):
        head = bytearray(352)
        struct.pack_into('<i', head, 0, 348)
        struct.pack_into('<8h', head, 40, 3, 12, 12, 12, 1, 1, 1, 1)
        struct.pack_into('<hh', head, 70, 16, 32)
        struct.pack_into('<8f', head, 76, 1, 2, 2, 2, 1, 0, 0, 0)
        struct.pack_into('<f', head, 108, 352)
        head[344:347] = b'n+1'
        values = b''.join(struct.pack('<f', 8 * math.exp(-math.dist((x, y, z), (5, 5, 5)) ** 2 / 8))
                          for z in range(12) for y in range(12) for x in range(12))
        for intent, kind in ((0, 'mr'), (3, 'statistic'), (24, 'statistic'), (1001, 'statistic'), (1005, 'mr')):
            struct.pack_into('<h', head, 68, intent)
            self.write('a.nii', bytes(head) + values)
            self.bcc4('import', 'a.nii', '-o', 'a.bcc4', '--quiet', '--overwrite')
            self.assertEqual(self.kind('a.bcc4'), kind, intent)
            kept = self.json('info', 'a.bcc4')['attributes'].get('kind.value')
            self.assertEqual(kept, kind if kind == 'statistic' else None, 'what is found is not written down')
        for modality, kind in (('MET_MOD_CT', 'ct'), ('MET_MOD_MR', 'mr'), ('MET_MOD_OTHER', 'unknown')):
            self.write('a.mha', f'ObjectType = Image\nNDims = 3\nModality = {modality}\nDimSize = 12 12 12\nElementType = MET_FLOAT\n'
                       'ElementDataFile = LOCAL\n'.encode() + values)
            self.bcc4('import', 'a.mha', '-o', 'a.bcc4', '--quiet', '--overwrite')
            self.assertEqual(self.kind('a.bcc4'), kind)

    # The kinds of real data, as their files are imported.
    KINDS = {
        'cardiac_cine_256x256x19x20_i16.nii.gz': ('mr', ['--frames', '0-0']),
        'pcasl_52x68x20x10_f32.nii.gz': ('mr', ['--frames', '0-0']),
        'statmap_64x64x21_f32be.nii.gz': ('statistic', []),
        'cranium.nhdr': ('ct', []),
        'headsq/quarter.nhdr': ('ct', []),
        'tooth_103x94x161_u8.nrrd': ('unknown', []),
        'fuel_64x64x64_u8.vti': ('unknown', []),
        'ncep_forecast_36x33x10x7_f32.nc': ('map', ['--channel', 'T', '--frames', '0-0']),
        'smoke.vdb': ('smoke', []),
    }

    def test_kinds_of_real_data(self):
        here = [name for name in self.KINDS if DATA and os.path.exists(os.path.join(DATA, name))]
        if not here:
            raise unittest.SkipTest('SKIPPED: none of the real data sets is here')
        for name in here:
            kind, arguments = self.KINDS[name]
            reader = {'.vdb': 'openvdb', '.nc': 'netcdf'}.get(os.path.splitext(name)[1])
            if reader and not has_reader(reader):
                continue
            with self.subTest(name):
                self.bcc4('import', os.path.join(DATA, name), *arguments, '-o', 'real.bcc4', '--overwrite', '--quiet')
                self.assertEqual(self.kind('real.bcc4'), kind)

    def test_an_x_ray_is_a_film(self):
        v = self.made(lambda x, y, z: math.exp(-radius(x, y, z) ** 2 / 50))
        rows, _ = self.picture(v, '--mode', 'xray')
        self.assertEqual({tuple(p) for p in rows[0]}, {(0, 0, 0, 255)})
        rows, _ = self.picture(v, '--mode', 'xray', '--background', '1,1,1')
        self.assertEqual(tuple(rows[0][0]), (255, 255, 255, 255))

    def test_looks_are_chosen_and_refused(self):
        v = self.made(lambda x, y, z: 100 * math.exp(-radius(x, y, z) ** 2 / 50))
        looks = ('auto', 'ct-bone', 'ct-soft', 'mr', 'fog', 'fire', 'signed')
        drawn = [self.picture(v, '--look', look)[0] for look in looks]
        for i, one in enumerate(drawn):
            self.assertNotIn(one, drawn[:i])
        self.refused(2, 'whole numbers', 'render', v, '--look', 'labels', '-o', 'x.png', output='x.png')
        self.refused(2, '--look', 'render', v, '--look', 'fog', '--range', '1,2', '-o', 'x.png', output='x.png')
        self.refused(2, 'did you mean fire?', 'render', v, '--look', 'fir', '-o', 'x.png', output='x.png')

    def test_the_look_is_told_unless_another_is_given(self):
        v = self.made(lambda x, y, z: 100 * math.exp(-radius(x, y, z) ** 2 / 50))
        self.assertIn('to change', self.picture(v)[1])
        self.assertEqual(self.picture(v, '--range', '0,90')[1], '')
        self.assertEqual(self.picture(v, '--quiet')[1], '')

    @staticmethod
    def luminance(pixel):
        return sum(w * c for w, c in zip((.2126, .7152, .0722), pixel)) / 255

    def noise(self, rows, inside, reach=5):
        """Of luminance about its mean in a window, over pixels (x, y) that are inside."""
        off = []
        for x, y in inside:
            window = [self.luminance(rows[b][a]) for b in range(y - reach, y + reach + 1)
                      for a in range(x - reach, x + reach + 1)]
            off.append(self.luminance(rows[y][x]) - sum(window) / len(window))
        return math.sqrt(sum(d * d for d in off) / len(off))

    def test_a_ball_shows_no_rings(self):
        """Behind an edge of three voxels the field rings, which is not lit."""
        n, middle = 48, 23.5
        v = self.volume((n, n, n, 1), lambda x, y, z, t: min(1, max(0, .5 - (math.dist((x, y, z), (middle,) * 3) - 15) / 3)),
                        '--quiet', '--overwrite')
        self.bcc4('render', v, '-o', 'b.png', '--size', '200x200', '--quiet')
        rows = read_png(self.path('b.png'))
        half = sum(1 for p in rows[100] if p[3] > 60) / 2
        inside = [(x, y) for y in range(20, 180, 3) for x in range(20, 180, 3) if math.hypot(x - 100, y - 100) < .7 * half]
        self.assertGreater(len(inside), 500)
        self.assertLess(self.noise(rows, inside), .007)
        self.bcc4('render', v, '-o', 'n.png', '--size', '200x200', '--quiet', '--gradient-noise', 'none')
        self.assertGreater(self.noise(read_png(self.path('n.png')), inside), .01, 'there is something to hide')

    def test_steps_of_bytes_are_not_lit(self):
        """A smooth blob in bytes, whose slopes are terraces near its top."""
        v = self.volume((48, 48, 48, 1), lambda x, y, z, t: int(60 * math.exp(-math.dist((x, y, z), (23.5,) * 3) ** 2 / 300)),
                        '--quiet', '--overwrite', dtype='u8')
        self.bcc4('render', v, '-o', 'b.png', '--size', '200x200', '--quiet')
        self.bcc4('render', v, '-o', 'n.png', '--size', '200x200', '--quiet', '--gradient-noise', 'none')
        inside = [(x, y) for y in range(60, 141, 2) for x in range(60, 141, 2) if math.hypot(x - 100, y - 100) < 35]
        lit, all_lit = (self.noise(read_png(self.path(n)), inside, 2) for n in ('b.png', 'n.png'))
        self.assertLess(lit, .65 * all_lit)

    def test_maps_are_flat_and_opaque(self):
        """What is one sample thick has no surfaces, and one value has one colour."""
        v = self.volume((40, 40, 1, 6), lambda x, y, z, t: 1 if y > 8 else 0, '--quiet', '--overwrite')
        self.bcc4('render', v, '--index', '--time', 2, '-o', 'm.png', '--size', '160x160', '--quiet', '--view', 'front')
        rows = read_png(self.path('m.png'))
        inside = [(x, y) for y in range(30, 100, 2) for x in range(30, 130, 2)]
        self.assertGreater(min(rows[y][x][3] for x, y in inside), 200)
        self.assertLess(self.noise(rows, inside), .01)

    def test_both_signs_are_seen_where_one_is_rare(self):
        def activity(x, y, z):
            return (16 * math.exp(-math.dist((x, y, z), (12, 20, 20)) ** 2 / 40) -
                    7 * math.exp(-math.dist((x, y, z), (30, 20, 20)) ** 2 / 10) + noise.gauss(0, .6))

        noise = random.Random(5)
        v = self.made(activity)
        rows, err = self.picture(v, '--view', 'front', '--look', 'signed')
        seen = [p for row in rows for p in row if p[3] > 90]
        self.assertGreater(sum(p[0] > 1.5 * p[2] for p in seen), 50, 'red')
        self.assertGreater(sum(p[2] > 1.5 * p[0] for p in seen), 10, 'blue')

    def test_planes_over_time_are_seen(self):
        """A plane of few frames is as opaque along them as a frame is, and the same by a look that is asked for."""
        v = self.volume((40, 40, 40, 4), lambda x, y, z, t: 100 * math.exp(-math.dist((x, y), (CENTRE, CENTRE)) ** 2 / 60), '--quiet', '--overwrite')
        drawn = []
        for more in (('--time', 2, '--index'), ('--plane', '0,0,1,0,-20'), ('--plane', '0,0,1,0,-20', '--look', 'auto')):
            self.bcc4('render', v, *more, '-o', 'p.png', '--size', f'{PIXELS}x{PIXELS}', '--quiet', '--view', 'front', '--opacity', .02)
            drawn.append(read_png(self.path('p.png')))
        frame, plane, asked = (rows[PIXELS // 2][PIXELS // 2][3] for rows in drawn)
        self.assertGreater(frame, 60)
        self.assertLess(frame, 230, 'thick parts would be opaque either way')
        self.assertAlmostEqual(plane, frame, delta=.2 * frame)
        self.assertEqual(drawn[1], drawn[2])
        rows = self.plane(v, '--opacity', .02, '--unit-distance', 1)  # a voxel, as of frames
        self.assertLess(rows[PIXELS // 2][PIXELS // 2][3], .3 * frame, 'there is something to make up for')

    def plane(self, v, *more):
        self.bcc4('render', v, '--plane', '0,0,1,0,-20', '-o', 'q.png', '--size', f'{PIXELS}x{PIXELS}', '--quiet', '--view', 'front', *more)
        return read_png(self.path('q.png'))

    def test_planes_over_time_have_the_scale_of_their_own_values(self):
        """A plane through the dark part of a series is as bright as one through its bright part."""
        def two(x, y, z, t):
            return sum(most * math.exp(-math.dist((x, y, z), (12, 20, at)) ** 2 / 60) for most, at in ((1000, 30), (80, 8)))

        v = self.volume((28, 40, 40, 8), two, '--quiet', '--overwrite')
        light = []
        for at in (30, 8):
            self.bcc4('render', v, f'--plane=0,0,1,0,-{at}', '-o', 'p.png', '--size', f'{PIXELS}x{PIXELS}', '--quiet', '--view', 'front',
                      '--background', '0,0,0', '--dump-tf', f'{at}.json')
            light.append(max(self.luminance(p) for row in read_png(self.path('p.png')) for p in row))
        self.assertGreater(light[1], .7 * light[0])
        tops = [json.load(open(self.path(f'{at}.json')))[0]['RGBPoints'][-4] for at in (30, 8)]
        self.assertGreater(tops[0], 700)
        self.assertLess(tops[1], 120)

    def test_trails_of_dense_fields_are_what_stands_out(self):
        """Where nothing moved a dense field is drawn as without a trail; where the crest was the trail has its colours."""
        v = self.volume((40, 40, 10, 9), lambda x, y, z, t: 20 + x / 4 + 60 * math.exp(-((x - 8 - 3 * t) ** 2 + (y - 20) ** 2) / 30),
                        '--quiet', '--overwrite')
        drawn = []
        for more in ((), ('--trail', '7f,3')):
            self.bcc4('render', v, '--index', '--time', 8, '-o', 'p.png', '--size', f'{PIXELS}x{PIXELS}', '--quiet', '--view', 'front',
                      '--fit', 'domain', '--background', '0,0,0', *more)
            drawn.append(read_png(self.path('p.png')))
        scale = PIXELS * .92 / 40

        def changes(rows):
            at = [(round(PIXELS / 2 + (x - 19.5) * scale), y) for x in range(8, 26) for y in rows]
            return [max(abs(a - b) for a, b in zip(drawn[0][y][x][:3], drawn[1][y][x][:3])) for x, y in at]
        path, far = changes((PIXELS // 2,)), changes((PIXELS // 5, 4 * PIXELS // 5))
        self.assertGreater(sorted(path)[len(path) // 2], 30)
        self.assertLess(sorted(far)[len(far) // 2], 8)
        hues = {max(range(3), key=lambda c: drawn[1][PIXELS // 2][round(PIXELS / 2 + (x - 19.5) * scale)][c]) for x in (10, 22)}
        self.assertEqual(len(hues), 2, 'the first third is blue, the last orange')

    def test_the_default_surface_of_noisy_fog_is_whole(self):
        """Tissue that varies: its surface is nearer to the noise than to its middle, so that no part is missing."""
        noise = random.Random(6)
        v = self.made(lambda x, y, z: abs(noise.gauss(0, 10)) + ((300 + 18 * x) if radius(x, y, z) < 14 else 0))
        mask = self.mask(v, [149, 0, 151, 1])
        surface, _ = self.picture(v, '--mode', 'iso')
        self.assertGreaterEqual(self.overlap(surface, mask), .85)

    def test_the_default_surface_is_inside_what_has_no_edge(self):
        """Tissue that is as common near the noise as at its middle: a surface between the two is torn."""
        noise = random.Random(7)
        v = self.made(lambda x, y, z: abs(noise.gauss(150, 100) if radius(x, y, z) < 16 else noise.gauss(0, 6)))
        _, err = self.picture(v, '--mode', 'iso')
        value = float(re.search(r'the surface at ([\d.]+)', err).group(1))
        self.assertGreater(value, 115)
        self.assertLess(value, 185)

    # file: (import arguments, value at which the object begins)
    REAL = {
        'tooth_103x94x161_u8.nrrd': ([], 113),
        'engine_256x256x128_u8.raw.gz': (['--dims', '256,256,128', '--dtype', 'u8'], 65),
        'cranium.nhdr': ([], -480),
        'headsq/quarter.nhdr': ([], 500),
        'fuel_64x64x64_u8.vti': ([], 25),
        'neghip_64x64x64_u8.raw': (['--dims', '64,64,64', '--dtype', 'u8'], 60),
        'nucleon_41x41x41_u8.raw': (['--dims', '41,41,41', '--dtype', 'u8'], 50),
        'viscous_fingers_run01_t050_original_f32_zlib.vti': ([], 15),
        'pcasl_52x68x20x10_f32.nii.gz': ([], 350),
        'dx_mri_16x128x128_u16be.raw': (['--dims', '128,128,16', '--axes', 'zxy', '--dtype', 'u16', '--endian', 'big'],
                                        8000),
    }

    def test_real_data(self):
        here = [name for name in self.REAL if DATA and os.path.exists(os.path.join(DATA, name))]
        if not here:
            raise unittest.SkipTest('SKIPPED: none of the real data sets is here')
        for name in here:
            arguments, begins = self.REAL[name]
            with self.subTest(name):
                self.bcc4('import', os.path.join(DATA, name), *arguments, '-o', 'real.bcc4', '--overwrite', '--quiet')
                step = 1e-3 * abs(begins)
                self.check('real.bcc4', [begins - step, 0, begins + step, 1], 'air and noise below')


if __name__ == '__main__':
    main()

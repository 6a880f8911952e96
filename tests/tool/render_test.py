"""bcc4 render: options, files and statistics. What a picture must look like is tested beside the renderer."""
import json
import math
import os
import struct

from harness import ToolTest, exr_attributes, field, main, png_size, read_png

DIMS = (10, 9, 8, 6)


def bump(x, y, z, t):
    return 100 * math.exp(-((x - 4 - .3 * t) ** 2 + (y - 4) ** 2 + (z - 3) ** 2) / 8)


class Render(ToolTest):
    def setUp(self):
        super().setUp()
        self.volume(DIMS, bump, '--quiet')

    def test_files_with_every_sample_are_drawn_smoothly(self):
        self.volume(DIMS, bump, '--quiet', '--lattice', 'cc', '--overwrite')
        self.assertEqual(self.json('info', 'v.bcc4')['kernel'], 'exact')
        drawn = {}
        for quality in ('normal', 'best'):
            for kernel in ('', 'default', 'exact'):
                more = ('--kernel', kernel) if kernel else ()
                drawn[quality, kernel] = self.picture('--quality', quality, *more, name=f'{quality}{kernel}.png')
            self.assertNotEqual(drawn[quality, 'default'], drawn[quality, 'exact'])
        self.assertEqual(drawn['normal', ''], drawn['normal', 'default'])
        self.assertEqual(drawn['best', ''], drawn['best', 'exact'])

    def picture(self, *args, name='p.png', size='24x20'):
        self.bcc4('render', 'v.bcc4', '-o', name, '--size', size, '--quiet', *args)
        with open(self.path(name), 'rb') as f:
            return f.read()

    def test_writes_png_and_exr(self):
        self.picture('--time', 2.5)
        self.assertEqual(png_size(self.path('p.png')), (24, 20))
        self.assertEqual(self.picture('--time', 2.5, name='p.exr')[:4], b'\x76\x2f\x31\x01')

    def test_a_volume_one_sample_thick_is_drawn(self):
        for dims in ((20, 18, 1, 6), (20, 1, 18, 6), (1, 20, 18, 1)):
            v = self.volume(dims, lambda x, y, z, t: .5 + .4 * math.cos(.4 * x + .2 * t) * math.cos(.3 * y + .2 * z), '--quiet', '--overwrite', name='f.bcc4')
            for more in ([], ['--mode', 'mip'], ['--mode', 'xray'], ['--trail', '2f']):
                if '--trail' in more and dims[3] == 1:
                    continue
                self.bcc4('render', v, *more, '--index', '--time', min(2, dims[3] - 1), '-o', 'f.png', '--size', '40x40', '--quiet')
                self.assertGreater(os.path.getsize(self.path('f.png')), 400, (dims, more))  # empty ones have 158 bytes

    def test_deep_exr(self):
        self.picture('--time', 2, '--fps', 24, '--deep', name='d.exr')
        attributes = exr_attributes(self.path('d.exr'))
        self.assertEqual(attributes['type'], b'deepscanline')
        self.assertEqual(attributes['deepImageState'], b'\x03')  # tidy
        self.assertEqual(attributes['compression'], b'\x02')  # a line at a time
        for name in ('worldToCamera', 'framesPerSecond', 'comments', 'bccsplat/hyperplane'):
            self.assertIn(name, attributes)
        self.assertEqual([c[:-1] for c in (b'A\0', b'B\0', b'G\0', b'R\0', b'Z\0', b'ZBack\0') if c in attributes['channels']],
                         [b'A', b'B', b'G', b'R', b'Z', b'ZBack'])
        sizes = [len(self.picture('--time', 2, '--deep', '--deep-tolerance', e, name='d.exr')) for e in ('1e-6', '.1')]
        self.assertLess(sizes[1], sizes[0])
        self.picture('--time', 2, '--deep', '--trail', '1', name='d.exr')
        self.picture('--time', 2, '--deep', '--iso', '40', name='d.exr')
        go = ('render', 'v.bcc4', '--time', 2)
        self.refused(2, '.exr', *go, '--deep', '-o', 'x.png', output='x.png')
        self.refused(2, '--deep', *go, '--deep-tolerance', '.1', '-o', 'x.exr', output='x.exr')
        self.refused(2, 'above 0', *go, '--deep', '--deep-tolerance', '0', '-o', 'x.exr', output='x.exr')
        surfaces = ('--time', 2, '--deep', '--iso', '20,60')
        self.assertGreater(len(self.picture(*surfaces, '--opacity-stop', 1, name='d.exr')), len(self.picture(*surfaces, name='d.exr')))
        for wrong in (0, .0009, 1.5):
            self.refused(2, '--opacity-stop', *go, '--deep', '--opacity-stop', wrong, '-o', 'x.exr', output='x.exr')
        self.refused(2, 'composite and iso', *go, '--deep', '--mode', 'mip', '-o', 'x.exr', output='x.exr')

    def test_exr_holds_the_standard_attributes(self):
        with open(self.path('c.json'), 'w') as f:
            json.dump(dict(position=[4.5, 4, -30], target=[4.5, 4, 3.5], up=[0, -1, 0], ortho_height=10), f)
        with open(self.path('ms.nrrd'), 'wb') as f:
            f.write(b'NRRD0004\ntype: float\ndimension: 4\nsizes: 10 9 8 6\nkinds: space space space time\nspacings: 1 1 1 250\n'
                    b'units: "" "" "" "ms"\nencoding: raw\nendian: little\n\n' + field(DIMS, bump, 'f').tobytes())
        self.bcc4('import', 'ms.nrrd', '-o', 'ms.bcc4', '--quiet')

        def attributes(*more, out='p.exr', read='p.exr'):
            self.bcc4('render', 'ms.bcc4', '--camera', 'c.json', '--size', '20x10', '--quiet', '-o', out, *more)
            return exr_attributes(self.path(read))

        one = attributes('--time', 500)
        self.assertNotIn('framesPerSecond', one)
        self.assertNotIn('expTime', one)
        self.assertIn('render ms.bcc4 --camera c.json', one['comments'].decode())
        # Right and up of a camera that looks along +z with -y up are +x and -y; the last row moves the camera to 0.
        self.assertEqual(struct.unpack('<16f', one['worldToCamera']), (1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, -4.5, 4, 30, 1))
        # 20 wide, 10 high: (0, 0) is the corner at x = -5.5, y = -1.
        ndc = struct.unpack('<16f', one['worldToNDC'])
        for x, y, want in ((-5.5, -1, (0, 0)), (14.5, 9, (1, 1))):
            for c in range(2):
                self.assertAlmostEqual(x * ndc[c] + y * ndc[4 + c] + ndc[12 + c], want[c], 6)
        # Two frames of a quarter of a second each, clipped at the series' begin; a slab is its thickness.
        for trail, seconds in ((('--trail', '2f'), .5), (('--trail', 250), .25), (('--trail', 5000), .5), (('--thickness', 1), .25)):
            self.assertAlmostEqual(struct.unpack('<f', attributes('--time', 500, *trail)['expTime'])[0], seconds, 6)
        self.assertEqual(struct.unpack('<iI', attributes('--frames', '1-2', out='s.%d.exr', read='s.2.exr')['framesPerSecond']), (24, 1))
        self.assertEqual(struct.unpack('<iI', attributes('--time', 0, '--fps', '30000/1001')['framesPerSecond']), (30000, 1001))
        for wrong in ('0', '24/0', '23.976', '1/2/3', '24/'):
            self.refused(2, '--fps', 'render', 'v.bcc4', '--time', 2, '--fps', wrong, '-o', 'x.exr', output='x.exr')
        self.refused(2, '--fps', 'render', 'v.bcc4', '--time', 2, '--fps', 24, '-o', 'x.png', output='x.png')
        # Where the unit of time is unknown, so is the exposure.
        self.picture('--time', 2, '--trail', 1, name='q.exr')
        self.assertNotIn('expTime', exr_attributes(self.path('q.exr')))

    def test_views_are_named_by_their_side(self):
        # Right and up of the picture and where it looks, in the world; front has x to the right and y up, as maps have it.
        sides = {'front': ((1, 0, 0), (0, 1, 0), (0, 0, -1)), 'back': ((-1, 0, 0), (0, 1, 0), (0, 0, 1)),
                 'left': ((0, 0, 1), (0, 1, 0), (1, 0, 0)), 'right': ((0, 0, -1), (0, 1, 0), (-1, 0, 0)),
                 'top': ((1, 0, 0), (0, 0, -1), (0, -1, 0)), 'bottom': ((1, 0, 0), (0, 0, 1), (0, 1, 0))}
        for side, axes in sides.items():
            self.picture('--time', 1, '--view', side, name='v.exr')
            m = struct.unpack('<16f', exr_attributes(self.path('v.exr'))['worldToCamera'])
            for c, axis in enumerate(axes):
                for r in range(3):
                    self.assertAlmostEqual(m[4 * r + c], axis[r], 6, (side, c, r))
        self.assertNotEqual(self.picture('--time', 1, '--view', 'front'), self.picture('--time', 1, '--view', 'back'))
        self.refused(2, '--view', 'render', 'v.bcc4', '--time', 1, '--view', 'top', '--rotate-x', 3, '-o', 'x.png', output='x.png')
        self.refused(2, 'did you mean front?', 'render', 'v.bcc4', '--time', 1, '--view', 'frnt', '-o', 'x.png', output='x.png')

    def test_a_series_without_a_time_shows_the_frame_that_shows_most(self):
        _, err = self.bcc4('render', 'v.bcc4', '-o', 'p.png', '--size', '24x20', '--quiet')
        self.assertIn(', which shows most; --time chooses another; they run 0 to 5', err)
        ranges = self.json('info', 'v.bcc4', '--frames')['channels'][0]['frames']
        most = max(high - low for low, high in ranges)
        good = [n for n, (low, high) in enumerate(ranges) if high - low >= .95 * most]
        best = min(good, key=lambda n: abs(n - 2.5))
        self.assertIn(f'moment {best} of 0..5', err)
        chosen = self.picture('--index', '--time', best)
        self.bcc4('render', 'v.bcc4', '-o', 'p.png', '--size', '24x20', '--quiet')
        with open(self.path('p.png'), 'rb') as f:
            self.assertEqual(f.read(), chosen)
        first = self.picture('--time', 0)
        self.assertEqual(self.bcc4('render', 'v.bcc4', '--time', 0, '-o', 'p.png', '--quiet')[1], '')
        self.bcc4('render', 'v.bcc4', '--turntable', 2, '-o', 't.%d.png', '--size', '24x20', '--quiet')
        _, err = self.bcc4('render', 'v.bcc4', '-o', 'n.%d.png', '--size', '24x20', '--quiet')
        self.assertIn('no --frames given: all 6 frames are drawn', err)
        for frame in range(6):
            with open(self.path(f'n.{frame}.png'), 'rb') as f:
                self.assertEqual(f.read() == first, frame == 0)

    def test_times_are_printed_without_the_last_digits_of_sums(self):
        with open(self.path('tenths.raw'), 'wb') as f:
            f.write(bytes(range(256)) * 2)
        self.bcc4('import', 'tenths.raw', '-o', 'tenths.bcc4', '--dims', '8,8,2,4', '--dtype', 'u8', '--dt', 0.1, '--quiet')
        _, err = self.bcc4('render', 'tenths.bcc4', '-o', 'p.png', '--size', '8x8', '--quiet')
        self.assertIn('they run 0 to 0.3', err)
        self.assertNotIn('0.300', err)

    def test_every_option_changes_the_picture(self):
        plain = self.picture('--time', 2)
        self.assertEqual(plain, self.picture('--time', 2), 'not repeatable')
        self.assertEqual(plain, self.picture('--time', 2, '--threads', 3), 'threads change the picture')
        for more in (['--camera', 'persp'], ['--rotate-x', 60], ['--rotate-y', -80], ['--colormap', 'fire'], ['--range', '20,50'],
                     ['--opacity', 4], ['--unit-distance', .1], ['--iso', 30], ['--mode', 'xray'], ['--mode', 'mip'], ['--no-shading'],
                     ['--kernel', 'paper'], ['--quality', 'draft'], ['--step', 2], ['--background', '1,0,0'],
                     ['--gradient-noise', 20]):
            self.assertNotEqual(plain, self.picture('--time', 2, *more), more)
        self.assertEqual(plain, self.picture('--time', 2, '--gradient-noise', 'auto'))

        def mean(channel, *more):
            self.picture('--time', 2, *more)
            pixels = [p for row in read_png(self.path('p.png')) for p in row]
            return sum(p[channel] * (1 if channel == 3 else p[3] / 255) for p in pixels) / len(pixels)

        red, green, blue, alpha = range(4)
        opacity = [mean(alpha, '--opacity', o) for o in (.25, 1, 4)]
        self.assertEqual(opacity[1], mean(alpha))
        self.assertGreater(opacity[1], 1.5 * opacity[0])
        self.assertGreater(opacity[2], 1.2 * opacity[1])
        self.assertGreater(mean(alpha, '--unit-distance', .1), 1.2 * opacity[1])
        self.assertGreater(mean(red, '--colormap', 'fire'), 4 * mean(blue, '--colormap', 'fire'))
        self.assertGreater(mean(green, '--no-shading'), 1.1 * mean(green))
        self.assertGreater(mean(red, '--background', '1,0,0'), 200)
        self.assertLess(mean(blue, '--background', '1,0,0'), 50)
        self.assertLess(mean(alpha, '--range', '50,100'), .3 * opacity[1])  # less of the bump is seen
        self.assertLess(mean(alpha, '--iso', 90), .3 * mean(alpha, '--iso', 30))
        self.assertAlmostEqual(mean(alpha, '--zoom', 2), 4 * opacity[1], delta=.2 * opacity[1])
        self.assertEqual(self.picture('--time', 2, '--gradient-noise', 'none'), self.picture('--time', 2, '--gradient-noise', 0))
        for noise in ('-1', 'nan', 'some'):
            self.refused(2, '--gradient-noise', 'render', 'v.bcc4', '--time', 2, '--gradient-noise=' + noise, '-o', 'x.png',
                         output='x.png')
        self.assertNotEqual(plain, self.picture('--time', 4))
        self.assertNotEqual(plain, self.picture('--plane', '0,0,1,0,-3'))
        self.assertEqual(plain, self.picture('--plane', '0,0,0,1,-2'))
        self.picture('--time', 2, '--reference', size='8x8')

    def test_one_frame_has_no_trail(self):
        self.volume((*DIMS[:3], 1), bump, '--quiet', name='still.bcc4')
        for more in (['--trail', 2], ['--trail', '2f,3', '--deep'], ['--trail=-1:1']):
            name = 'x.exr' if '--deep' in more else 'x.png'
            self.refused(2, '--trail: still.bcc4 has one frame', 'render', 'still.bcc4', *more, '-o', name, output=name)

    def test_trails(self):
        still = self.picture('--time', 4)
        self.assertEqual(still, self.picture('--time', 4, '--trail', 0))
        past = self.picture('--time', 4, '--trail', 2)
        self.assertNotEqual(still, past)
        self.assertEqual(past, self.picture('--index', '--time', 4, '--trail', 2))
        self.assertNotEqual(past, self.picture('--time', 4, '--trail', -1))  # the future
        self.assertNotEqual(past, self.picture('--time', 4, '--trail', '2,3'))
        for more in (['--trail-content', 'mean'], ['--trail-content', 'max'], ['--trail-mode', 'interleaved']):
            self.assertNotEqual(past, self.picture('--time', 4, '--trail', 2, *more), more)
        # Clipped to the series.
        self.assertEqual(self.picture('--time', 4, '--trail', 4), self.picture('--time', 4, '--trail', 40))

    def test_trails_around_the_slice_in_times_and_frames(self):
        time = ('--time', 3)
        past = self.picture(*time, '--trail', 2)
        self.assertEqual(past, self.picture(*time, '--trail', '-2:0'))
        self.assertEqual(past, self.picture(*time, '--trail', '2f'))  # one frame per unit of time
        self.assertEqual(self.picture(*time, '--trail', -2), self.picture(*time, '--trail', '0:2'))
        centred = self.picture(*time, '--trail', '-1:1')
        self.assertNotIn(centred, (past, self.picture(*time, '--trail', '0:2'), self.picture(*time)))
        self.assertNotEqual(centred, self.picture(*time, '--trail', '-1:1,2'))
        self.assertEqual(self.picture(*time), self.picture(*time, '--trail', '0:0'))
        for more in (['--trail-opacity', 3], ['--trail-colormap', 'fire'], ['--trail-range', '1,20'], ['--trail-samples', 1]):
            self.assertNotEqual(past, self.picture(*time, '--trail', 2, *more), more)
        self.picture(*time, '--dump-tf', 'own.json', '--colormap', 'fire', '--opacity', 3)
        self.assertNotEqual(past, self.picture(*time, '--trail', 2, '--trail-tf', 'own.json'))
        # A function for each of two sub-intervals, which is not the same as one for both, nor as the other way round.
        self.picture(*time, '--dump-tf', 'other.json', '--colormap', 'viridis', '--opacity', .2)
        two = self.picture(*time, '--trail', '2,2', '--trail-tf', 'own.json,other.json')
        self.assertNotIn(two, [self.picture(*time, '--trail', '2,2', '--trail-tf', t) for t in ('own.json', 'other.json,own.json')])
        self.assertEqual(self.picture(*time, '--trail', '2', '--trail-tf', 'own.json'),
                         self.picture(*time, '--trail', '2,2', '--trail-tf', 'own.json,own.json', '--trail-samples', 2))
        self.refused(2, '--trail-tf names 2 files for 1 sub-intervals', 'render', 'v.bcc4', *time, '--trail', 2,
                     '--trail-tf', 'own.json,other.json', '-o', 'x.png', output='x.png')
        for bad in ('x', '1:2:3', '2:1', '1,2,3', '1,0', '1,1.5', 'f', '1e999'):
            self.refused(2, '--trail', 'render', 'v.bcc4', *time, '--trail', bad, '-o', 'x.png', output='x.png')

    def test_shutters(self):
        time = ['--index', '--time', 4]
        past = self.picture(*time, '--trail', '2f', '--trail-samples', 8)
        self.assertEqual(past, self.picture(*time, '--trail', '2f', '--trail-samples', 8, '--shutter', 'box'))
        # Equal weights are a box, in any unit; the curve of a triangle is what its weights say.
        four = ['--trail', '2f,4', '--trail-samples', 2]
        box = self.picture(*time, *four, '--shutter', 'box')
        self.assertEqual(box, past)
        self.assertEqual(box, self.picture(*time, *four[:1], '2f', *four[2:], '--shutter', '3,3,3,3'))
        self.assertNotEqual(box, self.picture(*time, *four))  # whose sub-intervals have colours
        triangle = self.picture(*time, *four, '--shutter', 'triangle')
        self.assertNotEqual(box, triangle)
        self.assertEqual(triangle, self.picture(*time, *four, '--shutter', '1,3,3,1'))
        self.assertNotEqual(triangle, self.picture(*time, '--trail', '2f', '--shutter', 'triangle'))
        self.assertNotEqual(past, self.picture(*time, '--trail', '2f', '--trail-samples', 8, '--trail-unlit'))
        for bad, text in (('0,0', 'never open'), ('1,-1', 'weights are'), ('round', '--shutter'), ('1,2,1', 'names 3 weights for 2')):
            self.refused(2, text, 'render', 'v.bcc4', *time, '--trail', '2f,2', '--shutter', bad, '-o', 'x.png', output='x.png')
        self.refused(2, '--trail DT', 'render', 'v.bcc4', *time, '--shutter', 'box', '-o', 'x.png', output='x.png')

    def test_trails_off_the_time_axis(self):
        plane = ('--plane', '1,0,0,0,-4')
        still = self.picture(*plane)
        past = self.picture(*plane, '--trail', 2)
        self.assertNotEqual(still, past)
        self.assertNotEqual(past, self.picture(*plane, '--trail', -2))
        self.assertEqual(past, self.picture(*plane, '--trail', '2f'))
        self.assertEqual(still, self.picture(*plane, '--trail', '50:60'))  # clipped to nothing
        self.picture('--plane', '1,1,0,1,-8', '--trail', '-1:1')

    def test_statistics_have_the_keys_promised(self):
        self.picture('--time', 2, '--stats', 's.json', '--repeat', 3)
        with open(self.path('s.json')) as f:
            j = json.load(f)
        self.assertEqual(set(j), {'ms', 'cpu_ms', 'threads', 'points', 'bytes_read', 'bytes_read_by', 'bytes_file', 'tiles', 'sheets',
                                  'sheets_skipped', 'sheets_reused', 'bricks', 'brick_visits', 'kernel', 'sheet_step', 'level', 'coarse_level', 'preintegrated', 'backend'})
        self.assertEqual(set(j['bricks']), {'total', 'invisible', 'outside'})
        self.assertEqual(set(j['brick_visits']), {'total', 'hidden', 'unread'})
        self.assertLessEqual(j['bytes_read_by']['slice'] + j['bytes_read_by']['render'], j['bytes_read'])
        self.assertEqual(set(j['ms']), {'open', 'slice', 'transform', 'splat', 'shade', 'total'})
        self.assertEqual(set(j['points']), {'total', 'after_cull', 'splatted', 'occluded', 'invisible'})
        self.assertEqual(j['bytes_file'], os.path.getsize(self.path('v.bcc4')))
        self.assertGreater(j['ms']['total'], 0)
        self.assertGreater(j['sheets'], 0)

    def test_sequences_are_numbered_by_frame(self):
        self.bcc4('render', 'v.bcc4', '--frames', '1-5x2', '-o', 'p.%03d.png', '--size', '8x8', '--stats', 's.json')
        self.assertEqual(sorted(n for n in os.listdir(self.folder) if n.endswith('.png')), ['p.001.png', 'p.003.png', 'p.005.png'])
        self.bcc4('render', 'v.bcc4', '--frames', '0-1x0.5', '-o', 'q.##.png', '--size', '8x8')
        self.assertEqual(sorted(n for n in os.listdir(self.folder) if n.startswith('q')), ['q.00.png', 'q.01.png', 'q.02.png'])
        self.picture('--index', '--time', 3, size='8x8')
        with open(self.path('p.003.png'), 'rb') as a, open(self.path('p.png'), 'rb') as b:
            self.assertEqual(a.read(), b.read())
        with open(self.path('s.json')) as f:
            self.assertEqual(len(json.load(f)['frames']), 3)
        self.refused(2, 'pattern', 'render', 'v.bcc4', '--frames', '0-2', '-o', 'x.png', output='x.png')
        self.refused(2, '0 to 5', 'render', 'v.bcc4', '--frames', '4-6', '-o', 'x.%d.png')

    def test_turntables_turn_the_camera(self):
        self.bcc4('render', 'v.bcc4', '--time', 2, '--turntable', 4, '-o', 't.%d.png', '--size', '16x16', '--stats', 's.json')
        names = [f't.{i}.png' for i in range(4)]
        self.assertEqual(sorted(n for n in os.listdir(self.folder) if n.startswith('t.')), names)
        for i, angle in enumerate((30, 120, 210, 300)):
            with open(self.path(names[i]), 'rb') as f:
                self.assertEqual(f.read(), self.picture('--time', 2, '--rotate-y', angle, size='16x16'), angle)
        with open(self.path('s.json')) as f:
            self.assertEqual(len(json.load(f)['frames']), 4)
        self.refused(2, 'pattern', 'render', 'v.bcc4', '--time', 2, '--turntable', 4, '-o', 'x.png', output='x.png')
        self.refused(2, 'exclude', 'render', 'v.bcc4', '--sweep', '0:1,2', '--turntable', 2, '-o', 'x.%d.png')

    def test_turntables_cut_once(self):
        self.volume(DIMS, bump, '--quiet', '--levels', 1, '--overwrite')
        for more in ((), ('--iso', 40), ('--iso', 40, '--camera', 'persp'), ('--trail', '1.5f'), ('--zoom', 6)):
            self.bcc4('render', 'v.bcc4', '--time', 2, '--turntable', 3, '-o', 't.%d.png', '--size', '40x40', '--stats', 's.json',
                      *more)
            for i in range(3):
                with open(self.path(f't.{i}.png'), 'rb') as f:
                    alone = self.picture('--time', 2, '--rotate-y', 30 + 120 * i, *more, size='40x40')
                    self.assertEqual(f.read(), alone, (more, i))
            with open(self.path('s.json')) as f:
                slicing = [frame['ms']['slice'] for frame in json.load(f)['frames']]
            self.assertGreater(slicing[0], 0)
            if more != ('--zoom', 6): # else each picture sees other samples
                self.assertEqual(slicing[1:], [0, 0], more)

    def test_frames_go_by_while_the_camera_turns(self):
        self.bcc4('render', 'v.bcc4', '--frames', '0-2', '--turntable', 8, '-o', 'b.%d.png', '--size', '16x16')
        self.assertEqual(sorted(n for n in os.listdir(self.folder) if n.startswith('b.')), [f'b.{i}.png' for i in range(3)])
        for i in range(3):
            with open(self.path(f'b.{i}.png'), 'rb') as f:
                self.assertEqual(f.read(), self.picture('--time', i, '--index', '--rotate-y', 30 + 45 * i, size='16x16'), i)

    def test_several_surfaces_with_opacities(self):
        def alphas(*more):
            self.bcc4('render', 'v.bcc4', '--time', 2, '-o', 'i.png', '--size', '40x40', '--quiet', '--smooth-edges', 'off', *more)
            return [a for row in read_png(self.path('i.png')) for *_, a in row]

        low, high = 20, 70
        one = alphas('--iso', low)
        self.assertEqual(one, alphas('--iso', f'{low}:1'))
        self.assertEqual(one, alphas('--iso', f'{low}:1,{high}:0'))
        thin, both = alphas('--iso', f'{low}:.3'), alphas('--iso', f'{low}:.3,{high}')
        self.assertEqual([a > 0 for a in thin], [a > 0 for a in one])
        self.assertLess(max(thin), 255)
        self.assertEqual(max(both), 255)
        self.assertGreater(sum(a == 255 for a in both), 5)
        self.assertEqual([a > 0 for a in both], [a > 0 for a in one])
        self.bcc4('render', 'v.bcc4', '--time', 2, '-o', 'i.png', '--size', '40x40', '--quiet', '--no-shading', '--smooth-edges', 'off',
                  '--iso', f'{low}:1:#ff8000')
        self.assertEqual({pixel[:3] for row in read_png(self.path('i.png')) for pixel in row if pixel[3]}, {(255, 128, 0)})
        args = ['render', 'v.bcc4', '--time', 2, '-o', 'i.png', '--size', '40x40', '--quiet', '--iso']
        self.assertRegex(self.bcc4(*args, f'{low},999')[1], r'warning: --iso 999: the values are \d')
        self.assertEqual(self.bcc4(*args, low)[1], '')
        for wrong in (f'{low}:2', 'x', f'{low}:1:red', ','.join(['1'] * 17)):
            self.refused(2, '--iso', 'render', 'v.bcc4', '--time', 2, '--iso', wrong, '-o', 'x.png', output='x.png')
        self.refused(2, 'opaque', 'render', 'v.bcc4', '--time', 2, '--iso', f'{low}:.5', '--trail', '1f', '-o', 'x.png', output='x.png')

    def test_zoom_narrows_the_view(self):
        with open(self.path('c.json'), 'w') as f:
            json.dump(dict(position=[4.5, 4, -30], target=[4.5, 4, 3.5], ortho_height=10), f)
        with open(self.path('d.json'), 'w') as f:
            json.dump(dict(position=[4.5, 4, -30], target=[4.5, 4, 3.5], ortho_height=5), f)
        self.assertEqual(self.picture('--time', 2, '--camera', 'c.json', '--zoom', 2), self.picture('--time', 2, '--camera', 'd.json'))
        for camera in ('ortho', 'persp'):
            self.assertNotEqual(self.picture('--time', 2, '--camera', camera), self.picture('--time', 2, '--camera', camera, '--zoom', 2))
            self.assertEqual(self.picture('--time', 2, '--camera', camera), self.picture('--time', 2, '--camera', camera, '--zoom', 1))
        self.refused(2, '--zoom', 'render', 'v.bcc4', '--time', 2, '--zoom', 0, '-o', 'x.png', output='x.png')

    def test_cameras_move_through_their_frames(self):
        def camera(position):
            return dict(position=position, target=[4.5, 4, 3.5], ortho_height=12)
        places = [[4.5, 4, -30], [30, 4, 3.5], [10, 30, -20]]
        with open(self.path('path.json'), 'w') as f:
            json.dump(dict(target=[4.5, 4, 3.5], ortho_height=12, resolution=[12, 10], frames=[dict(position=p) for p in places]), f)
        self.bcc4('render', 'v.bcc4', '--time', 2, '--camera', 'path.json', '-o', 'c.%d.png')
        self.bcc4('render', 'v.bcc4', '--frames', '1-3', '--camera', 'path.json', '-o', 'f.%d.png')
        for i, place in enumerate(places):
            with open(self.path('one.json'), 'w') as f:
                json.dump(camera(place), f)
            for time, name in ((2, f'c.{i}.png'), (i + 1, f'f.{i + 1}.png')):
                with open(self.path(name), 'rb') as f:
                    self.assertEqual(f.read(), self.picture('--index', '--time', time, '--camera', 'one.json', size='12x10'), name)
        self.refused(2, '3 frames', 'render', 'v.bcc4', '--frames', '1-2', '--camera', 'path.json', '-o', 'x.%d.png')
        # A turntable about a camera of a file is the file's camera on a circle.
        with open(self.path('one.json'), 'w') as f:
            json.dump(camera(places[0]), f)
        self.bcc4('render', 'v.bcc4', '--time', 2, '--camera', 'one.json', '--turntable', 4, '-o', 'o.%d.png', '--size', '12x10')
        with open(self.path('half.json'), 'w') as f:
            json.dump(camera([4.5, 4, 37]), f)
        self.picture('--time', 2, '--camera', 'half.json', size='12x10')
        self.assertEqual(png_size(self.path('o.2.png')), (12, 10))
        self.assertLessEqual(self.difference('o.2.png', 'p.png'), 2)
        self.assertGreater(self.difference('o.2.png', 'o.0.png'), 20)

    def difference(self, a, b):
        """The largest of two pictures' channels."""
        a, b = (read_png(self.path(name)) for name in (a, b))
        self.assertEqual((len(a), len(a[0])), (len(b), len(b[0])))
        return max(abs(p - q) for rows in zip(a, b) for pixels in zip(*rows) for p, q in zip(*pixels))

    def test_transfer_functions_come_and_go_as_paraview_json(self):
        self.picture('--time', 2, '--colormap', 'inferno', '--opacity', 2, '--dump-tf', 'tf.json')
        with open(self.path('tf.json')) as f:
            j = json.load(f)
        self.assertEqual(j[0]['ColorSpace'], 'RGB')
        self.assertEqual(len(j[0]['RGBPoints']) % 4, 0)
        self.picture('--time', 2, '--tf', 'tf.json', name='q.png')
        self.assertLessEqual(self.difference('p.png', 'q.png'), 2)  # up to rounding of the colours
        self.picture('--time', 2, name='q.png')
        self.assertGreater(self.difference('p.png', 'q.png'), 20)
        for space in ('RGB', 'HSV', 'Lab', 'Diverging', 'Step'):
            with open(self.path('m.json'), 'w') as f:
                json.dump([{'ColorSpace': space, 'Name': 'm', 'RGBPoints': [0, .2, .3, .8, 50, .9, .9, .9, 100, .7, 0, .1],
                            'Points': [0, 0, .5, 0, 100, .8, .5, 0]}], f)
            self.picture('--time', 2, '--tf', 'm.json')
        for text, part in (('{', 'no JSON'), ('[]', 'ParaView'), ('[{"RGBPoints": [1, 2, 3]}]', 'groups of 4'),
                           ('[{"RGBPoints": [5, 0, 0, 0, 1, 1, 1, 1]}]', 'must rise'), ('[{"RGBPoints": [1, "a", 0, 0]}]', 'numbers')):
            self.write('bad.json', text.encode())
            self.refused(3, part, 'render', 'v.bcc4', '--time', 2, '-o', 'x.png', '--tf', 'bad.json', output='x.png')
        self.refused(2, 'did you mean viridis?', 'render', 'v.bcc4', '--time', 2, '-o', 'x.png', '--colormap', 'viridi', output='x.png')

    def test_narrow_functions_are_drawn_between_sheets(self):
        def draw(half, *choice):
            with open(self.path('n.json'), 'w') as f:
                json.dump([{'ColorSpace': 'RGB', 'Name': 'n', 'RGBPoints': [0, 1, 1, 1, 100, 1, 1, 1],
                            'Points': [40 - half, 0, .5, 0, 40, .9, .5, 0, 40 + half, 0, .5, 0]}], f)
            picture = self.picture('--time', 2, '--tf', 'n.json', '--stats', 's.json', *choice)
            with open(self.path('s.json')) as f:
                return picture, json.load(f)['preintegrated']

        off, on, by_itself = (draw(.5, *choice) for choice in (('--preintegrate', 'off'), ('--preintegrate', 'on'), ()))
        self.assertNotEqual(off[0], on[0])
        self.assertEqual((off[1], on[1], by_itself), (False, True, on))
        off, by_itself = draw(40, '--preintegrate', 'off', '--step', '.25'), draw(40, '--preintegrate', 'auto', '--step', '.25')
        self.assertEqual(off, by_itself)
        self.assertFalse(off[1])
        self.refused(2, '--preintegrate', 'render', 'v.bcc4', '--time', 2, '-o', 'x.png', '--preintegrate', 'maybe', output='x.png')

    def test_edges_of_isosurfaces_are_smooth_but_of_drafts(self):
        def draw(quality, *choice):
            return self.picture('--time', 2, '--iso', 40, '--quality', quality, *choice)

        for quality, default in (('draft', 'off'), ('normal', 'on'), ('fine', 'on')):
            pictures = {choice: draw(quality, '--smooth-edges', choice) for choice in ('on', 'off', 'auto')}
            self.assertNotEqual(pictures['on'], pictures['off'])
            self.assertEqual(pictures['auto'], pictures[default])
            self.assertEqual(pictures['auto'], draw(quality))
        self.refused(2, '--smooth-edges', 'render', 'v.bcc4', '--time', 2, '-o', 'x.png', '--smooth-edges', 'maybe', output='x.png')

    def test_cameras_from_files(self):
        def camera(**c):
            with open(self.path('c.json'), 'w') as f:
                json.dump(c, f)
            return ['--camera', 'c.json']

        look = dict(position=[4.5, 4, -30], target=[4.5, 4, 3.5], up=[0, -1, 0])
        self.bcc4('render', 'v.bcc4', '--time', 2, '-o', 'a.png', *camera(**look, ortho_height=10, resolution=[14, 11]))
        self.assertEqual(png_size(self.path('a.png')), (14, 11))
        self.assertNotEqual(self.picture('--time', 2, *camera(**look, fovy_deg=20)), self.picture('--time', 2, *camera(**look, ortho_height=10)))
        for bad, part in ((dict(look), 'fovy_deg'), (dict(look, fovy_deg=-1), 'positive'), (dict(look, fovy_deg=20, positon=1), 'did you mean position?'),
                          (dict(position=[0, 0, 0], fovy_deg=20), 'target'), (dict(look, up=[1, 2], fovy_deg=20), 'three numbers')):
            self.refused(3, part, 'render', 'v.bcc4', '--time', 2, '-o', 'x.png', *camera(**bad), output='x.png')

    def test_refusals(self):
        go = ('render', 'v.bcc4', '--time', 2, '-o', 'x.png')
        self.refused(2, '.png or .exr', 'render', 'v.bcc4', '--time', 2, '-o', 'x.jpg', output='x.jpg')
        self.refused(2, 'value of an isosurface', *go, '--mode', 'mip', '--iso', 3, output='x.png')
        self.refused(2, '--opacity inf', *go, '--opacity', 'inf', output='x.png')
        self.refused(2, 'WxH', *go, '--size', '0x5', output='x.png')
        self.refused(2, 'WxH', *go, '--size', '512x', output='x.png')
        self.refused(2, 'did you mean composite?', *go, '--mode', 'compsite', output='x.png')
        self.refused(2, '--trail DT', *go, '--trail-mode', 'interleaved', output='x.png')
        self.refused(2, '0 to 1', *go, '--background', '255,0,0', output='x.png')
        self.refused(2, 'exclude', *go, '--tf', 'a.json', '--colormap', 'fire', output='x.png')
        self.refused(2, 'camera read from a file', *go, '--camera', 'c.json', '--rotate-x', 3, output='x.png') if self.write(
            'c.json', b'{"position": [0,0,-9], "target": [0,0,0], "fovy_deg": 30}') else None
        self.refused(3, 'none/x.png', 'render', 'v.bcc4', '--time', 2, '-o', 'none/x.png', '--size', '8x8')


if __name__ == '__main__':
    main()

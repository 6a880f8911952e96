"""bcc4 render of several channels and volumes in one picture, with labels, shadow and ambient occlusion; bcc4 probe of many
places."""
import csv
import json
import math

from harness import ToolTest, field, main, read_png

SIDE = 20
MIDDLE = (SIDE - 1) / 2
PIXELS = 40


def ball(x, y, z, t):
    return 100 * math.exp(-((x - MIDDLE) ** 2 + (y - MIDDLE) ** 2 + (z - MIDDLE) ** 2) / 30)


def heat(x, y, z, t):
    return 10 * x + y


def thirds(x, y, z, t):
    return 0 if x < 6.5 else 2 if x < 12.5 else 5


class Beside(ToolTest):
    store = 'samples'

    def setUp(self):
        super().setUp()
        self.volume((SIDE, SIDE, SIDE, 3), ball, '--quiet')

    def channels(self):
        """Density, heat and labels of one grid."""
        arrays = [field((SIDE, SIDE, SIDE, 1), f, 'B').tobytes() for f in (ball, heat, thirds)]
        self.write('c.raw', b''.join(arrays))
        self.bcc4('import', 'c.raw', '--dims', f'{SIDE},{SIDE},{SIDE}', '--dtype', 'u8', '--count', 3, '--lattice', 'cc',
                  '-o', 'c.bcc4', '--quiet')

    def picture(self, *args, file='v.bcc4', name='p.png'):
        where = () if '--time' in args else ('--index', '--time', 0, '--view', 'front')
        self.bcc4('render', file, '-o', name, '--size', PIXELS, '--quiet', *where, *args)
        return read_png(self.path(name))

    def test_two_volumes_are_in_one_picture_whatever_their_order(self):
        self.volume((SIDE, SIDE, SIDE, 3), ball, '--quiet', name='w.bcc4')
        looks = ('--range', '0,100', '--colormap', 'gray')
        one = self.picture(*looks, '--with', 'w.bcc4,range=0:100,colormap=magma,move=12:0:0')
        self.assertGreater(sum(p[3] for row in one for p in row), 0)
        alone = self.picture(*looks)
        self.assertNotEqual(one, alone)
        other = self.picture('--range', '0,100', '--colormap', 'magma', '--with',
                             'v.bcc4,range=0:100,colormap=gray,move=-12:0:0', file='w.bcc4')
        # The same picture, which is elsewhere in the world.
        worst = max(abs(a - b) for r, s in zip(one, other) for p, q in zip(r, s) for a, b in zip(p, q))
        self.assertLessEqual(worst, 12)
        mean = sum(abs(a - b) for r, s in zip(one, other) for p, q in zip(r, s) for a, b in zip(p, q)) / (4 * PIXELS ** 2)
        self.assertLess(mean, 0.5)
        # Two halves in one place are the volume.
        half = self.picture(*looks, '--opacity', 0.5, '--with', 'v.bcc4,range=0:100,colormap=gray,opacity=0.5')
        middle = half[PIXELS // 2][PIXELS // 2]
        self.assertGreater(middle[3], 30)
        for wrong, text in (('w.bcc4,hue=3', 'no key hue'), ('w.bcc4,range=3', '2 numbers'),
                            ('w.bcc4,look=bones', 'must be auto'), ('w.bcc4,density=0', 'positive')):
            self.refused(2, text, 'render', 'v.bcc4', '-o', 'w.png', '--with', wrong, output='w.png')
        # They are seen from the side that one of them is, and fill the picture: what is moved to the right is on the right.
        self.volume((SIDE, SIDE, SIDE, 1), lambda x, y, z, t: 100 if abs(x - 3) + abs(y - 9) + abs(z - 9) < 3 else 0, '--quiet', name='d.bcc4')
        dots = self.picture('--range', '0,100', '--colormap', 'gray', '--no-shading', '--with',
                            'd.bcc4,move=12:0:0,range=0:100,colormap=magma', file='d.bcc4')
        across = [[sum(r[x][c] * r[x][3] for r in dots) for c in range(3)] for x in range(PIXELS)]
        seen = [x for x, column in enumerate(across) if sum(column) > 999]
        self.assertLess(seen[0], 6)
        self.assertGreater(seen[-1], PIXELS - 11)
        left, right = across[seen[0] + 2], across[seen[-1] - 2]
        self.assertLess(max(left), 1.05 * min(left), 'gray')
        self.assertGreater(max(right), 1.3 * min(right), 'and pink')
        self.refused(3, 'nowhere.bcc4', 'render', 'v.bcc4', '-o', 'w.png', '--time', 1, '--with', 'nowhere.bcc4',
                     output='w.png')
        self.refused(2, 'a plane off the time axis', 'render', 'v.bcc4', '-o', 'w.png', '--plane', '1,0,0,0,-9', '--with',
                     'w.bcc4', output='w.png')

    def test_units_are_those_of_the_first(self):
        """Moments are one by the dates of both, places by their lengths."""
        def make(name, times, step, unit, length, epoch='', shift=0):
            head = (f'NRRD0005\ntype: uint8\ndimension: 4\nspace dimension: 3\nsizes: {SIDE} {SIDE} {SIDE} 3\nspace directions: ({step},0,0) (0,{step},0) '
                    f'(0,0,{step}) none\nspace units: "{length}" "{length}" "{length}"\nunits: "" "" "" "{unit}"\nkinds: space space space time\nencoding: raw\n'
                    f'axis 3 index type:=numeric\naxis 3 index values:={times}\n{epoch}\n')
            moved = lambda x, y, z, t: ball(x - 3 * (t + shift), y, z, 0)
            self.write('b.nrrd', head.encode() + field((SIDE, SIDE, SIDE, 3), moved, 'B').tobytes())
            self.bcc4('import', 'b.nrrd', '-o', name, '--quiet', '--overwrite')
        looks = 'range=0:100,colormap=magma,move=30:0:0'
        first = 'time epoch:=2000-01-01\n'
        make('a.bcc4', '0 1 2', 1, 'days', 'mm', first)
        seen = lambda: self.picture('--time', 1, '--view', 'front', '--range', '0,100', '--with', f'b.bcc4,{looks}', file='a.bcc4')
        make('b.bcc4', '0 1 2', 1, 'days', 'mm', first)
        same = seen()
        for case in (('0 24 48', .001, 'hours', 'm', first), ('1 2 3', 1000, 'd', 'um', 'time epoch:=1999-12-31\n'), ('0 1 2', 1, '', '')):
            make('b.bcc4', *case)
            self.assertLessEqual(self.worst(same, seen()), 1, case)
        make('b.bcc4', '0 1 2', 1, 'days', 'mm', 'time epoch:=2000-01-02\n')
        self.assertGreater(self.worst(same, seen()), 20)
        for case, text in ((('0 1 2', 1, 'furlongs', 'mm'), 'its times are in furlongs, those of the first volume in days'),
                           (('0 1 2', 1, 'days', 'mm', first + 'time calendar:=noleap\n'), 'calendar noleap'),
                           (('0 1 2', 1, 'days', 'hPa'), 'its x is in hPa, that of the first volume in mm')):
            make('b.bcc4', *case)
            self.refused(3, text, 'render', 'a.bcc4', '-o', 'w.png', '--time', 1, '--with', 'b.bcc4', output='w.png')

    def test_volumes_have_trails(self):
        self.volume((SIDE, SIDE, SIDE, 5), lambda x, y, z, t: ball(x - 2 * t + 4, y, z, 0), '--quiet', name='m.bcc4')
        self.volume((SIDE, SIDE, SIDE, 5), lambda x, y, z, t: ball(x - 2 * t + 4, y, z, 0), '--quiet', '--dt', 0.5, name='h.bcc4')

        def seen(x, *args, file='m.bcc4', time=2):
            """From the front, around that x."""
            camera = {'position': [x, MIDDLE, 100], 'target': [x, MIDDLE, 0], 'ortho_height': 24}
            self.write('camera.json', json.dumps(camera).encode())
            return self.picture('--time', time, '--camera', 'camera.json', '--range', '0,100', '--colormap', 'gray', *args, file=file)

        looks = 'range=0:100,colormap=gray'
        far = ('--with', f'm.bcc4,{looks},move=1000:0:0')
        still = seen(MIDDLE)
        self.assertEqual(still, seen(MIDDLE, *far))
        for trail in (('--trail', 2), ('--trail', '-1:1f,3'), ('--trail', 2, '--shutter', 'triangle'), ('--trail', 2, '--trail-unlit'),
                      ('--trail', 2, '--trail-colormap', 'fire', '--trail-opacity', 3), ('--trail', 2, '--iso', 50),
                      ('--trail', 2, '--trail-mode', 'interleaved', '--trail-content', 'mean', '--trail-samples', 3)):
            alone = seen(MIDDLE, *trail)
            self.assertNotEqual(alone, seen(MIDDLE, *trail[2:] if '--iso' in trail else ()), trail)
            self.assertEqual(alone, seen(MIDDLE, *trail, *far), trail)
        # The trail of the other one, where that is.
        for trail, key in ((('--trail', 2), 'trail=2'), (('--trail', '-1:1f'), 'trail=-1:1f'), (('--trail', -2), 'trail=-2')):
            alone, other = seen(MIDDLE, *trail), seen(MIDDLE + 1000, '--with', f'm.bcc4,{looks},move=1000:0:0,{key}')
            self.assertLessEqual(self.worst(alone, other), 2)
            self.assertGreater(self.worst(still, other), 20)
        past = seen(MIDDLE, '--trail', 2, '--shutter', 'triangle')
        self.assertLessEqual(self.worst(past, seen(MIDDLE + 1000, '--shutter', 'triangle', '--with', f'm.bcc4,{looks},move=1000:0:0,trail=2')), 2)
        # Times are those of the world, also where the first volume's frames say which: half as long are the other's frames.
        there = MIDDLE + 1000
        two = seen(there, '--with', f'h.bcc4,{looks},move=1000:0:0,trail=2f', time=1)
        self.assertEqual(two, seen(there, '--with', f'h.bcc4,{looks},move=1000:0:0,trail=1', time=1))
        self.assertNotEqual(two, seen(there, '--with', f'h.bcc4,{looks},move=1000:0:0,trail=1f', time=1))
        frames = ('--frames', '1-2', '--overwrite')
        camera = ('--camera', 'camera.json', '--size', PIXELS, '--quiet', '--range', '0,100', '--colormap', 'gray')
        self.bcc4('render', 'm.bcc4', *frames, *camera, '-o', 'f.%d.png', '--with', f'h.bcc4,{looks},move=1000:0:0,trail=1')
        self.assertEqual(two, read_png(self.path('f.1.png')))
        # Extinctions add, those of trails as well: two of half are the volume, thin as it is.
        thin = ('--no-shading', '--trail', 2)
        whole, halves = (seen(MIDDLE, *thin, '--opacity', o, *more) for o, more in (
            (.05, ()), (.025, ('--with', f'm.bcc4,{looks},opacity=.025,trail=2'))))
        self.assertLessEqual(self.worst(whole, halves), 2)
        self.assertGreater(max(p[3] for row in whole for p in row), 30)
        self.assertGreater(self.worst(whole, seen(MIDDLE, *thin, '--opacity', .025, '--with', f'm.bcc4,{looks},opacity=.025')), 4)
        self.channels()
        go = ('render', 'm.bcc4', '-o', 'w.png', '--time', 1)
        for args, words in ((('--trail', 1, '--color-channel', 0), 'without --color-channel'),
                            (('--trail', 1, '--mask-channel', 0, '--mask-labels', 1), 'without --color-channel'),
                            (('--with', 'h.bcc4,trail=1,color-channel=0'), 'not both'), (('--with', 'h.bcc4,trail=x'), 'a number'),
                            (('--with', 'c.bcc4,trail=1'), 'c.bcc4 has one frame'), (('--with', 'h.bcc4', '--shutter', 'box'), '--trail DT'),
                            (('--with', 'h.bcc4,trail=1', '--trail-opacity', 2), 'go with --trail DT'),
                            (('--with', 'h.bcc4,trail=1', '--shadow'), '--trail')):
            self.refused(2, words, *go, *args, output='w.png')

    def worst(self, one, other):
        return max(abs(a - b) for r, s in zip(one, other) for p, q in zip(r, s) for a, b in zip(p, q))

    def test_shadow_and_occlusion_darken(self):
        plain = self.picture('--light', '0,1,0')
        for options in (('--shadow',), ('--ao',), ('--shadow', '--ao')):
            dark = self.picture('--light', '0,1,0', *options)
            self.assertEqual([[p[3] for p in row] for row in dark], [[p[3] for p in row] for row in plain], 'opacity stays')
            self.assertLess(sum(p[1] for row in dark for p in row), 0.97 * sum(p[1] for row in plain for p in row), options)
        lower = slice(PIXELS // 2, PIXELS)
        shadowed = self.picture('--light', '0,1,0', '--shadow')
        lost = [sum(p[1] * p[3] for row in rows for p in row) for rows in (plain[lower], shadowed[lower],
                                                                           plain[:PIXELS // 2], shadowed[:PIXELS // 2])]
        self.assertLess(lost[1] / lost[0], 0.95 * lost[3] / lost[2], 'what is away from the light')
        for more in ('--no-shading', '--reference'):
            self.refused(2, 'lit composites', 'render', 'v.bcc4', '-o', 'w.png', '--time', 1, '--shadow', more, output='w.png')
        self.refused(2, 'direction', 'render', 'v.bcc4', '-o', 'w.png', '--time', 1, '--light', '0,0,0', output='w.png')

    def test_colours_are_another_channels(self):
        self.channels()
        density = ('--channel', 0, '--range', '0,100', '--no-shading', '--background', '0,0,0')
        painted = self.picture(*density, '--color-channel', 1, '--color-range', '0,200', '--color-colormap', 'gray', file='c.bcc4')
        gray = self.picture(*density, '--colormap', 'gray', file='c.bcc4')
        row = painted[PIXELS // 2]
        bright = [p[0] for p in row]
        lit = [n for n, b in enumerate(bright) if b > 20]
        self.assertGreater(len(lit), 8)
        self.assertGreater(row[PIXELS // 2 + 4][0], row[PIXELS // 2 - 4][0] + 10, 'heat rises to the right')
        mirrored = gray[PIXELS // 2]
        self.assertLess(abs(mirrored[PIXELS // 2 + 4][0] - mirrored[PIXELS // 2 - 5][0]), 12, 'and density does not')
        surface = self.picture('--channel', 0, '--iso', 50, '--no-shading', '--color-channel', 1, '--color-range', '0,200',
                               '--color-colormap', 'gray', file='c.bcc4')
        across = [p[0] for p in surface[PIXELS // 2] if p[3] == 255]
        self.assertEqual(across, sorted(across))
        self.assertGreater(across[-1], across[0] + 30)
        self.refused(2, 'X-ray', 'render', 'c.bcc4', '-o', 'w.exr', '--mode', 'xray', '--color-channel', 1, output='w.exr')
        self.refused(2, '--color-channel', 'render', 'c.bcc4', '-o', 'w.png', '--color-range', '0,1', output='w.png')

    def test_labels_are_nearest_and_mask(self):
        self.channels()
        slices = self.bcc4('slice', 'c.bcc4', '--channel', 2, '--time', 0, '-o', 's.nrrd', '--quiet')
        self.assertIsNotNone(slices)
        values = self.json('probe', 'c.bcc4', '--channel', 2, '--index', '--at', '6.4,3,3', '--at', '6.6,3,3', '--at', '12.6,3.5,3')
        self.assertEqual(values[0]['values'], [0, 2, 5])
        whole = self.picture('--channel', 0, '--range', '0,100', '--no-shading', file='c.bcc4')
        masked = self.picture('--channel', 0, '--range', '0,100', '--no-shading', '--mask-channel', 2, '--mask-labels', '2',
                              file='c.bcc4')
        self.assertLess(sum(p[3] for row in masked for p in row), 0.8 * sum(p[3] for row in whole for p in row))
        both = self.picture('--channel', 0, '--range', '0,100', '--no-shading', '--mask-channel', 2, '--mask-labels', '0,2,5',
                            file='c.bcc4')
        worst = max(abs(a - b) for r, s in zip(both, whole) for p, q in zip(r, s) for a, b in zip(p, q))
        self.assertLessEqual(worst, 2)
        for args in (('--mask-labels', '1'), ('--mask-channel', '0')):
            self.refused(2, 'go together', 'render', 'v.bcc4', '-o', 'w.png', '--time', 1, *args, output='w.png')

    def test_many_places_make_a_table(self):
        places = [(1 + n % 17, 2 + n % 13, 3 + n % 11) for n in range(60)]
        self.write('places.csv', ('z,name,x,y\n' + ''.join(f'{z},at {n},{x},{y}\n' for n, (x, y, z) in enumerate(places))).encode())
        self.write('bare.csv', ''.join(f'{x},{y},{z}\n' for x, y, z in places).encode())
        self.bcc4('probe', 'v.bcc4', '--points', 'places.csv', '-o', 'series.csv')
        with open(self.path('series.csv'), newline='') as f:
            rows = list(csv.reader(f))
        self.assertEqual(rows[0], ['time'] + [f'at {n}' for n in range(60)])
        self.assertEqual([float(r[0]) for r in rows[1:]], [0, 1, 2])
        for row in rows[1:]:
            for value, (x, y, z) in zip(row[1:], places):
                self.assertAlmostEqual(float(value), ball(x, y, z, 0), delta=1.5)
        self.bcc4('probe', 'v.bcc4', '--points', 'bare.csv', '-o', 'bare_series.csv')
        with open(self.path('bare_series.csv'), newline='') as f:
            bare = list(csv.reader(f))
        self.assertEqual(bare[0][:3], ['time', 'p1', 'p2'])
        self.assertEqual([r[1:] for r in bare[1:]], [r[1:] for r in rows[1:]])
        at = [arg for x, y, z in places[:3] for arg in ('--at', f'{x},{y},{z}')]
        printed = self.bcc4('probe', 'v.bcc4', *at)[0].split('\n')[0].split('\t')[1:]
        self.assertEqual(printed, rows[1][1:4])
        self.refused(2, 'exists', 'probe', 'v.bcc4', '--points', 'bare.csv', '-o', 'series.csv')
        self.write('wrong.csv', b'1,2,3\n4,five,6\n')
        self.refused(3, 'line 2', 'probe', 'v.bcc4', '--points', 'wrong.csv')
        self.write('empty.csv', b'# nothing\n')
        self.refused(3, 'no points', 'probe', 'v.bcc4', '--points', 'empty.csv')


if __name__ == '__main__':
    main()

"""Pictures that say what they show: text is read back by tesseract where it is installed, the rest is looked for in the pixels."""
import math
import re
import shutil
import struct
import subprocess
import unittest
import zlib

from harness import BCC4, ToolTest, field, main, read_png

DIMS = (20, 18, 16, 6)
WHITE, BLACK, GREY = (('--background', f'{v},{v},{v}') for v in (1, 0, .45))
READER = unittest.skipUnless(shutil.which('tesseract'), 'tesseract is not here: the text of pictures is not read back')


def bump(x, y, z, t):
    return 100 * math.exp(-((x - 9 - .3 * t) ** 2 + (y - 8) ** 2 + (z - 8) ** 2) / 12)


def write_png(path, rows):
    """Rows of grey bytes."""
    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))
    with open(path, 'wb') as f:
        f.write(b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', len(rows[0]), len(rows), 8, 0, 0, 0, 0)) +
                chunk(b'IDAT', zlib.compress(b''.join(b'\0' + row for row in rows), 1)) + chunk(b'IEND', b''))


def enlarged(rows, factor):
    """Linearly between the pixels, as text is smoother for who reads it."""
    def between(one, other):
        return [[a + (b - a) * k / factor for a, b in zip(one, other)] for k in range(factor)]

    tall = [row for one, other in zip(rows, rows[1:]) for row in between(one, other)]
    columns = list(zip(*tall))
    wide = [column for one, other in zip(columns, columns[1:]) for column in between(one, other)]
    return [bytes(map(int, row)) for row in zip(*wide)]


class Annotate(ToolTest):
    def setUp(self):
        super().setUp()
        self.write('flow.nrrd', b'NRRD0005\ntype: float\ndimension: 4\nspace dimension: 3\nsizes: 20 18 16 6\n'
                   b'kinds: space space space time\nspace directions: (2,0,0) (0,2,0) (0,0,2) none\nspace units: "mm" "mm" "mm"\n'
                   b'spacings: nan nan nan 250\nunits: "" "" "" "ms"\nencoding: raw\nendian: little\n\n' + field(DIMS, bump, 'f').tobytes())
        self.bcc4('import', 'flow.nrrd', '-o', 'flow.bcc4', '--quiet')
        tried = subprocess.run([BCC4, 'render', 'flow.bcc4', '-o', 'tried.png', '--size', '64x64', '--annotate'],
                               capture_output=True, text=True, cwd=self.folder, timeout=300)
        if 'built without a font' in tried.stderr:
            self.skipTest('this bcc4 was built without a font: nothing is written into pictures')

    def picture(self, *more, size=300, name='p.png'):
        fit = () if '--camera' in more else ('--fit', 'domain')
        self.said = self.bcc4('render', 'flow.bcc4', '--size', f'{size}x{size}', '-o', name, '--quiet', *fit, *more)[1]
        return read_png(self.path(name)) if size <= 300 else None

    def read(self, rows, box, larger=4, mode='6'):
        """The words of a part of a picture, (left, top, right, bottom) in shares; bright letters become dark ones."""
        height, width = len(rows), len(rows[0])
        left, top, right, bottom = (round(b * n) for b, n in zip(box, (width, height) * 2))
        part = [[(r * a + g * a + b * a) // 765 for r, g, b, a in row[left:right]] for row in rows[top:bottom]]
        if sum(map(sum, part)) < 128 * sum(map(len, part)):
            part = [[255 - v for v in row] for row in part]
        write_png(self.path('read.png'), enlarged(part, larger))
        return self.tesseract('read.png', mode)

    def tesseract(self, name, mode):
        done = subprocess.run(['tesseract', name, '-', '--psm', mode], cwd=self.folder, capture_output=True, text=True, check=True)
        return ' '.join(done.stdout.split())

    def ink(self, rows, test):
        """Where (x, y) the colours pass."""
        return [(x, y) for y, row in enumerate(rows) for x, pixel in enumerate(row) if test(*pixel)]

    @READER
    def test_text_is_read_at_300_and_at_3000_pixels(self):
        parts = ('--time', 500, '--annotate', 'title,time,colorbar,scale', '--title', 'Flow of air')
        for background in (WHITE, BLACK, GREY):
            rows = self.picture(*parts, *background)
            self.assertEqual(self.said, '')
            self.assertRegex(self.read(rows, (0, 0, .6, .18)), r'^Flow of air t ?= ?500 ms$')
            self.assertRegex(self.read(rows, (.7, .2, 1, .8)), r'value.*80.*60.*40.*20')
            self.assertRegex(self.read(rows, (.65, .85, 1, .95)), r'\b10 mm')
        self.picture(*parts, *WHITE, size=3000)
        self.assertRegex(self.tesseract('p.png', '11'), r'Flow of air.*t ?= ?500 ms.*value.*80.*60.*40.*20.*10 mm')

    @READER
    def test_labels_have_a_field_each(self):
        def shells(x, y, z, t):
            r = math.dist((x, y, z), (9, 8, 8))
            return 0 if r > 8 else 3 if r > 6 else 7 if r > 3 else 12
        self.bcc4('import', *self.raw('l.raw', (20, 18, 16, 1), shells, 'u8'), '-o', 'flow.bcc4', '--overwrite', '--quiet')
        rows = self.picture('--annotate', 'colorbar', *WHITE)
        self.assertRegex(self.read(rows, (.7, .2, 1, .85)), r'12.*7.*3$')
        # Others than the colours of labels have a bar from value to value.
        rows = self.picture('--annotate', 'colorbar', '--range', '0,20', *WHITE)
        self.assertRegex(self.read(rows, (.7, .2, 1, .85)), r'20.*15.*10.*5.*0')

    @READER
    def test_ticks_are_round_numbers_of_the_range(self):
        for span, ticks in (('0,1', '1.0 0.8 0.6 0.4 0.2 0.0'), ('-1000,1000', '1000 500 0 -500 -1000'), ('0,3e-5', '3e-5 2e-5 1e-5 0'),
                            ('10,10.3', '10.3 10.2 10.1 10.0'), ('5,5.00004', '5.00004 5.00003 5.00002 5.00001 5.00000'), ('0,4e7', '4e7 3e7 2e7 1e7 0'), ('0,40000', '40000 30000 20000 10000 0')):
            rows = self.picture('--time', 500, '--annotate', 'colorbar', '--range', span, *WHITE)
            # A single 0 is not always found beside the bar, and what is drawn behind a 1 may hide it at one size.
            read = [re.findall(r'-?\d[\d.e-]*', self.read(rows, (.6, .2, 1, .8), larger=n).replace('le', '1e')) for n in (3, 4, 6)]
            self.assertIn([t for t in ticks.split() if t != '0'], [[number for number in numbers if number != '0'] for numbers in read], span)

    @READER
    def test_what_is_drawn_is_named(self):
        for more, box, text in ((('--iso', 40, '--time', 500), (.7, .2, 1, .4), 'value.*40'),
                                (('--mode', 'xray', '--time', 500, *BLACK), (.6, .2, 1, .3), 'value . mm'),
                                (('--plane', '1,0,0,0,-12.5'), (0, 0, .5, .18), 'flow x ?= ?12.5'),
                                (('--plane', '1,0,1,.5,-20'), (0, 0, .7, .18), 'plane 1, 0, 1, 0.5, -20')):
            self.assertRegex(self.read(self.picture(*more, '--annotate', 'colorbar,time,title', *(() if BLACK[0] in more else WHITE)), box), text)

    @READER
    def test_letters_beyond_ascii(self):
        rows = self.picture('--time', 500, '--annotate', 'title', '--title', 'Größe 20 °C Ångström', *WHITE)
        self.assertEqual(self.said, '')
        self.assertRegex(self.read(rows, (0, 0, .9, .1)), '^Gr..e 20 .C .ngstr.m$')
        self.picture('--time', 500, '--annotate', 'title', '--title', 'µm² Ω жар 温度 Å')
        self.assertRegex(self.said, 'boxes are drawn .*: 温度$')

    @READER
    def test_several_surfaces_and_the_colours_of_trails_have_bars(self):
        bar = (.55, .15, 1, .9)
        rows = self.picture('--time', 500, '--annotate', 'colorbar', '--iso', '20:.4:#4040ff,55.5:.5:#40ff40,80', *WHITE, size=300)
        self.assertRegex(self.read(rows, bar), r'value.*80.*55\.5 \(50%\).*20\.?0? \(40%\)')
        trail = ('--time', 750, '--annotate', 'colorbar', '--trail', '500,4')
        rows = self.picture(*trail, *WHITE)
        self.assertRegex(self.read(rows, bar), r'value.*trail.*ms.*-500')
        inside = self.ink(rows, lambda r, g, b, a: b > 200 and r < 90)
        self.assertGreater(len([x for x, y in inside if x > 200 and y > 150]), 40)  # the oldest, blue
        # Of a trail that begins with the series only what is there.
        rows = self.picture('--time', 250, '--annotate', 'colorbar', '--trail', '500,4', *WHITE)
        self.assertRegex(self.read(rows, bar), r'trail.*ms.*-250')
        self.assertRegex(self.read(self.picture(*trail[:-1], '2f,4', *WHITE), bar), r'trail.*frames.*-2')

    @READER
    def test_films_and_sheets_have_it_on_each_picture(self):
        series = ('--annotate', 'time,title', '--title', 'Air')
        self.bcc4('render', 'flow.bcc4', '--size', '200x200', '--sheet', '2x1', '--frames', '1-2x.5', '-o', 's.png', '--quiet', *series, *BLACK)
        sheet = read_png(self.path('s.png'))
        for part, moment in (((0, 0, .4, .25), 'Air t ?= ?250'), ((.5, 0, .9, .25), 'Air t ?= ?500')):
            self.assertRegex(self.read(sheet, part, 5), moment + ' ms')
        if shutil.which('ffmpeg'):
            self.bcc4('render', 'flow.bcc4', '--size', '300x300', '--frames', '3-4', '-o', 'f.mp4', '--quiet', *series, *WHITE)
            subprocess.run(['ffmpeg', '-v', 'error', '-i', 'f.mp4', '-pix_fmt', 'rgb24', 'f%d.png'], cwd=self.folder, check=True)
            for number, moment in ((1, 750), (2, 1000)):
                self.assertRegex(self.read(read_png(self.path(f'f{number}.png')), (0, 0, .6, .18)), f'Air t ?= ?{moment} ms')

    def test_the_box_is_that_of_the_domain(self):
        rows = self.picture('--time', 0, '--annotate', 'box', '--opacity', 0, '--view', 'front', *BLACK)
        lines = self.ink(rows, lambda r, g, b, a: r > 60)
        left, top, right, bottom = min(x for x, _ in lines), min(y for _, y in lines), max(x for x, _ in lines), max(y for _, y in lines)
        self.assertAlmostEqual((right - left) / (bottom - top), 19 / 17, delta=.03)
        self.assertAlmostEqual(left + right, 299, delta=2)
        self.assertAlmostEqual(top + bottom, 299, delta=2)
        # Seen from nearby the box reaches beyond the picture, though only a part of the slice is cut for that.
        near = self.picture('--time', 0, '--annotate', 'box', '--opacity', 0, '--view', 'front', '--zoom', 4, *BLACK)
        self.assertEqual(self.ink(near, lambda r, g, b, a: r > 60), [])

    def test_edges_behind_the_volume_are_hidden_and_those_before_are_not(self):
        full = self.volume((16, 16, 16, 1), lambda x, y, z, t: 100, '--quiet', name='full.bcc4')
        drawn = {}
        for opacity in (0, 1000):
            for name, more in (('with', ('--annotate', 'box')), ('without', ())):
                self.bcc4('render', full, '--size', '200x200', '-o', 'b.png', '--quiet', '--no-shading', '--range', '0,50', '--colormap',
                          'fire', '--opacity', opacity, *more, *BLACK)
                drawn[opacity, name] = read_png(self.path('b.png'))
        changed = {opacity: sum(a != b for one, two in zip(drawn[opacity, 'with'], drawn[opacity, 'without']) for a, b in zip(one, two))
                   for opacity in (0, 1000)}
        # Three of the twelve edges are behind.
        self.assertGreater(changed[1000], .55 * changed[0])
        self.assertLess(changed[1000], .9 * changed[0])

    def test_arrows_point_along_the_axes(self):
        def arrows(side):
            rows = self.picture('--time', 0, '--annotate', 'axes', '--opacity', 0, '--view', side, *BLACK)
            colors = (lambda r, g, b, a: r > 150 and g < 110, lambda r, g, b, a: g > 120 and r < 110 and b < 110, lambda r, g, b, a: b > 160 and r < 110)
            middles = []
            for color in colors:
                found = self.ink(rows, color)
                self.assertTrue(found, side)
                middles.append(tuple(sum(p[i] for p in found) / len(found) for i in (0, 1)))
            return middles

        x, y, _ = arrows('front')
        self.assertGreater(x[0], y[0] + 8)
        self.assertLess(y[1], x[1] - 8)
        x, y, _ = arrows('back')
        self.assertLess(x[0], y[0] - 8)
        x, _, z = arrows('top')
        self.assertGreater(x[0], z[0] + 8)
        self.assertGreater(z[1], x[1] + 8)  # away from the top of the picture

    def test_arrows_of_planes_over_time_are_those_of_moments(self):
        """Of data whose x runs to the left the picture of z = constant has x to the right, as that of a moment has, and so do their values."""
        with open(self.path('flow.nrrd'), 'rb') as f:
            turned = f.read().replace(b'(2,0,0)', b'(-2,0,0)')
        self.write('flow.nrrd', turned)
        self.bcc4('import', 'flow.nrrd', '-o', 'flow.bcc4', '--quiet', '--overwrite')
        red, green = (lambda r, g, b, a: r > 150 and g < 110), (lambda r, g, b, a: g > 120 and r < 110 and b < 110)
        for cut in (('--index', '--time', 5), ('--plane', '0,0,1,0,-8'), ('--plane', '0,0,1,0.02,-8')):
            rows = self.picture(*cut, '--annotate', 'axes', '--opacity', 0, '--view', 'front', *BLACK)
            x, y = (self.ink(rows, color) for color in (red, green))
            self.assertGreater(sum(p[0] for p in x) / len(x), sum(p[0] for p in y) / len(y) + 8, cut)
            rows = self.picture(*cut, '--view', 'front', *BLACK)
            bright = self.ink(rows, lambda r, g, b, a: max(r, g, b) > 60)
            self.assertLess(sum(p[0] for p in bright) / len(bright), 148, cut)  # the bump is right of the middle of the samples

    def names_of_x(self, space):
        """Ink and width of the names at the tip of the x arrow and at its other end, 0 where there is none: x runs to the right."""
        with open(self.path('flow.nrrd'), 'rb') as f:
            named = f.read().replace(b'space dimension: 3', space[0]).replace(b'space units: "mm" "mm" "mm"', b'space units: ' + space[1])
        self.write('named.nrrd', named)
        self.bcc4('import', 'named.nrrd', '-o', 'named.bcc4', '--quiet', '--overwrite')
        with open(self.path('c.json'), 'w') as f:
            f.write('{"position": [19, 17, 150], "target": [19, 17, 15], "ortho_height": 100}')
        self.bcc4('render', 'named.bcc4', '--index', '--time', 0, '-o', 'n.png', '--size', '600x600', '--quiet', '--annotate', 'axes', '--opacity', 0,
                  '--camera', 'c.json', *BLACK)
        red = [(x, r - (g + b) / 2) for row in read_png(self.path('n.png')) for x, (r, g, b, _) in enumerate(row) if r - (g + b) / 2 > 20]
        columns = sorted({x for x, _ in red})
        parts = [[columns[0]]]
        for x in columns[1:]:
            parts.append([x]) if x > parts[-1][-1] + 2 else parts[-1].append(x)
        arrow = max(parts, key=len)
        ends = [[p for p in parts if p[0] > arrow[-1]], [p for p in parts if p[-1] < arrow[0]]]
        return [(sum(w for x, w in red if x in set(sum(end, []))) / 180, sum(p[-1] - p[0] + 1 for p in end)) for end in ends]

    def test_sides_of_patients_and_points_of_the_compass(self):
        """R has more ink than L, W is wider than E; axes of other worlds have a letter at their tip alone."""
        plain = (b'space dimension: 3', b'"mm" "mm" "mm"')
        tip, other = self.names_of_x(plain)
        self.assertGreater(tip[0], 0)
        self.assertEqual(other[0], 0)
        (right, _), (left, _) = self.names_of_x((b'space: right-anterior-superior', plain[1]))
        self.assertGreater(right, 1.3 * left)
        (left, _), (right, _) = self.names_of_x((b'space: left-posterior-superior', plain[1]))
        self.assertGreater(right, 1.3 * left)
        self.assertGreater(left, 0)
        (_, east), (_, west) = self.names_of_x((plain[0], b'"degrees" "degrees" "degrees"'))
        self.assertGreater(west, 1.3 * east)
        self.assertGreater(east, 0)

    def test_the_scale_is_the_cameras(self):
        with open(self.path('c.json'), 'w') as f:
            f.write('{"position": [19, 17, -90], "target": [19, 17, 15], "ortho_height": 100}')
        rows = self.picture('--time', 0, '--annotate', 'scale', '--opacity', 0, '--camera', 'c.json', *BLACK)
        line = max(([x for x, (r, _, _, _) in enumerate(row) if r > 200] for row in rows[240:]), key=len)
        self.assertAlmostEqual(line[-1] - line[0], 60, delta=2)  # 20 mm, at a third of a millimetre a pixel
        self.assertEqual(len(line), line[-1] - line[0] + 1)

    def test_the_bar_has_the_colours_of_the_values(self):
        rows = self.picture('--time', 0, '--annotate', 'colorbar', '--opacity', 0, '--range', '0,90', '--colormap', 'gray', *WHITE)
        column = max((x for x in range(200, 300)), key=lambda x: sum(40 < row[x][0] < 215 for row in rows))
        inside = [row[column][0] for row in rows[95:220]]
        self.assertEqual(inside, sorted(inside, reverse=True))
        self.assertGreater(inside[0], 240)
        self.assertLess(inside[-1], 40)
        self.assertNotEqual(rows, self.picture('--time', 0, '--annotate', 'colorbar', '--opacity', 0, '--range', '0,90', *WHITE))

    def test_parts_and_transparent_pictures(self):
        plain = self.picture('--time', 500)
        every = self.picture('--time', 500, '--annotate')
        self.assertEqual(every, self.picture('--time', 500, '--annotate=all'))
        self.assertEqual(every, self.picture('--time', 500, '--annotate', 'box,title,colorbar,time,axes,scale'))
        self.assertEqual(self.picture('--time', 500, '--title', 'A'), self.picture('--time', 500, '--annotate', 'title', '--title', 'A'))
        self.assertEqual(every[299], plain[299])
        self.assertEqual(plain[15][12:60], [(0, 0, 0, 0)] * 48)
        letters = [pixel for row in every[8:24] for pixel in row[12:60]]
        self.assertTrue(any(r > 230 and a > 230 for r, _, _, a in letters) and any(r < 30 and a > 120 for r, _, _, a in letters))

    def test_refusals_and_what_a_picture_cannot_have(self):
        go = ('render', 'flow.bcc4', '--time', 500)
        self.refused(2, 'EXR', *go, '--annotate', '-o', 'x.exr', output='x.exr')
        self.refused(2, 'EXR', *go, '--title', 'A', '-o', 'x.exr', '--deep', output='x.exr')
        self.refused(2, 'did you mean colorbar?', *go, '--annotate', 'colourbar', '-o', 'x.png', output='x.png')
        self.refused(2, 'no room', *go, '--annotate', '--size', '300x80', '-o', 'x.png', output='x.png')
        self.refused(2, 'the file before it', 'render', '--annotate', 'flow.bcc4', '--time', 500, '-o', 'x.png', output='x.png')
        self.picture('--plane', '1,0,0,0,-5', '--annotate', 'scale,box')
        self.assertIn('--annotate scale', self.said)
        still = self.volume((8, 8, 8, 1), lambda x, y, z, t: x, '--quiet', name='still.bcc4')
        self.assertIn('one moment', self.bcc4('render', still, '--annotate', 'time', '-o', 'x.png', '--quiet')[1])
        self.assertNotIn('one moment', self.bcc4('render', still, '--annotate', '-o', 'x.png', '--quiet')[1])


if __name__ == '__main__':
    main()

"""Contact sheets: which pictures stand where."""
import math

from harness import ToolTest, main, png_size, read_png

DIMS = (10, 9, 8, 6)


def bump(x, y, z, t):
    return 100 * math.exp(-((x - 1 - 1.5 * t) ** 2 + (y - 4) ** 2 + (z - 3) ** 2) / 8)


class Sheet(ToolTest):
    def setUp(self):
        super().setUp()
        self.volume(DIMS, bump, '--quiet')

    def rows(self, *args, name='p.png', size='60x50'):
        said = self.bcc4('render', 'v.bcc4', '-o', name, '--size', size, *args)
        self.said = ''.join(said)
        return read_png(self.path(name)) if '%' not in name else None

    def pieces(self, rows, columns, lines, width=60, height=50, gap=1):
        self.assertEqual((len(rows[0]), len(rows)), (columns * (width + gap) - gap, lines * (height + gap) - gap))
        return [[row[c * (width + gap):][:width] for row in rows[r * (height + gap):][:height]] for r in range(lines) for c in range(columns)]

    def singles(self, numbers, *args):
        self.rows(*args, name='s.%d.png')
        return [read_png(self.path(f's.{n}.png')) for n in numbers]

    def test_all_frames_in_rows_and_empty_places(self):
        sheet = self.rows('--sheet', '4x2')
        self.assertIn('all 6 frames', self.said)
        self.assertIn('6 pictures on 243 x 101', self.said)
        pieces = self.pieces(sheet, 4, 2)
        self.assertEqual(pieces[:6], self.singles(range(6), '--frames', '0-5'))
        self.assertNotEqual(pieces[0], pieces[1])
        for piece in pieces[6:]:
            self.assertFalse(any(any(pixel) for row in piece for pixel in row))

    def test_of_more_pictures_than_places_some_are_taken_evenly(self):
        three = self.pieces(self.rows('--sheet', '3x1'), 3, 1)
        self.assertIn('3 pictures', self.said)
        self.assertEqual(three, self.singles((0, 3, 5), '--frames', '0-5'))
        turned = self.singles((0, 3, 6, 9), '--time', 2, '--turntable', 12)
        self.assertEqual(self.pieces(self.rows('--sheet', '2x2', '--time', 2, '--turntable', 12), 2, 2), turned)
        self.assertEqual(self.pieces(self.rows('--sheet', '1x1', '--frames', '2-5'), 1, 1), self.singles((2,), '--frames', '2-5'))

    def test_lies_over_a_background(self):
        self.bcc4('render', 'v.bcc4', '-o', 'p.png', '--size', '60x50', '--sheet', '2x1', '--frames', '0-1', '--background', '1,1,1')
        with open(self.path('p.png'), 'rb') as f:
            self.assertEqual(f.read()[25], 2)  # red, green and blue without opacity
        self.assertEqual(png_size(self.path('p.png')), (121, 50))

    def test_refusals(self):
        go = ('render', 'v.bcc4', '--frames', '0-5')
        for wrong in ('4', '0x3', '4x', '4x3x2', 'axb'):
            self.refused(2, 'columns and rows', *go, '--sheet', wrong, '-o', 'x.png', output='x.png')
        self.refused(2, 'is a PNG', *go, '--sheet', '2x2', '-o', 'x.exr', output='x.exr')
        self.refused(2, 'is a PNG', *go, '--sheet', '2x2', '-o', 'x.mp4', output='x.mp4')
        self.refused(2, 'no pattern', *go, '--sheet', '2x2', '-o', 'x.%d.png')
        self.refused(3, 'none/x.png: cannot be written', *go, '--sheet', '2x2', '-o', 'none/x.png')
        self.refused(2, 'too many', *go, '--sheet', '1000x1', '-o', 'x.png', output='x.png')


if __name__ == '__main__':
    main()

"""Options that commands share: what is there is replaced with --overwrite only, --out is -o; colours and sizes by short names."""
import math
import os

from harness import ToolTest, main, png_size, read_png

DIMS = (8, 7, 6, 3)


class Options(ToolTest):
    def setUp(self):
        super().setUp()
        self.volume(DIMS, lambda x, y, z, t: x + y * z + t, '--quiet')

    def test_every_command_leaves_what_is_there(self):
        one = ('--time', 1, '--quiet')
        for out, args in (('x.png', ('render', 'v.bcc4', *one)), ('x.nrrd', ('slice', 'v.bcc4', *one)), ('y.nrrd', ('export', 'v.bcc4', *one)),
                          ('x.bcc4', ('import', *self.raw('a.raw', DIMS, lambda *p: sum(p)), '--quiet'))):
            self.write(out, b'before')
            _, said = self.bcc4(*args, '-o', out, expect=2, overwrite=False)
            self.assertIn('--overwrite replaces it', said)
            with open(self.path(out), 'rb') as f:
                self.assertEqual(f.read(), b'before')
            self.bcc4(*args, '-o', out, '--overwrite')
            self.assertGreater(os.path.getsize(self.path(out)), 6)
        self.write('s.json', b'before')
        _, said = self.bcc4('render', 'v.bcc4', *one, '-o', 'z.png', '--stats', 's.json', expect=2, overwrite=False)
        self.assertIn('s.json: exists already', said)
        self.assertFalse(os.path.exists(self.path('z.png')))

    def test_out_is_another_name_of_o(self):
        self.bcc4('slice', 'v.bcc4', '--time', 1, '--out', 'o.nrrd', '--quiet')
        self.bcc4('render', 'v.bcc4', '--time', 1, '--out', 'o.png', '--quiet')
        self.bcc4('export', 'v.bcc4', '--time', 1, '--out', 'e.nrrd', '--quiet')
        self.bcc4('import', 'e.nrrd', '--out', 'e.bcc4', '--quiet')
        self.assertEqual([os.path.exists(self.path(n)) for n in ('o.nrrd', 'o.png', 'e.bcc4')], [True] * 3)

    def test_a_square_is_one_number(self):
        self.bcc4('render', 'v.bcc4', '--time', 1, '--size', 70, '-o', 's.png', '--quiet')
        self.assertEqual(png_size(self.path('s.png')), (70, 70))
        for wrong in ('70x', 'big', '0', '70x60x50'):
            self.refused(2, 'the edge of a square', 'render', 'v.bcc4', '--time', 1, '--size', wrong, '-o', 'w.png', output='w.png')

    def test_turbo_and_jet(self):
        # The middle of both is green, their lower part blue, their upper part red.
        for name in ('turbo', 'jet'):
            for share, strongest in ((.2, 2), (.5, 1), (.93, 0)):
                value = share * 40
                self.volume(DIMS, lambda x, y, z, t: value, '--quiet', '--air', '-1', '--overwrite', name='c.bcc4')
                self.bcc4('render', 'c.bcc4', '--time', 1, '--colormap', name, '--range', '0,40', '--opacity', 1000, '--no-shading', '--size', 40,
                          '-o', 'c.png', '--quiet')
                pixel = read_png(self.path('c.png'))[20][20][:3]
                self.assertEqual(max(range(3), key=lambda c: pixel[c]), strongest, (name, share, pixel))

    def test_bytes_read_as_pairs_are_noticed(self):
        smooth = lambda x, y, z, t: 100 + 60 * ((x - 16) ** 2 + (y - 16) ** 2) / 512 + z
        self.raw('b.raw', (32, 32, 16, 1), smooth, 'u8')
        for kind in ('u16', 'i16'):
            _, said = self.bcc4('import', 'b.raw', '--dims', '16,32,16', '--dtype', kind, '--dry-run')
            self.assertIn('as u8 the values would be smooth', said)
        _, said = self.bcc4('import', 'b.raw', '--dims', '32,32,16', '--dtype', 'u8', '--dry-run')
        self.assertNotIn('is --dtype right', said)
        args = self.raw('p.raw', (32, 32, 16, 1), lambda x, y, z, t: 97 * smooth(x, y, z, t), 'u16')
        _, said = self.bcc4('import', *args, '--dry-run')
        self.assertNotIn('is --dtype right', said)

    def test_lowpass_refuses_frames_that_are_missing(self):
        args = self.raw('h.raw', (8, 8, 8, 5), lambda x, y, z, t: math.nan if t == 2 else math.sin(x + t), 'f32')
        go = ('import', *args, '--on-nonfinite', 'hole', '--lattice', 'd4star', '--quiet')
        self.refused(3, 'frame 2 has no value at all', *go, '--lowpass', '-o', 'h.bcc4', output='h.bcc4')
        self.bcc4(*go, '-o', 'h.bcc4')
        args = self.raw('h.raw', (8, 8, 8, 5), lambda x, y, z, t: math.nan if t == 2 and x < 7 else math.sin(x + t), 'f32')
        self.bcc4(*go, '--lowpass', '-o', 'h.bcc4', '--overwrite')

    def test_signed_values_read_as_unsigned_are_noticed(self):
        # Noise about 0 with a bright ball whose values go through the middle of u16: few of them do.
        ball = lambda x, y, z, t: 25000 * math.exp(-((x - 16) ** 2 + (y - 16) ** 2 + (z - 8) ** 2) / 3) + 60 * ((x * 7 + y * 13 + z * 29) % 41 - 20)
        self.raw('n.raw', (32, 32, 16, 1), ball, 'i16')
        _, said = self.bcc4('import', 'n.raw', '--dims', '32,32,16', '--dtype', 'u16', '--dry-run')
        self.assertIn('as i16 they would be close', said)
        _, said = self.bcc4('import', 'n.raw', '--dims', '32,32,16', '--dtype', 'i16', '--dry-run')
        self.assertNotIn('is --dtype right', said)
        # A bright and smooth object of u16 is not taken for one of i16.
        args = self.raw('u.raw', (32, 32, 16, 1), lambda x, y, z, t: 65000 * math.exp(-((x - 16) ** 2 + (y - 16) ** 2) / 40), 'u16')
        _, said = self.bcc4('import', *args, '--dry-run')
        self.assertNotIn('is --dtype right', said)


if __name__ == '__main__':
    main()

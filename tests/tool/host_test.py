"""bcc4 render among another program's things: its view, its picture with depths, and what is cut open."""
import json
import math

from harness import ToolTest, main, read_png

SIDE = 24
PIXELS = 48


def ball(x, y, z, t):
    return 100 * math.exp(-((x - 11.5) ** 2 + (y - 11.5) ** 2 + (z - 11.5) ** 2) / 40)


class Host(ToolTest):
    def setUp(self):
        super().setUp()
        self.volume((SIDE, SIDE, SIDE, 2), ball, '--quiet')

    def picture(self, *args, name='p.png'):
        self.bcc4('render', 'v.bcc4', '-o', name, '--index', '--time', 0, '--size', f'{PIXELS}x{PIXELS}', '--quiet', *args)
        return read_png(self.path(name)) if name.endswith('.png') else self.path(name)

    def front(self):
        """Looks along z with x to the left, as --rotate-y 0 --rotate-x 0: SIDE * 2 world units high."""
        half = SIDE
        return {'world_to_view': [-1, 0, 0, 11.5, 0, 1, 0, -11.5, 0, 0, -1, -50, 0, 0, 0, 1],
                'projection': [1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, -1 / 200, 0, 0, 0, 0, 1]}

    def camera(self):
        return {'position': [11.5, 11.5, -50], 'target': [11.5, 11.5, 0], 'up': [0, 1, 0], 'ortho_height': 2 * SIDE}

    def write_json(self, name, value):
        self.write(name, json.dumps(value).encode())
        return name

    def opacity(self, rows, x):
        return sum(row[x][3] for row in rows)

    def test_a_plane_and_a_box_cut_the_world(self):
        camera = self.write_json('c.json', self.camera())
        whole = self.picture('--camera', camera)
        half = self.picture('--camera', camera, '--clip=1,0,0,-11.5')
        for x in range(PIXELS):  # world x falls with the column
            expected = self.opacity(whole, x) if x < PIXELS // 2 else 0
            self.assertEqual(self.opacity(half, x), expected, x)
        both = self.picture('--camera', camera, '--clip=1,0,0,-11.5', '--clip=-1,0,0,14')
        box = self.picture('--camera', camera, '--box=11.5,-100,-100,14,100,100')
        self.assertEqual(both, box)
        self.assertGreater(self.opacity(box, PIXELS // 2 - 1), 0)
        self.assertEqual(self.opacity(box, PIXELS // 2 - 4), 0)
        for wrong, text in ((('--clip', '0,0,0,1'), 'normal'), (('--clip', '1,2,3'), '4'),
                            (('--box', '3,0,0,1,9,9'), 'x0 < x1'), (('--box', '1,2'), '6')):
            self.refused(2, text, 'render', 'v.bcc4', '-o', 'w.png', *wrong, output='w.png')

    def test_matrices_are_a_view(self):
        by_camera = self.picture('--camera', self.write_json('c.json', self.camera()))
        view = self.front()
        self.assertEqual(self.picture('--view-matrix', self.write_json('m.json', view)), by_camera)
        view['y_down'] = True
        self.assertEqual(self.picture('--view-matrix', self.write_json('m.json', view)), by_camera[::-1])
        view['y_down'], view['resolution'] = False, [40, 30]
        self.bcc4('render', 'v.bcc4', '-o', 'r.png', '--index', '--time', 0, '--quiet', '--view-matrix',
                  self.write_json('m.json', view))
        rows = read_png(self.path('r.png'))
        self.assertEqual((len(rows), len(rows[0])), (30, 40))
        for code, key, value, text in ((3, 'projection', [1] * 15, '16 numbers'), (2, 'depth', '0..2', '0..1, -1..1 or'),
                                       (3, 'eye', [0, 0, 0], 'unknown key'), (2, 'projection', [0] * 16, 'camera')):
            self.write_json('m.json', {**self.front(), key: value})
            self.refused(code, text, 'render', 'v.bcc4', '-o', 'w.png', '--index', '--time', 0, '--view-matrix', 'm.json',
                         output='w.png')
        self.write_json('m.json', self.front())
        for other in (('--rotate-x', 3), ('--zoom', 2), ('--annotate',), ('--camera', 'persp'), ('--turntable', 3)):
            self.refused(2, '--view-matrix' if other[0] != '--annotate' else '--annotate', 'render', 'v.bcc4', '-o', 'w.png',
                         '--view-matrix', 'm.json', *other, output='w.png')

    def test_another_picture_hides_and_is_hidden(self):
        camera = self.write_json('c.json', self.camera())
        # An opaque shell before and behind: a surface is the host's picture.
        host = self.picture('--camera', camera, '--mode', 'iso', '--iso', 50, '--no-shading', name='host.exr')
        self.assertTrue(host)
        alone = self.picture('--camera', camera, '--mode', 'iso', '--iso', 50, '--no-shading')
        # Nothing of the volume: the host's picture as it is.
        self.assertEqual(self.picture('--camera', camera, '--over', 'host.exr', '--clip', '0,0,1,-1000'), alone)
        # The volume before the surface hides it in part, and is hidden behind it: what lies behind changes nothing.
        over = self.picture('--camera', camera, '--over', 'host.exr')
        self.assertNotEqual(over, alone)
        before = self.picture('--camera', camera, '--over', 'host.exr', '--clip', '0,0,-1,11.5')
        middle = PIXELS // 2
        self.assertEqual(over[middle][middle], before[middle][middle])
        self.refused(2, '--size', 'render', 'v.bcc4', '-o', 'w.png', '--time', 0, '--over', 'host.exr', '--size', '8x8',
                     output='w.png')
        self.write('bad.exr', b'no picture')
        self.refused(3, 'OpenEXR', 'render', 'v.bcc4', '-o', 'w.png', '--time', 0, '--over', 'bad.exr', output='w.png')


if __name__ == '__main__':
    main()

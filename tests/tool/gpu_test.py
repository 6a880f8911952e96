"""bcc4 with a GPU: what info says of it, pictures like those of the CPU, and reasons where it does not draw. Mesa's
rasteriser is enough of one."""
import json
import math
import os
import subprocess
import unittest

from harness import BCC4, ToolTest, main, read_png

NO_GPU = subprocess.run([BCC4, 'info', '--gpu'], capture_output=True, text=True)


def bump(x, y, z, t):
    return max(0, 1 - math.dist((x, y, z), (11 + t, 10, 9)) / 9)


@unittest.skipIf(NO_GPU.returncode, f'SKIPPED: no GPU: {NO_GPU.stderr}')
class Gpu(ToolTest):
    store = 'samples'

    def setUp(self):
        super().setUp()
        self.volume((24, 22, 20, 4), bump, '--quiet')

    def draw(self, gpu, *more, name='p.png'):
        self.bcc4('render', 'v.bcc4', '--time', 1.5, '--size', '64x64', '-o', name, '--gpu', gpu, '--quiet', '--stats', 's.json', *more)
        with open(self.path('s.json')) as f:
            return read_png(self.path(name)), json.load(f)['backend']

    def test_info_says_what_there_is(self):
        gpu = self.json('info', '--gpu')
        self.assertEqual(set(gpu), {'vendor', 'renderer', 'version', 'software', 'entry', 'memory'})
        self.assertIn(gpu['entry'], ('compute', 'fragment'))
        words, _ = self.bcc4('info', '--gpu')
        self.assertIn(gpu['renderer'], words)
        self.assertIn(gpu['version'], words)

    def test_pictures_are_those_of_the_cpu(self):
        for more in ((), ('--camera', 'persp', '--quality', 'fine'), ('--iso', .4), ('--mode', 'mip'), ('--trail', -1), ('--trail', -1, '--iso', .4)):
            (a, by_gpu), (b, by_cpu) = self.draw('on', *more), self.draw('off', *more)
            self.assertEqual((by_gpu, by_cpu), ('gpu', 'cpu'))
            squares = [(p - q) ** 2 for rows in zip(a, b) for pixels in zip(*rows) for p, q in zip(*pixels)]
            self.assertGreater(sum(row[3] > 30 for rows in a for row in rows), 200)
            least = 30 if '--iso' in more and '--trail' in more else 45  # dB; a surface among moments is lit without the CPU's smoothing
            self.assertLess(math.sqrt(sum(squares) / len(squares)), 255 * 10 ** (-least / 20), more)

    def test_a_rasteriser_is_not_taken_unasked(self):
        software = self.json('info', '--gpu')['software']
        self.assertEqual(self.draw('auto')[1], 'cpu' if software else 'gpu')

    def test_what_it_does_not_draw_is_named(self):
        through = ('--trail', -1, '--iso', .4, '--trail-mode', 'interleaved')
        self.refused(2, 'the GPU does not draw a trail behind a surface that rays go through', 'render', 'v.bcc4', '--time', 2, *through, '--gpu', 'on',
                     '-o', 't.png', output='t.png')
        self.assertEqual(self.draw('auto', *through)[1], 'cpu')
        self.refused(2, '--gpu', 'render', 'v.bcc4', '--time', 2, '--gpu', 'maybe', '-o', 't.png', output='t.png')


@unittest.skipIf('built without' in NO_GPU.stderr, 'built without a GPU')
class WithoutOpenGl(ToolTest):
    """Where no library of OpenGL can be loaded, which the environment says here, the tool says so, and the CPU draws."""

    def setUp(self):
        super().setUp()
        self.volume((24, 22, 20, 4), bump, '--quiet')
        os.environ['BCCSPLAT_MISSING_LIBRARIES'] = 'libEGL.so.1'
        self.addCleanup(os.environ.pop, 'BCCSPLAT_MISSING_LIBRARIES')

    def test_it_is_said(self):
        for words in (('info', '--gpu'), ('render', 'v.bcc4', '--time', 1.5, '--gpu', 'on', '-o', 'p.png')):
            run = subprocess.run([BCC4, *map(str, words)], capture_output=True, text=True, cwd=self.path('.'))
            self.assertNotEqual(run.returncode, 0)
            self.assertIn('the system has no EGL or no OpenGL', run.stderr)

    def test_the_cpu_draws(self):
        picture = ('render', 'v.bcc4', '--time', 1.5, '--size', '64x64', '--quiet', '--stats', 's.json')
        self.bcc4(*picture, '-o', 'auto.png', '--gpu', 'auto')
        with open(self.path('s.json')) as f:
            self.assertEqual(json.load(f)['backend'], 'cpu')
        self.bcc4(*picture, '-o', 'off.png', '--gpu', 'off')
        self.assertEqual(read_png(self.path('auto.png')), read_png(self.path('off.png')))


if __name__ == '__main__':
    main()

"""Films: what ffmpeg is given and told, by a stand-in that keeps both, and what becomes of a film that fails or is stopped.
With the real ffmpeg where it is installed."""
import json
import math
import os
import shutil
import signal
import subprocess
import time
import unittest

from harness import BCC4, ToolTest, main, read_png

DIMS = (10, 9, 8, 6)

# Keeps its arguments and what is piped to it beside itself; does what STANDIN tells.
STANDIN = '''#!/usr/bin/env python3
import json, os, sys, time
here = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(here, 'arguments.json'), 'w') as f:
    json.dump(dict(arguments=sys.argv[1:], pid=os.getpid(), group=os.getpgid(0)), f)
mode = os.environ.get('STANDIN', '')
if mode == 'refuse':
    sys.stderr.write("Unknown encoder 'libx264'\\n")
    sys.exit(1)
with open(sys.argv[-1].removeprefix('file:'), 'wb') as film:
    film.write(b'film')
if mode == 'hang':
    time.sleep(120)
data = sys.stdin.buffer.read()
with open(os.path.join(here, 'piped.rgb'), 'wb') as f:
    f.write(data)
if mode == 'talk':
    sys.stderr.write('x' * 300000)
if mode == 'full':
    sys.stderr.write('Error closing file: No space left on device\\n')
sys.exit(3 if mode == 'late' else 0)
'''


def bump(x, y, z, t):
    return 100 * math.exp(-((x - 4 - .3 * t) ** 2 + (y - 4) ** 2 + (z - 3) ** 2) / 8)


class Film(ToolTest):
    def setUp(self):
        super().setUp()
        self.volume(DIMS, bump, '--quiet')
        os.makedirs(self.path('bin'))
        self.write('bin/ffmpeg', STANDIN.encode())
        os.chmod(self.path('bin/ffmpeg'), 0o755)

    def environment(self, mode=''):
        return dict(os.environ, PATH=self.path('bin') + os.pathsep + os.environ['PATH'], STANDIN=mode)

    def film(self, *args, out='f.mp4', size=(24, 20), mode='', expect=0):
        """What the stand-in was given: its arguments, the pictures as rows of pixels, and what the tool said."""
        said = self.bcc4('render', 'v.bcc4', '-o', out, '--size', '{}x{}'.format(*size), *args, expect=expect, env=self.environment(mode))
        if expect:
            return said[1]
        with open(self.path('bin/arguments.json')) as f:
            given = json.load(f)
        with open(self.path('bin/piped.rgb'), 'rb') as f:
            data = f.read()
        width, height = (int(n) for n in self.after(given, '-video_size').split('x'))
        self.assertEqual(len(data) % (3 * width * height), 0)
        rows = [data[at:at + 3 * width] for at in range(0, len(data), 3 * width)]
        return given, [rows[at:at + height] for at in range(0, len(rows), height)], said

    def after(self, given, option):
        return given['arguments'][given['arguments'].index(option) + 1]

    def test_pictures_are_piped_as_they_are(self):
        given, pictures, said = self.film('--frames', '1-4', '--fps', '30000/1001', '--background', '.2,.4,.6')
        self.assertEqual(len(pictures), 4)
        self.assertEqual(pictures[0][0][:3], bytes((51, 102, 153)))
        for option, value in (('-framerate', '30000/1001'), ('-video_size', '24x20'), ('-pix_fmt', 'yuv420p'), ('-c:v', 'libx264'),
                              ('-colorspace', 'bt709'), ('-color_primaries', 'bt709'), ('-color_trc', 'bt709'), ('-f', 'rawvideo')):
            self.assertEqual(self.after(given, option), value)
        self.assertIn('render v.bcc4 -o f.mp4', self.after(given, '-metadata'))
        self.assertIn('4 pictures, 0.133 s at 29.97 per second', said[0])
        self.assertTrue(given['arguments'][-1].startswith('file:'))
        self.assertIn('partial', given['arguments'][-1])
        self.assertNotEqual(given['group'], os.getpgid(0))
        with open(self.path('f.mp4'), 'rb') as f:
            self.assertEqual(f.read(), b'film')

    def test_transparent_pictures_lie_over_the_background(self):
        _, (picture,), _ = self.film('--time', 2, '--threads', 1)
        self.bcc4('render', 'v.bcc4', '--time', 2, '-o', 'p.png', '--size', '24x20', '--quiet')
        linear = [v / 12.92 if v <= .04045 else ((v + .055) / 1.055) ** 2.4 for v in (n / 255 for n in range(256))]
        for row, want in zip(picture, read_png(self.path('p.png'))):
            for x, (*color, alpha) in enumerate(want):
                for c in range(3):
                    v = linear[color[c]] * alpha / 255  # over black
                    self.assertAlmostEqual(linear[row[3 * x + c]], v, delta=.01)

    def test_odd_sizes_get_a_line_of_background(self):
        given, (picture,), said = self.film('--time', 2, '--background', '1,0,0', size=(25, 19), out='f.webm')
        self.assertEqual(self.after(given, '-video_size'), '26x20')
        self.assertEqual(picture[19], bytes((255, 0, 0)) * 26)
        self.assertEqual({row[75:] for row in picture}, {bytes((255, 0, 0))})
        self.assertIn('25 x 19 becomes 26 x 20', said[1])
        self.assertEqual(self.after(given, '-c:v'), 'libvpx-vp9')

    def test_animated_pictures_are_shown_without_end(self):
        given, pictures, _ = self.film('--frames', '0-3', out='f.webp')
        self.assertEqual(len(pictures), 4)
        self.assertEqual([self.after(given, k) for k in ('-c:v', '-loop')], ['libwebp_anim', '0'])
        self.assertEqual(given['arguments'][-2], 'webp')
        self.assertNotIn('bt709', given['arguments'])

    def test_every_kind_of_series(self):
        self.assertEqual(len(self.film('--time', 2, '--turntable', 5)[1]), 5)
        self.assertEqual(len(self.film('--plane', '1,0,0,0,-2', '--sweep', '0:4,3')[1]), 3)
        self.assertEqual(len(self.film('--frames', '0-5x.5')[1]), 11)
        _, pictures, said = self.film()
        self.assertEqual(len(pictures), 6)
        self.assertIn('all 6 frames', said[1])
        with open(self.path('c.json'), 'w') as f:
            json.dump(dict(target=[4.5, 4, 3.5], fovy_deg=30, frames=[dict(position=[4.5, 4, z]) for z in (-30, -25, -20)]), f)
        self.assertEqual(len(self.film('--camera', 'c.json', '--time', 1)[1]), 3)

    def test_refusals(self):
        go = ('render', 'v.bcc4', '--time', 2)
        self.refused(2, '--deep', *go, '--deep', '-o', 'x.mp4', output='x.mp4')
        self.refused(2, 'no pattern', 'render', 'v.bcc4', '--frames', '0-3', '-o', 'x.%04d.mp4')
        self.refused(2, '.mp4, .webm or .webp', *go, '-o', 'x.avi', output='x.avi')
        self.refused(2, '--fps', *go, '--fps', 24, '-o', 'x.png', output='x.png')
        _, err = self.bcc4(*go, '-o', 'none/x.mp4', expect=3, env=self.environment('refuse'))
        self.assertIn('none/x.mp4: cannot be written', err)
        os.makedirs(self.path('d.mp4'))
        self.refused(2, 'folder', *go, '-o', 'd.mp4')

    def test_without_ffmpeg_nothing_is_drawn(self):
        _, err = self.bcc4('render', 'v.bcc4', '-o', 'x.mp4', expect=3, env=dict(os.environ, PATH='/nonexistent'))
        self.assertIn('not installed', err)
        self.assertIn('x.%04d.png', err)

    def test_a_failure_says_why_and_keeps_the_film_before(self):
        self.write('f.mp4', b'before')
        # More than a pipe holds, so that the one who went is noticed in the midst of a picture.
        for mode, size in (('refuse', (24, 20)), ('refuse', (400, 400))):
            self.assertIn("Unknown encoder 'libx264'", self.film(mode=mode, size=size, expect=3))
        self.assertIn('without a word', self.film(mode='late', expect=3))
        self.assertIn('No space left', self.film(mode='full', expect=4))
        with open(self.path('f.mp4'), 'rb') as f:
            self.assertEqual(f.read(), b'before')
        self.film(mode='talk')
        with open(self.path('f.mp4'), 'rb') as f:
            self.assertEqual(f.read(), b'film')

    def test_seconds_and_times_shown(self):
        given, pictures, said = self.film('--seconds', .5, '--fps', 20, '--loop', 3)
        self.assertEqual(len(pictures), 10)  # from frame 0 to 5, by moments between them
        self.assertIn('loop=loop=2:size=10:start=0,', self.after(given, '-vf'))
        self.assertIn('10 pictures, 3 times, 1.5 s at 20 per second', said[0])
        _, whole, _ = self.film('--frames', '0-5x5')
        self.assertEqual((pictures[0], pictures[-1]), (whole[0], whole[1]))
        given, pictures, _ = self.film('--frames', '1-3', '--seconds', .25)
        self.assertEqual(len(pictures), 6)
        self.assertNotIn('loop=', self.after(given, '-vf'))
        _, pictures, _ = self.film('--time', 2, '--turntable', 8, '--seconds', .5, '--fps', 8)
        self.assertEqual(len(pictures), 4)
        _, turn, _ = self.film('--time', 2, '--turntable', 4)
        self.assertEqual(pictures, turn)
        self.refused(2, 'are for films', 'render', 'v.bcc4', '--time', 0, '--seconds', 2, '-o', 'p.png', output='p.png')
        self.refused(2, 'nothing moves', 'render', 'v.bcc4', '--time', 0, '--seconds', 2, '-o', 'x.mp4', output='x.mp4')
        self.refused(2, '2 to 1000000 can be drawn', 'render', 'v.bcc4', '--seconds', .01, '-o', 'x.mp4', output='x.mp4')
        self.refused(2, '1 to 1000 times', 'render', 'v.bcc4', '--loop', 0, '-o', 'x.mp4', output='x.mp4')

    def test_signals_end_ffmpeg_and_leave_nothing(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            for out in os.listdir(self.path('bin')):
                if out != 'ffmpeg':
                    os.remove(self.path(os.path.join('bin', out)))
            p = subprocess.Popen([BCC4, 'render', 'v.bcc4', '-o', 'f.mp4', '--size', '400x400', '--quiet'], cwd=self.folder,
                                 env=self.environment('hang'), stderr=subprocess.PIPE, text=True)
            deadline = time.monotonic() + 60
            while not any('partial' in n for n in os.listdir(self.folder)):
                self.assertLess(time.monotonic(), deadline)
                time.sleep(.02)
            p.send_signal(number)
            _, err = p.communicate(timeout=60)
            self.assertEqual(p.returncode, 130, err)
            with open(self.path('bin/arguments.json')) as f:
                self.assertRaises(ProcessLookupError, os.kill, json.load(f)['pid'], 0)
            self.assertEqual(sorted(os.listdir(self.folder)), ['bin', 'v.bcc4', 'v.bcc4.raw'])

    def test_a_kill_leaves_the_film_before(self):
        self.write('f.mp4', b'before')
        p = subprocess.Popen([BCC4, 'render', 'v.bcc4', '-o', 'f.mp4', '--size', '400x400', '--quiet', '--overwrite'],
                             cwd=self.folder, env=self.environment('hang'))
        deadline = time.monotonic() + 60
        while not any('partial' in n for n in os.listdir(self.folder)):
            self.assertLess(time.monotonic(), deadline)
            time.sleep(.02)
        p.kill()
        p.wait(timeout=60)
        with open(self.path('bin/arguments.json')) as f:
            os.kill(json.load(f)['pid'], signal.SIGKILL)  # a real one ends with its pipe
        with open(self.path('f.mp4'), 'rb') as f:
            self.assertEqual(f.read(), b'before')
        os.remove(next(self.path(n) for n in os.listdir(self.folder) if 'partial' in n))

    @unittest.skipUnless(shutil.which('ffmpeg') and shutil.which('ffprobe'), 'SKIPPED: no ffmpeg or no ffprobe here, so no real film was made')
    def test_real_films_are_tagged_and_show_the_pictures(self):
        for out, codec in (('f.mp4', 'h264'), ('f.webm', 'vp9')):
            self.bcc4('render', 'v.bcc4', '-o', out, '--fps', 12, '--size', '64x48', '--background', '.2,.4,.6', '--quiet')
            found = subprocess.run(['ffprobe', '-v', 'error', '-count_frames', '-show_streams', '-of', 'json', out], cwd=self.folder,
                                   capture_output=True, text=True, check=True).stdout
            stream = json.loads(found)['streams'][0]
            self.assertEqual((stream['codec_name'], stream['width'], stream['height'], stream['pix_fmt']), (codec, 64, 48, 'yuv420p'))
            self.assertEqual((stream['color_space'], stream['color_primaries'], stream['color_transfer']), ('bt709',) * 3)
            self.assertEqual((stream['r_frame_rate'], stream['nb_read_frames'], stream['color_range']), ('12/1', '6', 'tv'))
            first = subprocess.run(['ffmpeg', '-v', 'error', '-i', out, '-vframes', '1', '-f', 'rawvideo', '-pix_fmt', 'rgb24', '-'],
                                   cwd=self.folder, capture_output=True, check=True).stdout
            for c, want in enumerate((51, 102, 153)):
                self.assertAlmostEqual(first[c], want, delta=4)
            # The fourth picture of the film is that of frame 3.
            self.bcc4('render', 'v.bcc4', '-o', 'p.png', '--time', 3, '--index', '--size', '64x48', '--background', '.2,.4,.6',
                      '--quiet')
            shown = subprocess.run(['ffmpeg', '-v', 'error', '-i', out, '-vf', r'select=eq(n\,3)', '-vframes', '1', '-f', 'rawvideo',
                                    '-pix_fmt', 'rgb24', '-'], cwd=self.folder, capture_output=True, check=True).stdout
            drawn = bytes(c for row in read_png(self.path('p.png')) for pixel in row for c in pixel[:3])
            self.assertEqual(len(shown), len(drawn))
            squares = sum((a - b) ** 2 for a, b in zip(shown, drawn)) / len(drawn)
            self.assertGreater(10 * math.log10(255 ** 2 / squares), 38, out)


if __name__ == '__main__':
    main()

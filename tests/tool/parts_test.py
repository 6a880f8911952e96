"""Series imported in parts by several processes and joined: the same bytes as one process writes."""
import json
import math
import os
import shutil
import subprocess

from harness import BCC4, DATA, LONG, TOP, ToolTest, main, some

DIMS = (18, 16, 14, 47)


def blob(x, y, z, t):
    """Moves, fades in and out, and leaves air behind."""
    r2 = (x - 8 - 4 * math.sin(t / 9)) ** 2 + (y - 8) ** 2 + (z - 7 + t / 20) ** 2
    return 90 * math.exp(-r2 / 9) if r2 < 30 else 0


def broken(x, y, z, t):
    """Holes, and two frames that are missing altogether: the very first ones, and some where parts meet."""
    if t in (0, 1, 15, 16, 17) or (x, y, z) == (4, 5, 6) and t % 3 == 0:
        return math.nan
    return blob(x, y, z, t)


class Parts(ToolTest):
    def cut(self, args, spans, *more):
        """Imports by one process, and by parts made last to first; returns the two files' bytes."""
        self.bcc4('import', *args, *more, '-o', 'one.bcc4', '--quiet', '--overwrite')
        self.plan(args, *more)
        names = [self.part(span) for span in reversed(spans)]
        self.bcc4('concat', *names, '-o', 'joined.bcc4', '--quiet', '--overwrite')
        return self.read('one.bcc4'), self.read('joined.bcc4')

    def plan(self, args, *more, name='plan.json'):
        self.bcc4('import', *args, *more, '--dry-run', '--plan', name, '--overwrite')

    def part(self, span, plan='plan.json', name=None):
        name = name or f'part.{span.replace("/", "of")}.bcc4'
        self.bcc4('import', '--plan', plan, '--part', span, '-o', name, '--quiet', '--overwrite')
        return name

    def assert_equal(self, files, what=''):
        one, joined = files
        self.assertEqual(len(one), len(joined), what)
        at = next((i for i in range(len(one)) if one[i] != joined[i]), None)
        self.assertIsNone(at, f'{what}: the files differ from byte {at} on')

    def test_two_three_and_seven_parts(self):
        args = self.raw('a.raw', DIMS, blob)
        for spans in (['0-45', '46-46'], ['0-22', '23-46'], ['0-3', '4-40', '41-46'], [f'{k}/7' for k in range(1, 8)]):
            self.assert_equal(self.cut(args, spans), spans)
        self.assertEqual(self.json('verify', 'joined.bcc4')['ok'], True)

    def test_planes_outside_the_faces(self):
        args = self.raw('a.raw', DIMS, blob)
        self.assert_equal(self.cut(args, ['0-14', '15-46'], '--faces', 'predict'))
        self.assertNotEqual(self.json('info', 'one.bcc4')['planes_outside']['before'], [0, 0, 0])
        # A series that goes on keeps the planes it has.
        fixed = ('--lattice', 'd4star', '--exact')
        self.bcc4('import', *self.raw('b.raw', DIMS[:3] + (30,), blob), *fixed, '--faces', 'predict', '-o', 'grown.bcc4', '--quiet')
        self.bcc4('import', *args, *fixed, '--append', '-o', 'grown.bcc4', '--quiet')
        self.bcc4('import', *args, *fixed, '--faces', 'predict', '-o', 'whole.bcc4', '--quiet')
        self.assert_equal((self.read('whole.bcc4'), self.read('grown.bcc4')), 'append')

    def test_the_tasks_of_an_array(self):
        """examples/import_array.sh as Slurm calls it, one task twice; and the line for one machine."""
        args = self.raw('a.raw', DIMS, blob)
        self.bcc4('import', *args, '-o', 'one.bcc4', '--quiet')
        self.plan(args)
        tools = self.path('tools')
        os.mkdir(tools)
        os.symlink(os.path.abspath(BCC4), os.path.join(tools, 'bcc4'))
        path = tools + os.pathsep + os.environ['PATH']
        script = os.path.join(TOP, 'examples', 'import_array.sh')
        for task in '3', '1', '2', '1':
            slurm = {'SLURM_ARRAY_TASK_ID': task, 'SLURM_ARRAY_TASK_COUNT': '3', 'SLURM_CPUS_PER_TASK': '2', 'SLURM_MEM_PER_NODE': '512'}
            subprocess.run(['bash', script, 'plan.json', 'p'], cwd=self.folder, env={**os.environ, **slurm, 'PATH': path}, check=True)
        self.bcc4('concat', *[f'p.part{k}.bcc4' for k in (1, 2, 3)], '-o', 'joined.bcc4', '--quiet')
        self.assertEqual(self.read('joined.bcc4'), self.read('one.bcc4'))
        if shutil.which('parallel'):
            with open(script) as f:
                line = next(line for line in f if ': parallel' in line).split(': ', 1)[1].replace('smoke', 'q')
            subprocess.run(['bash', '-c', line], cwd=self.folder, env={**os.environ, 'PATH': path}, check=True,
                           stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.bcc4('concat', *[f'q.part{k}.bcc4' for k in range(1, 9)], '-o', 'joined2.bcc4', '--quiet')
            self.assertEqual(self.read('joined2.bcc4'), self.read('one.bcc4'))

    def test_every_option_that_looks_beyond_a_frame(self):
        args = self.raw('a.raw', DIMS, blob)
        spans = ['0-11', '12-12', '13-30', '31-46']
        cases = [['--lowpass'], ['--time-scale', 2.7], ['--scale', 1.4, '--time-scale', .3],
                 ['--quantize', 'u8'], ['--measure', 'all'], ['--measure', 'none'],
                 ['--lattice', 'cc'], ['--air-threshold', 1, '--kernel', 'fine'],
                 ['--times', ','.join(str(t * t) for t in range(47))], ['--scale', '.7,.85,1.1,1.6', '--lowpass'],
                 ['--lowpass', '--quantize', 'u16', '--time-scale', 1.5]]
        for more in some(cases, 4):
            self.assert_equal(self.cut(args, spans, *more), more)

    def test_bounds_and_their_corrections(self):
        args = self.raw('a.raw', DIMS, blob)
        cases = [['--psnr', 40], ['--abs', .2], ['--abs', .3, '--lattice', 'cc']]
        for more in some(cases, 2):
            self.assert_equal(self.cut(args, ['0-5', '6-25', '26-27', '28-46'], *more), more)
            if more[0] == '--abs':
                report = self.json('verify', 'joined.bcc4', '--against', 'a.raw', '--frames', '0-46')
                self.assertLessEqual(report['max_abs'], more[1])
        # A part promises nothing: its neighbours' frames are not in it.
        self.assertNotIn('bound', self.bcc4('info', 'part.6-25.bcc4')[0])

    def test_missing_frames_and_holes(self):
        args = self.raw('a.raw', DIMS, broken)
        for spans in some([['0-0', '1-9', '10-46'], ['0-19', '20-46'], ['0-15', '16-16', '17-46']]):
            for more in (['hole'], ['clamp']):
                self.assert_equal(self.cut(args, spans, '--on-nonfinite', *more), (spans, more))

    def test_holes_with_a_low_pass(self):
        args = self.raw('a.raw', DIMS, lambda x, y, z, t: math.nan if (x, y, z) == (4, 5, 6) and t % 3 == 0 else blob(x, y, z, t))
        more = ['--on-nonfinite', 'hole', '--lowpass']
        self.assert_equal(self.cut(args, ['0-19', '20-46'], *more), more)

    def test_channels_and_files(self):
        nrrd = (b'NRRD0004\ntype: uint8\ndimension: 5\nsizes: 2 9 9 9 31\n'
                b'kinds: 2-vector space space space time\nencoding: raw\n\n')
        self.write('a.nrrd', nrrd + bytes((x * (c + 3) * t + 5 * y * z) % 211 for t in range(31) for z in range(9)
                                          for y in range(9) for x in range(9) for c in range(2)))
        self.assert_equal(self.cut(['a.nrrd'], ['1/3', '2/3', '3/3'], '--abs', 60))
        for t in range(1, 24):
            self.write(f's.{t}.raw', bytes((x * t + y * y) % 97 for z in range(6) for y in range(7) for x in range(8)))
        args = ['s.%d.raw', '--dims', '8,7,6', '--dtype', 'u8', '--frames', '3-21']
        self.assert_equal(self.cut(args, ['0-9', '10-18']))
        # The plan names the input; another folder may stand for it.
        os.mkdir(self.path('elsewhere'))
        for t in range(1, 24):
            os.rename(self.path(f's.{t}.raw'), self.path(f'elsewhere/s.{t}.raw'))
        _, err = self.bcc4('import', '--plan', 'plan.json', '--part', '1/2', '-o', 'p.bcc4', expect=3)
        self.assertIn('s.%d.raw', err)
        self.bcc4('import', 'elsewhere/s.%d.raw', '--plan', 'plan.json', '--part', '0-9', '-o', 'p.bcc4', '--quiet')
        self.assertEqual(self.read('p.bcc4'), self.read('part.0-9.bcc4'))

    def test_a_plan_without_a_part_is_the_whole(self):
        args = self.raw('a.raw', DIMS, blob)
        self.bcc4('import', *args, '--psnr', 45, '-o', 'one.bcc4', '--quiet')
        self.plan(args, '--psnr', 45)
        self.bcc4('import', '--plan', 'plan.json', '-o', 'two.bcc4', '--quiet')
        self.assertEqual(self.read('one.bcc4'), self.read('two.bcc4'))

    def test_a_part_is_made_of_a_few_frames_more(self):
        self.plan(self.raw('a.raw', DIMS, blob), '--measure', 'none', '--lattice', 'd4star')
        part = self.json('import', '--plan', 'plan.json', '--part', '20-25', '-o', 'p.bcc4')['part']
        self.assertEqual((part['first'], part['last']), (20, 25))
        # Slabs of 8 layers span 5.7 frames; the first of them may begin at its first frame's own layers.
        self.assertTrue(10 < part['read'][0] <= 20 and 25 < part['read'][1] < 40, part)

    def test_a_killed_part_resumes(self):
        args = self.raw('a.raw', (24, 24, 24, 60), blob)
        self.plan(args)
        whole = self.read(self.part('20-39'))
        for seconds in (.1, .2, .4):
            command = [BCC4, 'import', '--plan', 'plan.json', '--part', '20-39', '-o', 'k.bcc4', '--quiet', '--resume',
                       '--overwrite']
            process = subprocess.Popen(command, cwd=self.folder, stderr=subprocess.DEVNULL)
            try:
                process.wait(seconds)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.bcc4(*command[1:])
        self.assertEqual(self.read('k.bcc4'), whole)

    def test_what_does_not_fit_is_refused(self):
        args = [*self.raw('a.raw', DIMS, blob), '--exact', '--lattice', 'd4star']
        self.plan(args)
        a, b, c = self.part('0-15'), self.part('16-30'), self.part('31-46')
        wide = self.part('10-20')
        out = ['-o', 'x.bcc4']
        self.refused(2, 'frames 16 to 30 of 47 are in none of the parts', 'concat', a, c, *out, output='x.bcc4')
        self.refused(2, 'frames 31 to 46 of 47', 'concat', b, a, *out, output='x.bcc4')
        self.refused(2, 'frames 0 to 15 of 47', 'concat', b, c, *out, output='x.bcc4')
        self.refused(2, f'frames 10 to 15 are both in {a} and in {wide}', 'concat', a, wide, c, *out, output='x.bcc4')
        self.refused(2, f'frames 16 to 30 are both in {b} and in {b}', 'concat', a, b, b, c, *out, output='x.bcc4')
        self.bcc4('concat', c, a, b, '-o', 'whole.bcc4', '--quiet')
        self.refused(2, 'a whole file, not a part', 'concat', a, b, c, 'whole.bcc4', *out, output='x.bcc4')
        self.refused(2, 'exists already', 'concat', a, b, c, '-o', 'whole.bcc4')
        self.refused(2, 'PART... is missing', 'concat', *out)
        for more, text in ((['--quantize', 'u8'], 'rounded'), (['--lowpass'], 'the attributes differ'),
                           (['--on-nonfinite', 'hole'], 'other options'),
                           (['--times', ','.join(str(2 * t) for t in range(47))], 'the times differ'),
                           (['--lattice', 'cc'], 'the lattices differ'), (['--frames', '0-45'], 'numbers of samples or frames')):
            self.plan(args[:-2] if more[0] == '--lattice' else args, *more, name='other.json')
            other = self.part('16-30', 'other.json', 'other.bcc4')
            self.refused(2, text, 'concat', a, other, c, *out, output='x.bcc4')
        damaged = bytearray(self.read(b))
        damaged[20000] ^= 1
        self.write('damaged.bcc4', bytes(damaged))
        self.refused(3, 'bad checksum', 'concat', a, 'damaged.bcc4', c, *out, output='x.bcc4')
        self.refused(2, 'a part of a series; join all parts first', 'import', *args, '--append', '-o', a)
        info = self.json('info', b)
        self.assertEqual(info['part'], {'first': 16, 'last': 30})
        self.assertEqual(info['dims'], list(DIMS))
        self.assertNotIn('part', self.json('info', 'whole.bcc4'))
        self.refused(2, 'a part of a series', 'verify', b, '--against', 'a.raw')
        self.assertEqual(self.json('verify', b)['ok'], True)

    def test_the_plan_is_checked(self):
        args = self.raw('a.raw', DIMS, blob)
        self.plan(args)
        run = ['import', '--plan', 'plan.json', '-o', 'x.bcc4']
        for span, text in (('0-47', 'from 0 to 46'), ('9-3', 'from 0 to 46'), ('0/3', 'is 1/3'), ('4/3', 'is 1/3'),
                           ('1/48', '47 frames'), ('a-b', 'a number is expected')):
            self.refused(2, text, *run, '--part', span, output='x.bcc4')
        self.refused(2, 'the plan decides that', *run, '--part', '1/2', '--scale', 2, output='x.bcc4')
        self.refused(2, '--part needs the --plan', 'import', *args, '--part', '1/2', '-o', 'x.bcc4', output='x.bcc4')
        self.refused(2, 'exists already', 'import', *args, '--dry-run', '--plan', 'plan.json')
        self.write('bad.json', b'{"bcc4_plan": 2}')
        self.refused(3, 'not a plan of this version; bcc4 import --dry-run --plan', 'import', '--plan', 'bad.json', '-o', 'x.bcc4', output='x.bcc4')
        with open(self.path('plan.json')) as f:
            plan = json.load(f)
        self.assertEqual(plan['dims'], list(DIMS))
        self.write('a.raw', self.read('a.raw') + bytes(4))
        self.refused(3, 'bytes', *run, '--part', '1/2', output='x.bcc4')

    def test_looking_at_a_part(self):
        """Whoever looks at a part is told, and shown a frame that it has."""
        args = self.raw('a.raw', DIMS, blob)
        self.plan(args)
        part = self.part('20-33')
        words = 'a part of a series, frames 20 to 33'
        small = ['--size', '24x20']
        _, said = self.bcc4('render', part, '-o', 'p.png', *small)
        self.assertIn(words, said)
        self.assertIn('moment 20 of 20..33, the first; --time chooses another; they run 20 to 33', said)
        self.bcc4('render', part, '-o', 'q.png', '--index', '--time', 20, *small)
        self.assertEqual(self.read('p.png'), self.read('q.png'))
        self.bcc4('render', part, '-o', 'f.%02d.png', *small)
        self.assertEqual(sorted(n for n in os.listdir(self.folder) if n[:2] == 'f.'), [f'f.{k}.png' for k in range(20, 34)])
        self.assertIn(words, self.bcc4('slice', part, '--time', 25, '-o', 's.nrrd')[1])
        self.assertIn(words, self.bcc4('export', part, '--time', 25, '-o', 'e.nrrd')[1])
        self.assertEqual(self.bcc4('slice', part, '--time', 25, '-o', 't.nrrd', '--quiet')[1], '')

    def test_real_series(self):
        path = os.path.join(DATA, 'viscous_fingers_run01_64x64x64x99_u16.nrrd')
        if not os.path.exists(path):
            self.skipTest('no such data')
        frames = [] if LONG else ['--frames', '40-59']
        self.assert_equal(self.cut([path, *frames], ['1/3', '2/3', '3/3'], '--abs', 40))


class Frames(ToolTest):
    def test_pictures_by_frame_ranges(self):
        """Ranges drawn by processes of their own are the pictures of one process."""
        v = self.volume(DIMS, blob, '--quiet')
        common = ['--size', '48x40', '--trail', '3f', '--camera', 'persp', '--rotate-y', 20, '--quiet']
        for name in ('one', 'many'):
            os.mkdir(self.path(name))
        self.bcc4('render', v, '--frames', '0-23', *common, '-o', 'one/p.%03d.png')
        ranges = '\n'.join(['0-6', '7-7', '8-19', '20-23'])
        subprocess.run(['xargs', '-P2', '-I', '{}', BCC4, 'render', v, '--frames', '{}', *map(str, common), '-o',
                        'many/p.%03d.png'], input=ranges, text=True, check=True, cwd=self.folder)
        names = sorted(os.listdir(self.path('one')))
        self.assertEqual(len(names), 24)
        self.assertEqual(sorted(os.listdir(self.path('many'))), names)
        for name in names:
            with open(self.path('one/' + name), 'rb') as a, open(self.path('many/' + name), 'rb') as b:
                self.assertEqual(a.read(), b.read(), name)


if __name__ == '__main__':
    main()

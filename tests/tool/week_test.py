"""A newcomer's first week: the tasks that people of other programs come with, each by the commands that README.md and
`bcc4 help` show, and the mistakes that they make on the way, which are answered with a way out."""
import math
import os
import re
import shlex
import shutil
import signal
import subprocess
import time

from harness import BCC4, TOP, Nrrd, ToolTest, field, has_openvdb, has_reader, main, png_size

DIMS = (24, 24, 24)
AS = ('--dims', '24,24,24', '--dtype', 'f32', '--dt', '0.5')


def puff(x, y, z, t):
    v = math.exp(-((x - 8 - .7 * t) ** 2 + (y - 12) ** 2 + (z - 11) ** 2) / 30)
    return v if v > .01 else 0


class Week(ToolTest):
    def day(self, name, first, last):
        for t in range(first, last):
            with open(self.path(f'{name}.{t:02}.raw'), 'wb') as f:
                field(DIMS + (1,), lambda x, y, z, _: puff(x, y, z, t), 'f').tofile(f)
        return [f'{name}.{t:02}.raw' for t in range(first, last)]

    def first_day(self):
        files = self.day('day1', 0, 6)
        self.bcc4('import', *files, *AS, '-o', 'a.bcc4', '--quiet')
        return files

    def test_convert_to_each_format_and_back(self):
        self.first_day()
        names = ['a.nii', 'a.nii.gz', 'a.pvd', 'a.nrrd'] + ['a.nc'] * has_reader('netcdf') + ['a.tif'] * has_reader('tiff')
        for name in names + ['a.%02d.nrrd'] + ['a.%02d.vdb'] * has_openvdb():
            self.bcc4('export', 'a.bcc4', '--all', '-o', name)
            back = [n for n in sorted(os.listdir(self.folder)) if re.fullmatch(name.replace('.', r'\.').replace('%02d', r'\d\d'), n)]
            self.bcc4('import', *back, '-o', 'back.bcc4', '--quiet', '--overwrite')
            info = self.json('info', 'back.bcc4')
            self.assertEqual((info['dims'], info['times']['last']), ([*DIMS, 6], 2.5), name)
            # 2 % of what was exported, which goes a little beyond the range of the source.
            self.assertLess(self.json('compare', 'a.bcc4', 'back.bcc4', '--tolerance', .05)['max_abs'], .0215, name)

    def test_cut_compare_and_probe(self):
        files = self.first_day()
        self.bcc4('export', 'a.bcc4', '--all', '--roi', '4-15,6-17,8-15', '-o', 'part.nrrd')
        self.assertEqual(Nrrd(self.path('part.nrrd')).sizes, [12, 12, 8, 6])
        self.assertIn('RMSE', self.bcc4('compare', 'a.bcc4', *files, *AS, '--tolerance', .05)[0])
        self.bcc4('compare', 'a.bcc4', *files, *AS, expect=1)
        lines = self.bcc4('probe', 'a.bcc4', '--at', '10,12,11')[0].splitlines()
        self.assertEqual([float(line.split('\t')[0]) for line in lines], [0, .5, 1, 1.5, 2, 2.5])
        for t, line in enumerate(lines):
            self.assertAlmostEqual(float(line.split('\t')[1]), puff(10, 12, 11, t), delta=.01)
        found = self.json('probe', 'a.bcc4', '--at', '10,12,11', '--at', '20,2,2', '--time', .75)
        self.assertEqual(len(found), 1)
        self.assertAlmostEqual(found[0]['values'][0], puff(10, 12, 11, 1.5), delta=.01)
        self.assertAlmostEqual(found[0]['values'][1], 0, delta=.01)
        found = self.json('probe', 'a.bcc4', '--at', '10.5,12,11', '--time', 3, '--index')
        self.assertAlmostEqual(found[0]['values'][0], puff(10.5, 12, 11, 3), delta=.01)
        out, said = self.bcc4('probe', 'a.bcc4', '--at', '99,0,0', '--time', 1, expect=1)
        self.assertIn('outside the data', said)
        self.assertIn('nan', out)

    def test_probe_follows_the_place_and_the_time(self):
        # The world is turned and moved: a place of it is asked for, with --index a sample.
        head = ('NRRD0004\ntype: float\ndimension: 4\nsizes: 24 24 24 6\nspace dimension: 3\n'
                'space directions: (0.8,0.6,0) (-0.6,0.8,0) (0,0.5,1) none\nspace origin: (5,6,7)\nkinds: domain domain domain time\n'
                'endian: little\nencoding: raw\n\n')
        self.write('w.nrrd', head.encode() + field(DIMS + (6,), puff, 'f').tobytes())
        self.bcc4('import', 'w.nrrd', '-o', 'w.bcc4', '--quiet')
        place = (5 + .8 * 10 - .6 * 12, 6 + .6 * 10 + .8 * 12 + .5 * 11, 7 + 11)
        for at, more in ((place, ()), ((10, 12, 11), ('--index',))):
            found = self.json('probe', 'w.bcc4', '--at', ','.join(map(str, at)), '--time', 2, *more)
            self.assertAlmostEqual(found[0]['values'][0], puff(10, 12, 11, 2), delta=.01)
        self.refused(2, '--at X,Y,Z or --points FILE.csv is missing', 'probe', 'w.bcc4')
        self.refused(2, '3 numbers are expected', 'probe', 'w.bcc4', '--at', '1,2')

    def test_pictures_films_and_planes_over_time(self):
        self.first_day()
        self.bcc4('render', 'a.bcc4', '--time', 1, '-o', 'p.png', '--size', 200)
        self.assertEqual(png_size(self.path('p.png')), (200, 200))
        for name in ('p.mp4', 'p.webm', 'p.webp'):
            if shutil.which('ffmpeg'):
                self.bcc4('render', 'a.bcc4', '-o', name, '--size', 96)
                self.assertGreater(os.path.getsize(self.path(name)), 500)
        self.bcc4('slice', 'a.bcc4', '--plane', '1,0,0,0,-12', '-o', 'x12.nrrd')
        plane = Nrrd(self.path('x12.nrrd'))
        self.assertEqual(plane.sizes, [24, 24, 6])
        self.assertAlmostEqual(plane.values[12 + 24 * (11 + 24 * 4)], puff(12, 12, 11, 4), delta=.02)
        self.bcc4('render', 'a.bcc4', '--plane', '1,0,0,0,-12', '-o', 'x12.png', '--size', 96)

    def test_another_day_is_appended(self):
        first = self.first_day()
        second = self.day('day2', 6, 10)
        self.refused(2, 'give the files of these and the new ones together', 'import', *second, *AS, '-o', 'a.bcc4', '--append')
        self.bcc4('import', *second, *AS, '-o', 'b.bcc4', '--quiet')
        _, said = self.bcc4('concat', 'a.bcc4', 'b.bcc4', '-o', 'c.bcc4', expect=2)
        self.assertIn('bcc4 import --append adds the frames', said)
        self.bcc4('import', *first, *second, *AS, '-o', 'a.bcc4', '--append', '--quiet')
        self.assertEqual(self.json('info', 'a.bcc4')['dims'][3], 10)
        self.bcc4('compare', 'a.bcc4', *first, *second, *AS, '--tolerance', .05)

    def test_an_interrupted_import_goes_on(self):
        # So many frames that it can be stopped in between.
        for t in range(60):
            self.write(f's.{t:03}.raw', field((40, 40, 40, 1), lambda x, y, z, _: (x + y * z + t) % 97, 'f') if t < 2 else b'')
            if t >= 2:
                shutil.copy(self.path(f's.{t % 2:03}.raw'), self.path(f's.{t:03}.raw'))
        go = ['import', *[f's.{t:03}.raw' for t in range(60)], '--dims', '40,40,40', '--dtype', 'f32', '--lattice', 'd4star', '-o', 's.bcc4']
        run = subprocess.Popen([BCC4, *go], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        journal = self.path('s.bcc4.journal')
        while run.poll() is None and not (os.path.exists(journal) and os.path.getsize(journal) > 4096):
            time.sleep(.005)
        run.send_signal(signal.SIGINT)
        _, said = run.communicate(timeout=120)
        if run.returncode == 0:
            self.skipTest('the import was too fast to be stopped')
        self.assertEqual(run.returncode, 130)
        if os.path.exists(journal):
            self.assertIn('--resume goes on', said)
        self.bcc4(*go, '--resume', '--quiet')
        self.assertEqual(self.json('info', 's.bcc4')['dims'][3], 60)

    def test_mistakes_are_answered(self):
        self.first_day()
        for words, answer in (
                (('render', 'a.bcc4', '--tiem', 1, '-o', 'x.png'), 'did you mean --time?'),
                (('rendr', 'a.bcc4'), 'did you mean render?'),
                (('crop', 'a.bcc4', '--roi', '0-3,0-3,0-3'), 'bcc4 export --roi'),
                (('convert', 'a.nii'), 'bcc4 import makes'),
                (('append', 'a.bcc4'), 'bcc4 import --append'),
                (('compare', 'a.bcc4'), 'see bcc4 help compare'),
                (('slice', 'a.bcc4', '--time', 99, '-o', 'x.nrrd'), 'the series runs from 0 to 2.5'),
                (('export', 'a.bcc4', '--all', '-o', 'a.mha'), '.nii.gz'),
                (('export', 'a.bcc4', '-o', 'a.nrrd'), '--all'),
                (('export', 'a.bcc4', '--all', '--roi', '0-99,0-3,0-3', '-o', 'a.nrrd'), 'the file has 0 to 23'),
                (('render', 'a.bcc4', '--time', 1, '-o', 'x.jpg'), '.png'),
                (('import', 'day1.00.raw', '-o', 'b.bcc4'), '--dims'),
                (('import', 'day1.00.raw', *AS, '-o', 'a.bcc4'), '--overwrite'),
                (('info', 'day1.00.raw'), 'not a .bcc4 file'),
                (('info', 'absent.bcc4'), 'No such file')):
            p = subprocess.run([BCC4, *map(str, words)], capture_output=True, text=True, cwd=self.folder)
            self.assertIn(p.returncode, (2, 3), words)
            self.assertIn(answer, p.stderr, words)
            self.assertTrue(p.stderr.startswith('bcc4: '), p.stderr)

    def test_the_commands_of_the_readme_work(self):
        with open(os.path.join(TOP, 'README.md')) as f:
            lines = re.findall(r'^    (bcc4 [^#\n]*)', f.read(), re.M)
        self.assertEqual([line.split()[1] for line in lines], ['import', 'info', 'render', 'slice', 'export'])
        for t in range(3):  # its smoke, smaller
            with open(self.path(f'smoke.{t:04}.raw'), 'wb') as f:
                field((48, 48, 48, 1), lambda x, y, z, _: math.exp(-((x - 36) ** 2 + (y - 24) ** 2 + (z - 20 - t) ** 2) / 60), 'f').tofile(f)
        for line in lines:
            words = shlex.split(line.replace('96,96,96', '48,48,48').replace('--dt 0.04', '--dt 0.4'))[1:]
            if words[-1].endswith('.nc') and not has_reader('netcdf'):
                continue
            spread = [n for w in words for n in ([f'smoke.{t:04}.raw' for t in range(3)] if '*' in w else [w])]
            self.bcc4(*spread)


if __name__ == '__main__':
    main()

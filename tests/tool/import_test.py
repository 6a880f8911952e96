"""bcc4 import: what comes out, and what is refused."""
import array
import math
import os
import random
import signal
import subprocess
import time

from harness import BCC4, ToolTest, field, main, write_gzip, Nrrd

DIMS = (9, 8, 7, 6)


def bump(x, y, z, t):
    """Smooth and well inside the band of every lattice."""
    return 100 * math.exp(-((x - 4 - .3 * t) ** 2 + (y - 4) ** 2 + (z - 3) ** 2) / 8)


class Import(ToolTest):
    store = 'samples'

    def test_a_constant_comes_back(self):
        v = self.volume(DIMS, lambda x, y, z, t: 7, '--quiet')
        report = self.json('verify', v, '--against', 'v.bcc4.raw')
        self.assertLess(report['max_abs'], 1e-5 * 7)  # without a ripple, as no site is air
        self.assertEqual(report['samples_compared'], 9 * 8 * 7 * 6)

    def test_dense_floats_get_air_about_their_mean(self):
        def warm(x, y, z, t):
            return 280 + 2 * math.cos(math.pi * x / 8) * math.cos(math.pi * y / 7) * math.cos(math.pi * t / 5)

        args = self.raw('a.raw', DIMS, warm)
        worst = {}
        for name, options in (('own', []), ('zero', ['--air', 0])):
            air = self.json('import', *args, '--dry-run', *options)['channels'][0]['air']
            self.assertTrue(abs(air - 280) < 8 if name == 'own' else air == 0, air)
            self.bcc4('import', *args, *options, '-o', name + '.bcc4', '--quiet')
            self.assertEqual(self.json('info', name + '.bcc4')['channels'][0]['air'], air)
            worst[name] = self.json('verify', name + '.bcc4', '--against', 'a.raw', '--dims', '9,8,7,6', '--dtype', 'f32')['max_abs']
        self.assertLess(worst['zero'], 1.1 * worst['own'])  # air 0 does not let the field ripple
        # A series that goes on keeps the air it has, whatever its own would be.
        long = self.raw('b.raw', DIMS[:3] + (12,), warm)
        self.bcc4('import', *long, '--append', '-o', 'zero.bcc4', '--quiet')
        info = self.json('info', 'zero.bcc4')
        self.assertEqual((info['channels'][0]['air'], info['dims'][3]), (0, 12))

    def test_what_is_empty_stays_air(self):
        for name, f in (('blob', lambda x, y, z, t: max(0, bump(x, y, z, t) - 40)), ('waves', lambda x, y, z, t: math.sin(x + y + t) + .1),
                        ('constant', lambda x, y, z, t: 7)):
            args = self.raw(name, DIMS, f)
            self.assertEqual(self.json('import', *args, '--dry-run')['channels'][0]['air'], 0, name)
        counts = self.raw('counts', DIMS, lambda x, y, z, t: 100 + x, 'u16')  # integers: a step is more than the ripple
        self.assertEqual(self.json('import', *counts, '--dry-run')['channels'][0]['air'], 0)

    def test_ends_of_time(self):
        args = self.raw('a.raw', DIMS, bump)
        worst, sites = {}, {}
        for ends in ('predict', 'mirror'):
            fixed = ('--lattice', 'd4star', '--ends', ends)
            j = self.json('import', *args, *fixed, '-o', ends + '.bcc4')
            sites[ends] = j['sites_total']
            self.assertEqual(self.json('import', *args, *fixed, '--dry-run', '-o', 'no.bcc4')['sites_total'], sites[ends])
            frames = self.json('verify', ends + '.bcc4', '--against', 'a.raw', '--dims', '9,8,7,6', '--dtype', 'f32')['frames']
            worst[ends] = max(frames[0]['max_abs'], frames[-1]['max_abs'])
        self.assertGreater(sites['predict'], sites['mirror'])
        self.assertLess(2 * worst['predict'], worst['mirror'])

    def test_faces(self):
        dims = (20, 18, 44, 3)
        args = self.raw('a.raw', dims, lambda x, y, z, t: 100 + 50 * math.sin(.9 * x - .6 * y + .5 * z + .4 * t), 'f32')
        fixed = ('--lattice', 'd4star', '--exact')
        worst = {}
        for faces in ('predict', 'mirror'):
            self.bcc4('import', *args, *fixed, '--faces', faces, '-o', faces + '.bcc4', '--quiet')
            worst[faces] = self.json('verify', faces + '.bcc4', '--against', 'a.raw', '--dims', '20,18,44,3', '--dtype', 'f32')['max_abs']
        self.bcc4('import', *args, *fixed, '-o', 'default.bcc4', '--quiet')
        outside = {n: self.json('info', n + '.bcc4')['planes_outside']['before'] for n in ('predict', 'mirror', 'default')}
        self.assertEqual(outside, {'predict': [2, 2, 2], 'mirror': [0, 0, 0], 'default': [0, 0, 2]})
        self.assertLess(3 * worst['predict'], worst['mirror'])
        self.assertEqual(self.json('info', 'predict.bcc4')['sites_total'], self.json('info', 'mirror.bcc4')['sites_total'])
        self.assertGreater(self.json('info', 'predict.bcc4')['sites_outside'], 0)
        self.assertIn('planes outside z 2 + 2', self.bcc4('info', 'default.bcc4')[0])
        # Whichever way one looks, the domain is that of the samples.
        self.bcc4('slice', 'predict.bcc4', '--plane', '0,0,1,0,0', '-o', 'z0.nrrd', '--quiet')
        self.bcc4('export', 'predict.bcc4', '--index', '--time', 1, '-o', 'f.nrrd', '--quiet')

    def test_values_that_would_overflow_are_refused(self):
        args = self.raw('a.raw', DIMS, lambda x, y, z, t: 1e37 if (x, y, z, t) == (1, 2, 3, 2) else 1)
        _, err = self.bcc4('import', *args, '-o', 'a.bcc4', expect=3)
        self.assertIn('frame 2', err)
        self.assertIn('1e+36', err)

    def test_reports_and_records(self):
        args = self.raw('a.raw', DIMS, bump)
        j = self.json('import', *args, '--dt', .25, '-o', 'a.bcc4')
        self.assertEqual(j['cc_samples'], 9 * 8 * 7 * 6)
        self.assertEqual(j['bytes']['file'], os.path.getsize(self.path('a.bcc4')))
        self.assertIn('bcc4 import a.raw --dims 9,8,7,6', j['command'])
        info = self.json('info', 'a.bcc4')
        self.assertEqual(info['dims'], list(DIMS))
        self.assertEqual(info['times'], {'count': 6, 'first': 0, 'last': 1.25, 'unit': '', 'uniform': True, 'periodic': False, 'end': 1.25})
        self.assertEqual(info['attributes']['import.dims'], '9,8,7,6')

    def test_verify_recalls_what_the_source_cannot_be_read_without(self):
        def nrrd(name, sizes, extra, t=0):
            head = (f'NRRD0005\ntype: float\ndimension: {len(sizes)}\nsizes: {" ".join(map(str, sizes))}\nendian: little\n'
                    f'encoding: raw\n{extra}\n\n')
            self.write(name, head.encode() + field((*sizes[:3], sizes[3] if len(sizes) > 3 else 1), lambda x, y, z, s: bump(x, y, z, t + s), 'f').tobytes())
        for t in range(3):  # of another place each
            nrrd(f'p.{t}.nrrd', DIMS[:3], f'axis mins: {5 * t} 0 0\nspacings: 1 1 1', t)
        nrrd('t.nrrd', DIMS, 'kinds: domain domain domain time\naxis 3 index type:=numeric\naxis 3 index values:=0 1 1 2 3 4')
        self.write('times.txt', b'0 1 1.5 2 3 4\n')
        for source, *options in (('p.*.nrrd', '--spacing', '1,1,2'), ('t.nrrd', '--dt', '.5'), ('t.nrrd', '--times', 'times.txt')):
            self.refused(3, '--', 'import', source, '-o', 'b.bcc4', output='b.bcc4')
            self.bcc4('import', source, *options, '-o', 'a.bcc4', '--quiet', '--overwrite')
            if '--times' in options:
                os.remove(self.path('times.txt'))
            self.assertTrue(self.json('verify', 'a.bcc4', '--against', source)['ok'], options)

    def test_axes_endianness_and_gzip_change_nothing(self):
        self.volume(DIMS, bump, '--quiet', name='plain.bcc4')
        nx, ny, nz, nt = DIMS
        swapped = field((nt, nz, ny, nx), lambda t, z, y, x: bump(x, y, z, t), 'f')
        swapped.byteswap()
        write_gzip(self.path('other.raw.gz'), swapped.tobytes())
        self.bcc4('import', 'other.raw.gz', '--dims', '9,8,7,6', '--dtype', 'float', '--axes', 'tzyx', '--endian', 'big',
                  '-o', 'other.bcc4', '--quiet')
        self.assertEqual(self.json('verify', 'other.bcc4', '--against', 'plain.bcc4.raw', '--dims', '9,8,7,6', '--dtype',
                                   'f32', '--axes', 'xyzt', '--endian', 'little')['max_abs'],
                         self.json('verify', 'plain.bcc4', '--against', 'plain.bcc4.raw')['max_abs'])

    def test_one_file_per_step(self):
        self.volume(DIMS, bump, '--quiet', name='one.bcc4')
        for t in range(6):
            self.write(f's.{t + 8}.raw', field((9, 8, 7, 1), lambda x, y, z, _: bump(x, y, z, t), 'f'))
        for inputs in (['s.%d.raw'], ['s.*.raw'], [f's.{t}.raw' for t in (13, 9, 8, 12, 10, 11)]):
            self.bcc4('import', *inputs, '--dims', '9,8,7', '--dtype', 'f32', '-o', 'many.bcc4', '--quiet', '--overwrite')
            for name in ('one', 'many'):
                self.bcc4('slice', f'{name}.bcc4', '--time', 2.5, '-o', f'{name}.nrrd')
            self.assertEqual(Nrrd(self.path('one.nrrd')).values, Nrrd(self.path('many.nrrd')).values)

    def test_threads_and_memory_limit_change_no_byte(self):
        args = self.raw('a.raw', (24, 20, 22, 9), bump)
        self.bcc4('import', *args, '-o', 'one.bcc4', '--threads', 1, '--quiet')
        for name, more in (('three', ['--threads', 3]), ('small', ['--max-mem', '200M'])):
            self.bcc4('import', *args, '-o', f'{name}.bcc4', '--quiet', *more)
            with open(self.path('one.bcc4'), 'rb') as a, open(self.path(f'{name}.bcc4'), 'rb') as b:
                self.assertEqual(a.read(), b.read(), name)

    def test_a_lattice_distance_per_axis(self):
        args = self.raw('a.raw', (25, 22, 20, 17), bump)

        def scales(*more):
            self.bcc4('import', *args, '-o', 'a.bcc4', '--overwrite', '--quiet', *more)
            return self.json('info', 'a.bcc4')['scales']

        def assert_near(realised, asked):
            # In space as many planes as end on the last sample.
            for d, ask, n in zip(realised, asked, (25, 22, 20)):
                planes = math.ceil((n - 1) / (ask * math.sqrt(.5)) - 1e-9)
                self.assertAlmostEqual(d, (n - 1) / (planes * math.sqrt(.5)))
            self.assertAlmostEqual(realised[3], asked[3])

        assert_near(scales('--lattice', 'd4star'), (1, 1, 1, 1))
        assert_near(scales('--scale', 1.5), (1.5, 1.5, 1.5, 1))
        assert_near(scales('--scale', '.7,1,1.3'), (.7, 1, 1.3, 1))
        assert_near(scales('--scale', '.7,1,1.3', '--time-scale', 2), (.7, 1, 1.3, 2))
        assert_near(scales('--scale', '.7,1,1.3,2.3'), (.7, 1, 1.3, 2.3))
        self.assertIn('distances 0.693 x 0.99 x 1.28 x 2.3', self.bcc4('info', 'a.bcc4')[0])
        self.bcc4('import', *args, '--scale', '.7,1,1.3,2.3', '--dry-run', '--plan', 'p.json')
        self.bcc4('import', '--plan', 'p.json', '-o', 'planned.bcc4', '--quiet')
        with open(self.path('a.bcc4'), 'rb') as a, open(self.path('planned.bcc4'), 'rb') as b:
            self.assertEqual(a.read(), b.read())
        bound = self.json('import', *args, '--scale', '.7,1,1.3,2.3', '--abs', 5, '-o', 'b.bcc4')
        self.assertLessEqual(bound['error']['channels'][0]['max_abs'], 5)
        self.assertEqual(self.json('info', 'b.bcc4')['scales'], self.json('info', 'a.bcc4')['scales'])
        for wrong, more in (('.7,1', ()), ('1,1,0', ()), ('1,2,3,4,5', ()), ('1,1,1,2', ('--time-scale', 2))):
            self.refused(2, '--scale', 'import', 'a.raw', '--scale', wrong, *more, '-o', 'c.bcc4')

    def test_files_of_distances_that_differ_are_as_good_in_every_form(self):
        def waves(x, y, z, t):
            return 100 + 40 * math.sin(1.3 * x) * math.cos(1.1 * y) + 30 * math.cos(.6 * z + .35 * t) * math.sin(.8 * y)

        args = self.raw('a.raw', (25, 22, 20, 30), waves)
        psnr = {}
        for name, more in (('samples', []), ('cc', ['--lattice', 'cc'])):
            file = name + '.bcc4'
            self.bcc4('import', *args, *more, '--scale', '.7,.75,1,1.9', '--air', 100, '-o', file, '--quiet')
            psnr[name] = self.json('verify', file, '--against', 'a.raw')['psnr']
            self.bcc4('export', file, '--all', '-o', 'back.nrrd', '--overwrite')
            back = Nrrd(self.path('back.nrrd')).values
            truth = (waves(x, y, z, t) for t in range(30) for z in range(20) for y in range(22) for x in range(25))
            self.assertLess(max(abs(a - b) for a, b in zip(back, truth)), 9)
            self.bcc4('slice', file, '--plane', '.3,1,.2,.4,-18', '-o', name + '.nrrd')
        oblique = {name: Nrrd(self.path(name + '.nrrd')).values for name in psnr}
        inside = [(a, b) for a, b in zip(oblique['cc'], oblique['samples']) if math.isfinite(a) and math.isfinite(b)]
        self.assertGreater(len(inside), 3000)
        self.assertLess(math.sqrt(sum((a - b) ** 2 for a, b in inside) / len(inside)), 2)
        self.assertGreater(min(psnr.values()), 42)

    def test_cartesian_samples_come_back_as_they_were(self):
        random.seed(5)
        for dims, kind, dtype in (((23, 18, 20, 9), 'B', 'u8'), ((33, 20, 18), 'H', 'u16'), ((20, 21, 22, 7), 'h', 'i16')):
            count = math.prod(dims)
            low, high = {'B': (0, 255), 'H': (900, 1300), 'h': (-300, 300)}[kind]
            values = array.array(kind, (random.randint(low, high) for _ in range(count)))
            self.write('n.raw', values.tobytes())
            args = ['n.raw', '--dims', ','.join(map(str, dims)), '--dtype', dtype]
            self.bcc4('import', *args, '--lattice', 'cc', '-o', 'n.bcc4', '--overwrite', '--quiet')
            self.assertEqual(self.json('info', 'n.bcc4')['kernel'], 'exact')
            self.assertLess(self.json('verify', 'n.bcc4', '--against', *args)['max_abs'], .1)
            self.bcc4('export', 'n.bcc4', '--all', '-o', 'back.nrrd', '--overwrite')
            self.assertEqual(Nrrd(self.path('back.nrrd')).values, values, dtype)
        # Elsewhere the sites are no samples.
        for more in (['--scale', 1.2], ['--time-scale', .9], ['--kernel', 'default']):
            self.bcc4('import', *args, '--lattice', 'cc', *more, '-o', 'n.bcc4', '--overwrite', '--quiet')
            self.assertEqual(self.json('info', 'n.bcc4')['kernel'], 'radial20+b3')

    def test_a_source_of_another_format_is_read_as_it_says(self):
        """What was told of raw values at import says nothing of what they were exported to."""
        self.bcc4('import', *self.raw('a.raw', (9, 8, 7, 6), bump), '--frames', '1-4', '--exact', '-o', 'v.bcc4', '--quiet')
        self.bcc4('export', 'v.bcc4', '--all', '-o', 'e.nrrd', '--quiet')
        exported = self.json('verify', 'v.bcc4', '--against', 'e.nrrd')
        self.assertEqual(exported['samples_compared'], 9 * 8 * 7 * 4)
        self.assertLess(exported['max_abs'], self.json('verify', 'v.bcc4', '--against', 'a.raw')['max_abs'] + 1e-6)
        self.refused(2, '--dims describes raw files', 'verify', 'v.bcc4', '--against', 'e.nrrd', '--dims', '9,8,7,4')

    def test_lattice_scale_quantize_and_threshold_are_honoured(self):
        args = self.raw('a.raw', (16, 16, 16, 16), bump)

        def info(*more):
            self.bcc4('import', *args, '-o', 'a.bcc4', '--overwrite', '--quiet', *more)
            return self.json('info', 'a.bcc4')

        plain = info('--lattice', 'd4star', '--exact')
        self.assertEqual(plain['lattice'], 'd4star')
        self.assertEqual(plain['value_type'], 'f32')
        self.assertLess(plain['sites_total'], .65 * plain['cc_samples'])
        self.assertEqual(info('--lattice', 'cc')['sites_total'], plain['cc_samples'])
        self.assertLess(info('--scale', 1.5)['sites_total'], .5 * plain['sites_total'])
        self.assertLess(info('--time-scale', 2)['sites_total'], .7 * plain['sites_total'])
        self.assertLess(info('--air-threshold', 10)['sites_kept'], .7 * plain['sites_kept'])
        for kind in ('u8', 'u16', 'f16'):
            self.assertEqual(info('--quantize', kind)['value_type'], kind)
            self.assertGreater(self.json('verify', 'a.bcc4', '--against', 'a.raw')['psnr'], 40)
        self.assertEqual(info('--kernel', 'fine')['kernel'], self.json('info', 'a.bcc4')['recommended_kernel'])
        files = set()
        for more in ((), ('--lowpass',)):
            info(*more)
            with open(self.path('a.bcc4'), 'rb') as f:
                files.add(f.read())
        self.assertEqual(len(files), 2)
        self.refused(2, 'a low-pass is of use on D4* and BCC only', 'import', *args, '--lowpass', '--lattice', 'cc',
                     '-o', 'b.bcc4')

    def test_dry_run_says_everything_and_writes_nothing(self):
        args = self.raw('a.raw', DIMS, bump)
        before = os.listdir(self.folder)
        out, _ = self.bcc4('import', *args, '--dry-run', '--spacing', '1,2,3', '-o', 'a.bcc4')
        for part in ('9 x 8 x 7, 6 frames', 'x 9 (fastest)', 'spacing 1 2 3', 'none given', '% air', 'sites', 'estimate'):
            self.assertIn(part, out)
        j = self.json('import', *args, '--dry-run')
        self.assertEqual(j['dims'], list(DIMS))
        self.assertEqual(os.listdir(self.folder), before)
        self.bcc4('import', *args, '-o', 'a.bcc4', '--quiet')
        self.assertEqual(j['sites_total'], self.json('info', 'a.bcc4')['sites_total'])

    def test_arrays_and_origin_of_a_raw_file(self):
        self.write('a.raw', bytes([10] * 125 + [200] * 125))
        args = ['--dims', '5,5,5', '--dtype', 'u8', '--count', 2]
        self.bcc4('import', 'a.raw', *args, '--spacing', '1,2,3', '--origin', '10,-20,.5', '-o', 'a.bcc4', '--quiet')
        info = self.json('info', 'a.bcc4')
        self.assertEqual([c['range'] for c in info['channels']], [[10, 10], [200, 200]])
        self.assertEqual([[row[i] for i in (n, 3)] for n, row in enumerate(info['affine'][:3])], [[1, 10], [2, -20], [3, .5]])
        self.assertEqual(len(self.json('verify', 'a.bcc4', '--against', 'a.raw')['channels']), 2)  # --count is remembered

    def test_every_psnr_has_the_range_of_the_source_as_its_peak(self):
        # The brightest frame is the last: what is sampled for the estimate and what is measured never see it.
        dims = (12, 11, 10, 40)
        args = self.raw('a.raw', dims, lambda x, y, z, t: bump(x, y, z, 0) * (9 if t == 39 else 1))
        peaks = {self.json('import', *args, '--dry-run')['estimate']['error'][0]['peak']}
        j = self.json('import', *args, '-o', 'a.bcc4')
        peaks.add(j['error']['channels'][0]['peak'])
        peaks.add(self.json('verify', 'a.bcc4', '--against', 'a.raw')['peak'])
        self.assertEqual(len(peaks), 1, peaks)
        shown = {line.split('(peak ')[1].split(')')[0] for line in (
            self.bcc4('import', *args, '--dry-run')[0] + self.bcc4('import', *args, '-o', 'a.bcc4', '--overwrite')[0] +
            self.bcc4('verify', 'a.bcc4', '--against', 'a.raw')[0]).splitlines() if '(peak' in line}
        self.assertEqual(len(shown), 1, shown)

    def test_the_report_says_what_it_is_of(self):
        out, _ = self.bcc4('import', *self.raw('a.raw', (12, 11, 10, 20), bump), '-o', 'a.bcc4')
        self.assertIn('measured on 3 of 20 frames: ', out)
        out, _ = self.bcc4('help', 'import', 'values')
        words = ' '.join(out.split())
        self.assertIn('differ by the ringing of the filter only', words)
        self.assertNotIn('default 0: exact', words)

    def test_large_frames_are_measured_in_boxes(self):
        data = random.Random(1).randbytes(128 * 128 * 100 * 2)
        self.write('a.raw', data)
        args = ('a.raw', '--dims', '128,128,100,2', '--dtype', 'u8', '--lattice', 'd4star', '--exact', '-o', 'a.bcc4',
                '--overwrite')
        out, _ = self.bcc4('import', *args)
        self.assertRegex(out, r'measured on 2 of 2 frames, in boxes with \d+ % of their samples: max')
        boxes = self.json('import', *args)['error']['channels'][0]
        self.assertTrue(0.1 < boxes['compared_part'] < 0.35, boxes['compared_part'])
        self.assertNotIn('in boxes', self.bcc4('import', *args, '--measure', 'all')[0])
        whole = self.json('import', *args, '--measure', 'all')['error']['channels'][0]
        self.assertEqual(whole['compared_part'], 1)
        self.assertAlmostEqual(boxes['rmse'] / whole['rmse'], 1, delta=0.06)
        for frame in boxes['frames']:
            self.assertLessEqual(frame['max_abs'], whole['max_abs'])

    def test_frames_with_gaps_are_measured_in_boxes(self):
        # More values are missing in all frames than the boxes leave out of the measured ones.
        plane = array.array('f', [math.nan] * (128 * 60) + [float(i % 97) for i in range(128 * 68)])
        self.write('a.raw', plane.tobytes() * 100 * 6)
        args = ('a.raw', '--dims', '128,128,100,6', '--dtype', 'f32', '--lattice', 'd4star', '--on-nonfinite', 'hole',
                '--store', 'samples', '--quantize', 'u8', '-o', 'a.bcc4', '--overwrite')
        out, _ = self.bcc4('import', *args)
        self.assertRegex(out, r'measured on 3 of 6 frames, in boxes with \d+ % of their samples: max')
        self.assertLess(self.json('import', *args)['error']['channels'][0]['compared_part'], .35)
        whole = self.json('import', *args, '--measure', 'all')['error']['channels'][0]
        self.assertEqual(whole['compared_part'], 1)
        self.assertEqual(whole['samples_compared'] + whole['lost'], 128 * 68 * 100 * 6)

    def test_channels(self):
        nrrd = b'NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 5 5 5\nkinds: 2-vector space space space\nencoding: raw\n\n'
        self.write('a.nrrd', nrrd + bytes(v for i in range(125) for v in (10, 200)))
        self.bcc4('import', 'a.nrrd', '-o', 'a.bcc4', '--quiet')
        info = self.json('info', 'a.bcc4')
        self.assertEqual([c['name'] for c in info['channels']], ['c0', 'c1'])
        for name, value in (('c0', 10), ('c1', 200), ('1', 200)):
            self.bcc4('slice', 'a.bcc4', '--channel', name, '-o', 's.nrrd')
            for v in Nrrd(self.path('s.nrrd')).values:
                self.assertAlmostEqual(v, value, delta=.005 * value)
        self.refused(2, 'there are c0 and c1', 'slice', 'a.bcc4', '--channel', 'density', '-o', 'x.nrrd', output='x.nrrd')
        report = self.json('verify', 'a.bcc4', '--against', 'a.nrrd')
        self.assertEqual(len(report['channels']), 2)

    def test_frames_without_a_value_are_named(self):
        def holes(x, y, z, t):
            return float('nan') if t in (1, 2, 4) or (t, x) == (3, 0) else x + t
        args = self.raw('h.raw', (5, 4, 3, 6), holes)
        said, _ = self.bcc4('import', *args, '--on-nonfinite', 'hole', '--lattice', 'cc', '--exact', '-o', 'h.bcc4')
        self.assertIn('192 source values were not finite, all of frame 1-2 and 4', said)

    def test_nonfinite_values(self):
        args = self.raw('a.raw', DIMS, lambda x, y, z, t: math.nan if (x, y, z, t) == (1, 2, 3, 4) else bump(x, y, z, t))
        for text in ('not finite', 'frame 4', '(1, 2, 3)', '--on-nonfinite'):
            self.refused(3, text, 'import', *args, '-o', 'a.bcc4', '--quiet', output='a.bcc4')
        for policy in ('hole', 'clamp'):
            self.bcc4('import', *args, '-o', 'a.bcc4', '--on-nonfinite', policy, '--overwrite', '--quiet')
            self.assertEqual(self.json('info', 'a.bcc4')['holes'], policy == 'hole')
        self.bcc4('slice', 'a.bcc4', '--time', 4, '-o', 's.nrrd')

    def test_doubles_beyond_floats(self):
        def values(x, y, z, t):
            return {(1, 2, 3, 4): -1e300, (2, 2, 3, 4): math.inf}.get((x, y, z, t), bump(x, y, z, t))

        args = self.raw('a.raw', DIMS, values, 'f64')
        self.refused(3, '2 values are beyond 32-bit floats or not finite, the first one, -1e+300, at voxel (1, 2, 3)', 'import', *args,
                     '-o', 'a.bcc4', '--quiet', output='a.bcc4')
        for policy in ('hole', 'clamp'):
            said, _ = self.bcc4('import', *args, '-o', 'a.bcc4', '--on-nonfinite', policy, '--overwrite')
            self.assertIn('2 source values were not finite or beyond 32-bit floats', said)
            out, _ = self.bcc4('verify', 'a.bcc4', '--against', 'a.raw')
            self.assertIn('2 source samples are not finite or beyond 32-bit floats', out)
            self.assertLess(self.json('verify', 'a.bcc4', '--against', 'a.raw')['max_abs'], 150)
        plan = self.json('import', *args, '--dry-run')['channels'][0]
        self.assertEqual(plan['nonfinite'], 2)
        self.assertLess(plan['range'][1] - plan['range'][0], 101)
        self.assertIn('2 not finite or beyond 32-bit floats, the first in frame 4', self.bcc4('import', *args, '--dry-run')[0])
        # Others are told as before.
        args = self.raw('b.raw', DIMS, lambda *p: math.nan if p == (1, 2, 3, 4) else bump(*p), 'f64')
        self.refused(3, '1 values are not finite, the first one at voxel (1, 2, 3)', 'import', *args, '-o', 'b.bcc4', '--quiet', output='b.bcc4')

    def test_older_headers_are_latin_1(self):
        head = 'NRRD0004\ntype: uint8\ndimension: 3\nspace dimension: 3\nsizes: 5 5 5\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n' \
               'space units: "\u00b5m" "\u00b5m" "\u00b5m"\nencoding: raw\nMaterial:=Fl\u00fcssigkeit\n\n'
        for encoding in 'latin-1', 'utf-8':
            self.write('a.nrrd', head.encode(encoding) + bytes(range(125)))
            self.bcc4('import', 'a.nrrd', '-o', encoding + '.bcc4', '--quiet')
            info = self.json('info', encoding + '.bcc4')
            self.assertEqual(info['spatial_unit'], '\u00b5m', encoding)

    def test_bad_input_is_refused(self):
        good = self.raw('a.raw', DIMS, bump)
        out = ['-o', 'x.bcc4']
        self.refused(3, 'no such file', 'import', 'none.raw', '--dims', '1,1,1', '--dtype', 'u8', *out, output='x.bcc4')
        self.refused(3, '9 x 8 x 6 x 6 frames x 4 bytes (f32) = 10368', 'import', 'a.raw', '--dims', '9,8,6,6', '--dtype', 'f32',
                     *out, output='x.bcc4')
        self.refused(2, '--dims 9,0,7', 'import', 'a.raw', '--dims', '9,0,7', '--dtype', 'f32', *out, output='x.bcc4')
        self.refused(2, '--dims', 'import', 'a.raw', '--dtype', 'f32', *out, output='x.bcc4')
        self.refused(2, 'did you mean f32?', 'import', 'a.raw', '--dims', '9,8,7,6', '--dtype', 'f3', *out, output='x.bcc4')
        self.refused(3, 'none/x.bcc4', 'import', *good, '-o', 'none/x.bcc4', '--quiet')
        self.refused(2, '-o is missing', 'import', *good)
        self.write('cut.nrrd', b'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\n' + bytes(63))
        self.refused(3, '64 (data) = 126 are expected', 'import', 'cut.nrrd', *out, output='x.bcc4')
        self.write('empty.raw', b'')
        self.refused(3, '0 bytes', 'import', 'empty.raw', '--dims', '9,8,7,6', '--dtype', 'f32', *out, output='x.bcc4')
        write_gzip(self.path('short.gz'), bytes(100))
        self.refused(3, 'are expected', 'import', 'short.gz', '--dims', '9,8,7,6', '--dtype', 'f32', *out, output='x.bcc4')
        self.refused(2, '--times gives 2 times for 6 frames', 'import', *good, '--times', '0,1', *out, output='x.bcc4')
        self.refused(3, 'times must rise', 'import', *good, '--times', '0,1,2,2,3,4', *out, output='x.bcc4')

        self.refused(2, 'auto, d4star, bcc or cc', 'import', *good, '--lattice', 'd4', *out, output='x.bcc4')
        for name, of in (('x.nrrd', 'a file of nrrd'), ('x.nii.gz', 'a file of nifti'), ('-', 'has to have a name')):
            self.refused(2, of, 'import', *good, '-o', name, output=name)
        self.refused(2, 'NIfTI, MetaImage, NetCDF', 'import', 'a.raw', *out, output='x.bcc4')

    def test_what_floats_cannot_hold_is_said(self):
        def far(x, y, z, t):
            return 1e9 + math.sin(.7 * x)

        out, err = self.bcc4('import', *self.raw('far.raw', DIMS, far, 'f64'), '-o', 'far.bcc4')
        self.assertIn('are stored as 32-bit floats, which is off by up to', err)
        self.assertIn('subtract', err)
        self.assertIn('no PSNR of a constant', out)
        self.assertRegex(out, r'worst: .*: 1000000000, source (999999999|1000000000)\.\d+\n')
        for f, dtype, text in ((bump, 'f64', ''), (lambda x, y, z, t: 2**24 + x, 'i32', 'exact up to 16777216'),
                               (lambda x, y, z, t: x + y, 'i32', '')):
            _, err = self.bcc4('import', *self.raw('a.raw', DIMS, f, dtype), '-o', 'a.bcc4', '--quiet', '--overwrite')
            self.assertEqual('32-bit floats' in err, bool(text), err)
            self.assertIn(text, err)

    def test_a_constant_has_no_alternatives(self):
        out, _ = self.bcc4('import', *self.raw('a.raw', (24, 24, 24, 8), lambda x, y, z, t: 7), '-o', 'a.bcc4')
        self.assertIn('exact of the sampled range', out)
        self.assertNotIn('instead of', out)

    def test_an_existing_file_stays_unless_told(self):
        args = self.raw('a.raw', DIMS, bump)
        self.write('a.bcc4', b'precious')
        self.refused(2, '--overwrite', 'import', *args, '-o', 'a.bcc4')
        with open(self.path('a.bcc4'), 'rb') as f:
            self.assertEqual(f.read(), b'precious')
        # A failure leaves the old file, too.
        self.bcc4('import', 'a.raw', '--dims', '9,8,7,5', '--dtype', 'f32', '-o', 'a.bcc4', '--overwrite', expect=3)
        with open(self.path('a.bcc4'), 'rb') as f:
            self.assertEqual(f.read(), b'precious')
        self.bcc4('import', *args, '-o', 'a.bcc4', '--overwrite', '--quiet')
        self.bcc4('info', 'a.bcc4')

    def test_memory_does_not_grow_with_the_frames(self):
        n, frame = 40, bytes((x * 7 + y * 13 + z * 29) % 251 for z in range(40) for y in range(40) for x in range(40))
        peaks = []
        for frames in (40, 640):
            self.write('a.raw', frame * frames)
            peaks.append(self.json('import', 'a.raw', '--dims', f'{n},{n},{n},{frames}', '--dtype', 'u8', '-o', 'a.bcc4', '--overwrite')['peak_memory'])
        # 600 frames more are 38 MB, their samples as codes 16; what allocators hold beside differs by 5 from run to run.
        self.assertLess(peaks[1], peaks[0] + 10e6)

    def test_a_full_disk_is_said(self):
        args = self.raw('a.raw', (40, 40, 40, 8), lambda x, y, z, t: (x * 7919 + y * 104729 + z * 1299709 + t * 15485863) % 1000)
        self.assertIn('a.bcc4', self.full_disk(100000, 'import', *args, '-o', 'a.bcc4'))
        self.assertFalse(os.path.exists(self.path('a.bcc4')))
        for name in ('a.bcc4.partial', 'a.bcc4.journal'):  # on a slow machine there is something to resume
            if os.path.exists(self.path(name)):
                os.remove(self.path(name))

    def test_what_cannot_be_written_is_said_before_the_work(self):
        args = self.raw('a.raw', DIMS, bump)
        os.mkfifo(self.path('pipe.raw'))
        for code, text, output in ((3, 'none/a.bcc4: cannot be written', 'none/a.bcc4'), (2, 'is a folder', '.'), (2, 'no regular file', 'pipe.raw')):
            out, err = self.bcc4('import', *args, '-o', output, '--overwrite', expect=code)
            self.assertIn(text, err)
            self.assertEqual(out, '')
        self.refused(2, 'no regular file', 'export', self.volume(DIMS, bump, '--quiet'), '--all', '-o', 'pipe.raw', '--overwrite')
        self.assertTrue(os.path.exists(self.path('pipe.raw')) and not os.path.isfile(self.path('pipe.raw')))

    def test_nothing_is_written_over_its_source(self):
        v = self.volume(DIMS, bump, '--quiet')
        data = v + '.raw'
        os.symlink(data, self.path('link.raw'))
        self.write('head.nhdr', b'NRRD0004\ntype: float\ndimension: 4\nsizes: 9 8 7 6\nkinds: domain domain domain time\n'
                   b'encoding: raw\nendian: little\ndata file: ' + data.encode() + b'\n')
        def read(name):
            with open(self.path(name), 'rb') as f:
                return f.read()

        kept = {name: read(name) for name in (v, data, 'head.nhdr')}
        raw = ['--dims', '9,8,7,6', '--dtype', 'f32']
        for command in (['import', data, *raw, '-o', data, '--overwrite'], ['import', 'link.raw', *raw, '-o', data, '--overwrite'],
                        ['import', 'head.nhdr', '-o', data, '--overwrite'], ['import', data, *raw, '--dry-run', '--plan', data, '--overwrite'],
                        ['concat', v, '-o', v, '--overwrite'], ['export', v, '--all', '--format', 'raw', '-o', v, '--overwrite'],
                        ['render', v, '--time', 1, '-o', 'p.png', '--stats', v], ['render', v, '--time', 1, '-o', 'p.png', '--dump-tf', v]):
            self.refused(2, 'is an input', *command)
        for name, content in kept.items():
            self.assertEqual(read(name), content, name)

    def test_ctrl_c_leaves_nothing(self):
        n = 64
        self.write('big.raw', bytes(n * n * n * 200))
        p = subprocess.Popen([BCC4, 'import', 'big.raw', '--dims', f'{n},{n},{n},200', '--dtype', 'u8', '--air', '1', '-o', 'x.bcc4'],
                             cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        p.stdout.readline()  # the plan is printed once everything is open
        time.sleep(.3)
        p.send_signal(signal.SIGINT)
        _, err = p.communicate(timeout=60)
        self.assertEqual(p.returncode, 130, err)
        self.assertIn('interrupted', err)
        kept = set(os.listdir(self.folder)) - {'big.raw'} # what is worth resuming, if the machine is slow
        self.assertIn(kept, (set(), {'x.bcc4.partial', 'x.bcc4.journal'}))
        for name in kept:
            os.remove(self.path(name))

    def test_misspelt_things_get_the_nearest_name(self):
        self.refused(2, 'did you mean --dims?', 'import', 'a.raw', '--dim', '1,1,1')
        self.refused(2, 'did you mean import?', 'inport', 'a.raw')
        self.refused(2, 'did you mean --time-scale?', 'import', 'a.raw', '--timescale=2')
        self.refused(2, 'did you mean concat?', 'concta', 'a.bcc4')
        self.refused(2, 'did you mean --part?', 'import', '--plan', 'p.json', '--prat', '1/2')

    def test_version_names_readers(self):
        out, _ = self.bcc4('--version')
        self.assertRegex(out, r'bcc4 \d+\.\d+\.\d+')
        for reader in ('raw', 'nrrd', 'vti', 'nifti', 'openvdb'):
            self.assertIn(reader, out)


if __name__ == '__main__':
    main()

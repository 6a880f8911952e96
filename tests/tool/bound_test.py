"""Errors a user accepts: bounds hold in what the tool gives out, reports say the truth, spectra are measured."""
import array
import math
import os
import random
import re

from harness import DATA, Nrrd, ToolTest, field, main, some

DIMS = (18, 16, 14, 12)


def wave(x, y, z, t):
    return 10 + 4 * math.sin(.6 * x + .2 * y) * math.cos(.4 * z - .5 * t) + math.sin(.9 * y + .6 * t)


def puff(x, y, z, t):
    r = (x - 5 - .5 * t) ** 2 + (y - 8) ** 2 + (z - 7) ** 2
    return 200 * math.exp(-r / 9) if r < 20 else 0


class BoundTest(ToolTest):
    store = 'samples'

    def exported(self, file, dims):
        """Every source sample as `slice` gives it."""
        values = []
        for t in range(dims[3]):
            self.bcc4('slice', file, '--index', '--time', t, '-o', 's.nrrd')
            values += Nrrd(self.path('s.nrrd')).values
        return values

    def test_abs_holds_for_whoever_asks(self):
        noise = random.Random(5)
        for name, f, dtype in (('wave', wave, 'f32'), ('puff', puff, 'u8'), ('noise', lambda *_: noise.uniform(-50, 50), 'f64'),
                               ('i16', lambda *p: 300 * wave(*p), 'i16')):
            args = self.raw(name + '.raw', DIMS, f, dtype)
            source = field(DIMS, f, 'd') if name != 'noise' else None
            if name == 'noise':
                import array
                with open(self.path('noise.raw'), 'rb') as h:
                    source = array.array('d', h.read())
            if dtype in ('u8', 'i16'):
                source = [round(v) for v in source]
            peak = max(source) - min(source)
            for part in some([.1, .001, .01]):
                with self.subTest(name, part=part):
                    report = self.json('import', *args, '-o', 'v.bcc4', '--overwrite', '--abs', part * peak)
                    got = self.exported('v.bcc4', DIMS)
                    worst = max(abs(a - b) for a, b in zip(got, source))
                    self.assertLessEqual(worst, part * peak)
                    error = report['error']['channels'][0]
                    self.assertAlmostEqual(error['max_abs'], worst, delta=1e-6 * peak)
                    self.assertEqual(report['error']['frames_measured'], DIMS[3])
                    self.assertEqual([f['frame'] for f in error['frames']], list(range(DIMS[3])))
                    verified = self.json('verify', 'v.bcc4', '--against', name + '.raw')
                    self.assertEqual(verified['bound'], {'abs': part * peak, 'held': True})
                    for key in ('max_abs', 'worst'):
                        self.assertEqual(verified[key], error[key])
                    self.assertAlmostEqual(verified['rmse'], error['rmse'], delta=1e-9 * peak)
                    self.assertEqual(len(verified['frames']), DIMS[3])
                    self.assertEqual(max(f['max_abs'] for f in verified['frames']), verified['max_abs'])

    def test_what_is_accepted_is_saved(self):
        args = self.raw('a.raw', (28, 26, 24, 24), wave)
        sizes = []
        for part in (1, .1, .01, .001):
            report = self.json('import', *args, '-o', 'v.bcc4', '--overwrite', '--abs', part)
            sizes.append(report['bytes']['file'])
            tried = report['plan']['coding']['tried']
            self.assertGreater(len(tried), 3)
            holding = [t['bytes'] for t in tried if t['holds']]
            self.assertEqual(report['plan']['coding']['chosen']['bytes'], min(holding))
        self.assertEqual(sizes, sorted(sizes))
        self.assertLess(3 * sizes[0], sizes[3])

    def test_far_from_air(self):
        """The corrected field has a base of its own, which grows with the file; parts have air, and hold the bound."""
        def pressure(x, y, z, t):
            return 101325 + 10 * wave(x, y, z, t)
        more = ('--air', 0, '--abs', 1, '--lattice', 'd4star', '--scale', 1, '--ends', 'mirror', '--faces', 'mirror')
        args = self.raw('a.raw', DIMS, pressure)
        self.json('import', *args, '-o', 'whole.bcc4', *more)
        self.json('import', *self.raw('f.raw', (*DIMS[:3], 8), pressure), '-o', 'grown.bcc4', *more)
        self.json('import', *args, '-o', 'grown.bcc4', '--append', *more)
        with open(self.path('whole.bcc4'), 'rb') as a, open(self.path('grown.bcc4'), 'rb') as b:
            self.assertEqual(a.read(), b.read())
        self.json('import', *args, '--dry-run', '--plan', 'plan.json', *more)
        for part in 1, 2:
            self.json('import', '--plan', 'plan.json', '--part', f'{part}/2', '-o', f'p{part}.bcc4')
        self.json('concat', 'p1.bcc4', 'p2.bcc4', '-o', 'joined.bcc4')
        for name in 'whole.bcc4', 'joined.bcc4':
            verified = self.json('verify', name, '--against', 'a.raw', '--dims', ','.join(map(str, DIMS)), '--dtype', 'f32')
            self.assertEqual(verified['bound'], {'abs': 1, 'held': True}, name)

    def test_a_series_goes_on_with_its_own_error(self):
        whole = self.raw('a.raw', (16, 14, 12, 24), wave)
        begin = ('import', *self.raw('f.raw', (16, 14, 12, 14), wave), '-o', 'a.bcc4', '--overwrite', '--quiet')
        self.bcc4(*begin, '--psnr', 55)
        for option in ('--psnr', 55), ('--abs', 1), ('--density', .5):
            self.refused(2, f'{option[0]}: a.bcc4 goes on as it was made, with its own lattice and error: leave it out', 'import', *whole,
                         '-o', 'a.bcc4', '--append', *option)
        self.bcc4('import', *whole, '-o', 'a.bcc4', '--append')
        self.assertEqual(self.json('info', 'a.bcc4')['dims'][3], 24)
        self.bcc4(*begin, '--abs', .05, '--store', 'samples')
        self.bcc4('import', *whole, '-o', 'a.bcc4', '--append')
        self.assertEqual(self.json('verify', 'a.bcc4', '--against', *whole)['bound'], {'abs': .05, 'held': True})
        self.bcc4(*begin, '--lattice', 'd4star', '--scale', 1.5, '--exact')
        self.refused(2, 'import all anew, or leave out --store, --lattice and --scale: --append goes on as the file was made', 'import', *whole, '-o', 'a.bcc4',
                     '--append', '--lattice', 'd4star', '--scale', 1.2)
        self.bcc4('import', *whole, '-o', 'a.bcc4', '--append')

    def test_an_error_that_floats_hold_is_named(self):
        """It is that of the largest value, wherever the first one that floats do not hold is."""
        values = array.array('d', ((1 + 1e-8) * 10 ** (2 + 4 * x / 11) * (1 + .001 * math.sin(y + z + t))
                                   for t in range(4) for z in range(6) for y in range(5) for x in range(12)))
        self.write('d.raw', values)
        args = ('import', 'd.raw', '--dims', '12,5,6,4', '--dtype', 'f64', '-o', 'd.bcc4')
        _, err = self.bcc4(*args, '--abs', 1e-6, expect=1)
        held = re.search('hold errors down to about (\\S+) where the largest is (\\S+); accept that much', err)
        self.assertLess(abs(float(held[2]) - max(values)), 2e-3 * max(values))
        self.bcc4(*args, '--abs', held[1])
        self.assertLess(self.json('info', 'd.bcc4')['channels'][0]['errors']['bound'], 1)

    def test_psnr_is_reached(self):
        args = self.raw('a.raw', (20, 18, 16, 14), wave)
        sizes = []
        for goal in (30, 45, 60, 90):
            report = self.json('import', *args, '-o', 'v.bcc4', '--overwrite', '--psnr', goal)
            verified = self.json('verify', 'v.bcc4', '--against', 'a.raw')
            self.assertGreaterEqual(verified['psnr'], goal)
            self.assertLess(verified['psnr'], goal + .6)
            self.assertAlmostEqual(verified['psnr'], report['error']['channels'][0]['psnr'], places=6)
            sizes.append(report['bytes']['file'])
        self.assertEqual(sizes, sorted(sizes))

    def test_real_series_land_close_to_the_goal(self):
        # Sizes: a tenth above what was measured, less than half of those of the cubic lattice.
        for name, goal, kib in some([('isabel_windspeed_125x125x25x12_u16.nrrd', 50, 1100),
                                     ('cardiac_cine_256x256x19x20_i16.nii.gz', 45, 270), ('pcasl_52x68x20x10_f32.nii.gz', 50, 136)]):
            path = os.path.join(DATA, name)
            if not os.path.exists(path):
                self.skipTest(path)
            report = self.json('import', path, '-o', 'v.bcc4', '--overwrite', '--psnr', goal)
            self.assertTrue(goal <= report['error']['channels'][0]['psnr'] < goal + 1, report['error'])
            self.assertLess(report['bytes']['file'], kib * 1024)
            # No corrections: what is promised is what is drawn.
            self.assertNotIn('corrections', self.bcc4('info', 'v.bcc4')[0])

    def test_holes_do_not_break_a_bound(self):
        args = self.raw('a.raw', DIMS, lambda x, y, z, t: math.nan if 5 < x < 9 and y > 8 and z > 4 else wave(x, y, z, t))
        self.bcc4('import', *args, '-o', 'v.bcc4', '--abs', .05, '--on-nonfinite', 'hole')
        verified = self.json('verify', 'v.bcc4', '--against', 'a.raw')
        self.assertLessEqual(verified['max_abs'], .05)
        self.assertEqual(verified['holes']['file'], 0)
        self.assertGreater(verified['holes']['source'], 0)

    def test_a_bound_that_floats_cannot_hold_is_refused(self):
        args = self.raw('a.raw', DIMS, lambda *p: 1e7 + wave(*p), 'f64')
        for text in ('bound', 'frame', 'voxel', '32-bit floats'):
            self.refused(1, text, 'import', *args, '-o', 'v.bcc4', '--overwrite', '--abs', .01, output='v.bcc4')
        self.refused(2, '--abs must be positive', 'import', *args, '-o', 'v.bcc4', '--abs', 0)
        for option, number in (('--abs', 'nan'), ('--abs', 'inf'), ('--psnr', 'inf'), ('--air', 'nan'), ('--air', '1e300'), ('--air-threshold', 'inf')):
            self.refused(2, f'{option} {float(number):g}'[:9], 'import', *args, '-o', 'v.bcc4', option, number)
        self.refused(2, 'choose one', 'import', *args, '-o', 'v.bcc4', '--abs', 1, '--psnr', 40)

    def test_a_constant_has_every_psnr(self):
        args = self.raw('a.raw', DIMS, lambda *_: 7.5)
        for name, air in (('far', []), ('own', ['--air', 7.5])):
            self.bcc4('import', *args, '-o', name + '.bcc4', *air, '--psnr', 50)
            self.assertIn('exact', self.bcc4('verify', name + '.bcc4', '--against', 'a.raw')[0])

    def test_verify_fails_when_the_source_is_another(self):
        args = self.raw('a.raw', DIMS, wave)
        self.bcc4('import', *args, '-o', 'v.bcc4', '--abs', .1)
        self.raw('b.raw', DIMS, lambda *p: wave(*p) + .5)
        out, err = self.bcc4('verify', 'v.bcc4', '--against', 'b.raw', expect=1)
        self.assertIn('promises an error of at most 0.1', err)

    def test_a_psnr_that_the_series_misses_is_tried_again(self):
        # Too long to be tried out whole, and loud in one frame that nobody looks at.
        n = range(20)
        calm = array.array('f', (40 * math.sin(.2 * x) * math.cos(.15 * y) for _ in n for y in n for x in n))
        loud = array.array('f', (v + 20 * math.sin(2.9 * i) for i, v in enumerate(calm)))
        self.write('late.raw', calm * 37 + loud + calm * 1562)
        args = ('late.raw', '--dims', '20,20,20,1600', '--dtype', 'f32')
        out, _ = self.bcc4('import', *args, '-o', 'late.bcc4', '--psnr', 55)
        self.assertIn('again with', out)
        # Nothing stays of the first try.
        self.assertEqual([n for n in os.listdir(self.folder) if n.startswith('late.bcc4')], ['late.bcc4'])
        self.assertGreaterEqual(self.json('verify', 'late.bcc4', '--against', *args)['psnr'], 55)
        # Interrupted at its end, the last try goes on: by itself, with the options that were typed. Journals are committed
        # each 256 KiB, or each second, which a quick machine does not take.
        whole = self.read('late.bcc4')
        self.assertGreater(len(whole), 1.3 * 2**18)
        said = self.full_disk(len(whole) - 100, 'import', *args, '-o', 'again.bcc4', '--psnr', 55, '--store', 'samples')
        self.assertIn('goes on from there', said)
        out, _ = self.bcc4('import', *args, '-o', 'again.bcc4', '--psnr', 55, '--resume')
        self.assertNotIn('again with', out)
        self.assertEqual(self.read('again.bcc4'), whole)

    def test_choices_of_the_user_are_kept(self):
        args = self.raw('a.raw', DIMS, wave)
        self.bcc4('import', *args, '-o', 'v.bcc4', '--abs', .1, '--scale', 1.1, '--time-scale', .9, '--quantize', 'f16', '--lattice', 'cc')
        info = self.json('info', 'v.bcc4')
        self.assertEqual((info['lattice'], info['value_type']), ('cc', 'f16'))
        self.assertLessEqual(self.json('verify', 'v.bcc4', '--against', 'a.raw')['max_abs'], .1)

    def test_the_report_measures_some_frames_unless_told(self):
        args = self.raw('a.raw', DIMS, wave)
        for choice, frames in (([], 3), (['--measure', 'all'], 12), (['--measure', 'none'], 0)):
            report = self.json('import', *args, '-o', 'v.bcc4', '--overwrite', *choice)
            self.assertEqual(report['error']['frames_measured'], frames)
        out, _ = self.bcc4('import', *args, '-o', 'v.bcc4', '--overwrite')
        for text in ('coding error', 'error at the source samples', 'worst: frame'):
            self.assertIn(text, out)

    def test_bandwidth_is_that_of_the_waves(self):
        # cosines at a quarter and three quarters of the Nyquist frequency of x and t
        n = (32, 32, 32, 32)
        args = self.raw('a.raw', n, lambda x, y, z, t: math.cos(math.pi / 4 * x) + math.cos(.75 * math.pi * t) + math.cos(math.pi / 8 * (y + z)))
        spectrum = self.json('import', *args, '--dry-run')['spectrum']
        width = spectrum['bandwidth']
        self.assertAlmostEqual(width['x']['p99'], .25, delta=.13)
        self.assertAlmostEqual(width['y']['p99'], .125, delta=.13)
        self.assertAlmostEqual(width['t']['p99'], .75, delta=.13)
        self.assertLess(spectrum['outside_cell'], .01)
        # half the energy in a corner of the Cartesian band that D4* has no room for
        args = self.raw('b.raw', n, lambda x, y, z, t: math.cos(math.pi / 4 * x) + math.cos(.9 * math.pi * x + .9 * math.pi * t))
        spectrum = self.json('import', *args, '--dry-run')['spectrum']
        self.assertAlmostEqual(spectrum['outside_cell'], .5, delta=.05)

    def test_time_scale_auto(self):
        args = self.raw('a.raw', (16, 16, 16, 32), lambda x, y, z, t: math.cos(math.pi / 16 * (x + t)) + math.sin(.3 * (y + z)))
        self.bcc4('import', *args, '-o', 'plain.bcc4', '--lattice', 'd4star')
        self.bcc4('import', *args, '-o', 'auto.bcc4', '--time-scale', 'auto')
        plain, auto = self.json('info', 'plain.bcc4'), self.json('info', 'auto.bcc4')
        self.assertLess(auto['sites_total'], .6 * plain['sites_total'])
        self.assertGreater(self.json('verify', 'auto.bcc4', '--against', 'a.raw')['psnr'], 45)
        self.refused(2, '--time-scale', 'import', *args, '-o', 'x.bcc4', '--time-scale', 'fast')

    def test_real_series(self):
        for name, part in some([('viscous_fingers_run01_64x64x64x99_u16.nrrd', .02), ('pcasl_52x68x20x10_f32.nii.gz', .05)]):
            path = os.path.join(DATA, name)
            if not os.path.exists(path):
                self.skipTest(path)
            bound = part * {'p': 2640, 'v': 4083}[name[0]]
            more = ['--frames', '40-59'] if name[0] == 'v' else []
            report = self.json('import', path, '-o', 'v.bcc4', '--overwrite', '--abs', bound, *more)
            error = report['error']['channels'][0]
            self.assertLessEqual(error['max_abs'], bound)
            verified = self.json('verify', 'v.bcc4', '--against', path, *more)
            self.assertEqual(verified['max_abs'], error['max_abs'])
            self.assertLess(10 * report['bytes']['file'], 6 * report['bytes']['source'])


if __name__ == '__main__':
    main()

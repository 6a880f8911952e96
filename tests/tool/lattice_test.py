"""The lattice that import chooses: it fits the spectrum axis by axis, its error is predicted, its values are rounded where
that adds next to nothing, and all of it is settled before the first chunk."""
import array
import math
import os
import random

from harness import CODES, DATA, Nrrd, ToolTest, field, main


def slow(x, y, z, t):
    """As fine in space as voxels are, hardly changing in time."""
    return 50 * math.cos(2.2 * x) * math.cos(2.1 * y + .05 * t) * math.cos(1.9 * z) + 3 * math.sin(.2 * t)


def fast(x, y, z, t):
    """The other way round."""
    return 50 * math.cos(.3 * x + .2 * y - .25 * z) * math.cos(2.1 * t) + 20 * math.sin(.3 * y + 1.9 * t)


def mild(x, y, z, t):
    """Well inside the cell of the cubic lattice, but for its faces."""
    return 50 * math.cos(.9 * x + .8 * y - .2 * t) + 30 * math.sin(.7 * z + .9 * t - .3 * x)


class LatticeTest(ToolTest):
    store = 'samples'

    def imported(self, args, *more, name='v.bcc4'):
        return self.json('import', *args, '-o', name, '--overwrite', '--measure', 'all', *more)

    def assert_predicted(self, report):
        predicted, reached = report['plan']['choice']['rounded']['rmse'][0], report['error']['channels'][0]['rmse']
        self.assertLess(abs(20 * math.log10(predicted / reached)), 1.5, (predicted, reached))

    def test_distances_follow_the_spectrum(self):
        for f, coarse in ((slow, True), (fast, False)):
            args = self.raw('a.raw', (24, 22, 20, 18), f)
            report = self.imported(args)
            choice = report['plan']['choice']
            chosen = next(c for c in choice['candidates'] if c['name'] == choice['chosen'])
            cubic = next(c for c in choice['candidates'] if c['name'] == 'd4star, cubic')
            self.assertEqual(chosen['distances'][3] > 1.3, coarse, chosen)
            self.assertEqual(chosen['distances'][3] < .9, not coarse, chosen)
            self.assertLess(chosen['density'], .62)
            self.assertGreater(chosen['psnr'], cubic['psnr'] + 10)
            self.assertTrue(cubic['tried'])
            self.assert_predicted(report)
            info = self.json('info', 'v.bcc4')
            self.assertEqual((info['lattice'], [round(s, 6) for s in info['scales']]),
                             (chosen['lattice'], [round(s, 6) for s in chosen['distances']]))
            forced = self.imported(args, '--lattice', 'd4star')
            self.assertGreater(forced['error']['channels'][0]['rmse'], 3 * report['error']['channels'][0]['rmse'])
            self.assert_predicted(forced)

    def assert_all_predicted(self, args):
        """What the report says of each candidate is what it gives; of those that were not tried it says nothing."""
        choice = self.imported(args)['plan']['choice']
        for c in choice['candidates']:
            self.assertEqual(c['tried'], c['psnr'] is not None, c['name'])
            if not c['tried']:
                self.assertFalse({'bytes', 'rmse', 'predicted'} & set(c), c['name'])
                continue
            given = self.imported(args, '--lattice', c['lattice'], '--scale', ','.join(map(repr, c['scales'])), '--exact',
                                  '--faces', c['faces_predicted'] or 'mirror', '--ends', 'predict' if c['ends_predicted'] else 'mirror')
            reached = given['error']['channels'][0]['psnr']
            self.assertLess(abs(c['psnr'] - reached), 1.5, (c['name'], c['psnr'], reached))

    def long_series(self, name, dims, of_frame, of_row):
        """Too much to be tried out whole: rows of waves whose phase and size depend on where they are."""
        values = array.array('f')
        for t in range(dims[3]):
            phase, size = of_frame(t)
            for z in range(dims[2]):
                for y in range(dims[1]):
                    shift, part = of_row(y, z)
                    values.extend(8 * math.sin(.31 * x + shift) + size * part * math.sin(.23 * x + shift + phase)
                                  for x in range(dims[0]))
        return self.write(name, values), '--dims', ','.join(map(str, dims)), '--dtype', 'f32'

    def test_what_moves_in_a_few_frames_only_is_predicted(self):
        # A jolt in the first frames, in a corner.
        def of_frame(t):
            return 2.3 * t, 20 if t < 4 else .01

        def of_row(y, z):
            return .2 * y - .15 * z, math.exp(-((y - 20) / 8) ** 2)
        self.assert_all_predicted(self.long_series('jolt.raw', (160, 160, 8, 20), of_frame, of_row))

    def test_series_that_end_in_full_swing_are_predicted(self):
        def of_frame(t):
            return .9 * t, 4 + .1 * t

        def of_row(y, z):
            return .25 * y + .3 * z, 1
        self.assert_all_predicted(self.long_series('swing.raw', (48, 48, 40, 48), of_frame, of_row))

    def test_the_report_says_what_was_chosen(self):
        args = self.raw('a.raw', (24, 22, 20, 18), slow)
        out, _ = self.bcc4('import', *args, '-o', 'v.bcc4')
        for text in (' of the sampled range predicted', 'instead of d4star, distances ', 'every second frame, blended', 'lossy: values in steps of',
                     '--exact keeps'):
            self.assertIn(text, out)

    def test_what_fits_no_lattice_is_said_with_what_keeps_it(self):
        noise = random.Random(5)
        args = self.raw('noise.raw', (20, 20, 20, 6), lambda x, y, z, t: noise.uniform(-1, 1))
        far = 'far from the source'
        self.assertIn(far, self.bcc4('import', *args, '-o', 'far.bcc4')[0])
        self.assertNotIn(far, self.bcc4('import', *args, '-o', 'all.bcc4', '--lattice', 'cc')[0])
        self.assertGreater(self.imported(args, '--lattice', 'cc')['error']['channels'][0]['psnr'], 60)
        self.assertNotIn(far, self.bcc4('import', *self.raw('b.raw', (20, 20, 20, 6), mild), '-o', 'near.bcc4')[0])

    def test_half_the_frames_blended_is_what_it_says(self):
        n = (9, 8, 7, 10)
        noise = random.Random(3)
        values = [noise.uniform(0, 9) for _ in range(n[0] * n[1] * n[2] * n[3])]
        at = iter(values)
        args = self.raw('a.raw', n, lambda *_: next(at), 'f64')
        predicted = self.json('import', *args, '-o', 'v.bcc4')['plan']['choice']['half_the_frames']
        frame, squares = n[0] * n[1] * n[2], 0
        for t in range(1, n[3], 2):
            for i in range(frame):
                before = values[(t - 1) * frame + i]
                after = values[(t + 1) * frame + i] if t + 1 < n[3] else before
                squares += ((before + after) / 2 - values[t * frame + i]) ** 2
        peak = max(values) - min(values)
        self.assertAlmostEqual(predicted, 20 * math.log10(peak / math.sqrt(squares / len(values))), places=3)

    def test_short_axes_are_measured(self):
        args = self.raw('a.raw', (20, 19, 12, 10), lambda x, y, z, t: math.cos(math.pi * z * 7 / 11) + .5 * math.cos(math.pi * t * 4 / 9))
        width = self.json('import', *args, '--dry-run')['spectrum']['bandwidth']
        self.assertAlmostEqual(width['z']['p90'], 7 / 11, delta=.02)
        self.assertAlmostEqual(width['t']['p99'], 4 / 9, delta=.02)
        self.assertLess(width['x']['p99'], .02)

    def test_density(self):
        args = self.raw('a.raw', (18, 17, 16, 33), slow)
        worst = []
        for density in (.25, .5, .8):
            report = self.imported(args, '--density', density)
            info = self.json('info', 'v.bcc4')
            self.assertAlmostEqual(info['sites_total'] / info['cc_samples'], density, delta=.25 * density)
            worst.append(report['error']['channels'][0]['rmse'])
        self.assertEqual(worst, sorted(worst, reverse=True))
        self.imported(args, '--lattice', 'cc', '--density', .5)
        self.assertEqual(self.json('info', 'v.bcc4')['lattice'], 'cc')
        for more, text in ((['--density', 0], '--density'), (['--density', .5, '--scale', 2], '--scale'), (['--lattice', 'fcc'], '--lattice')):
            self.refused(2, text, 'import', *args, *more, '-o', 'x.bcc4', output='x.bcc4')

    def test_rounding_adds_a_fifteenth_of_the_error(self):
        for dtype, f in (('f32', mild), ('u16', lambda *p: 30000 + 300 * mild(*p))):
            args = self.raw('a.raw', (24, 22, 20, 18), f, dtype)
            rmse = {}
            for name, more in (('default', []), ('exact', ['--exact'])):
                report = self.imported(args, '--lattice', 'd4star', *more)
                rmse[name] = report['error']['channels'][0]['rmse']
                info = self.json('info', 'v.bcc4')
                self.assertEqual(info['value_type'], 'u16' if name == 'default' else dtype)
            added = 10 * math.log10((rmse['default'] / rmse['exact']) ** 2)
            self.assertTrue(.05 < added < .4, added)
        sizes = [self.imported(args, '--lattice', 'd4star', *more)['bytes']['file'] for more in ([], ['--exact'])]
        self.assertLess(sizes[0], .75 * sizes[1])

    def test_rounding_has_an_end(self):
        # White noise: the lattice loses half of it, but rounding stays within 1/512 of the range.
        noise = random.Random(4)
        args = self.raw('a.raw', (16, 16, 16, 16), lambda *_: noise.uniform(0, 100))
        step = self.imported(args, '--lattice', 'd4star')['plan']['choice']['rounded']['steps'][0]
        self.assertAlmostEqual(step, math.sqrt(12) * 100 / 512, delta=.01)

    def test_what_stays_exact(self):
        grid = self.raw('a.raw', (16, 15, 14, 9), lambda *p: 1000 + 10 * slow(*p), 'i16')
        self.imported(grid, '--lattice', 'cc')
        self.assertEqual(self.json('info', 'v.bcc4')['channels'][0]['value_scale'], 1)
        static = self.raw('s.raw', (16, 15, 14, 1), lambda *p: slow(*p))
        self.imported(static)
        self.assertEqual(self.json('info', 'v.bcc4')['value_type'], 'f32')

    def test_faces_are_predicted_where_it_tells(self):
        args = self.raw('a.raw', (26, 22, 20, 12), lambda x, y, z, t: mild(x, y, z, .1 * t))
        report = self.imported(args)
        chosen = next(c for c in report['plan']['choice']['candidates'] if c['name'] == report['plan']['choice']['chosen'])
        self.assertEqual(chosen['faces_predicted'], 'xyz')
        self.assertEqual(self.json('info', 'v.bcc4')['planes_outside'], {'before': [2, 2, 2], 'behind': [2, 2, 2]})
        mirrored = self.imported(args, '--faces', 'mirror')
        self.assertEqual(self.json('info', 'v.bcc4')['planes_outside']['before'], [0, 0, 0])
        self.assertGreater(report['error']['channels'][0]['psnr'], mirrored['error']['channels'][0]['psnr'] + 6)
        # And a bound is kept in fewer bytes.
        small, large = (self.imported(args, '--psnr', 50, *more)['bytes']['file'] for more in ((), ('--faces', 'mirror')))
        self.assertLess(1.25 * small, large)
        # Across the axes that are named, whatever it costs.
        self.imported(args, '--faces', 'xz')
        self.assertEqual(self.json('info', 'v.bcc4')['planes_outside']['before'], [2, 0, 2])
        # Of noise nothing can be predicted: the planes would be in vain.
        noise = random.Random(1)
        report = self.imported(self.raw('a.raw', (20, 18, 16, 8), lambda *_: noise.uniform(0, 9)))
        self.assertEqual(self.json('info', 'v.bcc4')['planes_outside']['before'], [0, 0, 0])

    def test_labels_are_kept(self):
        def organ(x, y, z, t):
            r = math.hypot(x - 11 - .3 * t, y - 10, z - 9)
            return 0 if r > 9 else 37 if x + y < 20 else 4 if z > 8 else 12 if r > 4 else 90

        def smooth(x, y, z, t):
            return round(10 + 9 * math.sin(.3 * x + .2 * t) * math.cos(.25 * y - .2 * z))

        def mask(x, y, z, t):
            return 255 if math.hypot(x - 11 - .3 * t, y - 10, z - 9) < 8 else 0

        def shells(x, y, z, t):
            r = math.hypot(x - 11 - .3 * t, y - 10, z - 9)
            return 0 if r > 9 else 3 if r > 7 else 7 if r > 4 else 12

        def layers(x, y, z, t): # mostly in each other
            r = math.hypot(x - 11 - .3 * t, y - 10, z - 9)
            return 0 if r > 9 else 1 if r > 7 and z < 12 else 2 if r > 4 else 3

        def steps(x, y, z, t):
            return 4 * (smooth(x, y, z, t) // 4)

        def halves(x, y, z, t):
            return mask(x, y, z, t) / 510

        for f, labels, dtype in ((organ, True, 'u8'), (mask, True, 'u8'), (mask, True, 'f32'), (smooth, False, 'u8'), (halves, True, 'f32'),
                                 (shells, True, 'u8'), (layers, True, 'u8'), (steps, False, 'u8')):
            args = self.raw('a.raw', (22, 20, 18, 12), f, dtype)
            report = self.imported(args)
            self.assertEqual(report['plan']['choice']['labels'], [labels], f.__name__)
            self.assertEqual(self.json('info', 'v.bcc4')['lattice'] == 'cc' and report['error']['channels'][0]['max_abs'] < .01, labels)
            if labels:
                out, _ = self.bcc4('import', *args, '-o', 'v.bcc4', '--overwrite')
                self.assertIn('labels: value has no gradations', out)
                # On the samples themselves, and outside whatever was asked for.
                layers = self.json('info', 'v.bcc4')['layers']
                self.imported(args, '--faces', 'xz', '--ends', 'predict')
                info = self.json('info', 'v.bcc4')
                self.assertEqual((info['lattice'], info['planes_outside']['before'], info['layers']), ('cc', [2, 0, 2], layers + 4))
            # A still volume, too.
            report = self.imported(self.raw('a.raw', (22, 20, 18, 1), f, dtype))
            self.assertEqual(self.json('info', 'v.bcc4')['lattice'] == 'cc' and report['error']['channels'][0]['max_abs'] < .01, labels)
        # What any other still volume has is said, and what else there is.
        still = self.raw('a.raw', (22, 20, 18, 1), smooth, 'u8')
        for more, told in (((), True), (('--lattice', 'cc'), False), (('--psnr', 40), False)):
            out, _ = self.bcc4('import', *still, '-o', 'v.bcc4', '--overwrite', *more)
            self.assertEqual('bcc, as of any single frame' in out, told, more)
        # On a lattice that was asked for they are as precise as the source's, too.
        for more in (['--density', .5], ['--lattice', 'd4star']):
            report = self.imported(self.raw('a.raw', (22, 20, 18, 12), organ, 'u8'), *more)
            self.assertEqual(report['plan']['choice']['labels'], [True])
            self.assertEqual(report['plan']['choice']['rounded']['steps'], [])

    def test_labels_between_frames_are_the_nearest_frame_s(self):
        def organ(x, y, z, t):
            r = math.hypot(x - 5 - .4 * t, y - 5, z - 4)
            return 0 if r > 4 else 37 if x + y < 9 else 4

        dims = (12, 10, 9, 8)
        for f, dtype, labels in ((organ, 'u8', True), (lambda *p: 250 * (organ(*p) > 0), 'i16', True), (lambda *p: organ(*p) + .01 * p[0], 'f32', False)):
            self.imported(self.raw('a.raw', dims, f, dtype), *([] if labels else ['--lattice', 'cc']), '--exact', '--dt', 2)
            frames = [field((*dims[:3], 1), lambda x, y, z, _: f(x, y, z, t), CODES[dtype]) for t in range(dims[3])]
            for moment, nearest in ((3.4, 3), (3.5, 4), (6.75, 7), (5, 5)):
                _, said = self.bcc4('export', 'v.bcc4', '--index', '--time', moment, '-o', 'e.nrrd', '--overwrite')
                got = Nrrd(self.path('e.nrrd'))
                worst = max(abs(a - b) for a, b in zip(got.values, frames[nearest]))
                self.assertEqual(worst < .01, labels or moment == nearest, (dtype, moment, worst))
                self.assertEqual(f'labels: those of frame {nearest}, the nearest' in said, labels and moment != nearest)
                self.assertEqual(float(got.keys['time']), 2 * moment)  # it is what was asked for
            # Slices are of the nearest labels as well; of what is smooth they have the field.
            self.bcc4('slice', 'v.bcc4', '--index', '--time', 3.4, '-o', 's.nrrd', '--quiet')
            apart = max(abs(a - b) for a, b in zip(Nrrd(self.path('s.nrrd')).values, frames[3]))
            self.assertLess(apart, .01) if labels else self.assertGreater(apart, 1)

        self.imported(self.raw('a.raw', dims, lambda x, y, z, t: 10 + 9 * math.sin(.3 * x + .5 * t) * math.cos(.25 * y - .2 * z), 'u8'))
        self.assertEqual(self.json('info', 'v.bcc4')['lattice'], 'd4star')
        self.assertNotIn('labels', self.bcc4('export', 'v.bcc4', '--index', '--time', 3.4, '-o', 'f.nrrd')[1])

    def test_plan_parts_and_one_process_make_the_same_bytes(self):
        for dtype in ('f32', 'u16'):
            args = self.raw('a.raw', (18, 16, 14, 41), lambda *p: 500 + 5 * fast(*p), dtype)
            self.bcc4('import', *args, '-o', 'one.bcc4', '--overwrite', '--quiet')
            self.bcc4('import', *args, '--dry-run', '--plan', 'p.json', '--overwrite')
            self.bcc4('import', '--plan', 'p.json', '-o', 'planned.bcc4', '--overwrite', '--quiet')
            for part in ('0-9', '10-29', '30-40'):
                self.bcc4('import', '--plan', 'p.json', '--part', part, '-o', part + '.bcc4', '--overwrite', '--quiet')
            self.bcc4('concat', '0-9.bcc4', '10-29.bcc4', '30-40.bcc4', '-o', 'joined.bcc4', '--overwrite', '--quiet')
            self.assertEqual(self.read('one.bcc4'), self.read('planned.bcc4'))
            self.assertEqual(self.read('one.bcc4'), self.read('joined.bcc4'))

    def test_a_series_that_goes_on_keeps_lattice_and_steps(self):
        for dtype in ('f32', 'u16'):
            args = self.raw('a.raw', (18, 16, 14, 60), lambda *p: 500 + 5 * fast(*p), dtype)
            self.bcc4('import', *args, '--frames', '0-39', '-o', 'v.bcc4', '--overwrite', '--quiet')
            short = self.json('info', 'v.bcc4')
            self.bcc4('import', *args, '-o', 'v.bcc4', '--append', '--quiet')
            long = self.json('info', 'v.bcc4')
            self.assertEqual(long['dims'][3], 60)
            for key in ('lattice', 'scales', 'value_type'):
                self.assertEqual(short[key], long[key])
            self.assertEqual(short['channels'][0]['value_scale'], long['channels'][0]['value_scale'])
            # The same as what one import with these choices writes.
            self.bcc4('import', *args, '--dry-run', '--plan', 'p.json', '--overwrite', '-o', 'v.bcc4', '--append')
            self.bcc4('import', '--plan', 'p.json', '-o', 'one.bcc4', '--overwrite', '--quiet')
            self.assertEqual(self.read('v.bcc4'), self.read('one.bcc4'))

    def test_channels_have_steps_of_their_own(self):
        nrrd = b'NRRD0004\ntype: float\ndimension: 5\nsizes: 2 16 15 14 12\nkinds: 2-vector space space space time\nencoding: raw\nendian: little\n\n'
        import array
        values = array.array('f', (v for t in range(12) for z in range(14) for y in range(15) for x in range(16)
                                   for v in (fast(x, y, z, t), 1e-4 * fast(z, x, y, t))))
        self.write('a.nrrd', nrrd + values.tobytes())
        report = self.imported(['a.nrrd'], '--lattice', 'd4star')
        a, b = report['plan']['choice']['rounded']['steps']
        self.assertTrue(1e3 < a / b < 1e5, (a, b))
        for c in report['error']['channels']:
            self.assertGreater(c['psnr'], 15)

    def test_real_series_are_predicted(self):
        for name in ('pcasl_52x68x20x10_f32.nii.gz', 'isabel_windspeed_125x125x25x12_u16.nrrd', 'cardiac_cine_256x256x19x20_i16.nii.gz'):
            path = os.path.join(DATA, name)
            if not os.path.exists(path):
                self.skipTest(path)
            self.assert_predicted(self.imported([path]))


if __name__ == '__main__':
    main()

"""bcc4 import without options: 50 dB outside air, no sample off by more than 2 % of its channel's range, by the store of
wavelets; what asks for something else gets samples; --psnr and --abs without a search."""
import array
import math
import os

from harness import ToolTest, main

DIMS = (40, 36, 30, 20)


def waves(x, y, z, t):
    return 300 * math.sin(.2 * x + .3 * t) * math.cos(.25 * y - .2 * z) + 40 * math.sin(1.9 * x + 1.3 * y)


def puff(x, y, z, t):
    """A ball with a steep edge in much air, which moves."""
    return max(0, min(1, 7 - math.dist((x, y, z), (14 + .3 * t, 18, 15))))


class Promise(ToolTest):
    def imported(self, args, *more):
        return self.json('import', *args, '-o', 'v.bcc4', '--overwrite', *more)

    def exported(self):
        self.bcc4('export', 'v.bcc4', '--all', '-o', 'out.raw', '--overwrite', '--quiet')
        values = array.array('f')
        with open(self.path('out.raw'), 'rb') as f:
            values.frombytes(f.read())
        return values

    def errors(self, f, dims=DIMS):
        """Of what is exported: the largest one, and dB over the samples that are not 0, peak: the range."""
        it = iter(self.exported())
        source = [f(x, y, z, t) for t in range(dims[3]) for z in range(dims[2]) for y in range(dims[1]) for x in range(dims[0])]
        off = [(abs(next(it) - v), v) for v in source]
        peak = max(source) - min(source)
        inside = [e * e for e, v in off if v != 0]
        return max(e for e, _ in off) / peak, 20 * math.log10(peak / math.sqrt(sum(inside) / len(inside)))

    def test_it_is_kept(self):
        for f in (waves, puff):
            args = self.raw('a.raw', DIMS, f)
            report = self.imported(args)
            self.assertEqual(report['plan']['wavelets'], {'psnr': 50, 'abs': 0, 'share_of_range': .02}, f.__name__)
            self.assertEqual(self.json('info', 'v.bcc4')['store'], 'wavelets')
            worst, psnr = self.errors(f)
            self.assertLessEqual(worst, .02 * (1 + 1e-5), f.__name__)
            self.assertGreaterEqual(psnr, 49.5, f.__name__)  # the mean over slabs of one budget

    def test_it_is_said_with_how_to_ask_for_more(self):
        out, _ = self.bcc4('import', *self.raw('a.raw', DIMS, waves), '-o', 'v.bcc4')
        self.assertIn('wavelets, 50 dB outside air and no sample off by more than 2 % of the range; more or less with --psnr or --abs', out)

    def test_each_channel_has_its_own(self):
        """One of millions and one of thousandths: both within 2 % of their range."""
        size = DIMS[0] * DIMS[1] * DIMS[2]
        text = 'NRRD0004\ntype: float\ndimension: 5\nsizes: 2 %d %d %d %d\nkinds: vector space space space time\nencoding: raw\nendian: little\n\n' % DIMS
        values = array.array('f')
        for t in range(DIMS[3]):
            for i in range(size):
                x, y, z = i % DIMS[0], i // DIMS[0] % DIMS[1], i // DIMS[0] // DIMS[1]
                values.append(1e6 * waves(x, y, z, t))
                values.append(1e-3 * waves(z, x, y, t))
        self.write('two.nrrd', text.encode() + values.tobytes())
        report = self.imported(['two.nrrd'])
        errors = report['error']['channels']
        self.assertEqual(len(errors), 2)
        for e in errors:
            self.assertGreater(e['peak'], 0)
            self.assertLessEqual(e['max_abs'], .02 * e['peak'] * (1 + 1e-5), e['name'])
            self.assertGreaterEqual(e['psnr'], 50, e['name'])

    def test_whoever_asks_for_something_else_gets_samples(self):
        args = self.raw('a.raw', DIMS, waves)
        for more in (['--density', '.5'], ['--lattice', 'cc'], ['--scale', '1.2'], ['--exact'], ['--lowpass'], ['--quantize', 'f16'],
                     ['--store', 'samples'], ['--air-threshold', '.5'], ['--live', '1'], ['--max-mem', '16M']):
            out = more[0].strip('-') + '.bcc4'
            self.bcc4('import', *args, '-o', out, '--quiet', *more)
            self.assertEqual(self.json('info', out)['store'], 'samples', more)

    def test_labels_stay_whole(self):
        def organs(x, y, z, t):
            r = math.dist((x, y, z), (14 + .3 * t, 18, 15))
            return 0 if r > 12 else 37 if x + y < 30 else 4 if z > 12 else 90
        report = self.imported(self.raw('a.raw', DIMS, organs, 'u8'))
        self.assertEqual(report['plan']['choice']['labels'], [True])
        self.assertLess(report['error']['channels'][0]['max_abs'], .01)

    def test_a_constant_and_nothing(self):
        for value in (7, 0):
            report = self.imported(self.raw('a.raw', (12, 11, 10, 6), lambda x, y, z, t, v=value: v))
            self.assertNotIn('wavelets', report['plan'])
            self.assertTrue(all(abs(v - value) < 1e-5 for v in self.exported()))

    def test_air_is_air(self):
        self.imported(self.raw('a.raw', DIMS, puff))
        values = iter(self.exported())
        far = 0
        for t in range(DIMS[3]):
            for z in range(DIMS[2]):
                for y in range(DIMS[1]):
                    for x in range(DIMS[0]):
                        v = next(values)
                        if math.dist((x, y, z), (14 + .3 * t, 18, 15)) > 18:  # no block of 4^3 with a sample of it
                            far += 1
                            self.assertEqual(v, 0)
        self.assertGreater(far, 1000)

    def test_missing_samples_take_no_part_in_the_mean(self):
        def coast(x, y, z, t):
            return math.nan if x < 22 else waves(x, y, z, t)
        report = self.imported(self.raw('a.raw', DIMS, coast), '--on-nonfinite', 'hole', '--psnr', '55')
        self.assertIn('wavelets', report['plan'])
        self.assertGreaterEqual(report['error']['channels'][0]['psnr'], 55)

    def test_a_bound_takes_what_is_smallest(self):
        """Nearly every integer back: samples. A bound of every sample of something smooth: few corrections."""
        args = self.raw('a.raw', DIMS, lambda x, y, z, t: round(waves(x, y, z, t) / 4 + 100), 'u8')
        for more, store in ((['--psnr', '70'], 'samples'), (['--abs', '1'], 'samples'), (['--psnr', '45'], 'wavelets'), (['--abs', '3'], 'wavelets')):
            report = self.imported(args, *more)
            self.assertEqual(self.json('info', 'v.bcc4')['store'], store, more)
            self.assertEqual('coding' in report['plan'], store == 'samples', more)
            if more[0] == '--abs':
                self.assertLessEqual(report['error']['channels'][0]['max_abs'], float(more[1]))
        smooth = self.raw('b.raw', DIMS, lambda x, y, z, t: 300 * math.sin(.2 * x + .1 * t) * math.cos(.15 * y - .1 * z))
        tried = self.imported(smooth, '--abs', '6')['bytes']
        fixed = self.imported(smooth, '--abs', '6', '--store', 'wavelets')['bytes']
        self.assertEqual(tried, fixed, 'the same without being asked')
        self.assertLess(tried['corrections'], .5 * tried['file'])

    def test_a_series_goes_on_as_its_file_does(self):
        args = self.raw('a.raw', DIMS, waves)
        self.bcc4('import', *args, '--frames', '0-15', '-o', 'v.bcc4', '--quiet')
        before = self.json('info', 'v.bcc4')
        self.bcc4('import', *args, '-o', 'v.bcc4', '--append', '--quiet')
        after = self.json('info', 'v.bcc4')
        self.assertEqual((before['store'], after['store'], after['dims'][3]), ('wavelets', 'wavelets', DIMS[3]))
        self.assertLessEqual(self.errors(waves)[0], .02 * 1.01)

    def test_a_plan_and_its_parts_promise_the_same(self):
        args = self.raw('a.raw', DIMS, puff)
        self.bcc4('import', *args, '-o', 'whole.bcc4', '--quiet')
        self.bcc4('import', *args, '--dry-run', '--plan', 'p.json', '--quiet')
        for k in (1, 2):
            self.bcc4('import', '--plan', 'p.json', '--part', f'{k}/2', '-o', f'{k}.bcc4', '--quiet')
        self.bcc4('concat', '1.bcc4', '2.bcc4', '-o', 'joined.bcc4', '--quiet')
        with open(self.path('whole.bcc4'), 'rb') as a, open(self.path('joined.bcc4'), 'rb') as b:
            self.assertEqual(a.read(), b.read())
        self.assertTrue(os.path.exists(self.path('p.json')))


if __name__ == '__main__':
    main()

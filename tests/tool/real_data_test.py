"""Real data sets, each with what its import must give, a third of them in turn. Skipped where the files are not there."""
import array
import gzip
import math
import os
import struct
import sys
import zlib

from harness import DATA, Nrrd, ToolTest, has_openvdb, has_reader, main, some

FINGERS = 'viscous_fingers_run01_'
# name: (arguments, dims, source type, range, least PSNR in dB, {(x, y, z, frame): value}). Values and ranges were read from
# the bytes of the files, not by the readers.
SETS = {
    'tooth_103x94x161_u8.nrrd': ([], [103, 94, 161, 1], 'u8', [0, 255], 45,
                                 {(24, 45, 144, 0): 236, (13, 52, 120, 0): 246, (51, 43, 128, 0): 226}),
    'headsq/quarter.nhdr': ([], [64, 64, 93, 1], 'i16', [0, 3926], 36,
                            {(18, 25, 18, 0): 2026, (47, 28, 47, 0): 1104, (23, 50, 9, 0): 1090}),
    'fuel_64x64x64_u8.vti': ([], [64, 64, 64, 1], 'u8', [0, 255], 40, {(20, 31, 31, 0): 212, (43, 31, 33, 0): 79}),
    'neghip_64x64x64_u8.raw': (['--dims', '64,64,64', '--dtype', 'u8'], [64, 64, 64, 1], 'u8', [0, 255], 35,
                               {(18, 25, 23, 0): 255, (46, 21, 43, 0): 255}),
    'nucleon_41x41x41_u8.raw': (['--dims', '41,41,41', '--dtype', 'u8'], [41, 41, 41, 1], 'u8', [0, 249], 40,
                                {(24, 21, 29, 0): 233, (22, 23, 27, 0): 248, (14, 21, 14, 0): 190}),
    'engine_256x256x128_u8.raw.gz': (['--dims', '256,256,128', '--dtype', 'u8'], [256, 256, 128, 1], 'u8', [0, 255], 33,
                                     {(134, 109, 107, 0): 205, (113, 109, 10, 0): 255, (123, 66, 105, 0): 181}),
    'bonsai_256x256x256_u8_zlib.vti': ([], [256, 256, 256, 1], 'u8', [0, 255], 33,
                                       {(187, 32, 144, 0): 206, (194, 37, 166, 0): 205, (157, 3, 200, 0): 204}),
    'dx_mri_16x128x128_u16be.raw': (['--dims', '128,128,16', '--axes', 'zxy', '--dtype', 'u16', '--endian', 'big'],
                                    [128, 128, 16, 1], 'u16', [668, 57684], 38,
                                    {(40, 81, 11, 0): 21033, (35, 71, 8, 0): 21677, (38, 61, 9, 0): 19769}),
    'statmap_64x64x21_f32be.nii.gz': ([], [64, 64, 21, 1], 'f32', [-8.71, 18.58], 30, {(32, 9, 5, 0): 14.012}),
    'nan_17x21x3_f32be.nii': (['--on-nonfinite', 'hole'], [17, 21, 3, 1], 'f32', [409.300, 13360.962], 20,
                              {(10, 8, 1, 0): 11571}),
    'pcasl_52x68x20x10_f32.nii.gz': ([], [52, 68, 20, 10], 'f32', [0, 2640], 29,
                                     {(19, 9, 7, 0): 1476, (27, 21, 17, 0): 1552, (40, 20, 15, 7): 1532, (27, 21, 17, 7): 1539}),
    FINGERS + '64x64x64x99_u16.nrrd': ([], [64, 64, 64, 99], 'u16', [0, 4083], 50,
                                       {(32, 44, 61, 49): 2841, (23, 11, 61, 49): 2557, (30, 53, 61, 49): 2504}),
    FINGERS + 't001_original_f32_zlib.vti': ([], [64, 64, 64, 1], 'f32', [0, 76.763], 30,
                                             {(32, 44, 61, 0): 75.952, (30, 53, 61, 0): 75.745}),
    FINGERS + 't050_original_f32_zlib.vti': ([], [64, 64, 64, 1], 'f32', [0, 107.936], 30,
                                             {(32, 44, 61, 0): 94.364, (23, 11, 61, 0): 84.918}),
    FINGERS + 't099_original_f32_zlib.vti': ([], [64, 64, 64, 1], 'f32', [0, 123.874], 30,
                                             {(23, 11, 61, 0): 97.280, (27, 9, 61, 0): 101.564, (32, 44, 61, 0): 106.267}),
    'cardiac_cine_256x256x19x20_i16.nii.gz': ([], [256, 256, 19, 20], 'i16', [0, 3978], 45,
                                              {(83, 203, 8, 0): 1625, (168, 213, 7, 11): 2475}),
    'isabel_windspeed_125x125x25x12_u16.nrrd': ([], [125, 125, 25, 12], 'u16', [0, 64437], 38,
                                                {(92, 78, 2, 0): 54110, (32, 42, 2, 9): 49190}),
    'cranium.nhdr': ([], [256, 256, 108, 1], 'i16', [-1024, 2986], 50, {(160, 177, 1, 0): 2908, (128, 128, 50, 0): -6}),
    'cranium_256x256x108_i16le.raw.gz': (['--dims', '256,256,108', '--dtype', 'i16'], [256, 256, 108, 1], 'i16', [-1024, 2986],
                                         50, {(160, 177, 1, 0): 2908, (128, 128, 50, 0): -6}),
    'smoke.vdb': ([], [111, 222, 112, 1], 'f16', [0, 5.71], 41, {}),
}
# Sets whose bytes are plain: (type, bytes in front of them, moments looked at).
PLAIN = {
    'neghip_64x64x64_u8.raw': ('B', 0, [0]),
    'engine_256x256x128_u8.raw.gz': ('B', 0, [0]),
    'cardiac_cine_256x256x19x20_i16.nii.gz': ('h', 352, [0, 7, 7.000001, 18.999999]),
    'isabel_windspeed_125x125x25x12_u16.nrrd': ('H', 0, [0, 4, 4.000001, 11]),
}
# Times other than one frame at 0: (first, last, unit).
TIMES = {'cardiac_cine_256x256x19x20_i16.nii.gz': (0, .054283, 's'), 'isabel_windspeed_125x125x25x12_u16.nrrd': (0, 11, ''),
         'pcasl_52x68x20x10_f32.nii.gz': (0, 22.86, 's'), FINGERS + '64x64x64x99_u16.nrrd': (0, 98, '')}
# What other tests look at, or what is no volume.
ELSEWHERE = {'ncep_forecast_36x33x10x7_f32.nc', 'smoke-blosc.nvdb', 'dx_mri.general.txt'}


def vti_values(path):
    """The one float32 array of a .vti with appended zlib blocks."""
    with open(path, 'rb') as f:
        data = f.read()
    at = data.index(b'_', data.index(b'<AppendedData')) + 1
    count = struct.unpack_from('<Q', data, at)[0]
    sizes = struct.unpack_from(f'<{count}Q', data, at + 24)
    at += 24 + 8 * count
    out = b''
    for n in sizes:
        out += zlib.decompress(data[at:at + n])
        at += n
    return array.array('f', out)


class RealData(ToolTest):
    def sets(self):
        for name, row in some(list(SETS.items()), (len(SETS) + 2) // 3):
            path = os.path.join(DATA, name)
            if os.path.exists(path) and not (name.endswith('.vdb') and not has_openvdb()):
                yield name, path, *row

    def test_every_set_is_in_the_table(self):
        path = os.path.join(DATA, 'README.md')
        if not os.path.exists(path):
            self.skipTest('no such data')
        with open(path, encoding='utf-8') as f:
            listed = [line.split('`')[1] for line in f if line.startswith('| `')]
        self.assertGreater(len(listed), 15)
        self.assertEqual([name for name in listed if name not in SETS and name not in ELSEWHERE], [])

    def test_sets_say_what_they_hold(self):
        for name, path, args, dims, kind, limits, psnr, _ in self.sets():
            with self.subTest(name):
                self.bcc4('import', path, *args, '-o', 'a.bcc4', '--overwrite', '--quiet')
                j = self.json('info', 'a.bcc4')
                self.assertEqual(j['dims'], dims)
                self.assertEqual(j['channels'][0]['source_type'], kind)
                self.assertAlmostEqual(j['range'][0], limits[0], delta=.01)
                self.assertAlmostEqual(j['range'][1], limits[1], delta=.01)
                first, last, unit = TIMES.get(name, (0, 0, ''))
                self.assertAlmostEqual(j['times']['first'], first)
                self.assertAlmostEqual(j['times']['last'], last)
                self.assertTrue(unit in ('', j['times']['unit']), j['times'])
                self.assertEqual(j['store'], 'wavelets')
                report = self.json('verify', 'a.bcc4', '--against', path)
                if 'hole' in args:
                    self.assertEqual(report['samples_compared'], j['cc_samples'] - 153)
                    self.assertGreater(j['holes'], 0)
                elif dims[3] < 20:
                    self.assertEqual(report['samples_compared'], j['cc_samples'])
                self.assertGreater(report['psnr'], max(psnr, 49.9))
                self.assertLessEqual(report['max_abs'], .0201 * (limits[1] - limits[0]))

    def test_spot_voxels(self):
        """On the Cartesian lattice the samples themselves are stored: axes, byte order and scaling show in single values."""
        for _, path, args, dims, _, limits, _, spots in self.sets():
            if not spots:
                continue
            more = ['--frames', '40-60'] if dims[3] > 60 else []
            first = 40 if more else 0
            self.bcc4('import', path, *args, *more, '--lattice', 'cc', '-o', 'a.bcc4', '--overwrite', '--quiet')
            for frame in sorted({spot[3] for spot in spots}):
                self.bcc4('slice', 'a.bcc4', '--index', '--time', frame - first, '-o', 's.nrrd', '--quiet')
                values = Nrrd(self.path('s.nrrd')).values
                for (x, y, z, t), value in spots.items():
                    if t == frame:
                        got = values[x + dims[0] * (y + dims[1] * z)]
                        self.assertAlmostEqual(got, value, delta=.02 * (limits[1] - limits[0]), msg=f'{path} {(x, y, z, t)}')

    def test_moments_keep_the_promise(self):
        """Slices at frames and beside them, which are sums of layers, against the bytes of the source: 50 dB outside air,
        2 % of the range, and half a step for codes that slices do not round."""
        cases = [case for case in PLAIN.items() if os.path.exists(os.path.join(DATA, case[0]))]
        if not cases:
            self.skipTest('SKIPPED: none of ' + ', '.join(PLAIN))
        for name, (code, head, moments) in some(cases):
            path = os.path.join(DATA, name)
            args, dims, _, limits, _, _ = SETS[name]
            with (gzip.open if name.endswith('.gz') else open)(path, 'rb') as f:
                data = f.read()
            if name.endswith('.nrrd'):
                data = gzip.decompress(data[data.index(b'\n\n') + 2:])
            self.bcc4('import', path, *args, '-o', 'm.bcc4', '--overwrite', '--quiet')
            size = dims[0] * dims[1] * dims[2]
            peak = limits[1] - limits[0]
            for moment in moments:
                source = struct.unpack_from(f'<{size}{code}', data, head + round(moment) * size * struct.calcsize(code))
                self.bcc4('slice', 'm.bcc4', '--index', *(['--time', moment] if dims[3] > 1 else []), '-o', 'm.nrrd', '--overwrite',
                          '--quiet')
                got = Nrrd(self.path('m.nrrd')).values
                self.assertEqual(len(got), size)
                off = [(abs(g - v), v) for g, v in zip(got, source)]
                self.assertLessEqual(max(e for e, _ in off), .02 * peak * (1 + 1e-5) + .5, (name, moment))
                squares = [e * e for e, v in off if v != 0]
                psnr = 20 * math.log10(peak / math.sqrt(sum(squares) / len(squares)))
                self.assertGreaterEqual(psnr, 48.5, (name, moment))  # the budget is of all frames together

    def test_viscous_fingers(self):
        path = os.path.join(DATA, 'viscous_fingers_run01_64x64x64x99_u16.nrrd')
        if not os.path.exists(path):
            self.skipTest('no such data')
        self.bcc4('import', path, '-o', 'f.bcc4', '--quiet', '--store', 'samples')
        j = self.json('info', 'f.bcc4')
        self.assertEqual(j['dims'], [64, 64, 64, 99])
        self.assertEqual(j['times'], {'count': 99, 'first': 0, 'last': 98, 'unit': '', 'uniform': True, 'periodic': False,
                                      'end': 98})
        sites = j['sites_total'] + j['sites_outside']
        self.assertTrue(.45 < sites / j['cc_samples'] < .56, sites / j['cc_samples'])
        self.assertGreater(self.json('verify', 'f.bcc4', '--against', path, '--frames', '0-98')['psnr'], 50)
        # Step 50 of the original, in floats, is frame 49; the series was quantised to 136/4095.
        original = vti_values(os.path.join(DATA, 'viscous_fingers_run01_t050_original_f32_zlib.vti'))
        self.bcc4('slice', 'f.bcc4', '--time', 49, '-o', 'f.nrrd')
        squares = [(a * 136 / 4095 - b) ** 2 for a, b in zip(Nrrd(self.path('f.nrrd')).values, original)]
        self.assertLess((sum(squares) / len(squares)) ** .5, .005 * max(original))

    def test_forecast(self):
        path = os.path.join(DATA, 'ncep_forecast_36x33x10x7_f32.nc')
        if not os.path.exists(path) or not has_reader('netcdf'):
            self.skipTest('no such data or reader')
        self.refused(2, 'T, Z and Psl', 'import', path, '-o', 'x.bcc4', output='x.bcc4')
        out, _ = self.bcc4('import', path, '--channel', 'T', '-o', 't.bcc4')
        self.assertIn('10 samples at uneven places, 1000 to 100', out)
        j = self.json('info', 't.bcc4')
        self.assertEqual(j['dims'], [36, 33, 10, 7])
        self.assertEqual(j['affine'][2][2:], [-100, 1000])
        self.assertEqual(j['axes'][2]['coordinates'], [1000, 850, 700, 500, 400, 300, 250, 200, 150, 100])
        self.assertEqual([j['times'][key] for key in ('count', 'first', 'last', 'unit', 'uniform')], [7, 0, 48, 'hours', False])
        self.assertEqual(j['channels'][0]['name'], 'T')
        self.assertGreater(self.json('verify', 't.bcc4', '--against', path, '--channel', 'T')['psnr'], 45)
        # Fill values and what lies outside the file's valid range, 63880 of 83160 samples, are missing.
        self.bcc4('import', path, '--channel', 'Z', '-o', 'z.bcc4', '--quiet')
        self.assertEqual(self.json('info', 'z.bcc4')['channels'][0]['missing'], 63880)
        self.bcc4('slice', 'z.bcc4', '--time', 24, '-o', 'z.nrrd', '--quiet')
        values = Nrrd(self.path('z.nrrd')).values
        self.assertTrue(sum(v != v for v in values) > len(values) / 2)
        self.assertTrue(all(-500 < v < 5500 for v in values if v == v))

    def test_nan_and_foreign_formats_are_named(self):
        cases = {'nan_17x21x3_f32be.nii': '153 values are not finite', 'smoke-blosc.nvdb': 'NanoVDB'}
        missing = [name for name in cases if not os.path.exists(os.path.join(DATA, name))]
        for name in cases.keys() - set(missing):
            self.refused(3, cases[name], 'import', os.path.join(DATA, name), '-o', 'x.bcc4', output='x.bcc4')
        if missing:
            self.skipTest(f'SKIPPED: {", ".join(missing)} not there')

    def test_wrong_descriptions_are_suspected(self):
        path = os.path.join(DATA, 'dx_mri_16x128x128_u16be.raw')
        if not os.path.exists(path):
            self.skipTest('no such data')
        _, err = self.bcc4('import', path, '--dims', '128,128,16', '--dtype', 'u16', '--dry-run')
        self.assertIn('--endian', err)
        _, err = self.bcc4('import', path, '--dims', '128,128,16', '--dtype', 'u16', '--endian', 'big', '--dry-run')
        self.assertIn('16,128,128', err)


if __name__ == '__main__':
    if not os.path.isdir(DATA):
        sys.exit(77)
    main()

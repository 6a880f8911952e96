"""Real data sets, each with what its import must give. Skipped where the files are not there."""
import array
import os
import struct
import sys
import zlib

from harness import DATA, Nrrd, ToolTest, has_openvdb, has_reader, main

# name: (arguments, dims, source type, range, least PSNR in dB)
SETS = {
    'tooth_103x94x161_u8.nrrd': ([], [103, 94, 161, 1], 'u8', [0, 255], 45),
    'headsq/quarter.nhdr': ([], [64, 64, 93, 1], 'i16', [0, 3926], 36),
    'fuel_64x64x64_u8.vti': ([], [64, 64, 64, 1], 'u8', [0, 255], 40),
    'neghip_64x64x64_u8.raw': (['--dims', '64,64,64', '--dtype', 'u8'], [64, 64, 64, 1], 'u8', [0, 255], 35),
    'nucleon_41x41x41_u8.raw': (['--dims', '41,41,41', '--dtype', 'u8'], [41, 41, 41, 1], 'u8', [0, 249], 40),
    'dx_mri_16x128x128_u16be.raw': (['--dims', '128,128,16', '--axes', 'zxy', '--dtype', 'u16', '--endian', 'big'],
                                    [128, 128, 16, 1], 'u16', [668, 57684], 38),
    'statmap_64x64x21_f32be.nii.gz': ([], [64, 64, 21, 1], 'f32', [-8.71, 18.58], 30),
    'pcasl_52x68x20x10_f32.nii.gz': ([], [52, 68, 20, 10], 'f32', [0, 2640], 29),
    'smoke.vdb': ([], [111, 222, 112, 1], 'f16', [0, 5.71], 41),
}


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
    def test_sets_say_what_they_hold(self):
        for name, (args, dims, kind, limits, psnr) in SETS.items():
            path = os.path.join(DATA, name)
            if not os.path.exists(path) or (name.endswith('.vdb') and not has_openvdb()):
                continue
            with self.subTest(name):
                self.bcc4('import', path, *args, '-o', 'a.bcc4', '--overwrite', '--quiet')
                j = self.json('info', 'a.bcc4')
                self.assertEqual(j['dims'], dims)
                self.assertEqual(j['channels'][0]['source_type'], kind)
                self.assertAlmostEqual(j['range'][0], limits[0], delta=.01)
                self.assertAlmostEqual(j['range'][1], limits[1], delta=.01)
                self.assertLess(j['sites_total'], .75 * j['cc_samples'])
                report = self.json('verify', 'a.bcc4', '--against', path)
                self.assertEqual(report['samples_compared'], j['cc_samples'])
                self.assertGreater(report['psnr'], psnr)

    def test_viscous_fingers(self):
        path = os.path.join(DATA, 'viscous_fingers_run01_64x64x64x99_u16.nrrd')
        if not os.path.exists(path):
            self.skipTest('no such data')
        self.bcc4('import', path, '-o', 'f.bcc4', '--quiet')
        j = self.json('info', 'f.bcc4')
        self.assertEqual(j['dims'], [64, 64, 64, 99])
        self.assertEqual(j['times'], {'count': 99, 'first': 0, 'last': 98, 'unit': '', 'uniform': True})
        self.assertTrue(.49 < j['sites_total'] / j['cc_samples'] < .51, j['sites_total'] / j['cc_samples'])
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
        _, err = self.bcc4('import', path, '--channel', 'T', '-o', 't.bcc4')
        self.assertIn('level is not evenly spaced', err)
        j = self.json('info', 't.bcc4')
        self.assertEqual(j['dims'], [36, 33, 10, 7])
        self.assertEqual([j['times'][key] for key in ('count', 'first', 'last', 'unit', 'uniform')], [7, 0, 48, 'hours', False])
        self.assertEqual(j['channels'][0]['name'], 'T')
        self.assertGreater(self.json('verify', 't.bcc4', '--against', path, '--channel', 'T')['psnr'], 45)
        # Fill values and what lies outside the file's valid range, 63880 of 83160 samples, are holes.
        self.bcc4('import', path, '--channel', 'Z', '-o', 'z.bcc4', '--quiet')
        self.assertGreater(self.json('info', 'z.bcc4')['channels'][0]['holes'], 25000)
        self.bcc4('slice', 'z.bcc4', '--time', 24, '-o', 'z.nrrd', '--quiet')
        values = Nrrd(self.path('z.nrrd')).values
        self.assertTrue(sum(v != v for v in values) > len(values) / 2)
        self.assertTrue(all(-500 < v < 5500 for v in values if v == v))

    def test_nan_and_foreign_formats_are_named(self):
        for name, code, text in (('nan_17x21x3_f32be.nii', 3, '153 values are not finite'), ('smoke-blosc.nvdb', 3, 'NanoVDB')):
            path = os.path.join(DATA, name)
            if os.path.exists(path):
                self.refused(code, text, 'import', path, '-o', 'x.bcc4', output='x.bcc4')

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

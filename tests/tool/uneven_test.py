"""Axes of space whose samples are unevenly spaced: coordinates are kept, errors are those at the source's own samples, and
pictures are laid out by the coordinates."""
import math
import os
import struct
import unittest

from cases_netcdf_test import DIMS, axes, classic, field
from harness import DATA, Nrrd, ToolTest, exr_attributes, has_reader, main, read_png

try:
    import netCDF4
except ImportError:
    netCDF4 = None

CASE = os.path.join(DATA, 'cases', 'uneven_depths.nc')
DEPTHS = [0, 10, 20, 30, 50, 75, 100, 150, 200, 300, 500, 1000]
PRESSURES = [1000, 850, 700, 500, 250, 100]


def latitude(j):
    """Of equal area, 18 of them."""
    return math.degrees(math.asin(-.95 + 1.9 * j / 17))


def temperature(depth, lat, lon, t):
    return (4 + 22 * math.exp(-depth / 180) * math.cos(math.radians(lat)) +
            2 * math.cos(math.radians(lon) + t / 20) * math.exp(-depth / 80))


def weather(lev=PRESSURES):
    """A classic file over time, pressure, latitude and longitude."""
    values = [20 * math.log(p / 50) + 3 * math.sin(.7 * x + .3 * t) * math.cos(.4 * y)
              for t in range(4) for p in lev for y in range(7) for x in range(8)]
    level = ('lev', 'double', ['lev'], {'units': 'hPa'}, lev)
    return classic(axes(lev=level) + [field('float', values, units='K')]), array_of(values)


def levels_of(lev):
    """The same at fewer levels."""
    count = [(name, len(lev) if name == 'lev' else size) for name, size in DIMS]
    values = [20 * math.log(p / 50) + 3 * math.sin(.7 * x + .3 * t) * math.cos(.4 * y)
              for t in range(4) for p in lev for y in range(7) for x in range(8)]
    return classic(axes(lev=('lev', 'double', ['lev'], {'units': 'hPa'}, lev)) + [field('float', values, units='K')], count)


def array_of(values):
    """As floats of 32 bits."""
    return list(struct.unpack(f'{len(values)}f', struct.pack(f'{len(values)}f', *values)))


def numbers(text):
    return [float(n) for n in text.split()]


@unittest.skipUnless(has_reader('netcdf'), 'without NetCDF')
class Uneven(ToolTest):
    def case(self):
        if not os.path.exists(CASE):
            print('SKIPPED: no', CASE)
            self.skipTest('no such data')
        return CASE

    def test_parts_are_tried_of_long_axes(self):
        # Of frames of more than a tile a part is tried, whose axes are shorter.
        n, at = 72, lambda i: i * (1 + .01 * i)
        grid = [('lev', 'double', ['lev'], {'units': 'm'}, [at(i) for i in range(n)])]
        values = [round(60 + 50 * math.sin(.1 * z) * math.cos(.07 * y + .05 * x)) for z in range(n) for y in range(n) for x in range(n)]
        self.write('bytes.nc', classic(grid + [('v', 'byte', ['lev', 'lat', 'lon'], {}, values)], [(d, n) for d in ('lev', 'lat', 'lon')]))
        for bound in ((), ('--abs', '2')):
            self.bcc4('import', 'bytes.nc', *bound, '-o', 'b.bcc4', '--quiet', '--overwrite')
            self.assertLess(self.json('verify', 'b.bcc4', '--against', 'bytes.nc')['max_abs'], 2.01)

    def test_axes_of_different_units_have_a_fair_shape(self):
        """Degrees and metres: no bundle of rods, unless it is asked for."""
        text, _ = weather()
        self.write('w.nc', text)
        self.bcc4('import', 'w.nc', '-o', 'w.bcc4', '--quiet')

        def matrix(*more):
            _, err = self.bcc4('render', 'w.bcc4', '--index', '--time', 1, '-o', 'w.exr', '--size', '32x32', *more)
            m = exr_attributes(self.path('w.exr'))['worldToNDC']
            os.remove(self.path('w.exr'))
            return struct.unpack('<16f', m), err

        fair, said = matrix('--view', 'bottom')
        self.assertIn('x in degrees, y in degrees, z in hPa: drawn as a box of', said)
        stored, said = matrix('--view', 'bottom', '--shape', 'stored')
        self.assertNotIn('drawn as a box', said)
        asked, said = matrix('--view', 'bottom', '--shape', '1,1,.5')
        self.assertNotIn('drawn as a box', said)
        self.assertEqual(len({fair, stored, asked}), 3)
        # What is drawn by a scene has that shape, too.
        shares = []
        for more in [], ['--with', 'w.bcc4'], ['--color-channel', 0]:
            self.bcc4('render', 'w.bcc4', '--index', '--time', 1, '-o', 'w.png', '--size', '64x64', '--view', 'left', '--quiet', *more)
            shares.append(sum(pixel[3] > 0 for row in read_png(self.path('w.png')) for pixel in row))
        for share in shares[1:]:
            self.assertAlmostEqual(share, shares[0], delta=.1 * shares[0])
        self.refused(2, '--shape', 'render', 'w.bcc4', '--index', '--time', 1, '--shape', '1,0,1', '-o', 'x.png', output='x.png')
        self.refused(2, '--shape', 'render', 'w.bcc4', '--index', '--time', 1, '--shape', 'square', '-o', 'x.png', output='x.png')

    def test_even_axes_of_different_units_have_one_too(self):
        text, _ = weather([1000, 850, 700, 550, 400, 250])
        self.write('e.nc', text)
        self.bcc4('import', 'e.nc', '-o', 'e.bcc4', '--quiet')
        _, said = self.bcc4('render', 'e.bcc4', '--index', '--time', 1, '-o', 'e.png', '--size', '32x32')
        self.assertIn('z in hPa: drawn as a box of', said)
        # A host's clips are of the world as stored.
        _, said = self.bcc4('render', 'e.bcc4', '--index', '--time', 1, '-o', 'e.png', '--size', '32x32', '--clip=0,0,1,500')
        self.assertNotIn('drawn as a box', said)

    def test_the_bound_holds_at_the_source_s_own_samples(self):
        self.bcc4('import', self.case(), '-o', 'a.bcc4', '--psnr', 60)
        j = self.json('info', 'a.bcc4')
        self.assertEqual(j['dims'], [24, 18, 12, 8])
        self.assertEqual(j['spatial_unit'], '')
        self.assertEqual(j['axes'][2], {'unit': 'm', 'down': True, 'coordinates': DEPTHS})
        self.assertEqual([a['unit'] for a in j['axes']][:2], ['degrees', 'degrees'])
        for j_lat, lat in enumerate(j['axes'][1]['coordinates']):
            self.assertAlmostEqual(lat, latitude(j_lat), 4)
        verified = self.json('verify', 'a.bcc4', '--against', CASE)
        self.assertEqual(verified['samples_compared'], 24 * 18 * 12 * 8)
        self.assertGreaterEqual(verified['psnr'], 60)
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.nrrd')
        out = Nrrd(self.path('a.nrrd'))
        self.assertEqual(numbers(out.keys['axis 2 index values']), DEPTHS)
        self.assertEqual((out.keys['axis 2 index unit'], out.keys['axis 2 index positive']), ('m', 'down'))
        worst = squares = 0
        i, low, high = 0, math.inf, -math.inf
        for t in numbers(out.keys['axis 3 index values']):
            for depth in DEPTHS:
                for lat in j['axes'][1]['coordinates']:
                    for x in range(24):
                        truth = temperature(depth, lat, 15 * x, t)
                        worst, squares = max(worst, abs(out.values[i] - truth)), squares + (out.values[i] - truth) ** 2
                        low, high = min(low, truth), max(high, truth)
                        i += 1
        psnr = 20 * math.log10((high - low) / math.sqrt(squares / i))
        print(f'  at the source\'s own levels: {psnr:.1f} dB, at most {worst:.3f} off, file {os.path.getsize(self.path("a.bcc4"))} bytes')
        self.assertGreaterEqual(psnr, 60)
        self.assertAlmostEqual(worst, verified['max_abs'], 4)

    def test_an_independent_reader_has_the_same_coordinates(self):
        if netCDF4 is None:
            print('SKIPPED: no netCDF4 for Python')
            self.skipTest('no netCDF4')
        self.bcc4('import', self.case(), '-o', 'a.bcc4', '--abs', .01)
        self.bcc4('export', 'a.bcc4', '--time', 15, '-o', 'a.nrrd')
        j = self.json('info', 'a.bcc4')
        with netCDF4.Dataset(CASE) as f:
            self.assertEqual(j['axes'][2]['coordinates'], [float(v) for v in f['depth'][:]])
            self.assertEqual(j['axes'][1]['coordinates'], [float(v) for v in f['lat'][:]])
            source = f['temp'][3].ravel()
        values = Nrrd(self.path('a.nrrd')).values
        self.assertEqual(len(values), len(source))
        self.assertLessEqual(max(abs(a - b) for a, b in zip(values, source)), .01 + 1e-6)

    def test_pressures_that_fall_come_back(self):
        data, values = weather()
        self.write('a.nc', data)
        out, _ = self.bcc4('import', 'a.nc', '-o', 'a.bcc4', '--abs', .005)
        self.assertIn('6 samples at uneven places, 1000 to 100 hPa', out)
        info, _ = self.bcc4('info', 'a.bcc4')
        self.assertIn('1000 850 700 500 250 100 hPa', info)
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.nrrd')
        exported = Nrrd(self.path('a.nrrd'))
        self.assertLessEqual(max(abs(a - b) for a, b in zip(exported.values, values)), .005)
        # NRRD hands them on.
        self.bcc4('import', 'a.nrrd', '-o', 'b.bcc4', '--exact')
        self.assertEqual(self.json('info', 'b.bcc4')['axes'][2], {'unit': 'hPa', 'down': False, 'coordinates': PRESSURES})
        self.bcc4('export', 'a.bcc4', '--all', '--roi', '1-4,2-5,2-4', '-o', 'box.nrrd')
        box = Nrrd(self.path('box.nrrd'))
        self.assertEqual(numbers(box.keys['axis 2 index values']), [700, 500, 250])
        self.assertIn('(0,0,-225)', box.fields['space directions'])
        self.assertTrue(box.fields['space origin'].endswith(',700)'), box.fields['space origin'])
        for code in ('raw', 'vdb'):
            if code == 'vdb' and not has_reader('openvdb'):
                continue
            _, err = self.bcc4('export', 'a.bcc4', '--time', 0, '-o', 'f.' + code)
            self.assertIn('unevenly spaced', err)

    def test_spacing_shapes_the_box_alone(self):
        self.bcc4('import', self.case(), '-o', 'a.bcc4', '--spacing', '2,3,40')
        j = self.json('info', 'a.bcc4')
        self.assertEqual([j['affine'][i][i] for i in range(3)], [2, 3, -40])
        self.assertEqual(j['axes'][2], {'unit': 'm', 'down': True, 'coordinates': DEPTHS})
        self.assertEqual(len(j['axes'][1]['coordinates']), 18)

    def test_coordinates_that_are_told_twice_must_agree(self):
        self.write('w0.nc', weather()[0])
        self.write('w1.nc', weather([1000, 850, 700, 500, 300, 100])[0])
        self.refused(3, 'not at the places of the first file', 'import', 'w0.nc', 'w1.nc', '-o', 'x.bcc4', '--dt', 1,
                     output='x.bcc4')
        _, err = self.bcc4('import', 'w0.nc', 'w1.nc', '-o', 'x.bcc4', '--dt', 1, '--spacing', '1,1,1')
        self.assertIn('no coordinates are kept of it', err)
        self.assertNotIn('axes', self.json('info', 'x.bcc4'))

    def test_other_places_are_another_source(self):
        self.write('a.nc', weather()[0])
        self.bcc4('import', 'a.nc', '-o', 'a.bcc4')
        self.bcc4('verify', 'a.bcc4', '--against', 'a.nc')
        self.write('b.nc', weather([1000, 850, 700, 500, 300, 100])[0])
        self.refused(3, 'sample (0, 0, 4) of the source stands where a.bcc4 has (0, 0, 3.', 'verify', 'a.bcc4', '--against', 'b.nc')

    def test_parts_are_compared_at_their_places(self):
        self.write('a.nc', weather()[0])
        self.bcc4('import', 'a.nc', '-o', 'a.bcc4', '--lattice', 'cc', '--exact')
        for name in ('p.nc', 'p.nrrd'):
            self.bcc4('export', 'a.bcc4', '--all', '--roi', '1-7,0-5,2-5', '-o', name)
            j = self.json('compare', 'a.bcc4', name, '--tolerance', 2e-3)
            self.assertEqual((j['equal'], j['samples_compared'], j['samples_outside']), (True, 4 * 7 * 6 * 4, 0), name)
        whole = self.json('compare', 'a.bcc4', 'a.nc', '--tolerance', 2e-3)
        self.assertEqual((whole['equal'], whole['samples_compared']), (True, 4 * 8 * 7 * 6))
        # Every second level is at no even place, and every third beyond the first is outside.
        for levels, outside in ((PRESSURES[::2], 0), ([1100, 700, 250], 8 * 7)):
            self.write('b.nc', levels_of(levels))
            j = self.json('compare', 'a.bcc4', 'b.nc', '--tolerance', 2e-3)
            self.assertEqual((j['equal'], j['samples_outside']), (True, outside), levels)

    def test_series_that_go_on_keep_them(self):
        for i in range(2):
            self.write(f'a{i}.nc', weather()[0])
            self.write(f'b{i}.nc', weather([1000, 850, 700, 500, 300, 100])[0])
        self.bcc4('import', 'a0.nc', '-o', 'a.bcc4', '--lattice', 'cc', '--dt', 1)
        more = ['-o', 'a.bcc4', '--append', '--lattice', 'cc', '--dt', 1]
        _, err = self.bcc4('import', 'b0.nc', 'b1.nc', *more, expect=2)
        self.assertIn('its sample 4 along z is at 250', err)
        self.bcc4('import', 'a0.nc', 'a1.nc', *more)
        j = self.json('info', 'a.bcc4')
        self.assertEqual((j['dims'][3], j['axes'][2]['coordinates']), (8, PRESSURES))

    def test_pictures_are_laid_out_by_the_coordinates(self):
        # Values below 9, of deep water where samples are far apart, are transparent: what lies between those nobody knows.
        self.bcc4('import', self.case(), '-o', 'uneven.bcc4', '--exact', '--air', 9)
        # The same box, sampled evenly and finely from the formula.
        first, last = latitude(0), latitude(17)
        lats, levels = [first + (last - first) * i / 68 for i in range(69)], [1000 * i / 88 for i in range(89)]
        dims = (('time', 2), ('lev', 89), ('lat', 69), ('lon', 24))
        values = [temperature(z, y, 15 * x, t) for t in (15, 20) for z in levels for y in lats for x in range(24)]
        names = [name for name, _ in dims]
        coordinates = [('time', 'double', ['time'], {'units': 'days since 2001-02-27'}, [15, 20]),
                       ('lev', 'double', ['lev'], {'units': 'm', 'positive': 'down'}, levels),
                       ('lat', 'double', ['lat'], {'units': 'degrees_north'}, lats),
                       ('lon', 'double', ['lon'], {'units': 'degrees_east'}, [15 * x for x in range(24)])]
        self.write('even.nc', classic(coordinates + [('v', 'float', names, {}, values)], dims))
        self.bcc4('import', 'even.nc', '-o', 'even.bcc4', '--exact', '--air', 9)
        self.assertNotIn('axes', self.json('info', 'even.bcc4'))
        look = ['--colormap', 'viridis', '--range', '9,28', '--unit-distance', 20, '--size', '160x160', '--fit', 'domain', '--zoom', 3, '--background',
                '0,0,0', '--gradient-noise', 'none']  # which files with other histograms have each their own
        for camera in ('ortho', 'persp'):
            pictures = []
            for volume in ('uneven', 'even'):
                self.bcc4('render', f'{volume}.bcc4', '--time', 15, '--camera', camera, *look, '-o', f'{volume}.png')
                pictures.append([pixel[:3] for row in read_png(self.path(f'{volume}.png')) for pixel in row])
                os.remove(self.path(f'{volume}.png'))
            seen = [(p, q) for p, q in zip(*pictures) if any(p) or any(q)]
            squares = sum((a - b) ** 2 for p, q in seen for a, b in zip(p, q)) / (3 * len(seen))
            psnr = 20 * math.log10(255) - 10 * math.log10(max(squares, 1e-9))
            print(f'  {camera}: {psnr:.1f} dB over {len(seen)} pixels')
            self.assertGreater(len(seen), 2000)
            self.assertGreaterEqual(psnr, 45)

    def test_planes_count_samples(self):
        self.bcc4('import', self.case(), '-o', 'a.bcc4')
        for plane in ('0,0,1,0,-5', '0,1,0,0,-4', '1,0,0,0,-3', '0,0,.3,1,-5'):
            self.bcc4('render', 'a.bcc4', '--plane', plane, '--size', '64x64', '-o', 'p.png')
        self.bcc4('render', 'a.bcc4', '--time', 10, '--roi', '3-20,2-12,1-7', '--size', '64x64', '-o', 'box.png')
        self.bcc4('render', 'a.bcc4', '--time', 20, '--trail', '3f', '--size', '64x64', '-o', 'trail.png')
        self.bcc4('slice', 'a.bcc4', '--plane', '1,0,0,0,-3', '-o', 'x.nrrd')
        self.assertEqual(numbers(Nrrd(self.path('x.nrrd')).keys['axis 1 index values']), DEPTHS)


if __name__ == '__main__':
    main()

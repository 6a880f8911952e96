"""What a source says of its dimensions and variables beside their values: names, long names, units and other attributes are
kept in the file (formats/bcc4.md, record 7) and come back in NetCDF and NRRD, of slices, too."""
import array
import json
import unittest

from cases_netcdf_test import DIMS, axes, classic, field as variable, line, wave
from harness import Nrrd, ToolTest, field, has_reader, main

try:
    import netCDF4
except ImportError:
    netCDF4 = None

UNEVEN = [1000, 850, 700, 500, 250, 100]
LAT = {'units': 'degrees_north', 'standard_name': 'latitude', 'long_name': 'Latitude'}
VALUES = {'units': 'K', 'long_name': 'Air Temperature', 'standard_name': 'air_temperature', 'realm': ('short', [3]),
          'weights': ('double', [.25, 2.0]), 'cell_methods': 'time: mean', 'coordinates': 'lat lon', 'valid_min': ('float', [-1.0])}
KEPT = {'units': 'K', 'long_name': 'Air Temperature', 'standard_name': 'air_temperature', 'realm': 3, 'weights': [.25, 2.0],
        'cell_methods': 'time: mean'}


def weather(lev):
    return classic(axes(lev=lev, lat=line('lat', step=5, start=-15, **LAT),
                        time=line('time', 'hours since 2000-01-01', 6, long_name='when', calendar='standard')) +
                   [variable('float', wave(), **VALUES)])


EVEN_LEV = line('lev', 'm', 10, positive='down', long_name='Depth')
UNEVEN_LEV = ('lev', 'double', ['lev'], {'units': 'hPa', 'long_name': 'Depth'}, UNEVEN)


class Records(ToolTest):
    def kept(self, name):
        """The records of a file by their keys, without the attribute axis that a way through NetCDF adds."""
        found = {}
        for key, text in self.json('info', name)['attributes'].items():
            if key.startswith(('axis.', 'channel.')):
                found[key] = {of: value for of, value in json.loads(text).items() if of != 'axis'}
        return found

    def expect_weather(self, found, lev):
        self.assertEqual(found, {
            'axis.t': {'long_name': 'when', 'standard_name': 'time', 'name': 'time'} if 'standard_name' in found['axis.t'] else
                      {'long_name': 'when', 'name': 'time'},
            'axis.z': {**lev, 'long_name': 'Depth', 'name': 'lev'}, 'axis.y': {**LAT, 'name': 'lat'},
            'axis.x': {'units': 'degrees_east', 'name': 'lon'}, 'channel.v': KEPT})

    @unittest.skipUnless(has_reader('netcdf'), 'without NetCDF')
    def test_netcdf_comes_back(self):
        for lev, said in ((EVEN_LEV, {'units': 'm', 'positive': 'down'}), (UNEVEN_LEV, {'units': 'hPa'})):
            self.write('a.nc', weather(lev))
            self.bcc4('import', 'a.nc', '--lattice', 'cc', '--exact', '-o', 'a.bcc4', '--overwrite', '--quiet')
            self.expect_weather(self.kept('a.bcc4'), said)
            for way in ('b.nc', 'b.nrrd'):
                self.bcc4('export', 'a.bcc4', '--all', '-o', way, '--overwrite', '--quiet')
                self.bcc4('import', way, '--lattice', 'cc', '--exact', '-o', 'b.bcc4', '--overwrite', '--quiet')
                self.expect_weather(self.kept('b.bcc4'), said)
                a, b = self.json('info', 'a.bcc4'), self.json('info', 'b.bcc4')
                for key in ('affine', 'axes', 'times'):
                    self.assertEqual(a.get(key), b.get(key), (way, key))
                self.assertTrue(self.json('compare', 'a.bcc4', 'b.bcc4', '--tolerance', .01)['equal'])
            if netCDF4 is None:
                print('SKIPPED: no netCDF4 for Python: not read by another reader')
                continue
            with netCDF4.Dataset(self.path('b.nc')) as data:
                v = data['v']
                self.assertEqual(v.dimensions, ('time', 'lev', 'lat', 'lon'))
                self.assertEqual({key: v.getncattr(key) for key in ('units', 'long_name', 'standard_name', 'cell_methods')},
                                 {key: KEPT[key] for key in ('units', 'long_name', 'standard_name', 'cell_methods')})
                self.assertEqual((int(v.realm), v.weights.tolist()), (3, [.25, 2.0]))
                self.assertNotIn('coordinates', v.ncattrs())
                self.assertEqual([data[n].units for n in ('time', 'lev', 'lat', 'lon')],
                                 ['hours since 2000-01-01', said['units'], 'degrees_north', 'degrees_east'])
                self.assertEqual((data['time'].long_name, data['time'].calendar), ('when', 'standard'))
                self.assertEqual(list(data['lev'][:]), lev[4])

    @unittest.skipUnless(has_reader('netcdf'), 'without NetCDF')
    def test_a_series_that_goes_on_keeps_them(self):
        def data(frames, name):
            times = ('time', 'double', ['time'], {'units': 'hours since 2000-01-01', 'long_name': 'when'}, [6. * i for i in range(frames)])
            values = (name, *variable('float', wave(range(frames)), **VALUES)[1:])
            return classic(axes(lev=EVEN_LEV, time=times) + [values], (('time', frames), *DIMS[1:]))

        how = ['--lattice', 'cc', '--exact', '-o', 'a.bcc4', '--quiet']
        self.write('a.nc', data(3, 'v'))
        self.bcc4('import', 'a.nc', *how)
        before = self.kept('a.bcc4')
        self.assertIn('channel.v', before)
        self.assertEqual(self.json('info', 'a.bcc4')['times']['unit'], 'hours')
        # The channel keeps its name, whatever the input calls it, and has one record.
        self.write('b.nc', data(4, 'w'))
        self.assertIn('goes on as "v"', self.bcc4('import', 'b.nc', '--append', *how)[1])
        self.assertEqual(self.kept('a.bcc4'), before)
        # So does the unit of time, by whichever word.
        self.write('h.nc', data(5, 'v').replace(b'hours since 2000-01-01', b'h     since 2000-01-01'))
        self.bcc4('import', 'h.nc', '--append', *how)
        self.assertEqual(self.json('info', 'a.bcc4')['times']['unit'], 'hours')
        # An input that says nothing takes nothing away.
        self.write('c.raw', array.array('f', wave(range(6))))
        self.bcc4('import', 'c.raw', '--dims', '8,7,6,6', '--dtype', 'f32', '--dt', 6, '--append', *how)
        self.assertEqual(self.kept('a.bcc4'), before)
        self.assertEqual(self.json('info', 'a.bcc4')['dims'][3], 6)

    @unittest.skipUnless(has_reader('netcdf'), 'without NetCDF')
    def test_slices_have_them(self):
        if netCDF4 is None:
            print('SKIPPED: no netCDF4 for Python: slices are not looked at')
            self.skipTest('no netCDF4')
        for lev in (EVEN_LEV, UNEVEN_LEV):
            self.write('a.nc', weather(lev))
            self.bcc4('import', 'a.nc', '--lattice', 'cc', '--exact', '-o', 'a.bcc4', '--overwrite', '--quiet')
            self.bcc4('slice', 'a.bcc4', '--time', 6, '-o', 's.nc')
            with netCDF4.Dataset(self.path('s.nc')) as data:
                self.assertEqual(data['v'].dimensions, ('time', 'lev', 'lat', 'lon'))
                self.assertEqual((data['v'].long_name, data['lat'].units, data['lev'].long_name, list(data['lev'][:])),
                                 ('Air Temperature', 'degrees_north', 'Depth', lev[4]))
            self.bcc4('slice', 'a.bcc4', '--plane=1,0,0,0,-2', '-o', 's.nc')
            with netCDF4.Dataset(self.path('s.nc')) as data:
                self.assertEqual(data['v'].dimensions, ('time', 'lev', 'lat'))
                self.assertEqual((data['lat'].units, data['lev'].units, data['time'].units),
                                 ('degrees_north', lev[3]['units'], 'hours since 2000-01-01'))
                self.assertEqual(list(data['lev'][:]), lev[4])
                self.assertEqual(list(data['time'][:]), [0, 6, 12, 18])
            self.bcc4('slice', 'a.bcc4', '--plane=1,0,0,0,-2', '-o', 's.nrrd')
            s = Nrrd(self.path('s.nrrd'))
            self.assertEqual(s.fields['labels'], '"lat" "lev" "t"')
            self.assertEqual(s.fields['space units'], f'"degrees" "{lev[3]["units"]}" "hours"')
            self.bcc4('slice', 'a.bcc4', '--plane=1,0,0,0,-2', '--thickness', 2, '--slab', 'sum', '-o', 's.nc')
            with netCDF4.Dataset(self.path('s.nc')) as data:  # is no temperature
                self.assertNotIn('units', data['v'].ncattrs())
                self.assertNotIn('standard_name', data['v'].ncattrs())

    def nrrd(self, *lines):
        head = ('NRRD0005\ntype: float\ndimension: 4\nsizes: 5 4 3 4\nkinds: domain domain domain time\nendian: little\n'
                'encoding: raw\n' + '\n'.join(lines) + '\n\n')
        self.write('a.nrrd', head.encode() + field((5, 4, 3, 4), lambda x, y, z, t: x + t, 'f').tobytes())
        self.bcc4('import', 'a.nrrd', '--lattice', 'cc', '--exact', '-o', 'a.bcc4', '--quiet', '--overwrite')

    def test_nrrd_s_labels_and_units(self):
        self.nrrd('labels: "lon" "lat" "depth" "day"', 'spacings: 1 1 10 1', 'units: "degrees" "degrees" "m" "days"')
        self.assertEqual(self.kept('a.bcc4'), {
            'axis.x': {'units': 'degrees', 'name': 'lon'}, 'axis.y': {'units': 'degrees', 'name': 'lat'},
            'axis.z': {'units': 'm', 'name': 'depth'}, 'axis.t': {'name': 'day'}})
        j = self.json('info', 'a.bcc4')
        self.assertEqual((j['spatial_unit'], j['times']['unit']), ('', 'days'))
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'b.nrrd')
        self.assertEqual(Nrrd(self.path('b.nrrd')).fields['space units'], '"degrees" "degrees" "m"')
        self.nrrd('spacings: 1 1 10 1', 'units: "mm" "mm" "mm" "s"', 'labels: "x" "y" "z" "t"')
        self.assertEqual(self.kept('a.bcc4'), {})  # the file says it
        self.assertEqual(self.json('info', 'a.bcc4')['spatial_unit'], 'mm')

    @unittest.skipUnless(has_reader('netcdf'), 'without NetCDF')
    def test_names_that_are_taken(self):
        """Dimensions and the variable have names of their own."""
        self.nrrd('labels: "a" "a" "depth" "day"', 'content: x')
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'b.nc')
        self.bcc4('import', 'b.nc', '--lattice', 'cc', '--exact', '-o', 'b.bcc4')
        self.assertEqual([c['name'] for c in self.json('info', 'b.bcc4')['channels']], ['x_values'])
        self.assertNotIn('name', [v.get('name') for v in self.kept('b.bcc4').values()])
        self.assertTrue(self.json('compare', 'a.bcc4', 'b.bcc4', '--tolerance', .01, '--channel', '0')['equal'])


if __name__ == '__main__':
    main()

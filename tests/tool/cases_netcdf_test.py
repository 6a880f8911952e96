"""NetCDF files whose attributes change what the numbers mean: sign, scale, holes, times, places, groups. Classic files are
written here byte by byte, groups by netCDF4 where Python has it; values, coordinates and times are those that come back."""
import math
import struct
import unittest

from harness import Nrrd, ToolTest, has_reader, main

DIMS = (('time', 4), ('lev', 6), ('lat', 7), ('lon', 8))
SIZES = {name: size for name, size in DIMS}
COUNT = math.prod(size for _, size in DIMS)
CODES = {'byte': (1, 'b'), 'char': (2, 'c'), 'short': (3, 'h'), 'int': (4, 'i'), 'float': (5, 'f'), 'double': (6, 'd')}


def padded(data):
    return data + bytes(-len(data) % 4)


def name_of(text):
    return struct.pack('>i', len(text)) + padded(text.encode())


def packed(kind, values):
    if kind == 'char':
        return values.encode()
    return struct.pack(f'>{len(values)}{CODES[kind][1]}', *values)


def attributes(table):
    if not table:
        return bytes(8)
    out = struct.pack('>ii', 12, len(table))
    for key, value in table.items():
        kind, values = ('char', value) if isinstance(value, str) else value
        out += name_of(key) + struct.pack('>ii', CODES[kind][0], len(values)) + padded(packed(kind, values))
    return out


def classic(variables, dims=DIMS):
    """A file of the classic format: variables are (name, type, names of dimensions, attributes, values)."""
    names = [name for name, _ in dims]
    head = b'CDF\1' + struct.pack('>i', 0) + struct.pack('>ii', 10, len(dims))
    head += b''.join(name_of(name) + struct.pack('>i', size) for name, size in dims) + bytes(8)
    head += struct.pack('>ii', 11, len(variables))
    data = [padded(packed(kind, values)) for _, kind, _, _, values in variables]
    parts = []
    for (name, kind, over, table, _), values in zip(variables, data):
        parts.append(name_of(name) + struct.pack(f'>i{len(over)}i', len(over), *(names.index(d) for d in over)) +
                     attributes(table) + struct.pack('>ii', CODES[kind][0], len(values)))
    begin = len(head) + sum(len(p) + 4 for p in parts)
    for part, values in zip(parts, data):
        head += part + struct.pack('>i', begin)
        begin += len(values)
    return head + b''.join(data)


def line(name, units, step=1.0, start=0.0, kind='double', **more):
    values = [start + step * i for i in range(SIZES[name])]
    return (name, kind, [name], {'units': units, **more}, values if kind in ('float', 'double') else [int(v) for v in values])


def axes(**instead):
    """The coordinate variables, some of them other ones, or none of a name."""
    usual = {'time': line('time', 'hours since 2000-01-01', 6), 'lev': line('lev', 'm', 10),
             'lat': line('lat', 'degrees_north', 5, -15), 'lon': line('lon', 'degrees_east', 5)}
    return [v for v in {**usual, **instead}.values() if v]


def field(kind, values, **table):
    return ('v', kind, [name for name, _ in DIMS], table, values)


def wave(frames=range(4)):
    """Whole numbers from 0 to 200, x fastest."""
    return [round(100 + 100 * math.cos(.4 * x + .3 * t) * math.cos(.3 * y) * math.cos(.2 * z))
            for t in frames for z in range(6) for y in range(7) for x in range(8)]


def signed(values, bits):
    return [v - (1 << bits) if v >= 1 << (bits - 1) else v for v in values]


@unittest.skipUnless(has_reader('netcdf'), 'without NetCDF')
class Cases(ToolTest):
    def there_and_back(self, *files, options=()):
        """Imports files, given as bytes; returns what info says of the series and the values that export writes."""
        names = [f'in{i}.nc' for i in range(len(files))]
        for name, data in zip(names, files):
            self.write(name, data)
        self.bcc4('import', *names, *options, '--lattice', 'cc', '--exact', '--overwrite', '-o', 'o.bcc4')
        self.bcc4('export', 'o.bcc4', '--all', '--overwrite', '-o', 'o.nrrd')
        nrrd = Nrrd(self.path('o.nrrd'))
        self.assertEqual(nrrd.sizes[3], 4 * len(files))
        self.times = [float(t) for t in nrrd.keys['axis 3 index values'].split()]
        return self.json('info', 'o.bcc4'), nrrd.values

    def expect(self, found, wanted):
        self.assertEqual(len(found), len(wanted))
        for i, (f, w) in enumerate(zip(found, wanted)):
            if w is not None:
                self.assertAlmostEqual(f, w, delta=2e-3, msg=f'sample {i}')

    def holes(self, name='in0.nc'):
        return sum(c['nonfinite'] for c in self.json('import', name, '--dry-run')['channels'])

    def test_bytes_meant_unsigned(self):
        stored = wave()
        stored[5] = 255
        _, values = self.there_and_back(classic(axes() + [field(
            'byte', signed(stored, 8), _Unsigned='true', scale_factor=('double', [.4]), add_offset=('double', [10.]),
            _FillValue=('byte', [-1]))]))
        self.expect(values, [.4 * v + 10 if v < 255 else None for v in stored])
        self.assertEqual(self.holes(), 1)

    def test_limits_meant_unsigned(self):
        stored = [250 * v for v in wave()]
        stored[7] = 50001
        _, values = self.there_and_back(classic(axes() + [field(
            'short', signed(stored, 16), _Unsigned='true', scale_factor=('double', [.01]),
            valid_range=('short', [0, 50000 - 65536]))]))
        self.expect(values, [.01 * v if v <= 50000 else None for v in stored])
        self.assertEqual(self.holes(), 1)

    def test_holes_told_of_the_values(self):
        stored = wave()
        stored[9] = -19
        _, values = self.there_and_back(classic(axes() + [field(
            'short', stored, scale_factor=('double', [.5]), missing_value=('float', [-9.5]))]))
        self.expect(values, [.5 * v if v >= 0 else None for v in stored])
        self.assertEqual(self.holes(), 1)

    def test_packed_coordinates(self):
        info, values = self.there_and_back(classic(axes(
            time=line('time', 'days since 2000-01-01', kind='short', scale_factor=('double', [.25])),
            lev=line('lev', 'm', kind='short', scale_factor=('double', [10.]), add_offset=('double', [5.])),
            lon=line('lon', 'degrees_east', kind='float', scale_factor=('double', [.25]))) + [field('float', wave())]))
        self.expect(values, wave())
        self.assertEqual(self.times, [0, .25, .5, .75])
        affine = info['affine']
        self.assertEqual([affine[0][0], affine[2][2], affine[2][3]], [.25, 10, 5])

    def test_times_that_are_text(self):
        dates = ''.join(f'2013-07-0{7 + h // 24}_{h % 24:02}:30:00' for h in range(21, 25))
        text = ('Times', 'char', ['time', 'len'], {}, dates)
        info, _ = self.there_and_back(classic(axes(time=None) + [text, field('float', wave())], (*DIMS, ('len', 19))))
        self.assertEqual((self.times, info['times']['unit']), ([0, 1, 2, 3], 'hours'))
        self.assertEqual(info['attributes']['time_epoch'], '2013-07-07 21:30:00')

    def test_times_that_are_dates_as_numbers(self):
        dates = ('time', 'double', ['time'], {'units': 'day as %Y%m%d.%f'}, [20000228, 20000229, 20000301, 20000302.5])
        info, _ = self.there_and_back(classic(axes(time=dates) + [field('float', wave())]))
        self.assertEqual((self.times, info['times']['unit']), ([0, 1, 2, 3.5], 'days'))

    def test_times_of_another_name(self):
        units = 'hours since 2000-01-01'
        moments = ('ocean_time', 'double', ['nt'], {'units': units}, [0, 6, 18, 19])
        self.write('a.nc', classic(axes(time=None) + [moments, ('v', 'float', ['nt', 'lev', 'lat', 'lon'], {}, wave())],
                                   (('nt', 4), *DIMS[1:])))
        self.bcc4('import', 'a.nc', '-o', 'o.bcc4')
        self.assertEqual(self.json('info', 'o.bcc4')['times']['dates']['last'], '2000-01-01 19:00')
        names = []
        for t, hour in enumerate((6, 12, 13)):
            names.append(f'one{t}.nc')
            told = [('time', 'double', [], {'units': units, 'standard_name': 'time'}, [hour]),
                    ('run', 'double', [], {'units': units, 'standard_name': 'forecast_reference_time'}, [0])]
            self.write(names[-1], classic(axes(time=None) + told + [
                ('v', 'float', ['lev', 'lat', 'lon'], {'coordinates': 'time run'}, wave([t]))], DIMS[1:]))
        for files, first in ((names, 6), (names[1:2], 12)):
            self.bcc4('import', *files, '-o', 'o.bcc4', '--overwrite')
            times = self.json('info', 'o.bcc4')['times']
            self.assertEqual((times['first'], times['dates']['first']), (first, f'2000-01-01 {first:02}:00'))

    def test_a_time_that_is_guessed_has_to_rise(self):
        names = []
        for t in range(3):
            names.append(f'one{t}.nc')
            run = ('base_time', 'double', [], {'units': 'hours since 2000-01-01'}, [6])
            self.write(names[-1], classic(axes(time=None) + [run, ('v', 'float', ['lev', 'lat', 'lon'], {}, wave([t]))], DIMS[1:]))
        said = ''.join(self.bcc4('import', *names, '-o', 'o.bcc4'))
        self.assertIn('variable base_time does not rise from frame to frame', said)
        self.assertEqual(self.json('info', 'o.bcc4')['times']['last'], 2)

    def test_frames_out_of_order(self):
        times = ('time', 'double', ['time'], {'units': 'hours since 2000-01-01'}, [0, 12, 6, 18])
        self.write('a.nc', classic(axes(time=times) + [field('float', wave())]))
        self.refused(3, 'sort the frames', 'import', 'a.nc', '-o', 'o.bcc4', output='o.bcc4')

    def test_a_frame_without_a_time(self):
        times = ('time', 'double', ['time'], {'units': 'hours since 2000-01-01'}, [0, 12, float('nan'), 18])
        self.write('a.nc', classic(axes(time=times) + [field('float', wave())]))
        self.refused(3, 'time of frame 2 is not a finite number (coordinate variable time): give the times of all frames by --times, '
                     'or take those before it by --frames 0-1', 'import', 'a.nc', '-o', 'o.bcc4', output='o.bcc4')
        self.bcc4('import', 'a.nc', '--frames', '0-1', '-o', 'o.bcc4')
        self.assertEqual(self.json('info', 'o.bcc4')['times']['last'], 12)
        self.bcc4('import', 'a.nc', '--times', '0,12,15,18', '-o', 'o.bcc4', '--overwrite')
        self.assertEqual(self.json('info', 'o.bcc4')['times']['dates']['last'], '2000-01-01 18:00')
        self.write('a.nc', classic(axes(time=(*times[:4], [float('nan'), 6, 12, 18])) + [field('float', wave())]))
        self.bcc4('import', 'a.nc', '--dt', '6', '-o', 'o.bcc4', '--overwrite')
        self.assertEqual(self.json('info', 'o.bcc4')['times']['last'], 18)

    def test_files_with_dates_of_reference(self):
        for calendar, second in (('noleap', 62), ('standard', 63)):
            files = [classic(axes(time=line('time', f'days since 2000-{month}-01', 1, start, calendar=calendar)) +
                             [field('float', wave())]) for month, start in (('01', 56), ('03', 3))]
            self.there_and_back(*files)
            self.assertEqual(self.times, [56, 57, 58, 59] + [second + i for i in range(4)], calendar)

    def test_files_with_scales(self):
        files = []
        for i, (slope, offset) in enumerate(((.01, 0), (.005, 20))):
            stored = [round((v - offset) / slope) for v in wave(range(4 * i, 4 * i + 4))]
            files.append(classic(axes(time=line('time', 'hours since 2000-01-01', 6, 24 * i)) + [field(
                'int', stored, scale_factor=('double', [slope]), add_offset=('double', [float(offset)]))]))
        self.expect(self.there_and_back(*files)[1], wave(range(8)))

    def test_files_with_other_latitudes(self):
        first = classic(axes() + [field('float', wave())])
        later = line('time', 'hours since 2000-01-01', 6, 24)
        north_first = [v for t in range(4, 8) for z in range(6) for y in reversed(range(7))
                       for v in wave([t])[(7 * z + y) * 8:(7 * z + y + 1) * 8]]
        _, values = self.there_and_back(first, classic(axes(time=later, lat=line('lat', 'degrees_north', -5, 15)) + [
            field('float', north_first)]))
        self.expect(values, wave(range(8)))
        # Blocks read their own part of either file.
        args = ['in0.nc', 'in1.nc', '--blocks', '--on-nonfinite', 'clamp']
        self.bcc4('import', *args, '-o', 'one.bcc4')
        self.bcc4('import', *args, '--dry-run', '--plan', 'plan.json')
        for name, box in (('a', ',:2,'), ('b', ':5,2:,'), ('c', '5:,2:,')):
            self.bcc4('import', '--plan', 'plan.json', '--block', box, '-o', f'block_{name}.bcc4')
        self.bcc4('concat', *(f'block_{n}.bcc4' for n in 'abc'), '-o', 'joined.bcc4')
        with open(self.path('one.bcc4'), 'rb') as one, open(self.path('joined.bcc4'), 'rb') as joined:
            self.assertEqual(joined.read(), one.read())
        self.write('in1.nc', classic(axes(time=later, lat=line('lat', 'degrees_north', 5, 0)) + [field('float', wave())]))
        self.refused(3, 'in1.nc: the samples along lat', 'import', 'in0.nc', 'in1.nc', '-o', 'p.bcc4', output='p.bcc4')

    def test_curvilinear_grids(self):
        over = ['lat', 'lon']
        two = [(name, 'double', over, {'units': units}, [0.] * 56)
               for name, units in (('LON', 'degrees_east'), ('LAT', 'degrees_north'))]
        info, _ = self.there_and_back(classic(axes(lat=None, lon=None) + two + [
            field('float', wave(), coordinates='LON LAT')]))
        self.assertEqual([info['affine'][i][i] for i in range(3)], [1, 1, 10])
        self.assertEqual(info['spatial_unit'], '')
        self.assertIn('LON and LAT', ''.join(self.bcc4('import', 'in0.nc', '--dry-run')))

    def test_groups(self):
        try:
            import netCDF4
        except ImportError:
            self.skipTest('Python has no netCDF4: variables in groups are not tested here')
        with netCDF4.Dataset(self.path('a.nc'), 'w') as file:
            for name, size in DIMS:
                file.createDimension(name, size)
            for run in ('run1', 'run2'):
                v = file.createGroup(run).createVariable('f', 'f4', [name for name, _ in DIMS])
                v[:] = float(run[-1])
        self.refused(2, 'run1/f and run2/f', 'import', 'a.nc', '-o', 'o.bcc4', output='o.bcc4')
        self.bcc4('import', 'a.nc', '--channel', 'run2/f', '-o', 'o.bcc4')
        self.bcc4('export', 'o.bcc4', '--all', '--overwrite', '-o', 'o.nrrd')
        self.assertEqual(set(Nrrd(self.path('o.nrrd')).values), {2})


if __name__ == '__main__':
    main()

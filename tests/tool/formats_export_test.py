"""Exports to NIfTI, NetCDF, VTI and TIFF, read back by other people's readers (nibabel, netCDF4, VTK, tifffile) and by
import: the same values, places, times, units and calendars. Where a reader is not installed its part is skipped, which is
said."""
import importlib
import math
import os
import resource
import signal
import struct
import subprocess
import sys
import unittest

from harness import BCC4, DATA, ToolTest, field, has_reader, main

DIMS = (7, 6, 5, 4)
TIMES = '3 5 7 9'


def module(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f'NOT TESTED: what needs the Python module {name}, which is not installed', file=sys.stderr)
        return None


def value(x, y, z, t):
    return 5 + math.sin(x + t) + y * z


def missing(name):
    return module(name) is None


class FormatsExport(ToolTest):
    def make(self, name='a.bcc4', kind='float', code='f', f=value, space='left-posterior-superior', times=TIMES, unit='ms',
             directions='(0,2,0) (3,0,0) (0,0,4)', extra='', length='mm'):
        head = (f'NRRD0005\ntype: {kind}\ndimension: 4\nspace: {space}\nsizes: 7 6 5 4\n'
                f'space directions: {directions} none\nspace origin: (10,20,30)\nkinds: domain domain domain time\n'
                f'space units: "{length}" "{length}" "{length}"\nunits: "" "" "" "{unit}"\ncontent: wind speed\n'
                'sample units: m/s\nendian: little\n'
                f'encoding: raw\naxis 3 index type:=numeric\naxis 3 index values:={times}\n{extra}\n')
        self.write('a.nrrd', head.encode() + field(DIMS, f, code).tobytes())
        self.bcc4('import', 'a.nrrd', '-o', name, '--lattice', 'cc', '--exact', '--quiet', '--overwrite', '--on-nonfinite', 'hole')
        return name

    def alike(self, a, b, near=1e-5):
        """Place, times, name and unit of two files are one."""
        a, b = self.json('info', a), self.json('info', b)
        for key in ('count', 'unit'):
            self.assertEqual(a['times'][key], b['times'][key])
        for key in ('first', 'last'):
            self.assertAlmostEqual(a['times'][key], b['times'][key], delta=near * abs(b['times'][key]))
        self.assertEqual(a['spatial_unit'], b['spatial_unit'])
        return a, b

    def same_world(self, a, b, near=1e-5):
        for row_a, row_b in zip(a['affine'], b['affine']):
            for x, y in zip(row_a, row_b):
                self.assertAlmostEqual(x, y, delta=near * max(1, abs(y)))

    def equal(self, a, b, tolerance=1e-4):
        j = self.json('compare', a, b, '--tolerance', tolerance)
        self.assertEqual((j['equal'], j['samples_compared'], j['frames_outside']), (True, math.prod(DIMS), 0))

    @unittest.skipIf(missing('nibabel'), 'nibabel is not installed')
    def test_nifti_by_nibabel(self):
        import nibabel
        self.make()
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.nii.gz', '--quiet')
        image = nibabel.load(self.path('a.nii.gz'))
        lps = [[0, 3, 0, 10], [2, 0, 0, 20], [0, 0, 4, 30], [0, 0, 0, 1]]
        ras = [[-v for v in lps[0]], [-v for v in lps[1]], lps[2], lps[3]]
        for form, code in (image.header.get_sform(coded=True), image.header.get_qform(coded=True)):
            self.assertEqual(code, 1)
            for row, right in zip(form, ras):
                for v, w in zip(row, right):
                    self.assertAlmostEqual(v, w, places=4)
        self.assertEqual(image.header.get_xyzt_units(), ('mm', 'msec'))
        self.assertEqual((image.header['pixdim'][4], image.header['toffset']), (2, 3))
        self.assertEqual(image.shape, DIMS)
        data = image.get_fdata()
        for x, y, z, t in ((0, 0, 0, 0), (6, 5, 4, 3), (2, 3, 1, 2)):
            self.assertAlmostEqual(data[x, y, z, t], value(x, y, z, t), places=4)
        self.bcc4('import', 'a.nii.gz', '-o', 'b.bcc4', '--lattice', 'cc', '--exact', '--quiet')
        _, b = self.alike('a.bcc4', 'b.bcc4')
        self.assertEqual((b['channels'][0]['name'], b['channels'][0]['unit']), ('wind speed', 'm/s'))
        self.equal('a.bcc4', 'b.bcc4')  # one in RAS, one in LPS

    @unittest.skipIf(missing('nibabel'), 'nibabel is not installed')
    def test_nifti_of_integers_shears_and_mirrors(self):
        import nibabel
        self.make(kind='short', code='h', f=lambda x, y, z, t: 100 * x - y * z + t, space='right-anterior-superior',
                  directions='(2,0,0) (0.5,3,0) (0,0,-4)', unit='h', length='cm')
        _, said = self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.nii')
        self.assertIn('its times in h are written in seconds', said)
        self.assertIn('no code for lengths in cm', said)
        image = nibabel.load(self.path('a.nii'))
        with open(self.path('a.nii'), 'rb') as f:
            header = nibabel.Nifti1Header.from_fileobj(f)
        self.assertEqual((header.get_data_dtype().name, header['scl_slope'], header['scl_inter']), ('int16', 1, 0))
        self.assertEqual(image.header.get_xyzt_units(), ('unknown', 'sec'))
        self.assertEqual(image.header['pixdim'][4], 7200)
        _, code = image.header.get_qform(coded=True)
        self.assertEqual(code, 0)  # no rotation makes a shear
        self.assertAlmostEqual(image.affine[0][1], .5, places=6)
        self.assertEqual(image.dataobj[6, 5, 4, 3], 583)
        # A left-handed box has a qform, too.
        self.make(space='right-anterior-superior', directions='(2,0,0) (0,3,0) (0,0,-4)')
        self.bcc4('export', 'a.bcc4', '--time', 5, '-o', 'm.nii', '--quiet')
        image = nibabel.load(self.path('m.nii'))
        self.assertEqual((image.shape, image.header['toffset']), (DIMS[:3], 5))
        self.assertEqual((image.header.get_qform() - image.header.get_sform()).any(), False)
        self.bcc4('import', 'm.nii', '-o', 'm.bcc4', '--quiet')
        times = self.json('info', 'm.bcc4')['times']
        self.assertEqual((times['first'], times['unit']), (5, 'ms'))

    def test_nifti_tells_what_it_has_no_place_for(self):
        self.make(times='3 5 7 10', extra='time epoch:=2000-01-01\n')
        _, said = self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.nii')
        self.assertIn('uneven', said)
        self.assertIn('no place for the date of time 0, 2000-01-01', said)

    def test_nifti_of_long_axes_is_nifti_2(self):
        args = self.raw('l.raw', (33000, 1, 1, 1), lambda x, y, z, t: x % 100, 'u8')
        self.bcc4('import', *args, '--lattice', 'cc', '-o', 'l.bcc4', '--quiet')
        self.bcc4('export', 'l.bcc4', '--all', '-o', 'l.nii', '--quiet')
        with open(self.path('l.nii'), 'rb') as f:
            head = f.read(544)
        self.assertEqual((struct.unpack_from('<i', head)[0], head[4:8]), (540, b'n+2\0'))
        self.bcc4('import', 'l.nii', '--lattice', 'cc', '-o', 'm.bcc4', '--quiet')
        self.assertEqual(self.json('compare', 'l.bcc4', 'm.bcc4')['samples_compared'], 33000)
        if not missing('nibabel'):
            import nibabel
            self.assertEqual(nibabel.load(self.path('l.nii')).shape, (33000, 1, 1))

    @unittest.skipUnless(has_reader('netcdf'), 'no NetCDF in this build')
    def test_netcdf(self):
        self.make(directions='(2,0,0) (0,3,0) (0,0,4)', unit='days', extra='time epoch:=2000-02-27\ntime calendar:=noleap\n')
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.nc', '--quiet')
        self.bcc4('import', 'a.nc', '-o', 'b.bcc4', '--lattice', 'cc', '--exact', '--quiet')
        a, b = self.alike('a.bcc4', 'b.bcc4')
        self.same_world(a, b)
        self.equal('a.bcc4', 'b.bcc4')
        self.assertEqual(b['attributes']['time_calendar'], 'noleap')
        self.assertEqual(b['times']['dates'], a['times']['dates'])
        self.make(name='r.bcc4')
        self.refused(3, 'do not run along those of the world', 'export', self.make(name='r.bcc4', directions='(2,1,0) (0,3,0) (0,0,4)'),
                     '--all', '-o', 'r.nc', output='r.nc')
        if missing('netCDF4'):
            return
        import netCDF4
        with netCDF4.Dataset(self.path('a.nc')) as data:
            self.assertEqual(data.Conventions, 'CF-1.8')
            v = data['wind_speed']
            self.assertEqual((v.dimensions, v.units, v.long_name), (('time', 'z', 'y', 'x'), 'm/s', 'wind speed'))
            self.assertEqual(v.shape, DIMS[::-1])
            self.assertAlmostEqual(float(v[2, 1, 3, 2]), value(2, 3, 1, 2), places=4)
            self.assertEqual([float(data[n][1]) for n in 'xyz'], [12, 23, 34])
            self.assertEqual([data[n].units for n in 'xyz'], ['mm'] * 3)
            time = data['time']
            self.assertEqual((time.units, time.calendar), ('days since 2000-02-27', 'noleap'))
            date = netCDF4.num2date(time[0], time.units, time.calendar)
            self.assertEqual((date.month, date.day), (3, 2))  # three days on, without the 29th
            self.assertEqual(b['times']['dates']['first'], f'{date.year:04}-{date.month:02}-{date.day:02} {date.hour:02}:{date.minute:02}')

    @unittest.skipUnless(has_reader('netcdf'), 'no NetCDF in this build')
    def test_netcdf_of_what_is_missing(self):
        nan = float('nan')
        self.make(f=lambda x, y, z, t: nan if x == 2 else value(x, y, z, t), directions='(2,0,0) (0,3,0) (0,0,4)')
        missing_before = self.json('info', 'a.bcc4')['channels'][0]['missing']
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.nc', '--quiet')
        self.bcc4('import', 'a.nc', '-o', 'b.bcc4', '--lattice', 'cc', '--exact', '--quiet')
        self.assertGreater(missing_before, 0)
        self.assertEqual(self.json('info', 'b.bcc4')['channels'][0]['missing'], missing_before)
        if not missing('netCDF4'):
            import netCDF4
            with netCDF4.Dataset(self.path('a.nc')) as data:
                self.assertEqual(int(data['wind_speed'][:].mask.sum()), missing_before)

    def test_vti_and_its_collection(self):
        self.make()
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.pvd', '--quiet')
        self.assertEqual([os.path.exists(self.path(f'a.{t:04}.vti')) for t in range(5)], [True] * 4 + [False])
        self.bcc4('import', 'a.pvd', '-o', 'b.bcc4', '--lattice', 'cc', '--exact', '--quiet')
        a, b = self.json('info', 'a.bcc4'), self.json('info', 'b.bcc4')
        self.same_world(a, b)
        self.assertEqual([b['times'][k] for k in ('count', 'first', 'last')], [4, 3, 9])
        self.equal('a.bcc4', 'b.bcc4')
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'p_%02d.vti', '--quiet')
        with open(self.path('p.pvd')) as f:
            self.assertIn('timestep="5" group="" part="0" file="p_01.vti"', f.read())
        self.bcc4('import', 'p_*.vti', '-o', 'c.bcc4', '--quiet')  # by their own times
        self.assertEqual(self.json('info', 'c.bcc4')['times']['last'], 9)
        self.refused(2, 'holds one frame', 'export', 'a.bcc4', '--all', '-o', 'one.vti', output='one.vti')
        self.refused(2, 'a collection is of several frames', 'export', 'a.bcc4', '--time', 5, '-o', 'x.pvd', output='x.pvd')
        self.refused(2, '--overwrite', 'export', 'a.bcc4', '--all', '-o', 'a.pvd')

    @unittest.skipIf(missing('vtk'), 'VTK is not installed')
    def test_vti_by_vtk(self):
        import vtk
        self.make(directions='(0,2,0) (3,0,0) (0,0,-4)')
        self.bcc4('export', 'a.bcc4', '--time', 5, '-o', 'a.vti', '--quiet')
        reader = vtk.vtkXMLImageDataReader()
        reader.SetFileName(self.path('a.vti'))
        reader.Update()
        image = reader.GetOutput()
        self.assertEqual((image.GetDimensions(), image.GetOrigin(), image.GetSpacing()), (DIMS[:3], (10, 20, 30), (2, 3, 4)))
        d = image.GetDirectionMatrix()
        self.assertEqual([[d.GetElement(r, c) for c in range(3)] for r in range(3)], [[0, 1, 0], [1, 0, 0], [0, 0, -1]])
        array = image.GetPointData().GetScalars()
        self.assertEqual(array.GetName(), 'wind speed')
        self.assertEqual(array.GetInformation().Get(vtk.vtkDataArray.UNITS_LABEL()).strip(), 'm/s')
        self.assertAlmostEqual(array.GetValue(2 + 7 * (3 + 6 * 1)), value(2, 3, 1, 1), places=4)
        self.assertEqual(image.GetFieldData().GetArray('TimeValue').GetValue(0), 5)

    def test_tiff(self):
        out, _ = self.bcc4('--version')
        self.make(kind='ushort', code='H', f=lambda x, y, z, t: 1000 * t + 100 * z + 10 * y + x, unit='s')
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.tif', '--quiet')
        self.make(name='f.bcc4')
        self.bcc4('export', 'f.bcc4', '--all', '-o', 'f.%02d.tif', '--quiet')
        self.refused(2, '--overwrite', 'export', 'a.bcc4', '--all', '-o', 'a.tif')
        if missing('tifffile'):
            return
        import tifffile
        with tifffile.TiffFile(self.path('a.tif')) as tiff:
            stack = tiff.asarray()
            told = tiff.imagej_metadata
            self.assertEqual((stack.shape, stack.dtype), (DIMS[3::-1], 'uint16'))
            self.assertEqual((stack[3, 4, 5, 6], stack[1, 2, 3, 4]), (3456, 1234))
            self.assertEqual([told[k] for k in ('slices', 'frames', 'spacing', 'unit', 'finterval')], [5, 4, 4, 'mm', 2])
            self.assertEqual(tiff.pages[0].tags['XResolution'].value[0] / tiff.pages[0].tags['XResolution'].value[1], .5)
        self.assertEqual(sorted(n for n in os.listdir(self.folder) if n.startswith('f.0')), [f'f.{t:02}.tif' for t in range(4)])
        with tifffile.TiffFile(self.path('f.02.tif')) as tiff:
            self.assertEqual((tiff.asarray().shape, tiff.asarray().dtype), (DIMS[2::-1], 'float32'))
            self.assertAlmostEqual(float(tiff.asarray()[1, 3, 2]), value(2, 3, 1, 2), places=4)

    def test_slices(self):
        self.make(directions='(2,0,0) (0,3,0) (0,0,4)')
        for name in ('t.nii', 't.vti', 't.nrrd') + (('t.nc',) if has_reader('netcdf') else ()):
            self.bcc4('slice', 'a.bcc4', '--time', 5, '-o', name, '--quiet')
            self.bcc4('import', name, '-o', 't.bcc4', '--lattice', 'cc', '--exact', '--quiet', '--overwrite', '--on-nonfinite', 'hole')
            self.assertEqual(self.json('info', 't.bcc4')['times']['first'], 5, name)
            self.assertEqual(self.json('compare', 'a.bcc4', 't.bcc4', '--tolerance', 1e-4)['samples_compared'], 210, name)
        self.refused(2, 'must end in', 'slice', 'a.bcc4', '--time', 5, '-o', 't.raw', output='t.raw')

    def test_planes_name_their_axes(self):
        from harness import Nrrd
        self.make(directions='(2,0,0) (0,3,0) (0,0,4)')
        self.bcc4('slice', 'a.bcc4', '--plane', '1,0,0,0,-2', '-o', 'p.nrrd', '--quiet')
        fields = Nrrd(self.path('p.nrrd')).fields
        self.assertEqual(fields['labels'], '"y" "z" "t"')
        self.assertEqual(fields['space units'], '"mm" "mm" "ms"')
        self.assertEqual(fields['space directions'], '(3,0,0) (0,4,0) (0,0,2)')
        self.assertEqual(fields['space origin'], '(20,30,3)')
        self.make(directions='(2,0,0) (0,3,0) (0,0,4)', times='3 5 7 10')
        self.bcc4('slice', 'a.bcc4', '--plane', '1,0,0,0,-2', '-o', 'p.nrrd', '--quiet')
        self.assertEqual(Nrrd(self.path('p.nrrd')).fields['space units'], '"mm" "mm" "frames"')

    def test_planes_by_basis_name_their_axes(self):
        """Whichever axis is time, whichever way it runs, from wherever the point lies."""
        from harness import Nrrd
        self.make(directions='(2,0,0) (0,3,0) (0,0,4)')
        for basis, labels, directions, origin in (('0,1,0,0,0,0,1,0,0,0,0,1', '"y" "z" "t"', '(3,0,0) (0,4,0) (0,0,2)', '(20,30,3)'),
                                                  ('0,1,0,0,0,0,1,0,0,0,0,-1', '"y" "z" "t"', '(3,0,0) (0,4,0) (0,0,-2)', '(20,30,9)'),
                                                  ('0,0,0,1,0,1,0,0,0,0,1,0', '"t" "y" "z"', '(0,0,2) (3,0,0) (0,4,0)', '(20,30,3)')):
            self.bcc4('slice', 'a.bcc4', '--point', '2,1,2,1', '--basis', basis, '-o', 'p.nrrd', '--quiet')
            fields = Nrrd(self.path('p.nrrd')).fields
            self.assertEqual([fields[key] for key in ('labels', 'space directions', 'space origin')], [labels, directions, origin], basis)
        # Lengths and times have no unit in common.
        self.bcc4('slice', 'a.bcc4', '--plane', '1,0,0,0,-2', '-o', 'p.nii', '--quiet')
        with open(self.path('p.nii'), 'rb') as f:
            self.assertEqual(f.read()[123] & 7, 0)

    @unittest.skipUnless(has_reader('netcdf'), 'without NetCDF')
    def test_what_rings_is_not_missing(self):
        """Integers have their lowest number for what is missing, next to which values ring on a coarser lattice."""
        edge = field((12, 12, 12, 6), lambda x, y, z, t: 120 if 3 < x < 8 and y > 5 else 1, 'B')
        self.write('i.raw', edge)
        mask = field((12, 12, 12, 6), lambda x, y, z, t: float('nan') if z < 2 else (120 if 3 < x < 8 and y > 5 else 1), 'f')
        self.write('f.raw', mask)
        self.bcc4('import', 'f.raw', '--dims', '12,12,12,6', '--dtype', 'f32', '--on-nonfinite', 'hole', '--quantize', 'u8', '--density', .5,
                  '-o', 'f.bcc4', '--quiet')
        gone = self.json('info', 'f.bcc4')['channels'][0]['missing']
        self.bcc4('export', 'f.bcc4', '--all', '-o', 'f.nc', '--quiet')
        self.bcc4('import', 'f.nc', '--lattice', 'cc', '--exact', '-o', 'g.bcc4', '--quiet')
        self.assertEqual(self.json('info', 'g.bcc4')['channels'][0]['missing'], gone)

    def test_a_full_disk_leaves_nothing(self):
        self.make()
        for name in ('a.nii.gz', 'a.tif') + (('a.nc',) if has_reader('netcdf') else ()):
            self.refused(3, 'cannot be written', 'export', 'a.bcc4', '--all', '-o', 'absent/' + name, output='absent/' + name)

    def test_a_disk_that_fills_up_ends_with_4(self):
        self.make()
        # HDF5 fails when the file is closed, or before, where there is more to write.
        self.volume((24, 24, 24, 4), value, '--quiet', name='large.bcc4')

        def small_disk():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048))

        for source in ('a.bcc4', 'large.bcc4'):
            for name in ('full.nii', 'full.nrrd') + (('full.tif',) if has_reader('tiff') else ()) + (('full.nc',) if has_reader('netcdf') else ()):
                p = subprocess.run([BCC4, 'export', source, '--all', '-o', name, '--quiet'], capture_output=True, text=True, cwd=self.folder,
                                   preexec_fn=small_disk)
                self.assertEqual(p.returncode, 4, (source, name, p.stderr))
                self.assertIn(name, p.stderr)
                self.assertFalse(os.path.exists(self.path(name)))

    @unittest.skipUnless(os.path.exists(DATA), 'no shared data')
    def test_real_perfusion(self):
        source = os.path.join(DATA, 'pcasl_52x68x20x10_f32.nii.gz')
        self.bcc4('import', source, '-o', 'p.bcc4', '--lattice', 'cc', '--exact', '--quiet')
        self.bcc4('export', 'p.bcc4', '--all', '-o', 'p.nii.gz', '--quiet')
        # What is air in the file is air in the export, where the field ripples by a millionth of the peak.
        j = self.json('compare', 'p.bcc4', 'p.nii.gz', '--tolerance', .01)
        self.assertEqual(j['equal'], True)
        if not missing('nibabel'):
            import nibabel
            a, b = nibabel.load(source), nibabel.load(self.path('p.nii.gz'))
            self.assertLess(abs(a.affine - b.affine).max(), 1e-4)
            self.assertEqual(a.header.get_xyzt_units(), b.header.get_xyzt_units())
            self.assertEqual(a.header['pixdim'][4], b.header['pixdim'][4])
            self.assertLess(abs(a.get_fdata() - b.get_fdata()).max(), 1e-3 * a.get_fdata().max())


if __name__ == '__main__':
    main()

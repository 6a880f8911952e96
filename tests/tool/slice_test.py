"""bcc4 slice, verify, info and export on small volumes."""
import array
import json
import math
import os
import statistics
import subprocess
import unittest

from harness import BCC4, TOP, Nrrd, ToolTest, field, has_openvdb, main

DIMS = (14, 12, 13, 16)


def wave(x, y, z, t):
    """Cosines that end level at the borders, where the lattice mirrors the field: slow, so the kernels follow them."""
    c = [math.cos(math.pi * p / (n - 1)) for p, n in zip((x, 2 * y, z, 2 * t), DIMS)]
    return 500 + 250 * c[0] * c[1] + 200 * c[2] * c[3]


class Slice(ToolTest):
    store = 'samples'

    def setUp(self):
        super().setUp()
        self.volume(DIMS, wave, '--dt', '0.5', '--spacing', '1,2,3', '--quiet')

    def values(self, *args):
        self.bcc4('slice', 'v.bcc4', *args, '-o', 's.nrrd', '--quiet')
        return Nrrd(self.path('s.nrrd'))

    def test_samples_stand_at_source_samples(self):
        for frame in (0, 3, 7.5, 15):
            got = self.values('--index', '--time', frame)
            self.assertEqual(got.sizes, list(DIMS[:3]))
            wanted = field((*DIMS[:3], 1), lambda x, y, z, _: wave(x, y, z, frame), 'f')
            self.assertLess(max(abs(a - b) for a, b in zip(got.values, wanted)), 5, frame)

    def test_header(self):
        got = self.values('--time', 2)
        self.assertEqual(got.fields['type'], 'float')
        self.assertEqual(got.fields['endian'], 'little')
        self.assertEqual(got.fields['space directions'], '(1,0,0) (0,2,0) (0,0,3)')
        self.assertEqual(got.fields['space origin'], '(0,0,0)')
        self.assertEqual(got.keys['bccsplat hyperplane'], '0 0 0 1 -4')

    def test_time_index_and_plane_agree(self):
        by_time = self.values('--time', 3.6).values
        self.assertEqual(by_time, self.values('--index', '--time', 7.2).values)
        self.assertEqual(by_time, self.values('--plane', '0,0,0,2,-14.4').values)

    def test_kernels_differ(self):
        self.assertNotEqual(self.values('--time', 1).values, self.values('--time', 1, '--kernel', 'paper').values)

    def test_axis_and_oblique_planes(self):
        got = self.values('--plane', '1,0,0,0,-5')
        self.assertEqual(sorted(got.sizes), sorted(DIMS[1:]))
        j = self.json('slice', 'v.bcc4', '--plane', '1,0,0,0,-5', '-o', 's.nrrd')
        self.assertEqual(j['dims'], got.sizes)
        self.check_plane(j, 5)
        j = self.json('slice', 'v.bcc4', '--plane', '1,.5,0,.7,-13', '-o', 's.nrrd')
        self.assertEqual(j['nan'] > 0, any(math.isnan(v) for v in Nrrd(self.path('s.nrrd')).values))
        self.check_plane(j, 10)

    def check_plane(self, j, tolerance, margin=0):
        """Each sample, this far inside of the domain, is the field at origin + basis * its slice coordinate."""
        n, compared = Nrrd(self.path('s.nrrd')), 0
        for i, v in enumerate(n.values):
            if math.isnan(v):
                continue
            k = (i % n.sizes[0], i // n.sizes[0] % n.sizes[1], i // (n.sizes[0] * n.sizes[1]))
            uvw = [j['first_sample'][a] + k[a] * j['spacing'][a] for a in range(3)]
            p = [j['origin'][c] + sum(uvw[a] * j['basis'][a][c] for a in range(3)) for c in range(4)]
            if any(not margin <= q <= n - 1 - margin for q, n in zip(p, DIMS)) and margin:
                continue
            self.assertAlmostEqual(v, wave(*p), delta=tolerance)
            compared += 1
        self.assertGreater(compared, len(n.values) / 4)

    def test_slabs(self):
        self.bcc4('slice', 'v.bcc4', '--index', '--time', 8, '--thickness', 3, '-o', 's.nrrd', '--quiet')
        mean = Nrrd(self.path('s.nrrd'))
        self.assertEqual(mean.keys['bccsplat slab'], 'mean 3')
        thin = [self.values('--index', '--time', 8 + 3 * ((k + .5) / 64 - .5)).values for k in range(64)]
        for i in range(0, len(mean.values), 37):
            self.assertAlmostEqual(mean.values[i], sum(t[i] for t in thin) / 64, delta=.2)
        total = self.values('--index', '--time', 8, '--thickness', 3, '--slab', 'sum').values
        largest = self.values('--index', '--time', 8, '--thickness', 3, '--slab', 'max').values
        for a, b, c in zip(mean.values, total, largest):
            self.assertAlmostEqual(3 * a, b, delta=.01)
            self.assertGreaterEqual(c, a - 2)
        j = self.json('slice', 'v.bcc4', '--plane', '1,.5,0,.7,-13', '--thickness', 2, '--slab', 'sum', '-o', 's.nrrd')
        self.assertEqual(j['slab'], {'kind': 'sum', 'thickness': 2})

    def test_lattices_and_methods(self):
        j = self.json('slice', 'v.bcc4', '--plane', '1,.5,0,.7,-13', '--slice-lattice', 'cc', '-o', 's.nrrd')
        self.assertEqual(j['lattice'], 'cc')
        self.check_plane(j, 10)
        few = self.json('slice', 'v.bcc4', '--plane', '1,.5,0,.7,-13', '--slice-spacing', 1.5, '-o', 's.nrrd')
        self.assertLess(few['points'], j['points'])
        # The wider the 4D filter, the less is left of the waves.
        spread = []
        for widths in ('1,1,1,1', '1,1,1,3', '3,3,3,3'):
            self.json('slice', 'v.bcc4', '--kernel', 'paper', '--plane', '1,.5,0,.7,-13', '--bandwidth', widths, '-o', 's.nrrd')
            spread.append(statistics.pvariance(v for v in Nrrd(self.path('s.nrrd')).values if not math.isnan(v)))
        self.assertGreater(spread[0], 1.02 * spread[1])
        self.assertGreater(spread[1], 1.5 * spread[2])
        self.refused(2, 'kernel "paper"', 'slice', 'v.bcc4', '--plane', '1,.5,0,.7,-13', '--bandwidth', '2,2,2,2', '-o', 'b.nrrd',
                     output='b.nrrd')
        for method, tolerance, margin in (('merged', 2, 0), ('resampled', 5, 0), ('extracted', 15, 2)):  # no mirrors at the ends
            j = self.json('slice', 'v.bcc4', '--plane', '1,0,0,0,-6', '--slice-method', method, '-o', 's.nrrd')
            self.check_plane(j, tolerance, margin)

    def test_point_and_basis(self):
        j = self.json('slice', 'v.bcc4', '--point', '6,5,6,7', '--basis', '1,1,0,0,0,0,1,0,0,0,0,1', '-o', 's.nrrd')
        self.assertEqual(j['origin'], [6, 5, 6, 7])
        self.assertAlmostEqual(j['basis'][0][0], math.sqrt(.5))
        self.check_plane(j, 10)

    def test_sweeps(self):
        self.bcc4('slice', 'v.bcc4', '--plane', '0,-2,0,0,8', '--sweep', '-2:1,4', '-o', 's%02d.nrrd', '--quiet')
        for i in range(4):
            moved = Nrrd(self.path(f's{i:02}.nrrd')).values
            self.assertEqual(moved, self.values('--plane', f'0,1,0,0,{-(4 - (i - 2))}').values)
        j = self.json('slice', 'v.bcc4', '--index', '--time', 3, '--sweep', '0,4,3', '-o', 't##.nrrd')
        self.assertEqual([s['hyperplane'][4] for s in j['slices']], [-3, -5, -7])
        self.assertEqual(j['slices'][1]['output'], 't01.nrrd')
        j = self.json('slice', 'v.bcc4', '--point', '6,5,6,7', '--basis', '1,0,0,0,0,1,0,0,0,0,1,0', '--sweep', '-1,1,2', '-o', 'p##.nrrd')
        self.assertEqual([s['origin'] for s in j['slices']], [[6, 5, 6, 6], [6, 5, 6, 8]])
        self.refused(2, 'pattern', 'slice', 'v.bcc4', '--time', 1, '--sweep', '0,1,2', '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, '0 to 15', 'slice', 'v.bcc4', '--time', 1, '--sweep', '0,99,2', '-o', 'x##.nrrd', output='x00.nrrd')
        self.refused(2, 'whole number', 'slice', 'v.bcc4', '--time', 1, '--sweep', '0,1,1', '-o', 'x##.nrrd', output='x00.nrrd')

    def test_refusals(self):
        self.refused(2, '--thickness', 'slice', 'v.bcc4', '--time', 1, '--slab', 'sum', '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, 'positive', 'slice', 'v.bcc4', '--time', 1, '--thickness', 0, '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, 'together', 'slice', 'v.bcc4', '--point', '1,1,1,1', '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, 'depends', 'slice', 'v.bcc4', '--point', '1,1,1,1', '--basis', '1,0,0,0,2,0,0,0,0,0,1,0', '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, 'from 0 to 7.5', 'slice', 'v.bcc4', '--time', 7.6, '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, '0 to 15', 'slice', 'v.bcc4', '--index', '--time', -.1, '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, 'is missing', 'slice', 'v.bcc4', '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, '5 numbers', 'slice', 'v.bcc4', '--plane', '1,2,3', '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, 'all be 0', 'slice', 'v.bcc4', '--plane', '0,0,0,0,1', '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, 'finite', 'slice', 'v.bcc4', '--plane', '1,nan,0,0,1', '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, 'misses', 'render', 'v.bcc4', '--plane', '1,0,0,0,99', '-o', 'x.png', output='x.png')
        self.refused(2, 'misses', 'slice', 'v.bcc4', '--plane', '1,0,0,0,99', '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, 'exclude', 'slice', 'v.bcc4', '--time', 1, '--plane', '1,0,0,0,0', '-o', 'x.nrrd', output='x.nrrd')
        self.refused(2, 'must end in .nrrd, .vdb, .nii', 'slice', 'v.bcc4', '--time', 1, '-o', 'x.raw', output='x.raw')
        self.refused(2, 'did you mean paper?', 'slice', 'v.bcc4', '--time', 1, '--kernel', 'papper', '-o', 'x.nrrd', output='x.nrrd')
        self.refused(3, 'none', 'slice', 'v.bcc4', '--time', 1, '-o', 'none/x.nrrd')
        self.refused(3, 'none.bcc4', 'slice', 'none.bcc4', '--time', 1, '-o', 'x.nrrd', output='x.nrrd')
        self.write('no.bcc4', b'something else altogether')
        self.refused(3, 'not a .bcc4', 'slice', 'no.bcc4', '--time', 1, '-o', 'x.nrrd', output='x.nrrd')

    def test_motion_is_followed(self):
        def mover(x, y, z, t):
            return 1000 * math.exp(-((x - 6 - 4 * t) ** 2 + (y - 20) ** 2 + (z - 20) ** 2) / 18)
        dims = (40, 40, 40, 8)
        self.volume(dims, mover, '--quiet', name='m.bcc4')
        wanted = field((*dims[:3], 1), lambda x, y, z, _: mover(x, y, z, 3.5), 'f')

        def squares(command, *args):
            self.bcc4(command, 'm.bcc4', '--index', '--time', 3.5, *args, '-o', 'm.nrrd', '--overwrite', '--quiet')
            return sum((a - b) ** 2 for a, b in zip(Nrrd(self.path('m.nrrd')).values, wanted))
        for command in ('slice', 'export'):
            self.assertLess(squares(command, '--motion', 'on'), .5 * squares(command, '--motion', 'off'), command)
        self.refused(2, '--motion on', 'slice', 'm.bcc4', '--plane', '1,0,0,0,-5', '--motion', 'on', '-o', 'x.nrrd', output='x.nrrd')

    def test_files_of_before_are_refused_by_name(self):
        with open(os.path.join(TOP, 'tests', 'golden', 'bad_older_version.bcc4'), 'rb') as f:
            self.write('c.bcc4', f.read())
        said = 'made by a build before 0.1.0, whose files no later one reads; import its source again'
        self.refused(3, said, 'info', 'c.bcc4')
        self.refused(3, said, 'slice', 'c.bcc4', '--time', 1, '-o', 'x.nrrd', output='x.nrrd')

    def test_info_has_the_keys_promised(self):
        j = self.json('info', 'v.bcc4', '--histogram')
        for key in ('dims', 'lattice', 'cc_samples', 'sites_total', 'sites_kept', 'value_type', 'range', 'times', 'affine', 'air',
                    'bytes', 'kernel'):
            self.assertIn(key, j)
        self.assertEqual(set(j['times']), {'count', 'first', 'last', 'unit', 'uniform', 'periodic', 'end'})
        self.assertEqual(set(j['bytes']), {'file', 'runs', 'values', 'index'})
        self.assertEqual(j['affine'], [[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 3, 0], [0, 0, 0, 1]])
        self.assertEqual(sum(j['channels'][0]['histogram']), j['sites_kept'])
        self.assertEqual(j['bytes']['file'], os.path.getsize(self.path('v.bcc4')))
        self.assertNotIn('frames', j['channels'][0])
        out, _ = self.bcc4('info', 'v.bcc4', '--histogram')
        self.assertIn('14 x 12 x 13 x 16', out)

    def test_info_tells_the_range_of_every_frame(self):
        with open(self.path('v.bcc4.raw'), 'rb') as f:
            source = array.array('f', f.read())
        n = len(source) // 16
        frames = [source[t * n:(t + 1) * n] for t in range(16)]
        self.assertEqual(self.json('info', 'v.bcc4', '--frames')['channels'][0]['frames'], [[min(f), max(f)] for f in frames])
        out, _ = self.bcc4('info', 'v.bcc4', '--frames')
        self.assertEqual(out.count(' at '), 16)

    def test_verify_compares_every_sample(self):
        j = self.json('verify', 'v.bcc4', '--against', 'v.bcc4.raw')
        for key in ('ok', 'max_abs', 'rmse', 'psnr', 'worst', 'samples_compared', 'non_air'):
            self.assertIn(key, j)
        self.assertTrue(j['ok'])
        self.assertEqual(set(j['worst']), {'frame', 'voxel', 'expected', 'got'})
        # The same figures from the slices.
        worst, squares, count = 0, 0, 0
        for t in range(DIMS[3]):
            got = self.values('--index', '--time', t).values
            wanted = field((*DIMS[:3], 1), lambda x, y, z, _: wave(x, y, z, t), 'f')
            for a, b in zip(got, wanted):
                worst, squares, count = max(worst, abs(a - b)), squares + (a - b) ** 2, count + 1
        self.assertEqual(j['samples_compared'], count)
        self.assertAlmostEqual(j['max_abs'], worst, places=6)
        self.assertAlmostEqual(j['rmse'], math.sqrt(squares / count), places=6)
        with open(self.path('v.bcc4.raw'), 'rb') as f:
            source = array.array('f', f.read())
        peak = max(source) - min(source)
        self.assertAlmostEqual(j['psnr'], 20 * math.log10(peak / j['rmse']), places=6)
        x, y, z = j['worst']['voxel']
        self.assertAlmostEqual(j['worst']['expected'], source[((j['worst']['frame'] * 13 + z) * 12 + y) * 14 + x], places=6)
        self.assertAlmostEqual(abs(j['worst']['got'] - j['worst']['expected']), worst, places=6)

    def test_a_slice_of_holes_has_no_range(self):
        holes = self.volume(DIMS, lambda *_: math.nan, '--on-nonfinite', 'hole', '--quiet', name='h.bcc4')
        self.assertIn('samples, no value, ', self.bcc4('slice', holes, '--time', 1, '-o', 'h.nrrd')[0])
        self.assertIn('nothing to compare', self.bcc4('verify', holes, '--against', 'h.bcc4.raw')[0])

    def test_verify_sees_another_source(self):
        self.raw('other.raw', DIMS, lambda *p: wave(*p) + (50 if p == (3, 4, 5, 6) else 0))
        j = self.json('verify', 'v.bcc4', '--against', 'other.raw')
        self.assertEqual(j['worst']['voxel'], [3, 4, 5])
        self.assertEqual(j['worst']['frame'], 6)
        self.refused(3, '14 x 12 x 13 x 8', 'verify', 'v.bcc4', '--against', 'v.bcc4.raw', '--dims', '14,12,13,8', '--dtype', 'f64')

    def test_verify_finds_damage(self):
        with open(self.path('v.bcc4'), 'rb') as f:
            good = f.read()
        for at in range(0, len(good), max(1, len(good) // 40)):
            bad = bytearray(good)
            bad[at] ^= 16
            self.write('bad.bcc4', bytes(bad))
            p = subprocess.run([BCC4, 'verify', 'bad.bcc4', '--json'], capture_output=True, text=True, cwd=self.folder)
            self.assertIn(p.returncode, (1, 3) if at < 64 else (1,), (at, p.stderr))  # the head says what kind of file it is
            self.assertIn('bad.bcc4', p.stderr)
            if p.returncode == 1:
                self.assertFalse(json.loads(p.stdout)['ok'])
        self.write('cut.bcc4', good[:len(good) // 2])
        self.refused(1, 'cut.bcc4', 'verify', 'cut.bcc4')

    def test_export_gives_the_slices(self):
        self.bcc4('export', 'v.bcc4', '--all', '--format', 'raw', '-o', 'out/')
        names = sorted(os.listdir(self.path('out')))
        self.assertEqual(names, [f'v.{t:04}.raw' for t in range(16)])
        for t in (0, 9, 15):
            with open(self.path(f'out/v.{t:04}.raw'), 'rb') as f:
                self.assertEqual(array.array('f', f.read()), self.values('--index', '--time', t).values)
        self.bcc4('export', 'v.bcc4', '--all', '-o', 'all.nrrd')
        all_frames = Nrrd(self.path('all.nrrd'))
        self.assertEqual(all_frames.sizes, list(DIMS))
        self.assertEqual(all_frames.keys['axis 3 index values'].split(), ['0', '0.5'] + [str(t / 2).removesuffix('.0') for t in range(2, 16)])
        # What was exported can be imported again, times included.
        self.bcc4('import', 'all.nrrd', '-o', 'again.bcc4', '--quiet')
        self.assertEqual(self.json('info', 'again.bcc4')['times'], self.json('info', 'v.bcc4')['times'])
        self.assertEqual(self.json('info', 'again.bcc4')['affine'], self.json('info', 'v.bcc4')['affine'])
        self.bcc4('export', 'v.bcc4', '--time', 2.25, '-o', 'one.%03d.nrrd')
        self.assertTrue(os.path.exists(self.path('one.004.nrrd')) or os.path.exists(self.path('one.005.nrrd')))
        self.refused(2, '--overwrite', 'export', 'v.bcc4', '--all', '-o', 'all.nrrd')
        self.refused(2, '--time T or --all is missing', 'export', 'v.bcc4', '-o', 'x.nrrd', output='x.nrrd')

    def test_export_of_a_region(self):
        box, (x0, y0, z0), (nx, ny, nz) = '2-5,3-3,1-6', (2, 3, 1), (4, 1, 6)
        self.bcc4('export', 'v.bcc4', '--all', '--roi', box, '-o', 'part.nrrd')
        self.bcc4('export', 'v.bcc4', '--all', '-o', 'all.nrrd')
        part, whole = Nrrd(self.path('part.nrrd')), Nrrd(self.path('all.nrrd'))
        self.assertEqual(part.sizes, [nx, ny, nz, DIMS[3]])
        at = ((t, z, y, x) for t in range(DIMS[3]) for z in range(nz) for y in range(ny) for x in range(nx))
        for (t, z, y, x), value in zip(at, part.values, strict=True):
            self.assertEqual(value, whole.values[((t * DIMS[2] + z + z0) * DIMS[1] + y + y0) * DIMS[0] + x + x0])
        # It stands where it stood, in NRRD and OpenVDB: spacing 1, 2, 3.
        self.bcc4('import', 'part.nrrd', '-o', 'part.bcc4', '--quiet')
        whole, part = self.json('info', 'v.bcc4')['affine'], self.json('info', 'part.bcc4')['affine']
        self.assertEqual([part[a][3] - whole[a][3] for a in range(3)], [x0, 2 * y0, 3 * z0])
        self.bcc4('export', 'v.bcc4', '--index', '--time', 4, '--roi', box, '-o', 'part.raw')
        self.assertEqual(os.path.getsize(self.path('part.raw')), nx * ny * nz * 4)
        if has_openvdb():
            self.bcc4('export', 'v.bcc4', '--index', '--time', 4, '--roi', box, '-o', 'part.vdb')
            self.bcc4('import', 'part.vdb', '-o', 'vdb.bcc4', '--quiet')
            vdb = self.json('info', 'vdb.bcc4')
            self.assertEqual((vdb['dims'], [vdb['affine'][a][3] for a in range(3)]), ([nx, ny, nz, 1], [part[a][3] for a in range(3)]))
        for wrong, text in (('0-9,0-9', 'X0-X1,Y0-Y1,Z0-Z1'), ('5-2,0-1,0-1', 'does not rise'), (f'0-{DIMS[0]},0-1,0-1', f'has 0 to {DIMS[0] - 1}'), ('a,0,0', '--roi')):
            self.refused(2, text, 'export', 'v.bcc4', '--all', '--roi', wrong, '-o', 'x.nrrd', output='x.nrrd')

    def test_slice_and_picture_of_a_region(self):
        box, (x0, y0, z0), (nx, ny, nz) = '2-5,3-3,1-6', (2, 3, 1), (4, 1, 6)
        whole, part = self.values('--time', 3.25), self.values('--time', 3.25, '--roi', box)
        self.assertEqual(part.sizes, [nx, ny, nz])
        self.assertEqual(part.keys['bccsplat first sample'], f'{x0} {y0} {z0}')
        at = ((z, y, x) for z in range(nz) for y in range(ny) for x in range(nx))
        for (z, y, x), value in zip(at, part.values, strict=True):
            self.assertAlmostEqual(value, whole.values[((z + z0) * DIMS[1] + y + y0) * DIMS[0] + x + x0], places=5)
        pictures = []
        for options in ((), ('--roi', '0-13,0-11,0-4'), ('--roi', '0-13,0-11,0-12')):
            self.bcc4('render', 'v.bcc4', '--time', 3.25, '--size', '24x24', *options, '-o', 'p.png')
            with open(self.path('p.png'), 'rb') as f:
                pictures.append(f.read())
        self.assertNotEqual(pictures[0], pictures[1])
        self.assertEqual(pictures[0], pictures[2])
        for command in ('slice', 'render'):
            name = 'x.nrrd' if command == 'slice' else 'x.png'
            self.refused(2, '--roi goes with --time', command, 'v.bcc4', '--plane', '1,0,0,0,-3', '--roi', box, '-o', name, output=name)
            self.refused(2, 'has 0 to 13', command, 'v.bcc4', '--time', 3, '--roi', '0-14,0-1,0-1', '-o', name, output=name)
            self.refused(2, 'X0-X1,Y0-Y1,Z0-Z1', command, 'v.bcc4', '--time', 3, '--roi', '0-1', '-o', name, output=name)

    def test_export_rounds_to_the_source_type(self):
        for dtype, offset in (('u8', 0), ('i16', -500), ('u16', 60000)):
            self.volume(DIMS, lambda *p: wave(*p) / 10 + offset if dtype != 'u16' else 65535 - wave(*p), '--quiet', name=f'{dtype}.bcc4', dtype=dtype)
            self.bcc4('export', f'{dtype}.bcc4', '--all', '-o', f'{dtype}.raw')
            code = {'u8': 'B', 'i16': 'h', 'u16': 'H'}[dtype]
            with open(self.path(f'{dtype}.raw'), 'rb') as a, open(self.path(f'{dtype}.bcc4.raw'), 'rb') as b:
                got, source = array.array(code, a.read()), array.array(code, b.read())
            self.assertEqual(len(got), len(source))
            report = self.json('verify', f'{dtype}.bcc4', '--against', f'{dtype}.bcc4.raw')
            self.assertLessEqual(max(abs(g - s) for g, s in zip(got, source)), report['max_abs'] + .5)

    @unittest.skipUnless(has_openvdb(), 'built without OpenVDB')
    def test_openvdb_round_trip(self):
        self.bcc4('export', 'v.bcc4', '--all', '-o', 'v.####.vdb')
        self.bcc4('import', 'v.####.vdb', '-o', 'again.bcc4', '--quiet')
        info = self.json('info', 'again.bcc4')
        self.assertEqual(info['times'], self.json('info', 'v.bcc4')['times'])
        self.assertEqual(info['dims'][3], 16)
        self.assertEqual([info['affine'][a][a] for a in range(3)], [1, 2, 3])
        self.assertEqual(info['attributes']['import.format'], 'OpenVDB')
        self.assertGreater(self.json('verify', 'again.bcc4', '--against', 'v.####.vdb')['psnr'], 40)
        self.bcc4('import', 'v.####.vdb', '-o', 'few.bcc4', '--quiet', '--frames', '2-12x5')
        self.assertEqual(self.json('info', 'few.bcc4')['times'], {'count': 3, 'first': 1, 'last': 6, 'unit': '', 'uniform': True, 'periodic': False, 'end': 6})
        os.remove(self.path('v.0007.vdb'))
        self.refused(3, 'missing from the sequence: 7 (1 of 16)', 'import', 'v.####.vdb', '-o', 'x.bcc4', output='x.bcc4')
        for policy, count in (('hold', 16), ('skip', 15), ('interpolate', 16)):
            self.bcc4('import', 'v.####.vdb', '-o', 'gap.bcc4', '--gaps', policy, '--overwrite', '--quiet')
            times = self.json('info', 'gap.bcc4')['times']
            self.assertEqual((times['count'], times['last']), (count, 7.5))
            self.assertGreater(self.json('verify', 'gap.bcc4', '--against', 'v.####.vdb')['psnr'], 35)
        self.bcc4('slice', 'v.bcc4', '--time', 3.3, '-o', 's.vdb')
        self.bcc4('import', 's.vdb', '-o', 's.bcc4', '--quiet')
        self.assertEqual(self.json('info', 's.bcc4')['lattice'], 'bcc')
        self.refused(2, 'did you mean value?', 'import', 's.vdb', '--grid', 'valu', '-o', 'x.bcc4', output='x.bcc4')


if __name__ == '__main__':
    main()

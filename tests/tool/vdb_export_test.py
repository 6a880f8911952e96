"""OpenVDB grids there and back: what export writes is such a grid as import read."""
import json
import os
import resource
import signal
import struct
import subprocess
import sys

from harness import BCC4, DATA, ToolTest, main

PROBE = os.environ.get('BCC4_VDB_PROBE')


class VdbExport(ToolTest):
    store = 'samples'

    def make(self, name, kind):
        subprocess.run([PROBE, 'make', self.path(name), str(kind)], check=True)
        return name

    def grid(self, name):
        out = subprocess.run([PROBE, self.path(name)], capture_output=True, text=True, check=True).stdout
        return json.loads(out)

    def there_and_back(self, name):
        self.bcc4('import', name, '-o', 'a.bcc4', '--overwrite', '--quiet')
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.vdb', '--overwrite', '--quiet')
        return self.grid(name), self.grid('a.vdb')

    def alike(self, source, back):
        for key in ('name', 'class', 'background', 'half'):
            self.assertEqual(back[key], source[key], key)
        self.assertGreaterEqual(back['low'], source['low'])
        self.assertLessEqual(back['high'], source['high'])
        self.assertAlmostEqual(back['active'], source['active'], delta=.05 * source['active'])
        for a, b in zip(back['middle'], source['middle']):
            self.assertAlmostEqual(a, b, delta=.3)

    def test_a_level_set(self):
        source, back = self.there_and_back(self.make('s.vdb', 'sphere'))
        self.assertEqual((source['class'], source['name'], source['inside']), ('level set', '', -source['background']))
        source['low'] -= .02  # the band's inner edge was no voxel's value
        source['high'] += .02
        self.alike(source, back)
        self.assertEqual(back['inside'], source['inside'])
        # Read as fog it goes back as fog.
        self.bcc4('import', 's.vdb', '--level-set', 'fog', '-o', 'f.bcc4', '--quiet')
        self.bcc4('export', 'f.bcc4', '--all', '-o', 'f.vdb', '--quiet')
        fog = self.grid('f.vdb')
        self.assertEqual((fog['class'], fog['background']), ('fog volume', 0))
        self.assertTrue(0 < fog['low'] and fog['high'] <= 1, fog)

    def test_a_grid_that_goes_on_under_another_name(self):
        self.make('f.0.vdb', 0)
        smoke = self.read('f.0.vdb')
        for f in 1, 2:
            self.write(f'f.{f}.vdb', smoke)
        for f in range(4):
            self.write(f'g.{f}.vdb', smoke.replace(b'soot', b'mist'))
        how = ['--lattice', 'cc', '--exact', '--quiet', '-o', 'a.bcc4']

        def told():
            return {k: v for k, v in self.json('info', 'a.bcc4')['attributes'].items() if k.startswith('openvdb.') and 'active' not in k}

        self.bcc4('import', 'f.%d.vdb', *how)
        before = told()
        self.assertIn('openvdb.class.soot', before)
        self.assertIn('goes on as "soot"', self.bcc4('import', 'g.%d.vdb', '--append', *how)[1])
        self.assertEqual(told(), before)
        self.assertEqual(self.json('info', 'a.bcc4')['dims'][3], 4)

    def test_missing_values_are_told(self):
        args = self.raw('h.raw', (9, 8, 7, 1), lambda x, y, z, t: float('nan') if x < 2 else x + y)
        self.bcc4('import', *args, '--on-nonfinite', 'hole', '-o', 'h.bcc4', '--quiet')
        _, said = self.bcc4('export', 'h.bcc4', '--all', '-o', 'h.vdb')
        self.assertIn('112 missing values were written as background', said)

    def test_fog_with_a_sharp_edge(self):
        self.alike(*self.there_and_back(self.make('f.vdb', 0)))

    def test_real_smoke(self):
        path = os.path.join(DATA, 'smoke.vdb')
        if not os.path.exists(path):
            self.skipTest('no such data')
        os.symlink(path, self.path('smoke.vdb'))
        self.alike(*self.there_and_back('smoke.vdb'))

    def test_frames_regions_and_moments(self):
        for f in range(6):
            self.make(f'f.{f}.vdb', f)
        self.bcc4('import', 'f.%d.vdb', '-o', 'f.bcc4', '--quiet')
        self.bcc4('export', 'f.bcc4', '--all', '-o', 'e.%d.vdb', '--quiet')
        counts = []
        for f in range(6):
            source, back = self.grid(f'f.{f}.vdb'), self.grid(f'e.{f}.vdb')
            counts.append(source['active'])
            source['low'] = min(source['low'], 1e-3)
            source['high'] = 3.002
            self.alike(source, back)
        # A moment between frames has about as many voxels as they have, cut or exported; a region those it holds.
        for command in ('export', 'slice'):
            self.bcc4(command, 'f.bcc4', '--index', '--time', 2.5, '-o', f'{command}.vdb', '--quiet')
            self.assertAlmostEqual(self.grid(f'{command}.vdb')['active'], (counts[2] + counts[3]) / 2, delta=.05 * counts[2])
        dims = self.json('info', 'f.bcc4')['dims']
        halves = []
        for first, last in ((0, dims[0] // 2 - 1), (dims[0] // 2, dims[0] - 1)):
            self.bcc4('export', 'f.bcc4', '--index', '--time', 2, '--roi', f'{first}-{last},0-{dims[1] - 1},0-{dims[2] - 1}', '-o',
                      'r.vdb', '--overwrite', '--quiet')
            halves.append(self.grid('r.vdb')['active'])
        self.assertEqual(sum(halves), self.grid('e.2.vdb')['active'])
        # The end of a periodic series is frame 0 again.
        self.bcc4('import', 'f.%d.vdb', '--ends', 'periodic', '-o', 'p.bcc4', '--quiet')
        for time in 0, 6:
            self.bcc4('export', 'p.bcc4', '--index', '--time', time, '-o', f'p{time}.vdb', '--quiet')
        self.assertEqual(self.grid('p6.vdb')['active'], self.grid('p0.vdb')['active'])
        # Frames that are left out or filled in have their own counts.
        os.remove(self.path('f.3.vdb'))
        for gaps in ('hold', 'skip', 'interpolate'):
            self.bcc4('import', 'f.%d.vdb', '--gaps', gaps, '-o', 'g.bcc4', '--overwrite', '--quiet')
            known = self.json('info', 'g.bcc4')['attributes']['openvdb.active.soot'].split()
            self.assertEqual(len(known), 5 if gaps == 'skip' else 6)
            self.assertEqual(int(known[-1]), counts[5])

    def test_time_and_units(self):
        head = ('NRRD0005\ntype: float\ndimension: 4\nsizes: 5 4 3 3\nspace dimension: 3\nspace directions: (2,0,0) (0,2,0) (0,0,2) none\n'
                'kinds: domain domain domain time\nspace units: "mm" "mm" "mm"\nunits: "" "" "" "s"\ncontent: heat\n'
                'sample units: K\nendian: little\nencoding: raw\naxis 3 index type:=numeric\naxis 3 index values:=.5 2 3\n\n')
        self.write('a.nrrd', head.encode() + struct.pack('<180f', *(1 + .01 * i for i in range(180))))
        self.bcc4('import', 'a.nrrd', '-o', 'a.bcc4', '--quiet')
        known = self.json('info', 'a.bcc4')
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'f.%d.vdb', '--quiet')
        self.bcc4('import', 'f.%d.vdb', '-o', 'b.bcc4', '--quiet')
        back = self.json('info', 'b.bcc4')
        for j in known, back:
            self.assertEqual((j['times']['first'], j['times']['last'], j['times']['unit'], j['spatial_unit']), (.5, 3, 's', 'mm'))
            self.assertEqual((j['channels'][0]['name'], j['channels'][0]['unit']), ('heat', 'K'))
            self.assertEqual(j['affine'], known['affine'])
        # Slices of a moment have it, other planes and sums along their normal are of another kind.
        for options, time, unit in ((['--time', 1], 1, 'K'), (['--plane', '1,0,0,0,-2'], 0, 'K'),
                                    (['--plane', '1,0,0,0,-2', '--thickness', 1, '--slab', 'sum'], 0, '')):
            self.bcc4('slice', 'a.bcc4', *options, '-o', 's.vdb', '--quiet')
            self.bcc4('import', 's.vdb', '-o', 's.bcc4', '--quiet', '--overwrite')
            j = self.json('info', 's.bcc4')
            self.assertEqual((j['times']['first'], j['channels'][0]['unit']), (time, unit), options)

    def test_a_full_disk_is_said(self):
        self.make('f.vdb', 0)
        self.bcc4('import', 'f.vdb', '-o', 'f.bcc4', '--quiet')
        limit = os.path.getsize(self.path('f.vdb')) // 4

        def small_disk():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        for command in ('export', 'slice'):
            p = subprocess.run([BCC4, command, 'f.bcc4', '--index', '--time', '0', '-o', 'full.vdb'], capture_output=True, text=True,
                               cwd=self.folder, preexec_fn=small_disk)
            self.assertNotEqual(p.returncode, 0, p.stdout)
            self.assertIn('full.vdb: cannot be written (File too large)', p.stderr)
            self.assertFalse(os.path.exists(self.path('full.vdb')))


if __name__ == '__main__':
    if not PROBE:
        sys.exit(77)
    main()

"""What a file holds as air is air in exports, so that they import to as little as the source."""
import math
import os
import subprocess

from harness import BCC4, Nrrd, ToolTest, has_openvdb, main

PROBE = os.environ.get('BCC4_VDB_PROBE')
DIMS = (40, 40, 40, 4)


def ball(x, y, z, t):
    r = math.dist((x, y, z), (18 + t, 20, 20))
    return .5 + math.cos(.4 * x) ** 2 if r < 8 else 0


class Air(ToolTest):
    def test_a_float_export_is_as_sparse_as_its_source(self):
        self.volume(DIMS, ball, '--lattice', 'd4star', '--quiet', name='a.bcc4')
        source = self.json('info', 'a.bcc4')
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'b.nrrd', '--quiet')
        values = Nrrd(self.path('b.nrrd')).values
        far = [v for v, (x, y, z, t) in zip(values, ((x, y, z, t) for t in range(4) for z in range(40) for y in range(40) for x in range(40)))
               if math.dist((x, y, z), (18 + t, 20, 20)) > 15]
        self.assertGreater(len(far), 100000)
        self.assertEqual(set(far), {0})
        self.bcc4('import', 'b.nrrd', '-o', 'b.bcc4', '--lattice', 'd4star', '--quiet')
        back = self.json('info', 'b.bcc4')
        self.assertLess(source['sites_kept'], .2 * source['sites_total'])
        self.assertLess(back['sites_kept'], 2.5 * source['sites_kept'])
        # What is there stays: the object's inside is that of the field.
        self.bcc4('slice', 'a.bcc4', '--time', 2, '--index', '-o', 's.nrrd', '--quiet')
        field = Nrrd(self.path('s.nrrd')).values
        frame = values[2 * 64000:3 * 64000]
        differ = [i for i in range(64000) if frame[i] != field[i]]
        self.assertTrue(differ)
        self.assertTrue(all(frame[i] == 0 and ball(i % 40, i // 40 % 40, i // 1600, 2) == 0 for i in differ))

    def test_on_the_sources_grid_as_many_sites_come_back(self):
        self.volume(DIMS, ball, '--lattice', 'cc', '--quiet', name='a.bcc4')
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'b.nrrd', '--quiet')
        self.bcc4('import', 'b.nrrd', '-o', 'b.bcc4', '--lattice', 'cc', '--quiet')
        source, back = self.json('info', 'a.bcc4'), self.json('info', 'b.bcc4')
        self.assertLess(source['sites_kept'], .1 * source['sites_total'])
        self.assertEqual(back['sites_kept'], source['sites_kept'])

    def test_a_box_of_it_is_the_same(self):
        self.volume(DIMS, ball, '--lattice', 'd4star', '--quiet', name='a.bcc4')
        self.bcc4('export', 'a.bcc4', '--time', 1, '--index', '-o', 'w.nrrd', '--quiet')
        self.bcc4('export', 'a.bcc4', '--time', 1, '--index', '--roi', '4-30,5-20,6-25', '-o', 'r.nrrd', '--quiet')
        whole, part = Nrrd(self.path('w.nrrd')).values, Nrrd(self.path('r.nrrd')).values
        nx, ny = 27, 16
        for i, v in enumerate(part):
            x, y, z = i % nx + 4, i // nx % ny + 5, i // (nx * ny) + 6
            self.assertEqual(v == 0, whole[x + 40 * (y + 40 * z)] == 0)

    def test_a_bound_is_kept(self):
        self.volume(DIMS, ball, '--abs', .01, '--quiet', name='a.bcc4')
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'b.nrrd', '--quiet')
        j = self.json('compare', 'a.bcc4', 'b.nrrd', '--tolerance', 1e-6)
        self.assertTrue(j['equal'])

    def test_grids_of_doubles_and_their_boxes(self):
        if not PROBE or not has_openvdb():
            self.skipTest('no OpenVDB in this build')

        def probe(*args):
            return subprocess.run([PROBE, *args], capture_output=True, text=True, check=True).stdout
        import json
        probe('make', self.path('d.vdb'), 'dense')
        source = json.loads(probe(self.path('d.vdb')))
        self.bcc4('import', 'd.vdb', '-o', 'd.bcc4', '--quiet')
        self.bcc4('export', 'd.bcc4', '--all', '-o', 'b.vdb', '--quiet')
        back = json.loads(probe(self.path('b.vdb')))
        for key in ('name', 'type', 'active', 'box', 'background', 'voxel'):
            self.assertEqual(back[key], source[key], key)
        self.assertEqual((source['type'], source['active']), ('double', 32768))
        self.bcc4('export', 'd.bcc4', '--all', '--roi', '3-9,0-4,1-2', '-o', 'r.vdb', '--quiet')
        part = json.loads(probe(self.path('r.vdb')))
        self.assertEqual(part['box'], [source['box'][0] + 3, source['box'][1], source['box'][2] + 1,
                                       source['box'][0] + 9, source['box'][1] + 4, source['box'][2] + 2])


if __name__ == '__main__':
    main()

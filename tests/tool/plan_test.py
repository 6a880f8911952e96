"""The plan of the C API chooses as import does: a host in C that writes by it gets the bytes of the tool's file."""
import math
import os
import subprocess
import sys

from harness import ToolTest, main

HOST = os.environ.get('BCC4_PLAN_HOST')
if not HOST:
    print('skipped: no BCC4_PLAN_HOST, the C host of this test')
    sys.exit(77)

DIMS = (24, 24, 24, 12)


def smoke(x, y, z, t):
    """Plumes that rise and turn, nothing around them."""
    value = 0.0
    for i in range(3):
        dx, dy = x - 12 - 4 * math.cos(2.1 * i + .2 * t), y - 12 - 4 * math.sin(2.1 * i + .2 * t)
        dz = z - 4 - .9 * t + 2 * i
        value += math.exp(-(dx * dx + dy * dy) / 9 - dz * dz / 16)
    return value if value > 1e-3 else 0.0


def tissue(x, y, z, t):
    """Values of a scanner, in integers, with a texture."""
    return 900 + 500 * math.sin(.31 * x + .12 * t) * math.cos(.27 * y - .2 * z) + 40 * math.sin(1.7 * x + 2.1 * y + z)


def classes(x, y, z, t):
    return (3 if x > 14 else 40) if y + t > 12 else 0


class Plan(ToolTest):
    def alike(self, data, dtype, source, options, wishes):
        """Imports the source and writes its data by a plan; returns what was chosen."""
        for name in ('tool.bcc4', 'host.bcc4'):
            if os.path.exists(self.path(name)):
                os.remove(self.path(name))
        self.bcc4('import', *source, *options, '-o', 'tool.bcc4', '--quiet')
        run = subprocess.run([HOST, data, dtype, 'tool.bcc4', 'host.bcc4', *wishes], capture_output=True, text=True,
                             cwd=self.folder)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(self.path('tool.bcc4'), 'rb') as tool, open(self.path('host.bcc4'), 'rb') as host:
            self.assertTrue(tool.read() == host.read(), '%s: %s' % (options, run.stdout))
        return run.stdout.strip()

    def test_floats_of_a_raw_series(self):
        source = self.raw('smoke.raw', DIMS, smoke)
        chosen = self.alike('smoke.raw', 'f32', source, [], [])
        self.assertRegex(chosen, r'distances|wavelets')
        for options, wishes, word in ((['--psnr', '45'], ['psnr=45'], r'the smallest of \d+|wavelets'),
                                      (['--store', 'wavelets', '--psnr', '50'], ['store=wavelets', 'psnr=50'],
                                       'wavelets of the source\'s samples, rounded as far as at least 50 dB'),
                                      (['--density', '.25'], ['density=.25'], 'distances')):
            self.assertRegex(self.alike('smoke.raw', 'f32', source, options, wishes), word)

    def test_integers_of_a_nrrd_file(self):
        self.raw('tissue.raw', DIMS, tissue, 'u16')
        self.write('tissue.nrrd', '\n'.join([
            'NRRD0005', 'type: uint16', 'dimension: 4', 'sizes: 24 24 24 12', 'encoding: raw', 'endian: little',
            'space dimension: 3', 'space directions: (.5,0,0) (0,.5,0) (0,0,2) none', 'space origin: (-3,4,5)',
            'space units: "mm" "mm" "mm"', 'kinds: space space space time', 'data file: tissue.raw', '']).encode())
        for options, wishes in (([], []), (['--psnr', '45'], ['psnr=45']), (['--abs', '20'], ['abs=20']),
                                (['--store', 'wavelets', '--abs', '20'], ['store=wavelets', 'abs=20']),
                                (['--exact', '--ends', 'mirror'], ['exact', 'ends=mirror'])):
            self.alike('tissue.raw', 'u16', ['tissue.nrrd'], options, wishes)

    def test_labels_and_single_frames(self):
        chosen = self.alike('classes.raw', 'u8', self.raw('classes.raw', DIMS, classes, 'u8'), [], [])
        self.assertIn('labels', chosen)
        still = self.raw('still.raw', (*DIMS[:3], 1), smoke)
        for options, wishes in (([], []), (['--lattice', 'cc'], ['lattice=cc'])):
            self.alike('still.raw', 'f32', still, options, wishes)


if __name__ == '__main__':
    main()

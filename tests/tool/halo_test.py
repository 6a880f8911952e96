"""What a field rings beside an edge in air: little, and nothing is stored where the source is air all around."""
import math
import struct

from harness import ToolTest, main

SIDE, CENTRE, RADIUS = 64, 31.5, .34 * 64


def outside(x, y, z, edge):
    return math.dist((x, y, z), (CENTRE, CENTRE, CENTRE)) - RADIUS - edge / 2


class Halo(ToolTest):
    store = 'samples'

    def largest(self, edge):
        """Of a ball of value 1 whose edge falls over so many voxels: the largest value 3 voxels and more outside."""
        v = self.volume((SIDE, SIDE, SIDE, 1),
                        lambda x, y, z, t: min(1, max(0, -outside(x, y, z, edge) / edge)), '--quiet', '--overwrite')
        self.bcc4('export', v, '--all', '-o', 'ball.nrrd', '--overwrite', '--quiet')
        with open(self.path('ball.nrrd'), 'rb') as f:
            values = struct.unpack(f'<{SIDE ** 3}f', f.read()[-4 * SIDE ** 3:])
        place = [outside(n % SIDE, n // SIDE % SIDE, n // SIDE ** 2, edge) for n in range(SIDE ** 3)]
        self.assertLess(max(abs(v - 1) for v, p in zip(values, place) if p < -edge - 3), .03, 'the ball is not there')
        return max(abs(v) for v, p in zip(values, place) if p > 3)

    def test_soft_edges_end_in_air(self):
        self.assertLessEqual(self.largest(3), .0015)

    def test_harder_ones_nearly(self):
        self.assertLessEqual(self.largest(1), .0045)


if __name__ == '__main__':
    main()

"""Moments between frames: of every second frame those left out are asked for again, and come back as near as by the best
interpolation from sample to sample. `bccsplat_bench fit --held-out` prints how near for all sets at hand."""
import array
import gzip
import math
import os
import struct

from harness import DATA, Nrrd, ToolTest, main

# What the library may be behind the best of the others.
DECIBELS = .5


def nrrd_series(path):
    with open(path, 'rb') as f:
        head, data = f.read().split(b'\n\n', 1)
    sizes = next(line for line in head.split(b'\n') if line.startswith(b'sizes: '))
    return [int(n) for n in sizes.split()[1:]], array.array('H', gzip.decompress(data)), 'u16'


def nifti_series(path):
    with gzip.open(path) as f:
        data = f.read()
    return list(struct.unpack_from('<4h', data, 42)), array.array('f', data[352:]), 'f32'


def spline_weights(gap, n):
    """Weights of the frames 0 .. n-1 half-way between two of them: a cubic spline, straight at the ends."""
    def moments(values):
        slope, right = [0.] * n, [0.] * n
        for i in range(1, n - 1):
            pivot = 4 - slope[i - 1]
            slope[i] = 1 / pivot
            right[i] = (6 * (values[i - 1] - 2 * values[i] + values[i + 1]) - right[i - 1]) / pivot
        m = [0.] * n
        for i in range(n - 2, 0, -1):
            m[i] = right[i] - slope[i] * m[i + 1]
        return m

    weights = []
    for f in range(n):
        unit = [float(i == f) for i in range(n)]
        m = moments(unit)
        weights.append((unit[gap] + unit[gap + 1]) / 2 - (m[gap] + m[gap + 1]) / 16)
    return weights


def linear_weights(gap, n):
    return [.5 * (f in (gap, gap + 1)) for f in range(n)]


def cubic_weights(gap, n):
    """Catmull and Rom's; what it needs from beyond the ends goes on straight."""
    weights = [0.] * n
    for f, w in zip(range(gap - 1, gap + 3), (-1 / 16, 9 / 16, 9 / 16, -1 / 16)):
        if 0 <= f < n:
            weights[f] += w
        else:
            end, inner = (0, 1) if f < 0 else (n - 1, n - 2)
            weights[end] += 2 * w
            weights[inner] -= w
    return weights


class HeldOutTest(ToolTest):
    store = 'samples'

    def squares(self, dims, values, dtype, gaps, *options):
        """Squared errors in these gaps: of the library, and of the best of the others."""
        size = dims[0] * dims[1] * dims[2]
        kept = (dims[3] + 1) // 2
        frame = lambda t: values[t * size:(t + 1) * size]
        half = array.array(values.typecode)
        for t in range(kept):
            half.extend(frame(2 * t))
        self.write('half.raw', half)
        self.bcc4('import', 'half.raw', '--dims', ','.join(map(str, [*dims[:3], kept])), '--dtype', dtype, '-o', 'half.bcc4',
                  *options)
        own, others = 0., [0., 0., 0.]
        for gap in gaps:
            truth = frame(2 * gap + 1)
            self.bcc4('slice', 'half.bcc4', '--index', '--time', gap + .5, '-o', 'between.nrrd')
            own += sum((a - b) ** 2 for a, b in zip(Nrrd(self.path('between.nrrd')).values, truth))
            os.remove(self.path('between.nrrd'))
            for way, weights in enumerate((linear_weights, cubic_weights, spline_weights)):
                terms = [(w, frame(2 * f)) for f, w in enumerate(weights(gap, kept)) if abs(w) > 1e-4]
                blend = [0.] * size
                for w, samples in terms:
                    blend = [b + w * s for b, s in zip(blend, samples)]
                others[way] += sum((a - b) ** 2 for a, b in zip(blend, truth))
        return own, min(others)

    def check(self, dims, values, dtype, gaps, *options):
        own, best = self.squares(dims, values, dtype, gaps, *options)
        behind = 10 * math.log10(own / best)
        self.assertLess(behind, DECIBELS, f'{behind:.2f} dB behind')

    def test_waves(self):
        """From the first gap to the last, and better than all of them."""
        dims = (20, 18, 14, 41)
        waves = ((.5, .2, -.3, .45), (-.3, .6, .2, .35), (.2, -.4, .6, .5))
        values = array.array('f', (sum(math.cos(a * x + b * y + c * z + w * t) for a, b, c, w in waves)
                                   for t in range(dims[3]) for z in range(dims[2]) for y in range(dims[1]) for x in range(dims[0])))
        own, best = self.squares(dims, values, 'f32', range(20), '--faces', 'predict')
        self.assertLess(own, best)

    def real(self, name, read, gaps, *options):
        path = os.path.join(DATA, name)
        if not os.path.exists(path):
            self.skipTest(f'*** NO REAL DATA: {name} is not in {DATA} ***')
        self.check(*read(path), gaps, *options)

    def test_fingers(self):
        self.real('viscous_fingers_run01_64x64x64x99_u16.nrrd', nrrd_series, (0, 5, 20, 35, 48))

    def test_hurricane(self):
        self.real('isabel_windspeed_125x125x25x12_u16.nrrd', nrrd_series, range(1, 4))

    def test_perfusion(self):
        self.real('pcasl_52x68x20x10_f32.nii.gz', nifti_series, range(4))


if __name__ == '__main__':
    main()

"""Peak memory of an import does not depend on the number of frames."""
import gzip
import math
import os
import re
import subprocess
import sys

from harness import BCC4, ToolTest, main, some

N = 32
CYCLE = 25
LIMIT = '40M'


def cycle():
    """Frames of a blob that goes round, as bytes."""
    frames = []
    for t in range(CYCLE):
        centre = [N / 2 + N / 4 * math.cos(2 * math.pi * t / CYCLE), N / 2 + N / 4 * math.sin(2 * math.pi * t / CYCLE), N / 2]
        gx, gy, gz = ([math.exp(-(i - c) ** 2 / 30) for i in range(N)] for c in centre)
        frames.append(b''.join(bytes(int(230 * z * y * x) for x in gx) for z in gz for y in gy))
    return frames


def waves(n, frames):
    """A dense u8 series, every voxel of it different from air."""
    row = [[math.sin(x * k + k) for x in range(n)] for k in (.21, .37, .52)]
    for t in range(frames):
        for z in range(n):
            for y in range(n):
                a, b = row[1][(y + 2 * t) % n], row[2][(z + t) % n]
                yield bytes(int(128 + 40 * v + 40 * a + 30 * b) for v in row[0])


class Memory(ToolTest):
    store = 'samples'

    def peak(self, *args):
        """Largest resident set of one run of the tool, in bytes. With one heap, whose end goes back at once: how many threads
        come to have heaps of their own, and what lies unused in those or behind the last block, is chance."""
        process = subprocess.Popen([BCC4, *map(str, args)], cwd=self.folder, stdout=subprocess.DEVNULL,
                                   env={**os.environ, 'MALLOC_ARENA_MAX': '1', 'MALLOC_TRIM_THRESHOLD_': '131072'})
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(process.returncode, 0, args)
        return usage.ru_maxrss * 1024

    def test_four_times_the_frames(self):
        # With one thread: how much of a trial of a lattice is under way at a time is chance.
        frames = cycle()
        for count in (100, 400):
            os.mkdir(self.path(f's{count}'))
            with open(self.path(f's{count}.raw'), 'wb') as raw, gzip.open(self.path(f's{count}.raw.gz'), 'wb', 1) as packed:
                for t in range(count):
                    raw.write(frames[t % CYCLE])
                    packed.write(frames[t % CYCLE])
                    with open(self.path(f's{count}/{t}.raw'), 'wb') as f:
                        f.write(frames[t % CYCLE])
        cases = [('.raw.gz', []), ('/*.raw', []), ('.raw', []), ('.raw', ['--max-mem', LIMIT]),
                 ('.raw', ['--store', 'samples', '--max-mem', LIMIT]), ('.raw', ['--abs', 4, '--scale', 1])]
        for source, more in some(cases, 2):
            peaks, index = [], []
            for count in (100, 400):
                size = f'{N},{N},{N}' + ('' if '*' in source else f',{count}')
                peaks.append(self.peak('import', f's{count}{source}', '--dims', size, '--dtype', 'u8', '-o', 'o.bcc4',
                                       '--overwrite', '--quiet', '--threads', 1, *more))
                index.append(self.json('info', 'o.bcc4')['bytes']['index'])
            what = f'{source} {more}: {peaks[0] >> 10} KiB for 100 frames, {peaks[1] >> 10} KiB for 400'
            # The index stays in memory, as entries of 60 bytes that are packed to a fifth and less. What the lattice is
            # chosen on is a 128th of the series, up to a limit.
            sample = [max(N**3 * count // 128, 1 << 18) for count in (100, 400)]
            grows = 8 * (index[1] - index[0]) + 16 * (sample[1] - sample[0])
            self.assertLess(peaks[1], 1.15 * peaks[0] + grows, what)
            if '--max-mem' in more:
                self.assertLess(peaks[1], int(LIMIT[:-1]) << 20, what)

    def test_a_limit_too_small_is_refused_not_passed(self):
        with open(self.path('a.raw'), 'wb') as f:
            for frame in cycle()[:12]:
                f.write(frame)
        _, err = self.bcc4('import', 'a.raw', '--dims', f'{N},{N},{N},12', '--dtype', 'u8', '-o', 'o.bcc4', '--max-mem', '1M',
                           expect=4)
        self.assertIn('raise --max-mem', err)
        self.assertFalse(os.path.exists(self.path('o.bcc4')))

    def test_bytes_of_a_voxel(self):
        """What an import holds, in bytes per voxel of a frame: the window of the filter in time, a slab of layers, and what it
        takes to measure three frames; of wavelets, as without options, 16 layers as they are and as they come back."""
        n, frames = 112, 20
        with open(self.path('waves.raw'), 'wb') as raw:
            for row in waves(n, frames):
                raw.write(row)
        with open(self.path('little.raw'), 'wb') as raw:
            for row in waves(16, frames):
                raw.write(row)
        common = ('--dtype', 'u8', '-o', 'o.bcc4', '--overwrite', '--quiet', '--threads', 1)
        cases = [(('--store', 'samples', '--measure', 'none'), 60), (('--store', 'samples'), 130), ((), 110)]
        for more, most in some(cases):
            little = self.peak('import', 'little.raw', '--dims', f'16,16,16,{frames}', *common, *more)
            peak = self.peak('import', 'waves.raw', '--dims', f'{n},{n},{n},{frames}', *common, *more)
            self.assertLess((peak - little) / n ** 3, most, f'{more}: {(peak - little) / n ** 3} bytes a voxel')



if __name__ == '__main__':
    with open(BCC4, 'rb') as tool:
        if re.search(rb'__[at]san_init', tool.read()):
            sys.exit(77)  # the sanitizers hold freed memory back
    main()

"""Series imported in blocks of space and joined: the bytes of one import, and what does not fit together."""
import array
import functools
import json
import math
import os
import random
import re
import shutil
import subprocess
import time

from harness import BCC4, Nrrd, ToolTest, main, some

DIMS = (52, 40, 66, 9)


def rough(x, y, z, t):
    """A rough blob that moves through air."""
    r2 = (x - 20 - 2 * t) ** 2 / 8 + (y - 18) ** 2 / 4 + (z - 30) ** 2 / 9
    return 0 if r2 > 60 else int(200 / (1 + r2 / 9)) + (x * 7 + y * 13 + z * 29 + t * 3) % 17


@functools.cache
def series(nx, ny, nz, nt, frames=None, wide=(1, 1, 1)):
    """The blob, so many times as wide along each axis; again from its first frame on after 'frames' of them."""
    one = [bytes(rough(x // wide[0], y // wide[1], z // wide[2], t) for z in range(nz) for y in range(ny) for x in range(nx))
           for t in range(frames or nt)]
    return b''.join(one[t % len(one)] for t in range(nt))


class Blocks(ToolTest):
    made = {}  # by bounded()

    def setUp(self):
        super().setUp()
        self.write('a.raw', series(*DIMS))
        self.args = ['a.raw', '--dims', ','.join(map(str, DIMS)), '--dtype', 'u8', '--axes', 'xyzt']

    def test_memory_that_blocks_keep_is_told(self):
        noise = self.write('n.raw', random.Random(3).randbytes(3 * 96 ** 3))
        args = ('import', noise, '--dims', '96,96,96,3', '--dtype', 'u8', '--lattice', 'd4star', '--scale', 1, '--max-mem', '8M', '-o', 'n.bcc4')
        self.refused(4, 'raise --max-mem, or give --blocks, which takes less at a time', *args, output='n.bcc4')
        _, err = self.bcc4(*args, '--lowpass', expect=4)  # which holds whole frames
        self.assertIn('--blocks would take less at a time, but --lowpass holds whole frames', err)
        self.bcc4(*args, '--blocks')
        self.assertEqual(self.json('info', 'n.bcc4')['dims'], [96, 96, 96, 3])

    def block(self, box, *more):
        name = f'b{len([n for n in os.listdir(self.folder) if n.startswith("b")])}.bcc4'
        self.bcc4('import', '--plan', 'plan.json', '--block', box, *more, '-o', name, '--quiet')
        return name

    def joined_equals_one(self, args, *more):
        self.bcc4('import', *args, '--blocks', *more, '-o', 'one.bcc4', '--quiet', '--overwrite')
        self.bcc4('import', *args, '--blocks', *more, '--dry-run', '--plan', 'plan.json', '--overwrite')
        names = [self.block(',,40:'), self.block(':26,,0:40', '--part', '0-4'), self.block('26:,,:40', '--part', '0-4'),
                 self.block(',0:17,:40', '--part', '5-8'), self.block(',17:40,:40', '--part', '5-8')]
        self.bcc4('concat', *names, '-o', 'joined.bcc4', '--quiet', '--overwrite')
        self.assertEqual(self.read('joined.bcc4'), self.read('one.bcc4'), more)
        self.assertEqual(self.json('info', 'one.bcc4')['dims'], list(DIMS))
        for name in names:
            os.remove(self.path(name))

    def test_blocks_are_the_bytes_of_one_import(self):
        for more in ([], ['--lattice', 'd4star', '--scale', 1.3], ['--levels', 2]):
            self.joined_equals_one(self.args, *more)
        self.assertTrue(self.json('verify', 'joined.bcc4')['ok'])

    def test_words_and_floats(self):
        for dtype, code, scale in (('u16', 'H', 250), ('f32', 'f', .37)):
            with open(self.path('a.raw'), 'rb') as f:
                values = array.array(code, (scale * v for v in f.read()) if code == 'f' else (scale * v for v in f.read()))
            self.write('w.raw', values)
            self.joined_equals_one(['w.raw', *self.args[1:4], dtype, *self.args[5:]], '--lattice', 'd4star')

    def test_missing_values(self):
        with open(self.path('a.raw'), 'rb') as f:
            values = array.array('f', map(float, f.read()))
        n = DIMS[:3]
        for i in range(len(values)):
            x, y, z = i % n[0], i // n[0] % n[1], i // (n[0] * n[1]) % n[2]
            if x + y // 2 < 14 or (x - 30) ** 2 + (y - 17) ** 2 + (z - 41) ** 2 < 90 or (z < 40 and x < 26 and i > len(values) // 2):
                values[i] = float('nan')
        self.write('w.raw', values)
        args = ['w.raw', *self.args[1:4], 'f32', *self.args[5:]]
        self.joined_equals_one(args, '--on-nonfinite', 'hole')
        self.assertEqual(self.json('info', 'one.bcc4')['channels'][0]['missing'], sum(v != v for v in values))
        # Two frames one above the other, so that it can be divided.
        self.write('w.raw', values[:8 * n[0] * n[1] * n[2]])
        args = ['w.raw', '--dims', f'{n[0]},{n[1]},{2 * n[2]},4', '--dtype', 'f32', '--blocks', '--on-nonfinite', 'hole', '--levels', 1]
        self.bcc4('import', *args, '-o', 'one.bcc4', '--quiet', '--overwrite')
        said = self.bcc4('import', *args, '-o', 'two.bcc4', '--max-mem', '20M')[0]
        self.assertIn('block 2 of', said)
        self.assertEqual(self.read('two.bcc4'), self.read('one.bcc4'))

    def test_numbered_parts_are_boxes(self):
        self.write('still.raw', bytes(rough(x, y, z, 3) for z in range(DIMS[2]) for y in range(DIMS[1]) for x in range(DIMS[0])))
        args = ['still.raw', '--dims', ','.join(map(str, DIMS[:3])), '--dtype', 'u8', '--blocks']
        self.bcc4('import', *args, '-o', 'one.bcc4', '--quiet')
        self.bcc4('import', *args, '--dry-run', '--plan', 'plan.json')
        names = []
        for k in range(1, 7):
            names.append(f'b{k}.bcc4')
            self.bcc4('import', '--plan', 'plan.json', '--part', f'{k}/6', '-o', names[-1], '--quiet')
        self.bcc4('concat', *names, '-o', 'joined.bcc4', '--quiet')
        self.assertEqual(self.read('joined.bcc4'), self.read('one.bcc4'))
        self.refused(2, 'the first of 6', 'import', '--plan', 'plan.json', '--part', '7/6', '-o', 'x.bcc4', output='x.bcc4')

    def large(self):
        """Arguments of a series whose import takes more than 24 MiB."""
        dims = (120, 100, 196, 5)
        self.write('large.raw', series(*dims, frames=2, wide=(2, 2, 3)))
        return ['large.raw', '--dims', ','.join(map(str, dims)), '--dtype', 'u8', '--blocks', '--exact', '--lattice', 'd4star']

    def bounded(self, *more):
        """The report and the bytes of a large series with a bound, imported once for all tests."""
        made = type(self).made
        if more not in made:
            report = self.json('import', *self.large(), '--scale', 1.1, '--abs', 2, *more, '-o', 'made.bcc4', '--overwrite')
            made[more] = report, self.read('made.bcc4')
        return made[more]

    def left(self, what=r'\.block'):
        return [n for n in os.listdir(self.folder) if re.search(what, n)]

    def test_an_import_without_memory_divides_itself(self):
        args = self.large()
        self.bcc4('import', *args, '-o', 'one.bcc4', '--quiet')
        said = self.bcc4('import', *args, '-o', 'two.bcc4', '--max-mem', '24M')[0]
        self.assertIn('block 2 of', said)
        self.assertEqual(self.read('two.bcc4'), self.read('one.bcc4'))
        self.assertEqual(self.left(), [])
        self.bcc4('import', *args, '--quiet', '--max-mem', '8M', '-o', 'three.bcc4')
        self.assertEqual(self.read('three.bcc4'), self.read('one.bcc4'))

    def test_a_series_of_blocks_goes_on_as_it_was_made(self):
        """What is smooth would have other samples predicted outside its faces than blocks have."""
        dims = (30, 28, 26, 12)

        def frames(count):
            return array.array('f', (100 + 40 * math.cos(.3 * x + .2 * y - .25 * z) * math.cos(.3 * t)
                                     for t in range(count) for z in range(dims[2]) for y in range(dims[1]) for x in range(dims[0])))

        args = ['w.raw', '--dtype', 'f32', '--exact', '--lattice', 'd4star', '--scale', 1, '--air', 0, '--quiet']
        made = ['--blocks', '--ends', 'mirror', '--faces', 'predict', '--levels', 'none']
        size = ','.join(map(str, dims[:3]))
        self.write('w.raw', frames(9))
        self.bcc4('import', *args, *made, '--dims', size + ',9', '-o', 'grown.bcc4')
        self.write('w.raw', frames(12))
        self.bcc4('import', *args, *made, '--dims', size + ',12', '-o', 'one.bcc4')
        self.bcc4('import', *args, '--dims', size + ',12', '--append', '-o', 'grown.bcc4')
        for name in ('one', 'grown'):
            self.bcc4('export', name + '.bcc4', '--all', '-o', name + '.nrrd', '--quiet')
        self.assertEqual(Nrrd(self.path('grown.nrrd')).values, Nrrd(self.path('one.nrrd')).values)
        self.assertEqual(self.json('info', 'grown.bcc4')['attributes']['import.predictions'], 'fixed')  # and so on

    def test_without_a_limit_all_is_one_block(self):
        said = self.bcc4('import', *self.args, '--blocks', '-o', 'one.bcc4')[0]
        self.assertNotIn('block 1 of', said)
        self.assertEqual(self.left(), [])

    def test_levels_tell_what_they_lose(self):
        self.bcc4('import', *self.args, '--blocks', '--levels', 1, '-o', 'one.bcc4', '--quiet')
        self.assertGreater(self.json('info', 'one.bcc4')['levels'][0]['relative_rmse'], 0)

    def test_a_frame_larger_than_its_memory_needs_no_option(self):
        args = [a for a in self.large() if a not in ('--blocks', '--exact', '--lattice', 'd4star')]
        small = ['--max-mem', '8M']  # a quarter of it is less than a frame
        self.bcc4('import', *args, '--blocks', '-o', 'one.bcc4', '--quiet')
        said = self.bcc4('import', *args, '-o', 'two.bcc4', *small)[0]
        self.assertIn('block 2 of', said)
        self.assertEqual(self.read('two.bcc4'), self.read('one.bcc4'))  # the lattice and steps among it
        whole, planes = (self.json('import', *args, '--blocks', '--dry-run', *more) for more in ([], small))
        for key in ('channels', 'spectrum', 'motion', 'choice', 'round', 'levels'):
            self.assertEqual(planes[key], whole[key], key)
        self.refused(4, '--lowpass holds whole frames: raise --max-mem', 'import', *args, '--lowpass', *small, '-o', 'three.bcc4',
                     output='three.bcc4')

    def test_floats_and_ranges_are_read_by_planes(self):
        self.large()
        with open(self.path('large.raw'), 'rb') as f:
            self.write('w.raw', array.array('f', (90 + .37 * v for v in f.read(2 * 120 * 100 * 196))))
        args = ['w.raw', '--dims', '120,100,196,2', '--dtype', 'f32', '--blocks', '--quantize', 'u16']
        self.bcc4('import', *args, '-o', 'one.bcc4', '--quiet')
        self.bcc4('import', *args, '-o', 'two.bcc4', '--quiet', '--max-mem', '36M')
        self.assertEqual(self.read('two.bcc4'), self.read('one.bcc4'))

    def test_errors_are_measured_and_bounds_kept(self):
        lattice = ['--lattice', 'd4star', '--scale', 1.1]
        for more in some([['--abs', 1], ['--psnr', 30], ['--measure', 'all']], 2):
            self.joined_equals_one(self.args, *lattice, *more)

    def test_a_bound_without_memory_for_frames(self):
        """What blocks measured is told of the series."""
        whole, one = self.bounded()
        blocks, divided = self.bounded('--max-mem', '24M')
        self.assertEqual(divided, one)
        self.assertEqual(blocks['error']['frames_measured'], whole['error']['frames_measured'])
        for key in ('max_abs', 'worst', 'corrected', 'samples_compared', 'compared_part', 'uncorrected_max_abs', 'peak'):
            self.assertEqual(blocks['error']['channels'][0][key], whole['error']['channels'][0][key], key)
        self.assertAlmostEqual(blocks['error']['channels'][0]['psnr'], whole['error']['channels'][0]['psnr'], 9)
        self.assertGreater(whole['error']['channels'][0]['corrected'], 0)
        self.write('blocks.bcc4', divided)
        self.assertTrue(self.json('verify', 'blocks.bcc4', '--against', *self.large()[:5])['ok'])

    def test_a_psnr_that_is_missed_is_written_again(self):
        args = [*(a for a in self.large() if a != '--exact'), '--scale', 1.1]  # a search is another test's
        self.bcc4('import', *args, '--psnr', 38, '--dry-run', '--plan', 'plan.json')
        with open(self.path('plan.json')) as f:
            plan = json.load(f)
        for settings in plan['settings']:  # more than their steps keep
            settings['psnr'] += 4
            settings['abs_error'] *= 10 ** (-4 / 20)
            settings['abs_errors'] = [error * 10 ** (-4 / 20) for error in settings['abs_errors']]
        with open(self.path('plan.json'), 'w') as f:
            json.dump(plan, f)
        for name, more in (('one.bcc4', []), ('blocks.bcc4', ['--max-mem', '40M'])):
            said = self.bcc4('import', '--plan', 'plan.json', '-o', name, *more)[0]
            self.assertIn('again with', said)
        self.assertIn('block 2 of', said)
        self.assertEqual(self.read('blocks.bcc4'), self.read('one.bcc4'))
        self.assertGreaterEqual(self.json('verify', 'blocks.bcc4', '--against', *args[:5])['psnr'], 42)
        self.assertEqual(self.left(), [])

    def test_a_killed_import_goes_on_with_its_blocks(self):
        args = self.large()
        self.bcc4('import', *args, '-o', 'one.bcc4', '--quiet')
        command = ['import', *args, '-o', 'x.bcc4', '--max-mem', '24M', '--resume']
        with subprocess.Popen([BCC4, *command], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as p:
            while not self.left(r'\.block1of\d+\.[0-9a-f]{8}$') and p.poll() is None:
                time.sleep(.005)
            p.kill()
        self.assertFalse(os.path.exists(self.path('x.bcc4')), 'it was too late to kill it')
        self.assertIn(' is there', self.bcc4(*command)[0])
        self.assertEqual(self.read('x.bcc4'), self.read('one.bcc4'))
        self.assertEqual(self.left(), [])

    def test_a_full_disk_leaves_the_blocks_that_are_finished(self):
        args = self.large()
        self.bcc4('import', *args, '-o', 'one.bcc4', '--quiet')
        command = ['import', *args, '-o', 'x.bcc4', '--max-mem', '24M']
        limit = len(self.read('one.bcc4')) * 3 // 4  # which blocks do not need, and what is joined does
        said = self.full_disk(limit, *command)
        self.assertIn('x.bcc4', said)
        self.assertIn('finished blocks stay', said)
        self.assertFalse(os.path.exists(self.path('x.bcc4')))
        # Blocks of other options do not stand for these.
        other = ['import', *args, '--air-threshold', 3, '--max-mem', '24M', '-o', 'other.bcc4']
        self.bcc4(*other)
        os.rename(self.path('other.bcc4'), self.path('right.bcc4'))
        for name in self.left():
            shutil.copy(self.path(name), self.path(name.replace('x.bcc4', 'other.bcc4')))
        self.assertNotIn('is there', self.bcc4(*other, '--resume')[0])
        self.assertEqual(self.read('other.bcc4'), self.read('right.bcc4'))
        self.assertNotIn('import ', self.bcc4(*command, '--resume')[0].split('block 1 of')[1].split('is there')[0])
        self.assertEqual(self.read('x.bcc4'), self.read('one.bcc4'))

    def test_blocks_that_are_there_tell_their_errors(self):
        args = [*self.large(), '--scale', 1.1, '--abs', 2, '--max-mem', '24M']
        whole, one = self.bounded('--max-mem', '24M')
        command = list(map(str, ['import', *args, '-o', 'x.bcc4']))
        limit = len(one) * 3 // 4  # which blocks do not need, and what is joined does
        self.assertIn('finished blocks stay', self.full_disk(limit, *command))
        kept = {n: self.read(n) for n in self.left()}
        self.assertEqual(self.json(*command, '--resume')['error'], whole['error'])
        self.assertEqual(self.read('x.bcc4'), one)
        self.assertEqual(self.left(), [])
        # One whose errors are not known is written again.
        results = sorted(n for n in kept if n.endswith('.result'))
        self.assertGreater(len(results), 1)
        for name, data in kept.items():
            self.write(name, data[:len(data) - 9] if name == results[0] else data)
        said = self.bcc4(*command, '--resume', '--overwrite')[0]
        self.assertEqual(said.count(' is there'), len(results) - 1)
        self.assertEqual(self.read('x.bcc4'), one)

    def test_what_does_not_fit_is_refused(self):
        self.bcc4('import', *self.args, '--blocks', '--dry-run', '--plan', 'plan.json')
        run = ['import', '--plan', 'plan.json', '-o', 'x.bcc4']
        for box, text in (('0:60,,', 'from 0 to 52'), ('9:9,,', 'from 0 to 52'), ('1:2,3:4', 'X0:X1'), ('5,,', 'no colon'),
                          ('a:9,,', 'a number is expected')):
            self.refused(2, text, *run, '--block', box, output='x.bcc4')
        self.refused(2, '--block needs the --plan', 'import', *self.args, '--block', ',,0:9', '-o', 'x.bcc4', output='x.bcc4')
        for more, text in ((['--lowpass'], 'holds whole frames'), (['--store', 'wavelets'], 'step of wavelets'),
                           (['--periodic', 'x'], 'far away')):
            self.refused(2, text, 'import', *self.args, '--blocks', *more, '-o', 'x.bcc4', output='x.bcc4')
        a, b = self.block(',,:40'), self.block(',,40:')
        self.refused(2, 'x 0:52, y 0:40, z 40:66 of 9 are in none of the parts', 'concat', a, '-o', 'x.bcc4', output='x.bcc4')
        self.refused(2, f'z 40:66 are both in {b} and in {b}', 'concat', a, b, b, '-o', 'x.bcc4', output='x.bcc4')
        self.bcc4('import', *self.args, '--dry-run', '--lattice', 'd4star', '--ends', 'predict', '--measure', 'none', '--levels',
                  'none', '--plan', 'other.json')
        self.refused(2, 'fixed_predictions', 'import', '--plan', 'other.json', '--block', ',,:40', '-o', 'x.bcc4', output='x.bcc4')


if __name__ == '__main__':
    main()

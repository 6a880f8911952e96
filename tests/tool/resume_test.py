"""bcc4 import that is killed, interrupted, resumed and appended to. BCCSPLAT_KILLS sets how often it is killed."""
import fcntl
import os
import random
import re
import signal
import struct
import subprocess
import time
import zlib

from harness import BCC4, Nrrd, ToolTest, main

N, FRAMES = 40, 48


def without_record(data, record):
    """A .bcc4 as older writers made it: metadata without a record, uncompressed behind all else."""
    def crc(part):
        return struct.pack('<I', zlib.crc32(part))

    offset, stored, decoded, _, coding = struct.unpack_from('<QIIII', data, 64 + 24)
    block = data[offset:offset + stored]
    metadata = zlib.decompress(block, -15) if coding else block
    records, at = b'', 0
    while at < decoded:
        kind, _, size = struct.unpack_from('<HHI', metadata, at)
        end = at + 8 + (size + 7) // 8 * 8
        records += metadata[at:end] if kind != record else b''
        at = end
    assert len(records) < len(metadata), 'there is no such record'
    out = bytearray(data + records)
    root = 64
    out[root + 16:root + 24] = struct.pack('<Q', len(out))
    out[root + 24:root + 48] = struct.pack('<QII', len(data), len(records), len(records)) + crc(records) + bytes(4)
    out[root + 124:root + 128] = crc(out[root:root + 124])
    return bytes(out)


def end_of_options(journal):
    """Where a journal's first slab goes: behind 16 bytes and a record of u32 length, u32 checksum and the options."""
    return 24 + struct.unpack_from('<I', journal, 16)[0] if len(journal) >= 24 else len(journal)


# Otherwise the first frames and all of them may choose differently.
FIXED = ('--lattice', 'd4star', '--exact')


class Resume(ToolTest):
    store = 'samples'

    def setUp(self):
        super().setUp()
        # Noise does not compress: many commits.
        self.data = random.Random(1).randbytes(N * N * N * FRAMES)
        self.write('a.raw', self.data)
        self.dims = ['--dims', f'{N},{N},{N},{FRAMES}', '--dtype', 'u8', *FIXED]

    def run_import(self, *more, expect=0, output='x.bcc4'):
        return self.bcc4('import', 'a.raw', *self.dims, '-o', output, *more, expect=expect)

    def undisturbed(self, *more):
        began = time.monotonic()
        self.run_import('--quiet', *more, output='whole.bcc4')
        self.seconds = time.monotonic() - began
        return self.read('whole.bcc4')

    def lists_a_slab(self):
        if not os.path.exists(self.path('x.bcc4.journal')):
            return False
        journal = self.read('x.bcc4.journal')
        return len(journal) > end_of_options(journal)

    def started(self, *more):
        return subprocess.Popen([BCC4, 'import', 'a.raw', *self.dims, '-o', 'x.bcc4', *more], cwd=self.folder,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def killed_at_any_moment(self, *options):
        whole = self.undisturbed(*options)
        moments = random.Random(7)
        kills = int(os.environ.get('BCCSPLAT_KILLS', 8))
        early = reused = 0
        for kill in range(kills):
            # Every second time the resumed import is killed as well.
            for more in ([], ['--resume'])[:1 + kill % 2]:
                p = self.started(*options, *more)
                time.sleep(moments.uniform(0, 1.1 * self.seconds))
                p.kill()
                p.communicate()
                if os.path.exists(self.path('x.bcc4')):
                    break
                early += 1
            if os.path.exists(self.path('x.bcc4')):  # it was too late to kill it
                self.assertEqual(self.read('x.bcc4'), whole)
            else:
                reused += self.lists_a_slab()
                self.run_import('--resume', '--quiet', *options)
                self.assertEqual(self.read('x.bcc4'), whole, f'kill {kill}')
            self.assertEqual([n for n in os.listdir(self.folder) if n.startswith('x.')], ['x.bcc4'])
            os.remove(self.path('x.bcc4'))
        self.assertGreater(early, 0)
        if kills >= 8:
            self.assertGreater(reused, 0, 'no kill left anything to go on from')

    def test_killed_at_any_moment(self):
        self.killed_at_any_moment()

    def test_levels_killed_at_any_moment(self):
        self.killed_at_any_moment('--levels', '1')
        level, = self.json('info', 'whole.bcc4')['levels']
        self.assertGreater(level['bytes'], 100_000)

    def test_looked_at_while_it_is_written(self):
        whole = self.undisturbed('--live', '1')
        p = self.started('--live', '1')
        while p.poll() is None and subprocess.run([BCC4, 'info', self.path('x.bcc4.partial')],
                                                  capture_output=True).returncode != 0:
            time.sleep(.001)
        if p.poll() is not None:
            self.skipTest('it was faster than a look at it')
        p.kill()
        p.communicate()
        shown = self.json('info', 'x.bcc4.partial')['unfinished']
        self.assertEqual(shown['expected'], FRAMES)
        last = shown['frames'] - 1
        self.assertIn(f'{last + 1} of {FRAMES} frames can be looked at', self.bcc4('info', 'x.bcc4.partial')[0])
        self.bcc4('verify', 'x.bcc4.partial')
        for moment in 0, last / 2, last:
            for name in 'x.bcc4.partial', 'whole.bcc4':
                self.bcc4('slice', name, '--time', str(moment), '-o', name + '.nrrd')
            self.assertEqual(Nrrd(self.path('x.bcc4.partial.nrrd')).values, Nrrd(self.path('whole.bcc4.nrrd')).values)
        self.refused(2, f'from 0 to {last}', 'slice', 'x.bcc4.partial', '--time', str(last + .5), '-o', 'y.nrrd')
        self.bcc4('render', 'x.bcc4.partial', '--time', str(last), '--size', '64x64', '-o', 'x.png')
        self.bcc4('export', 'x.bcc4.partial', '--all', '-o', 'all.nrrd')
        self.assertEqual(Nrrd(self.path('all.nrrd')).sizes[3], last + 1)
        for name in 'x.bcc4.partial.nrrd', 'x.png':
            os.remove(self.path(name))
        self.run_import('--resume', '--quiet', '--live', '1')
        self.assertEqual(self.read('x.bcc4'), whole)

    def test_ctrl_c_says_how_to_go_on(self):
        self.dims = [*self.dims[:-len(FIXED)], '--store', 'samples']  # what was chosen is chosen again
        whole = self.undisturbed()
        p = self.started()
        while p.poll() is None:  # until something is worth keeping
            if self.lists_a_slab():
                p.send_signal(signal.SIGINT)
                break
            time.sleep(.001)
        _, err = p.communicate()
        if p.returncode == 0:
            self.skipTest('it was faster than the signal')
        self.assertEqual(p.returncode, 130, err)
        self.assertIn('--resume goes on from there', err)
        self.assertFalse(os.path.exists(self.path('x.bcc4')))
        # With other options or another source it is not the same import.
        self.refused(2, 'made with other options (', 'import', 'a.raw', *self.dims, '--lowpass', '-o', 'x.bcc4', '--resume')
        os.rename(self.path('a.raw'), self.path('b.raw'))
        self.write('a.raw', bytes(len(self.data)))
        self.refused(2, 'the unfinished file was made', 'import', 'a.raw', *self.dims, '-o', 'x.bcc4',
                     '--resume')
        os.rename(self.path('b.raw'), self.path('a.raw'))
        self.run_import('--resume', '--quiet')
        self.assertEqual(self.read('x.bcc4'), whole)

    def test_work_that_is_begun_anew_is_told(self):
        def has_work(live):
            if live:
                return subprocess.run([BCC4, 'info', self.path('x.bcc4.partial')], capture_output=True).returncode == 0
            return self.lists_a_slab()

        for live in (), ('--live', '1'):
            whole = self.undisturbed(*live, '--overwrite')
            p = self.started(*live)
            while p.poll() is None and not has_work(live):
                time.sleep(.001)
            p.kill()
            p.communicate()
            if os.path.exists(self.path('x.bcc4')):
                self.skipTest('it was faster than the signal')
            kept = {n: self.read(n) for n in ('x.bcc4.partial', 'x.bcc4.journal')}
            for more, told in (['--resume'], False), (['--quiet'], False), ([], True):
                for name, data in kept.items():
                    self.write(name, data)
                _, err = self.run_import(*live, *more)
                self.assertEqual(bool(re.search(r'x\.bcc4\.partial of an import that did not end \([0-9.]+ [KM]iB.*\) is begun anew; '
                                                r'--resume would have', err)), told, err)
                self.assertEqual(f' of {FRAMES} frames)' in err, told and bool(live), err)
                self.assertEqual(self.read('x.bcc4'), whole)
                os.remove(self.path('x.bcc4'))
        # A journal without a slab is no work.
        for name, data in kept.items():
            self.write(name, data[:end_of_options(data)] if name.endswith('.journal') else data)
        self.assertNotIn('begun anew', self.run_import()[1])

    def test_a_full_disk_keeps_what_can_be_gone_on_with(self):
        whole = self.undisturbed()
        for limit, kept in (20_000, False), (800_000, True):  # bytes: less than a slab, and more
            said = self.full_disk(limit, 'import', 'a.raw', *self.dims, '--store', 'samples', '-o', 'x.bcc4')
            self.assertEqual('--resume goes on from there' in said, kept, said)
            self.assertEqual(sorted(n for n in os.listdir(self.folder) if n.startswith('x.')),
                             ['x.bcc4.journal', 'x.bcc4.partial'] if kept else [])
        self.run_import('--resume', '--quiet')
        self.assertEqual(self.read('x.bcc4'), whole)

    def test_another_writer_keeps_its_file(self):
        with open(self.write('x.bcc4.partial', b'begun'), 'rb') as f:
            fcntl.flock(f, fcntl.LOCK_EX)
            self.refused(2, 'another writer is at work', 'import', 'a.raw', *self.dims, '-o', 'x.bcc4', output='x.bcc4')
        self.assertEqual(self.read('x.bcc4.partial'), b'begun')
        os.remove(self.path('x.bcc4.partial'))

    def test_resume_with_nothing_to_resume_begins(self):
        whole = self.undisturbed()
        self.run_import('--resume', '--quiet')
        self.assertEqual(self.read('x.bcc4'), whole)

    def test_appended_frames_make_the_same_file(self):
        whole = self.undisturbed()
        first = 29
        self.write('first.raw', self.data[:N * N * N * first])
        self.bcc4('import', 'first.raw', '--dims', f'{N},{N},{N},{first}', '--dtype', 'u8', *FIXED, '-o', 'x.bcc4', '--quiet')
        self.run_import('--append', '--quiet')
        self.assertEqual(self.read('x.bcc4'), whole)
        self.assertEqual(self.json('info', 'x.bcc4')['dims'], [N, N, N, FRAMES])

    def test_append_reads_new_frames_and_the_last_ones_before(self):
        frames = [self.data[i:i + N * N * N] for i in range(0, len(self.data), N * N * N)]
        for i, frame in enumerate(frames):
            self.write(f'f.{i:03}.raw', frame)
        one = ['--dims', f'{N},{N},{N}', '--dtype', 'u8', *FIXED, '--dt', '0.5']
        self.bcc4('import', 'f.*.raw', *one, '-o', 'whole.bcc4', '--quiet')
        first = 29
        self.bcc4('import', *[f'f.{i:03}.raw' for i in range(first)], *one, '-o', 'old.bcc4', '--quiet')
        old, whole = self.read('old.bcc4'), self.read('whole.bcc4')

        def append(*more):
            return self.json('import', 'f.*.raw', *one, '-o', 'x.bcc4', '--append', *more)

        self.write('x.bcc4', old)
        begin, last = append()['appended']['read']
        self.assertEqual(last, FRAMES - 1)
        self.assertTrue(10 <= begin < first, begin)
        self.assertEqual(self.read('x.bcc4'), whole)
        self.assertEqual(self.bcc4('import', 'f.*.raw', *one, '-o', 'x.bcc4', '--append')[0].count('already'), 1)
        self.assertEqual(self.read('x.bcc4'), whole)
        # In two steps; and a file that does not tell where its samples were clamped takes all frames.
        self.write('x.bcc4', old)
        self.bcc4('import', *[f'f.{i:03}.raw' for i in range(40)], *one, '-o', 'x.bcc4', '--append', '--quiet')
        append()
        self.assertEqual(self.read('x.bcc4'), whole)
        self.write('x.bcc4', without_record(old, 0x8004))
        self.assertIn('reading all frames', self.bcc4('import', 'f.*.raw', *one, '-o', 'x.bcc4', '--append')[0])
        self.assertEqual(self.read('x.bcc4'), whole)
        # A forgotten --dt is no new one.
        self.write('x.bcc4', old)
        self.refused(2, 'its frame 1 is at time 0.5', 'import', 'f.*.raw', *one[:-2], '-o', 'x.bcc4', '--append')
        self.assertEqual(self.read('x.bcc4'), old)
        # Another series is pointed out.
        os.rename(self.path('f.000.raw'), self.path('e.000.raw'))
        _, err = self.bcc4('import', 'e.000.raw', *[f'f.{i:03}.raw' for i in range(1, FRAMES)], *one, '-o', 'x.bcc4', '--append', '--quiet')
        self.assertIn('frame 0 was made of f.000.raw', err)
        os.rename(self.path('e.000.raw'), self.path('f.000.raw'))
        # What was read before stays as it was, whatever became of its files.
        for i in range(begin):
            self.write(f'f.{i:03}.raw', bytes(N * N * N))
        self.write('x.bcc4', old)
        append()
        self.assertEqual(self.read('x.bcc4'), whole)

    def test_interrupted_append_leaves_the_old_file(self):
        first = 29
        self.write('first.raw', self.data[:N * N * N * first])
        self.bcc4('import', 'first.raw', '--dims', f'{N},{N},{N},{first}', '--dtype', 'u8', *FIXED, '-o', 'x.bcc4', '--quiet')
        old = self.read('x.bcc4')
        whole = self.undisturbed()
        moments, early = random.Random(3), 0
        kills = max(6, int(os.environ.get('BCCSPLAT_KILLS', 8)) // 2 * 2)
        for stop in [signal.SIGKILL, signal.SIGINT] * (kills // 2):
            p = self.started('--append')
            time.sleep(moments.uniform(0, .6 * self.seconds))
            p.send_signal(stop)
            p.communicate()
            early += p.returncode != 0
            self.assertIn(self.read('x.bcc4'), (old, whole))
            self.write('x.bcc4', old)
        self.assertGreater(early, 0)
        self.run_import('--append', '--quiet')
        self.assertEqual(self.read('x.bcc4'), whole)
        self.assertEqual([n for n in os.listdir(self.folder) if n.startswith('x.')], ['x.bcc4'])

    def test_appended_frames_behind_a_low_pass_make_the_same_file(self):
        # The low-pass reaches 30 frames further: only the first slab is copied.
        self.dims.append('--lowpass')
        whole = self.undisturbed()
        first = 43
        self.write('first.raw', self.data[:N * N * N * first])
        self.bcc4('import', 'first.raw', '--dims', f'{N},{N},{N},{first}', '--dtype', 'u8', *FIXED, '--lowpass', '-o', 'x.bcc4',
                  '--quiet')
        self.run_import('--append', '--quiet')
        self.assertEqual(self.read('x.bcc4'), whole)

    def test_append_refuses_what_does_not_go_on(self):
        self.run_import('--append', '--quiet', expect=3)  # nothing to append to
        self.run_import('--quiet')
        old = self.read('x.bcc4')
        self.write('other.raw', bytes(8 * N * N * FRAMES))
        self.bcc4('import', 'other.raw', '--dims', f'8,{N},{N},{FRAMES}', '--dtype', 'u8', *FIXED, '-o', 'x.bcc4', '--append',
                  expect=2)
        self.run_import('--append', '--resume', expect=2)
        # Frames filtered in another way would not fit to those that are copied.
        self.refused(2, 'the new ones would be with', 'import', 'a.raw', *self.dims, '-o', 'x.bcc4', '--append', '--lowpass')
        self.assertEqual(self.read('x.bcc4'), old)
        # Nor are options taken that would be heard by nobody, or other places.
        self.write('b.raw', self.data[:N * N * N * (FRAMES - 1)])
        self.bcc4('import', 'b.raw', '--dims', f'{N},{N},{N},{FRAMES - 1}', *self.dims[2:], '-o', 'x.bcc4', '--quiet', '--overwrite')
        old = self.read('x.bcc4')
        open_lattice = ['--dims', f'{N},{N},{N},{FRAMES}', '--dtype', 'u8', '-o', 'x.bcc4', '--append']
        for option, other in (('--ends', 'mirror'), ('--faces', 'x'), ('--periodic', 'y')):
            for lattice in [], FIXED:
                self.refused(2, f'{option}: x.bcc4 goes on as it was made', 'import', 'a.raw', *open_lattice, option, other, *lattice)
        self.refused(2, 'its samples lie up to', 'import', 'a.raw', *open_lattice, '--spacing', '1,1,2')
        self.assertEqual(self.read('x.bcc4'), old)
        self.bcc4('import', 'a.raw', *open_lattice, '--ends', 'predict')

    def test_appended_frames_stand_where_the_others_do(self):
        """An input that says nothing of places changes none, and how frames were chosen is told anew."""
        half = self.data[:N * N * N * (FRAMES - 8)]
        place = ['--spacing', '2,2,3', '--origin', '5,6,7']
        self.write('b.raw', half)
        self.bcc4('import', 'b.raw', '--dims', f'{N},{N},{N},{FRAMES - 8}', *self.dims[2:], *place, '--frames', '0-9', '-o', 'x.bcc4', '--quiet')
        before = self.json('info', 'x.bcc4')
        self.run_import('--append', '--quiet')
        after = self.json('info', 'x.bcc4')
        self.assertEqual(after['affine'], before['affine'])
        self.assertEqual(after['dims'][3], FRAMES)
        self.assertNotIn('import.frames', after['attributes'])
        self.assertTrue(self.json('verify', 'x.bcc4', '--against', 'a.raw', *self.dims[:4])['ok'])


if __name__ == '__main__':
    main()

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""windows_test.py FOLDER COMMAND...: what the tool does with names, large files and interruptions where these are Windows'
(under Wine), or, with this machine's own tool as COMMAND, here. BCCSPLAT_HOST and BCCSPLAT_DLL name a host that loads the
library twenty times, and the library."""
import os
import shlex
import signal
import struct
import subprocess
import sys
import time
import unittest

FOLDER, COMMAND = '', []
DIMS = (16, 14, 12, 10)
UMLAUTS = 'Ordner mit Größe €'


class Windows(unittest.TestCase):
    def setUp(self):
        self.folder = os.path.join(FOLDER, UMLAUTS, self._testMethodName)
        os.makedirs(self.folder, exist_ok=True)
        for name in os.listdir(self.folder):
            os.remove(self.path(name))

    def path(self, name):
        return os.path.join(self.folder, name)

    def bcc4(self, *words, code=0, cwd=None):
        done = subprocess.run([*COMMAND, *map(str, words)], cwd=cwd or self.folder, capture_output=True, check=False)
        said = (done.stdout + done.stderr).decode('utf-8', 'replace')
        self.assertEqual(done.returncode, code, said)
        return said

    def series(self, name, dims=DIMS, skip=0):
        count = dims[0] * dims[1] * dims[2] * dims[3]
        with open(self.path(name), 'wb') as f:
            f.seek(skip)  # a hole, which takes no room
            f.write(struct.pack(f'<{count}H', *(1000 + i * 7919 % 500 for i in range(count))))
        return [name, '--dims', ','.join(map(str, dims)), '--dtype', 'u16', '--lattice', 'd4star']

    def test_names_with_umlauts_and_spaces(self):
        self.bcc4('import', *self.series('Größe und Maß.raw'), '-o', 'Ergebnis für €.bcc4')
        self.assertIn('Ergebnis für €.bcc4', os.listdir(self.folder))
        self.assertIn('16', self.bcc4('info', 'Ergebnis für €.bcc4'))
        inside = self.bcc4('info', os.path.join(UMLAUTS, self._testMethodName, 'Ergebnis für €.bcc4'), cwd=FOLDER)
        self.assertIn('16', inside)
        self.bcc4('export', 'Ergebnis für €.bcc4', '--all', '-o', 'äöü %04d.raw')
        self.assertEqual(sum(name.startswith('äöü ') for name in os.listdir(self.folder)), DIMS[3])
        self.bcc4('verify', 'Ergebnis für €.bcc4')
        said = self.bcc4('info', 'fehlt für immer.bcc4', code=3)
        self.assertIn('fehlt für immer.bcc4', said)
        for more in ['Bild für €.png'], ['Bild für €.exr'], ['darüber.png', '--over', 'Bild für €.exr']:
            self.bcc4('render', 'Ergebnis für €.bcc4', '--time', '1', '--size', '32x32', '-o', *more)
            self.assertGreater(os.path.getsize(self.path(more[0])), 100)

    def test_wildcards_and_numbers(self):
        for t in range(4):
            self.series(f'ä [{t}] {t:02}.raw', (*DIMS[:3], 1))
        more = ['--dims', ','.join(map(str, DIMS[:3])), '--dtype', 'u16']
        self.bcc4('import', 'ä ?*[0-2].raw', *more, '-o', 'glob.bcc4')
        self.assertRegex(self.bcc4('info', 'glob.bcc4'), r'\b3 frames|16 x 14 x 12 x 3|x 3\b')
        self.series('b.0001.raw', (*DIMS[:3], 1))
        self.series('b.0002.raw', (*DIMS[:3], 1))
        self.bcc4('import', 'b.%04d.raw', *more, '-o', 'pattern.bcc4')

    def test_a_series_that_goes_on(self):
        more = ['--dims', ','.join(map(str, DIMS[:3])), '--dtype', 'u16', '--lattice', 'd4star']
        for begin, end, words in (0, 24, ['-o', 'a.bcc4']), (24, 32, ['-o', 'a.bcc4', '--append']), (0, 0, ['-o', 'b.bcc4']):
            for t in range(begin, end):
                self.series(f's.{t:04}.raw', (*DIMS[:3], 1))
            self.bcc4('import', 's.%04d.raw', *more, *words)
        self.assertRegex(self.bcc4('info', 'a.bcc4'), r'\b32 frames')

    def test_nothing_is_overwritten_unasked(self):
        words = self.series('a.raw')
        self.bcc4('import', *words, '-o', 'a.bcc4')
        self.assertIn('exists already', self.bcc4('import', *words, '-o', 'a.bcc4', code=2))
        self.bcc4('import', *words, '-o', 'a.bcc4', '--overwrite')
        self.assertEqual(sorted(os.listdir(self.folder)), ['a.bcc4', 'a.raw'])

    def test_beyond_four_gigabytes(self):
        skip = (5 << 30) + 2
        words = self.series('large.raw', skip=skip)
        self.bcc4('import', *words, '--skip', skip, '-o', 'large.bcc4')
        self.bcc4('import', *self.series('small.raw'), '-o', 'small.bcc4')
        for name in 'large', 'small':
            self.bcc4('export', f'{name}.bcc4', '--all', '-o', f'{name}.out.raw', '--format', 'raw')
        with open(self.path('large.out.raw'), 'rb') as a, open(self.path('small.out.raw'), 'rb') as b:
            self.assertEqual(a.read(), b.read())
        os.remove(self.path('large.raw'))

    def test_a_full_disk(self):
        """On a file system of half a MiB, which is mounted for the test."""
        disk = self.path('voll')
        os.makedirs(disk, exist_ok=True)
        if subprocess.run(['mount', '-t', 'tmpfs', '-o', 'size=512k', 'none', disk], capture_output=True, check=False).returncode:
            os.rmdir(disk)
            self.skipTest('file systems can be mounted by root only')
        try:
            words = self.series('much.raw', (96, 96, 64, 4))
            said = self.bcc4('import', *words, '--exact', '--measure', 'none', '-o', 'voll/much.bcc4', code=4)
            self.assertIn('free some space or write elsewhere', said)
            self.assertNotIn('much.bcc4', os.listdir(disk))
            subprocess.run(['mount', '-o', 'remount,size=16m', disk], check=True)
            self.bcc4('import', *words, '--exact', '--measure', 'none', '-o', 'voll/more.bcc4')
            self.bcc4('verify', 'voll/more.bcc4')
        finally:
            subprocess.run(['umount', disk], check=True)
            os.rmdir(disk)

    def lists_a_slab(self, journal):
        """Whether there is more than 16 bytes and a record of u32 length, u32 checksum and the options."""
        if not os.path.exists(journal):
            return False
        with open(journal, 'rb') as f:
            data = f.read()
        return len(data) > 24 and len(data) > 24 + int.from_bytes(data[16:20], 'little')

    def stopped(self, number):
        """An import that is stopped by a signal when its journal has a slab; its exit code."""
        words = self.series('long.raw', (96, 96, 64, 24))
        import_ = subprocess.Popen([*COMMAND, 'import', *words, '--levels', 'none', '--measure', 'none', '--threads', '1',
                                    '-o', 'long.bcc4'], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        journal = self.path('long.bcc4.journal')
        while import_.poll() is None and not self.lists_a_slab(journal):
            time.sleep(.01)
        self.assertIsNone(import_.poll(), 'it ended before it could be stopped')
        if os.environ.get('BCCSPLAT_KILL') and number == signal.SIGKILL:  # the process below the emulator
            subprocess.run(shlex.split(os.environ['BCCSPLAT_KILL']), check=False, capture_output=True)
        import_.send_signal(number)
        return words, import_.wait()

    def test_a_killed_import_is_resumed(self):
        words, _ = self.stopped(signal.SIGKILL)
        more = ['--levels', 'none', '--measure', 'none']
        self.assertIn('long.bcc4.partial', os.listdir(self.folder))
        self.bcc4('import', *words, *more, '-o', 'long.bcc4', '--resume')
        self.bcc4('import', *words, *more, '-o', 'whole.bcc4')
        with open(self.path('long.bcc4'), 'rb') as a, open(self.path('whole.bcc4'), 'rb') as b:
            self.assertEqual(a.read(), b.read())
        self.assertNotIn('long.bcc4.journal', os.listdir(self.folder))

    def test_ctrl_c_keeps_what_is_done(self):
        _, code = self.stopped(signal.SIGINT)
        self.assertEqual(code, 130)
        self.assertNotIn('long.bcc4', os.listdir(self.folder))
        self.assertIn('long.bcc4.partial', os.listdir(self.folder))

    def test_what_is_left_out_says_so(self):
        if '.exe' not in COMMAND[-1]:
            self.skipTest('this tool has all')
        self.bcc4('import', *self.series('a.raw'), '-o', 'a.bcc4')
        said = self.bcc4('render', 'a.bcc4', '--time', '0', '-o', 'a.mp4', code=3)
        self.assertIn('ffmpeg', said)
        with open(self.path('core.wasm'), 'wb'):  # what a viewer is known by
            pass
        self.assertIn('no server', self.bcc4('view', 'a.bcc4', '--page', '.', code=3))

    def test_the_library_is_loaded_twenty_times(self):
        host, library = os.environ.get('BCCSPLAT_HOST'), os.environ.get('BCCSPLAT_DLL')
        if not host:
            self.skipTest('BCCSPLAT_HOST names no host')
        self.bcc4('import', *self.series('ä ö.raw'), '-o', 'ä ö.bcc4')
        done = subprocess.run([*COMMAND[:-1], host, library, 'ä ö.bcc4', '20'], cwd=self.folder, capture_output=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn(b'20 times', done.stdout)


if __name__ == '__main__':
    FOLDER, COMMAND = os.path.abspath(sys.argv[1]), sys.argv[2:]
    os.makedirs(FOLDER, exist_ok=True)
    unittest.main(argv=sys.argv[:1], verbosity=2)

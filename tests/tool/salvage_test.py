"""Damaged files: verify says what is lost and what is whole, export --salvage gets the rest out."""
import os
import re
import struct

from harness import Nrrd, ToolTest, main

DIMS = (40, 36, 20, 60)


def value(x, y, z, t):
    return 50 + 3 * ((x * 7 + y * 3 + z * 5 + t) % 13) + t


class Salvage(ToolTest):
    def setUp(self):
        super().setUp()
        self.args = self.raw('a.raw', DIMS, value)
        self.bcc4('import', *self.args, '--lattice', 'd4star', '--exact', '-o', 'v.bcc4', '--quiet')
        with open(self.path('v.bcc4'), 'rb') as f:
            self.whole = f.read()

    def damage(self, *offsets):
        bytes_ = bytearray(self.whole)
        for o in offsets:
            bytes_[o] ^= 0x10
        self.write('v.bcc4', bytes(bytes_))

    def frame(self, index, *more):
        self.bcc4('export', 'v.bcc4', '--index', '--time', index, '-o', f'f{index}.nrrd', '--overwrite', '--quiet', *more)
        return Nrrd(self.path(f'f{index}.nrrd')).values

    def test_a_chunk(self):
        before = {f: self.frame(f) for f in (0, 1, 30, 59)}
        # The first chunk: the first 8 layers of the first brick, 4 of them before frame 0.
        self.damage(192 + 40)
        _, err = self.bcc4('verify', 'v.bcc4', expect=1)
        self.assertIn('chunk at offset 192: bad checksum', err)
        self.assertRegex(err, r'lost: channel value, samples x 0 to \d+ y 0 to \d+ z 0 to 19 of frames 0 to \d+')
        first_whole = int(re.search(r'whole are frames (\d+) to 59', err).group(1))
        self.assertGreater(first_whole, 5)
        self.assertLessEqual(first_whole, 30)
        # Without --salvage nothing is drawn from it.
        _, err = self.bcc4('export', 'v.bcc4', '--index', '--time', 3, '-o', 'no.nrrd', expect=3)
        self.assertIn('bad checksum', err)
        for f, old in before.items():
            new = self.frame(f, '--salvage')
            lost = sum(v != v for v in new)
            if f >= first_whole:
                self.assertEqual(new, old, f'frame {f}')
            else:
                self.assertGreater(lost, 0, f'frame {f}')
                self.assertLess(lost, len(new) // 2, f'frame {f}')

    def test_a_page_of_the_index(self):
        # The only page: the directory says where. The root's reference of the directory is at 48.
        offset, stored, decoded, _, coding = struct.unpack_from('<QIIII', self.whole, 64 + 48)
        self.assertEqual((decoded, coding), (64, 0) if coding == 0 else (64, 1))
        page = self.page_offset(offset, stored, coding)
        self.damage(page)
        _, err = self.bcc4('verify', 'v.bcc4', expect=1)
        self.assertIn('index page at offset', err)
        self.assertIn('no frame is whole', err)
        values = self.frame(10, '--salvage')
        self.assertTrue(all(v != v for v in values))

    def page_offset(self, offset, stored, coding):
        import zlib
        directory = self.whole[offset:offset + stored]
        if coding == 1:
            directory = zlib.decompress(directory, -15)
        return struct.unpack_from('<Q', directory, 24)[0]

    def test_a_whole_file_is_exported_as_ever(self):
        before = self.frame(7)
        self.assertEqual(self.frame(7, '--salvage'), before)

    def test_what_cannot_be_salvaged_says_so(self):
        self.write('v.bcc4', self.whole[:len(self.whole) // 2])
        self.bcc4('export', 'v.bcc4', '--time', 0, '-o', 'no.nrrd', '--salvage', expect=3)
        self.assertFalse(os.path.exists(self.path('no.nrrd')))


if __name__ == '__main__':
    main()

"""Inputs that were read wrong in silence: each kind written here byte by byte, imported, and compared by the values,
matrices and times that come back, or refused by name."""
import array
import math
import os
import random
import struct
import subprocess
import unittest
import zlib

from harness import BCC4, DATA, Nrrd, ToolTest, has_openvdb, main

CASES = os.path.join(DATA, 'cases')
DIMS = (8, 7, 6, 3)


def ramp(dims=DIMS, code='f', scale=1):
    """Each value its own place."""
    nx, ny, nz, nt = dims
    return array.array(code, (scale * (x + 2 * y + 3 * z + 5 * t) for t in range(nt) for z in range(nz) for y in range(ny)
                              for x in range(nx)))


def nifti(values, dims=DIMS, code=16, slope=(1, 0), sform=None, qform=None):
    """sform: three rows; qform: x, y, z of the origin, without a rotation. Voxels of 2 x 3 x 4."""
    head = bytearray(352)
    struct.pack_into('<i', head, 0, 348)
    struct.pack_into('<8h', head, 40, 4, *dims, 1, 1, 1)
    struct.pack_into('<hh', head, 70, code, 8 * values.itemsize)
    struct.pack_into('<8f', head, 76, 1, 2, 3, 4, 1, 0, 0, 0)
    struct.pack_into('<3f', head, 108, 352, *slope)
    struct.pack_into('<hh', head, 252, qform is not None, sform is not None)
    if qform is not None:
        struct.pack_into('<3f', head, 268, *qform)
    for i, row in enumerate(sform or ()):
        struct.pack_into('<4f', head, 280 + 16 * i, *row)
    head[344:348] = b'n+1\0'
    return bytes(head) + values.tobytes()


def with_last_layer(data, layer):
    """A .bcc4 file that says of its lattice that it goes on to such a layer; its checksums are right."""
    root = 64
    offset, stored, _, _, coding = struct.unpack_from('<QIIII', data, root + 24)
    block = data[offset:offset + stored]
    records = bytearray(zlib.decompress(block, -15) if coding else block)
    struct.pack_into('<i', records, 8 + 32, layer)  # record 1 comes first
    out = bytearray(data) + records
    struct.pack_into('<Q', out, root + 16, len(out))
    struct.pack_into('<QIIII', out, root + 24, len(data), len(records), len(records), zlib.crc32(records), 0)
    struct.pack_into('<I', out, root + 124, zlib.crc32(out[root:root + 124]))
    return bytes(out)


def nrrd(values, fields, dims=DIMS[:3]):
    head = f'NRRD0005\ntype: float\ndimension: {len(dims)}\nsizes: {" ".join(map(str, dims))}\nendian: little\nencoding: raw\n'
    return (head + fields + '\n').encode() + values.tobytes()


def metaimage(values, fields, dims=DIMS[:3]):
    head = f'ObjectType = Image\nNDims = {len(dims)}\nDimSize = {" ".join(map(str, dims))}\nElementType = MET_FLOAT\n'
    return (head + fields + 'ElementDataFile = LOCAL\n').encode() + values.tobytes()


def labels(dims, largest, code):
    """Blocks of fourteen region numbers, 0 and the largest among them."""
    chosen = random.Random(5)
    numbers = [0, largest] + [chosen.randrange(1, largest) for _ in range(12)]
    nx, ny, nz, nt = dims
    return array.array(code, (numbers[((x // 4) * 7 + (y // 3) * 5 + (z // 3) * 3 + (x + y + t) // 9) % 14]
                              for t in range(nt) for z in range(nz) for y in range(ny) for x in range(nx)))


class Cases(ToolTest):
    def taken(self, *inputs):
        """Imports exactly; returns what info tells and what export gives back."""
        self.bcc4('import', *inputs, '--lattice', 'cc', '--exact', '-o', 'a.bcc4', '--overwrite', '--quiet')
        return self.again()

    def again(self):
        self.bcc4('export', 'a.bcc4', '--all', '-o', 'a.nrrd', '--overwrite', '--quiet')
        return self.json('info', 'a.bcc4'), Nrrd(self.path('a.nrrd'))

    def times(self):
        return [float(t) for t in Nrrd(self.path('a.nrrd')).keys['axis 3 index values'].split()]

    def assertRows(self, info, rows):
        for got, wanted in zip(info['affine'], rows):
            for a, b in zip(got, wanted):
                self.assertAlmostEqual(a, b, delta=1e-5, msg=f'{info["affine"]} instead of {rows}')

    def assertNear(self, got, wanted, delta):
        self.assertEqual(len(got), len(wanted))
        self.assertLess(max(abs(a - b) for a, b in zip(got, wanted)), delta)

    def test_the_first_cell_of_a_nrrd(self):
        fields = 'spacings: 2 3 4 .5\naxis mins: -22 0 10 5\nkinds: space space space time\n'
        for centres, origin in (('centerings: cell cell cell node\n', (-21, 1.5, 12)), ('', (-21, 1.5, 12)),
                                ('centerings: node node node node\n', (-22, 0, 10))):
            self.write('a.nrrd', nrrd(ramp(), fields + centres, DIMS))
            info, out = self.taken('a.nrrd')
            self.assertRows(info, [[2, 0, 0, origin[0]], [0, 3, 0, origin[1]], [0, 0, 4, origin[2]]])
            self.assertEqual(self.times(), [5, 5.5, 6])
            self.assertNear(out.values, ramp(), 1e-3)
        self.write('b.nrrd', nrrd(ramp((8, 7, 6, 1)), 'axis mins: 0 0 0\naxis maxs: 16 21 24\n'))
        self.assertRows(self.taken('b.nrrd')[0], [[2, 0, 0, 1], [0, 3, 0, 1.5], [0, 0, 4, 2]])

    def test_left_handed_space_is_no_mirror(self):
        place = 'space directions: (-1,0,0) (0,1,0) (0,0,1)\nspace origin: (39,5,6)\n'
        self.write('las.nrrd', nrrd(ramp((8, 7, 6, 1)), 'space: left-anterior-superior\n' + place))
        info, _ = self.taken('las.nrrd')
        self.assertRows(info, [[1, 0, 0, -39], [0, 1, 0, 5], [0, 0, 1, 6]])
        self.assertEqual(info['attributes']['space'], 'right-anterior-superior')

    def test_an_sform_without_a_volume(self):
        self.write('a.nii', nifti(ramp(), sform=[[0] * 4] * 3, qform=(7, 8, 9)))
        self.assertRows(self.taken('a.nii')[0], [[2, 0, 0, 7], [0, 3, 0, 8], [0, 0, 4, 9]])
        self.assertIn('sform spans no volume', self.bcc4('import', 'a.nii', '--dry-run')[0])
        self.write('b.nii', nifti(ramp(), sform=[[-2, 0, 0, 0], [0, 3, 0, 0], [0, 0, 4, 0]], qform=(0, 0, 0)))
        self.assertIn('left and right swapped', self.bcc4('import', 'b.nii', '--dry-run')[0])

    def test_floats_are_scaled(self):
        wanted = [2 * v + 5 for v in ramp()]
        for code, kind in (('f', 16), ('d', 64)):
            self.write('a.nii', nifti(ramp(code=code), code=kind, slope=(2, 5)))
            info, out = self.taken('a.nii')
            self.assertNear(out.values, wanted, 1e-3)
            self.assertAlmostEqual(info['range'][1], max(wanted), delta=1e-3)
        self.write('a.mha', metaimage(ramp(), 'ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = 5\n', DIMS))
        self.assertNear(self.taken('a.mha')[1].values, wanted, 1e-3)

    def test_labels_come_back_as_they_are(self):
        for dims in ((22, 18, 14, 6), (22, 18, 14, 1)):
            for code, kind, largest in (('i', 8, 12102), ('I', 768, 12102), ('q', 1024, 12102), ('i', 8, 1000000),
                                        ('i', 8, 2**24)):
                with self.subTest(dims=dims, code=code, largest=largest):
                    values = labels(dims, largest, code)
                    self.write('a.nii', nifti(values, dims, kind))
                    self.bcc4('import', 'a.nii', '-o', 'a.bcc4', '--overwrite', '--quiet')
                    out = self.again()[1]
                    self.assertEqual(out.fields['type'], 'uint32' if code == 'I' else 'int32')
                    self.assertEqual(list(out.values), list(values))
            self.write('a.nii', nifti(labels(dims, 2**31 - 1, 'I'), dims, 768))
            self.refused(3, 'number the labels anew', 'import', 'a.nii', '-o', 'b.bcc4', '--quiet', output='b.bcc4')

    def named(self, names):
        """Files of one frame each, of the value of their place in the list."""
        for i, name in enumerate(names):
            self.write(name, array.array('f', [i] * 336))
        return ['--dims', '8,7,6', '--dtype', 'f32']

    def order(self, out):
        return [round(out.values[336 * i]) for i in range(len(out.values) // 336)]

    def test_sizes_that_are_0(self):
        for qform in (None, (0, 0, 0)):
            head = bytearray(nifti(ramp(), qform=qform))
            struct.pack_into('<f', head, 88, 0)
            self.write('a.nii', bytes(head))
            _, said = self.bcc4('import', 'a.nii', '-o', 'a.bcc4', '--overwrite')
            self.assertIn('warning: pixdim[3] is 0: samples along z are taken to be 1 apart; --spacing sets it', said)
            _, said = self.bcc4('import', 'a.nii', '--spacing', '2,3,4', '-o', 'a.bcc4', '--overwrite')
            self.assertNotIn('pixdim', said)

    def test_a_file_that_is_cut_in_its_last_frame(self):
        values = ramp()
        more = 'kinds: space space space time\n'
        for name, whole, *options in (('a.nii', nifti(values)), ('a.nrrd', nrrd(values, more, DIMS)), ('a.mha', metaimage(values, '', DIMS)),
                                      ('a.raw', values.tobytes(), '--dims', '8,7,6,3', '--dtype', 'f32')):
            self.write(name, whole[:-100])
            self.refused(3, 'its first 2 frames are whole: --frames 0-1', 'import', name, *options, '-o', 'b.bcc4', output='b.bcc4')
            self.refused(3, 'its first 2 frames are whole: --frames 0-1', 'import', name, *options, '--frames', '1-2', '-o', 'b.bcc4', output='b.bcc4')
            _, got = self.taken(name, *options, '--frames', '0-1')
            self.assertNear(got.values, values[:2 * 8 * 7 * 6], 1e-3)
            self.write(name, whole + bytes(100))  # what is too long is not cut
            _, err = self.bcc4('import', name, *options, '-o', 'long.bcc4', '--overwrite', expect=0 if name == 'a.nii' else 3)
            self.assertNotIn('whole', err)

    def test_a_last_file_that_is_shorter(self):
        def write(end, make):
            for t in range(3):
                dims = (8, 7, 6 if t < 2 else 4)
                self.write(f'f{t}{end}', make(ramp((*dims, 1)), dims))
        writers = {'.nii': lambda v, d: nifti(v, (*d, 1)), '.nrrd': lambda v, d: nrrd(v, '', d), '.mha': lambda v, d: metaimage(v, '', d)}
        for end, make in writers.items():
            write(end, make)
            self.refused(3, f'f2{end}: its sizes or type differ from those of f0{end}: convert the files to one kind, or take those before it by '
                         '--frames 0-1', 'import', f'f*{end}', '-o', 'b.bcc4', output='b.bcc4')
            info, _ = self.taken(f'f*{end}', '--frames', '0-1')
            self.assertEqual(info['dims'], [8, 7, 6, 2])

    def test_times_of_frames_of_slicer(self):
        """Labels of a multi-volume are the values of a tag, which may be no time."""
        def times(tag, unit='ms', labels='10,20,45.5'):
            keys = {'FrameLabels': labels, 'FrameIdentifyingDICOMTagName': tag, 'FrameIdentifyingDICOMTagUnits': unit}
            text = 'kinds: list space space space\n' + ''.join(f'MultiVolume.{k}:={v}\n' for k, v in keys.items())
            self.write('a.nrrd', nrrd(ramp(), text, (3, 8, 7, 6)))
            said, _ = self.bcc4('import', 'a.nrrd', '-o', 'a.bcc4', '--overwrite')
            return said, self.again()[0]['times']['unit'], self.times()
        said, unit, got = times('TriggerTime')
        self.assertEqual((unit, got), ('ms', [10, 20, 45.5]))
        self.assertIn('MultiVolume.FrameLabels of the header', said)
        for tag, labels, text in (('FlipAngle', '10,20,45.5', 'are of FlipAngle, and not taken'), ('EchoTime', '10,20,45.5', 'not taken'),
                                  ('AcquisitionTime', '10,20,5', 'does not rise')):
            said, _, got = times(tag, labels=labels)
            self.assertEqual(got, [0, 1, 2], tag)
            self.assertIn(text, said)

    def test_names_with_several_numbers(self):
        months = [f'temp_{y}-{m:02}.raw' for y, first, last in ((2023, 7, 12), (2024, 1, 6)) for m in range(first, last + 1)]
        hours = [f'h_{d}T{h:02}.raw' for d in (20230131, 20230201) for h in (0, 12)]
        decimals = [f'dec_{t}.raw' for t in (0.5, 1.0, 1.5, 2.0, 10.0, 10.5)]
        exponents = [f'e_{t}.raw' for t in ('1e-03', '5e-03', '1e-02', '2e+00')]
        for names, glob in ((months, 'temp_*.raw'), (hours, 'h_*.raw'), (decimals, 'dec_*.raw'), (exponents, 'e_*.raw')):
            about = self.named(names)
            for inputs in (names, [glob]):
                with self.subTest(inputs[0]):
                    self.assertEqual(self.order(self.taken(*inputs, *about)[1]), list(range(len(names))))
        self.assertEqual(self.times(), [.001, .005, .01, 2])
        self.taken(*decimals, '--dims', '8,7,6', '--dtype', 'f32')
        self.assertEqual(self.times(), [.5, 1, 1.5, 2, 10, 10.5])

    def test_numbers_further_apart_are_times(self):
        about = self.named(['rt_1.raw', 'rt_3.raw', 'rt_5.raw'])
        self.taken('rt_%d.raw', *about)
        self.assertEqual(self.times(), [1, 3, 5])
        self.named(['rt_2.raw', 'rt_4.raw'])
        self.taken('rt_%d.raw', '--frames', '1-5x2', *about)
        self.assertEqual(self.times(), [1, 3, 5])

    def test_files_of_a_sequence_lie_in_one_place(self):
        values = ramp((8, 7, 6, 1))
        one = (8, 7, 6, 1)
        upright = [[2, 0, 0, 0], [0, 3, 0, 0], [0, 0, 4, 0]]
        mirrored = [[-2, 0, 0, 0], [0, 3, 0, 0], [0, 0, 4, 0]]
        space = 'space: left-posterior-superior\nspace origin: (0,0,0)\nspace directions: '
        kinds = {
            'nii': (nifti(values, one, sform=upright), nifti(values, one, sform=mirrored)),
            'nrrd': (nrrd(values, space + '(2,0,0) (0,2,0) (0,0,3)\n'), nrrd(values, space + '(-2,0,0) (0,2,0) (0,0,3)\n')),
            'mha': (metaimage(values, 'ElementSpacing = 2 2 3\nOffset = 0 0 0\n'),
                    metaimage(values, 'ElementSpacing = 2 2 5\nOffset = 40 0 0\n')),
        }
        for kind, (first, other) in kinds.items():
            with self.subTest(kind):
                self.write(f's_0.{kind}', first)
                self.write(f's_1.{kind}', other)
                self.refused(3, f's_1.{kind}: its spacing, directions or origin differ', 'import', f's_%d.{kind}', '-o', 'b.bcc4',
                             output='b.bcc4')
                self.write(f's_1.{kind}', first)
                self.assertNear(self.taken(f's_%d.{kind}')[1].values, values + values, 1e-3)
        for name, slope in (('s_0.nii', (1, 0)), ('s_1.nii', (3, 0))):
            self.write(name, nifti(values, one, slope=slope))
        self.refused(3, 'convert the files to one scaling', 'import', 's_%d.nii', '-o', 'b.bcc4', output='b.bcc4')

    def test_times_of_frames_in_a_metaimage(self):
        stamps = ''.join(f'Seq_Frame{i:04}_Timestamp = {t}\n' for i, t in enumerate((1.5, 1.75, 2.5)))
        for dims in (DIMS, (8, 42, 3)):
            self.write('a.mha', metaimage(ramp(), stamps, dims))
            info, out = self.taken('a.mha')
            self.assertEqual((self.times(), info['times']['unit']), ([1.5, 1.75, 2.5], 's'))
            self.assertNear(out.values, ramp(), 1e-3)

    def test_parts_are_no_frames(self):
        text = ' '.join(['1'] * 24)
        for name in ('d_0.vti', 'd_1.vti'):
            self.write(name, (f'<VTKFile type="ImageData"><ImageData WholeExtent="0 1 0 2 0 3"><Piece Extent="0 1 0 2 0 3">'
                              f'<PointData Scalars="d"><DataArray type="Float32" Name="d" format="ascii">{text}</DataArray></PointData>'
                              f'</Piece></ImageData></VTKFile>').encode())
        sets = ''.join(f'<DataSet timestep="0" part="{i}" file="d_{i}.vti"/>' for i in range(2))
        self.write('c.pvd', f'<VTKFile type="Collection"><Collection>{sets}</Collection></VTKFile>'.encode())
        for more in ([], ['--dt', 1]):
            self.refused(3, 'timestep 0 has several parts', 'import', 'c.pvd', *more, '-o', 'b.bcc4', output='b.bcc4')

    @unittest.skipUnless(has_openvdb(), 'built without OpenVDB')
    def test_a_grid_that_appears_later(self):
        for t, name in enumerate(('density', 'flame')):
            self.write('a.nrrd', nrrd(ramp((8, 7, 6, 1), scale=t + 1), f'content: {name}\n'))
            self.taken('a.nrrd', '--air', 0)
            self.bcc4('export', 'a.bcc4', '--all', '-o', f'g_{t}.vdb', '--quiet')
        self.bcc4('import', 'g_%d.vdb', '--grid', 'density,flame', '--lattice', 'cc', '--scale', '1,1,1,1', '-o', 'g.bcc4', '--quiet')
        for t, name in enumerate(('density', 'flame')):
            self.bcc4('export', 'g.bcc4', '--all', '--channel', name, '-o', 'g.nrrd', '--overwrite', '--quiet')
            values = Nrrd(self.path('g.nrrd')).values
            half = len(values) // 2
            self.assertAlmostEqual(max(values[t * half:(t + 1) * half]), (t + 1) * 34, delta=.05)
            self.assertLess(max(map(abs, values[(1 - t) * half:(2 - t) * half])), .05, f'{name} where it is not')

    def test_motion_of_many_voxels_a_frame(self):
        n, frames = 40, 8
        noise = random.Random(1)

        def told(value):
            self.write('m.raw', struct.pack(f'<{n ** 3 * frames}f', *(
                value(x, y, z, t) for t in range(frames) for z in range(n) for y in range(n) for x in range(n))))
            out, _ = self.bcc4('import', 'm.raw', '--dims', f'{n},{n},{n},{frames}', '--dtype', 'f32', '--dry-run')
            return [line for line in out.splitlines() if line.startswith('  motion')]

        def ball(step):
            return lambda x, y, z, t: math.exp(-((x - 6 - step * t) ** 2 + (y - 20) ** 2 + (z - 20) ** 2) / 8)

        fast = told(ball(4))
        self.assertEqual(len(fast), 1)
        self.assertIn('about 4 voxels', fast[0])
        self.assertEqual(told(ball(.5)), [])
        self.assertEqual(told(lambda *p: noise.random()), [], 'noise goes nowhere')

    @unittest.skipUnless(has_openvdb() and os.path.isdir(CASES), 'no OpenVDB or no such data')
    def test_puffs_far_apart(self):
        out, err = self.bcc4('import', os.path.join(CASES, 'reported', '36-vdb-two-islands', 'isl.vdb'), '-o', 'a.bcc4')
        self.assertIn('its parts lie far apart', err)
        self.assertIn('none: next to nothing of a frame is active', out)

    def test_what_a_file_claims_costs_no_memory(self):
        """Checksums are right, counts are not: refused when opened, within the memory that the tool takes anyway."""
        self.write('a.raw', bytes(range(64)) * 3)
        self.bcc4('import', 'a.raw', '--dims', '4,4,4,3', '--dtype', 'u8', '--lattice', 'cc', '--exact', '-o', 'a.bcc4')
        file = self.write('claims.bcc4', with_last_layer(self.read('a.bcc4'), 1 << 29))
        for args in (('slice', file, '--plane', '1,0,0,0,-5', '-o', 'x.nrrd'), ('info', file), ('verify', file),
                     ('render', file, '-o', 'x.png'), ('export', file, '--time', 0, '-o', 'x.nrrd')):
            with subprocess.Popen([BCC4, *map(str, args)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                  cwd=self.folder) as p:
                out = p.stdout.read()
                _, status, used = os.wait4(p.pid, 0)
                p.returncode = os.waitstatus_to_exitcode(status)
            self.assertEqual(p.returncode, 1 if args[0] == 'verify' else 3, f'{args}: {out}')
            self.assertRegex(out, 'layer [0-9]+ stands at frame|limit')
            self.assertLess(used.ru_maxrss, 256 << 10, f'KiB: {args}')


if __name__ == '__main__':
    main()

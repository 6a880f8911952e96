"""python_arrays_test.py TOP EXAMPLES SCRATCH TOOL: files as numpy arrays and arrays as files, with pictures of them."""
import gc
import os
import pickle
import signal
import struct
import subprocess
import sys
import unittest
import warnings

import python_support as support
from python_support import path, waves, without

support.need("numpy")
import numpy as np  # noqa: E402

import bccsplat  # noqa: E402
from bccsplat import Error, FieldArray, SharedFile, Status, abi  # noqa: E402
from bccsplat.field_array import chunk_frames, chunk_samples  # noqa: E402


class Arrays(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        support.fresh_scratch()
        cls.source = waves(14, 20, 22, 24)
        cls.name = path("s.bcc4")
        cls.report = bccsplat.save(cls.name, cls.source, dt=.04, start=1, spacing=(1, 2, 3), origin=5, name="density",
                                   unit="g", spatial_unit="mm", time_unit="s", attributes={"made": "up"}, levels=1,
                                   lattice="d4star")
        cls.volume = bccsplat.open(cls.name)
        cls.whole = np.asarray(cls.volume)

    def test_a_file_is_an_array(self):
        v = self.volume
        self.assertEqual((v.shape, v.ndim, v.dtype, len(v)), ((14, 20, 22, 24), 4, np.float32, 14))
        self.assertLess(abs(self.whole - self.source).max(), .03)
        self.assertTrue(np.array_equal(v[12.5], v.slice(frame=12.5).sample_grid()))
        self.assertTrue(np.array_equal(v.at(1.5), v[12.5]))
        self.assertEqual(len([frame for frame in v]), 14)
        self.assertTrue(np.array_equal(v[[2, -1]], np.stack([v[2], v[-1]])))
        self.assertTrue(np.array_equal(v[[2, 3.5]], np.stack([v[2], v[3.5]])))
        self.assertEqual(v[2.5, 3:6, ::2, -1].shape, (3, 11))

    def test_indexing_is_that_of_numpy(self):
        mask = np.arange(20) % 3 == 0
        for key in (3, -1, slice(2, 9, 3), (slice(5, 1, -2), 4), (3, Ellipsis, 5), (Ellipsis,), (2, slice(None, None, -1)),
                    (slice(4, 5), slice(3, 17, 5), slice(20, 2, -3), [1, 5, 2]), (slice(None), mask), (0, 0, 0, 0),
                    (6, [3, 4, 9], slice(None), slice(1, 2)), (slice(3, 3),)):
            found, expected = self.volume[key], self.whole[key]
            self.assertEqual(found.shape, expected.shape, key)
            np.testing.assert_allclose(found, expected, rtol=0, atol=2e-6, err_msg=str(key))
        for key in (14, (0, 20), (0, 0, -23), (0,) * 5, (Ellipsis, Ellipsis)):
            with self.assertRaises(IndexError, msg=str(key)):
                self.volume[key]
        with self.assertRaises(Error) as caught:
            self.volume[13.5]
        self.assertEqual(caught.exception.status, Status.OUT_OF_DOMAIN)
        with self.assertRaisesRegex(IndexError, "frame 13.5 is outside the series, 0 to 13"):
            self.volume[13.5, 1, 1, 1]

    def test_what_numpy_reads_otherwise_is_refused(self):
        pairs, mask = np.array([[0, 1], [2, 3]]), np.arange(20) % 3 == 0
        for where in self.volume, self.volume.field():
            for key in ((0, slice(None), [1, 2]), (slice(None), 0, slice(None), [1, 2]), (0, [1, 2], slice(None), 3), (np.array(3),),
                        (0, np.array(3)), [], (2, mask, slice(None), 5), (slice(None), [1, 2], 3, slice(None))):
                found, expected = where[key], self.whole[key]
                self.assertEqual(found.shape, expected.shape, key)
                np.testing.assert_allclose(found, expected, rtol=0, atol=2e-6)
            for key in (None, (0, None), (Ellipsis, None), True, np.True_, False, (0, True), pairs, (0, pairs), pairs.tolist(),
                        self.whole > 2, ([0, 1], [1, 2]), (0, [1, 2], slice(None), [1, 2]), (slice(None), mask, mask[:1])):
                with self.assertRaises(IndexError, msg=str(key)):
                    where[key]

    def test_a_part_is_read_without_the_rest(self):
        name = path("large.bcc4")
        bccsplat.save(name, waves(3, 96, 96, 96), lattice="d4star", overwrite=True)
        read = {}
        for part, key in (("corner", (1, slice(0, 8), slice(0, 8), slice(0, 8))), ("frame", (1,))):
            v = bccsplat.open(name)
            before = v.info().bytes_read
            v[key]
            read[part] = v.info().bytes_read - before
        self.assertLess(8 * read["corner"], read["frame"], read)
        self.assertGreater(read["corner"], 0)

    def test_positions_anywhere(self):
        axes = [[1.25], [3, 4.5, 5.5], [0, .7, 20], [2, 2.5, 3, 40]]
        field = FieldArray(self.volume, axes)
        found = field.read()
        self.assertTrue(np.isnan(found[..., 3]).all())
        inside = found[..., :3]
        t, z, y, x = np.meshgrid(*axes[:3], axes[3][:3], indexing="ij")
        np.testing.assert_allclose(inside, self.volume.evaluate(np.stack([x, y, z, t], -1)), atol=2e-6)
        many = FieldArray(self.volume, [[1.25], np.arange(20), np.arange(0, 21, .5), np.r_[0:10, 10.3]])  # no grid
        t, z, y, x = np.meshgrid(*many.axes, indexing="ij")
        np.testing.assert_allclose(many.read(), self.volume.evaluate(np.stack([x, y, z, t], -1)), atol=2e-6)
        out = np.empty(field.shape, np.float32)
        self.assertIs(field.read(out), out)
        np.testing.assert_array_equal(out, found)

    def test_levels_and_channels(self):
        coarse = self.volume.field("density", level=1)
        self.assertEqual(coarse.shape, (14, 10, 11, 12))
        self.assertLess(abs(np.asarray(coarse) - self.source[:, ::2, ::2, ::2]).max(), .2)
        with self.assertRaisesRegex(ValueError, "levels 0 to 1"):
            self.volume.field(level=2)
        name = path("two.bcc4")
        bccsplat.save(name, {"a": self.source, "b": -self.source}, overwrite=True)
        two = bccsplat.open(name)
        np.testing.assert_allclose(two.field("b")[2], -two.field("a")[2], atol=1e-5)
        self.assertEqual(two.channel_info(1).name, "b")
        with self.assertRaises(Error):
            two.field("c")

    def test_what_was_saved_is_told(self):
        info = self.volume.info()
        self.assertEqual(self.report.frames, 14)
        np.testing.assert_allclose(self.volume.times(), 1 + .04 * np.arange(14))
        self.assertEqual(info.affine[:], [1, 0, 0, 5, 0, 2, 0, 5, 0, 0, 3, 5, 0, 0, 0, 1])
        self.assertEqual((info.spatial_unit, info.time_unit, self.volume.channel_info().unit), ("mm", "s", "g"))
        self.assertEqual(self.volume.attributes()["made"], "up")

    def test_saving(self):
        name = path("x.bcc4")
        frame = np.arange(6 * 5 * 4, dtype=np.uint8).reshape(6, 5, 4)
        for array in (frame, frame[None], frame.astype(">i4")[::-1][::-1], frame.astype(np.int64), frame.tolist()):
            bccsplat.save(name, array, overwrite=True, lattice="cc")
            np.testing.assert_allclose(bccsplat.open(name)[0], frame, atol=1e-3)
        bccsplat.save(name, frame > 50, overwrite=True, lattice="cc")
        np.testing.assert_allclose(bccsplat.open(name)[0], frame > 50, atol=1e-3)
        mapped = np.memmap(path("m.raw"), np.float32, "w+", shape=self.source.shape)
        mapped[:] = self.source
        bccsplat.save(name, mapped, times=np.arange(14) ** 1.5, abs_error=.001, overwrite=True)
        volume = bccsplat.open(name)
        self.assertLessEqual(abs(np.asarray(volume) - self.source).max(), .001 + 1e-6)
        np.testing.assert_allclose(volume.times(), np.arange(14) ** 1.5)
        holes = self.source.copy()
        holes[5, 4, 3, 2] = np.nan
        with self.assertRaises(Error) as caught:
            bccsplat.save(name, holes, overwrite=True)
        self.assertEqual(caught.exception.status, Status.NONFINITE_VALUE)
        self.assertLessEqual(abs(bccsplat.open(name)[0] - self.source[0]).max(), .001 + 1e-6)  # as it was
        bccsplat.save(name, holes, overwrite=True, nonfinite="hole")
        self.assertEqual(np.argwhere(np.isnan(np.asarray(bccsplat.open(name)))).tolist(), [[5, 4, 3, 2]])
        with self.assertRaises(Error) as caught:
            bccsplat.save(name, self.source)
        self.assertEqual(caught.exception.status, Status.FILE_EXISTS)
        for wrong, text in ((np.zeros((3, 3)), "not of shape"), ({"a": frame, "b": frame[1:]}, "different shapes")):
            with self.assertRaisesRegex(ValueError, text):
                bccsplat.save(name, wrong, overwrite=True)
        with self.assertRaisesRegex(ValueError, "all 14 frames, not 3"):
            bccsplat.save(name, self.source, times=[1, 2, 3], overwrite=True)

    def test_what_is_said_twice_or_upside_down_is_refused(self):
        name = path("twice.bcc4")
        for options in ({"times": np.arange(14), "dt": 2}, {"times": np.arange(14), "start": 0}, {"affine": np.eye(4), "spacing": 2},
                        {"affine": np.eye(4), "origin": (0, 0, 0)}):
            with self.assertRaisesRegex(ValueError, "%s and %s say the same" % tuple(options)):
                bccsplat.save(name, self.source, **options)
        for nothing in self.source[:0], self.source[:, :, :0]:
            with self.assertRaisesRegex(ValueError, "has no values"):
                bccsplat.save(name, nothing)
        proxy = type("ArrayProxy", (), {"__module__": "nibabel.arrayproxy", "shape": (10, 9, 8, 5)})()
        with self.assertRaisesRegex(ValueError, "x, y, z, t.*dataobj.*[.]T"):
            bccsplat.save(name, proxy)
        self.assertFalse(os.path.exists(name))

    def test_losses_that_nobody_asked_for_are_told(self):
        """Of files without a bound; where one is kept, and where it is known that it is not, nothing is said."""
        noise = np.rint(1000 * np.random.default_rng(0).normal(size=(4, 16, 16, 16))).astype(np.int16)
        large = 10**9 + np.broadcast_to(np.arange(16.), noise.shape)
        for array, options, text in ((noise, {"exact": True}, "give abs_error="), (noise, {"density": .6}, "give abs_error="),
                                     (large, {}, "subtract an offset"), (2**40 + large.astype(np.int64), {}, "subtract an offset")):
            with self.assertWarnsRegex(UserWarning, "value is off by up to .*" + text) as caught:
                bccsplat.save(path("loss.bcc4"), array, overwrite=True, **options)
            self.assertEqual(os.path.basename(caught.filename), os.path.basename(__file__))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for array, options in ((noise, {}), (noise, {"abs_error": 50}), (noise, {"psnr": 30}), (noise, {"lattice": "d4star"}),
                                   (noise, {"exact": True, "lattice": "cc"}), (self.source, {}), (large - 10**9, {})):
                bccsplat.save(path("loss.bcc4"), array, overwrite=True, **options)
        bccsplat.save(path("loss.bcc4"), noise, exact=True, lattice="cc", overwrite=True)
        np.testing.assert_array_equal(bccsplat.open(path("loss.bcc4")), noise)

    def test_parts_of_frames_are_whole_numbers(self):
        v = self.volume
        for arguments in ((1.5,), (1, (.7, 0, 0)), (1, (0, 0, 0), (3.9, 3, 3)), ("1",)):
            with self.assertRaisesRegex(TypeError, "must be a whole number, not "):
                v.read_frame(*arguments)
        part = v.read_frame(np.int16(1), np.array([0, 1, 2]), np.uint8([3, 4, 5]))
        np.testing.assert_allclose(part, v[1, 2:5, 1:4, :3], rtol=1e-6)

    def test_dates_and_durations(self):
        name, dates = path("dates.bcc4"), np.datetime64("2000-02-28T18:00:00.5", "ns") + np.arange(3) * np.timedelta64(6, "h")
        for times, unit, right, epoch in (
                (dates, None, [.5, 21600.5, 43200.5], "2000-02-28 18:00:00"), (dates.astype("M8[h]"), "hours", [0, 6, 12], "2000-02-28 18:00:00"),
                (dates.astype("M8[us]").tolist(), None, [.5, 21600.5, 43200.5], "2000-02-28 18:00:00"),
                (dates - dates[0], "h", [0, 6, 12], None)):
            bccsplat.save(name, self.source[:3], times=times, time_unit=unit, overwrite=True)
            volume = bccsplat.open(name)
            np.testing.assert_allclose(volume.times(), right, atol=1e-9)
            self.assertEqual((volume.info().time_unit, volume.attributes().get("time_epoch")), (unit or "s", epoch))
        for times, unit, text in ((dates, "months", "it is one of ns, us"), (dates[:2], None, "all 3 frames, not 2")):
            with self.assertRaisesRegex(ValueError, text):
                bccsplat.save(name, self.source[:3], times=times, time_unit=unit, overwrite=True)
        with self.assertRaisesRegex(ValueError, "times must be numbers"):
            bccsplat.Plan(bccsplat.default_device(), (24, 22, 20, 3), lambda t, _: self.source[t], times=dates)
        with self.assertRaisesRegex(ValueError, "part_times must be numbers"):
            bccsplat.Writer(bccsplat.default_device(), name, (24, 22, 20, 3), part=(0, 3), part_times=dates, overwrite=True)

    def test_zeros_are_no_place(self):
        with self.assertRaisesRegex(ValueError, "affine is all zeros"):
            bccsplat.save(path("zeros.bcc4"), self.source, affine=np.zeros((4, 4)))
        with self.assertRaisesRegex(ValueError, "affine is all zeros"):
            bccsplat.Writer(bccsplat.default_device(), path("zeros.bcc4"), (24, 22, 20, 3), affine=[0] * 16)
        with self.assertRaisesRegex(ValueError, "all zeros"):
            bccsplat.Scene(bccsplat.default_device()).add(self.volume, placement=np.zeros((4, 4)))
        with self.assertRaisesRegex(ValueError, "unit has kelvins, which is no channel: there are a, b"):
            bccsplat.save(path("zeros.bcc4"), {"a": self.source, "b": self.source}, unit={"kelvins": "K"})

    def test_labels_have_nothing_between_them(self):
        blocks = np.kron(np.arange(24).reshape(4, 2, 3, 1) * 171 % 1036, np.ones((1, 5, 4, 12))).astype(np.float32)
        bccsplat.save(path("l.bcc4"), blocks, labels=True, lattice="cc")
        volume = bccsplat.open(path("l.bcc4"))
        self.assertEqual((volume.channel_info().labels, volume.attributes()["labels.value"]), (1, "yes"))
        self.assertTrue(np.array_equal(np.asarray(volume), blocks))
        self.assertTrue(np.array_equal(volume[1.5], blocks[2]))
        bccsplat.save(path("l.bcc4"), blocks, labels=False, lattice="cc", overwrite=True)
        self.assertGreater(abs(bccsplat.open(path("l.bcc4"))[1.5] - blocks[2]).max(), 10)
        bccsplat.save(path("l.bcc4"), blocks, labels=True, overwrite=True)  # a plan has the lattice that they need
        self.assertTrue(np.array_equal(np.asarray(bccsplat.open(path("l.bcc4"))), blocks))
        for options in ({"lattice": "d4star"}, {"psnr": 40, "lattice": "d4star"}):
            with self.assertRaisesRegex(Error, "labels come back whole from samples of lattice CC"):
                bccsplat.save(path("l.bcc4"), blocks, labels=True, overwrite=True, **options)

    def test_masks_are_holes(self):
        name, hidden = path("masked.bcc4"), np.zeros(self.source.shape, bool)
        hidden[3:, 4:9, 7, 5:] = True
        filled = np.where(hidden, np.float32(1e20), self.source)
        masked = np.ma.array(filled, mask=hidden)

        def holds(expected, off):
            found = np.asarray(bccsplat.open(name))
            missing = np.broadcast_to(hidden if len(found) > 1 else hidden[5], found.shape)
            np.testing.assert_array_equal(np.isnan(found), missing)
            self.assertLessEqual(np.nanmax(abs(found - np.where(missing, np.nan, expected))), off)

        for array, options in ((masked, {}), (masked, {"nonfinite": "hole"}), ([*masked], {}), ([[*one] for one in masked], {})):
            bccsplat.save(name, array, overwrite=True, lattice="cc", **options)
            holds(self.source, 1e-5)
        bccsplat.save(name, masked[5], overwrite=True, lattice="cc")
        holds(self.source[5], 1e-5)
        bccsplat.save(name, masked, overwrite=True, psnr=60)
        holds(self.source, .2)
        # Whole numbers, the first frame without a hole: of the type that they had.
        whole = np.ma.array((100 * self.source).astype(np.int16), mask=hidden)
        for options in {"lattice": "cc"}, {"psnr": 60}:
            bccsplat.save(name, whole, overwrite=True, **options)
            holds(whole.data, .01 if "lattice" in options else 20)
            self.assertEqual(bccsplat.open(name).channel_info().source_type, abi.TYPE_I16)
        with self.assertRaisesRegex(Error, "hole"):
            bccsplat.save(name, masked, overwrite=True, nonfinite="error")
        with self.assertRaises(Error):
            bccsplat.save(name, self.source, times=np.ma.masked_equal(np.arange(14.), 13), overwrite=True)
        cc = {"lattice": "cc", "overwrite": True, "nonfinite": "hole"}
        with bccsplat.Device() as device:
            with bccsplat.Writer(device, name, (24, 22, 20, 14), **cc) as writer:
                for t, frame in enumerate(whole):
                    writer.add_frame([((0, 0, 0), frame[:9]), ((0, 0, 9), frame[9:])], float(t))
            holds(whole.data, .01)
            for add in (lambda writer: writer.add_layer(masked[5], 0),
                        lambda writer: writer.add_field(lambda at: masked[5][tuple(at[:, 2::-1].astype(int).T)])):
                with bccsplat.Writer(device, name, (24, 22, 20, 1), **cc) as writer:
                    add(writer)
                holds(self.source[5], 1e-5)
        with self.assertRaisesRegex(ValueError, "frame [0-9]+ has .* give a type of floats"):
            bccsplat.Plan(bccsplat.default_device(), (24, 22, 20, 14), lambda t, _: whole[5 if t else t], types=[np.int16])

    def test_fill_values_are_holes(self):
        class Variable:  # of a file, as h5py and zarr have them
            def __init__(self, data, **attrs):
                self.data, self.attrs, self.shape = data, attrs, data.shape

            def __getitem__(self, key):
                return self.data[key]

        name, source = path("filled.bcc4"), (100 * self.source).astype(np.int16)
        source[2:, 3, 4] = -999
        for variable, fill in ((Variable(source, _FillValue=np.array([-999], np.int16)), -999),
                               (Variable(source.astype(np.float32) * .1, missing_value=-99.9), np.float32(-99.9)),
                               (Variable(source.astype(np.uint8), _FillValue=-999), None)):
            bccsplat.save(name, variable, overwrite=True, lattice="cc")
            np.testing.assert_array_equal(np.isnan(np.asarray(bccsplat.open(name))), variable.data == fill)

    @unittest.skipIf(*without("netCDF4"))
    def test_variables_of_netcdf(self):
        import netCDF4
        name, source = path("nc.bcc4"), self.source.copy()
        with netCDF4.Dataset(path("v.nc"), "w") as data:
            for axis, size in zip("tzyx", source.shape):
                data.createDimension(axis, size)
            packed = data.createVariable("p", "i2", tuple("tzyx"), fill_value=-32767)
            packed.scale_factor, packed.add_offset = .001, 2.
            one = data.createVariable("o", "f4", tuple("zyx"))  # the fill value of the library
            packed[:] = np.ma.array(source, mask=source > 3.5)
            one[:] = np.ma.array(source[0], mask=source[0] > 3.5)
        for masks in True, False:
            with netCDF4.Dataset(path("v.nc")) as data:
                data.set_auto_mask(masks)
                bccsplat.save(name, data["p"], overwrite=True, lattice="cc")
                found = np.asarray(bccsplat.open(name))
                np.testing.assert_array_equal(np.isnan(found), source > 3.5)
                self.assertLess(np.nanmax(abs(found - source)[source <= 3.5]), .001)
        with netCDF4.Dataset(path("v.nc")) as data:
            bccsplat.save(name, data["o"], overwrite=True, lattice="cc")
            np.testing.assert_array_equal(np.isnan(bccsplat.open(name)[0]), source[0] > 3.5)

    def test_a_bound_in_decibels(self):
        name, source = path("bound.bcc4"), self.source[:, :, ::-1]
        for psnr in 40, 60:
            report = bccsplat.save(name, source, psnr=psnr, dt=.5, start=2, spacing=(1, 2, 3), origin=4, name="d", unit="K",
                                   spatial_unit="mm", time_unit="h", attributes={"run": "7"}, overwrite=True)
            v = bccsplat.open(name)
            self.assertGreaterEqual(self.decibels(v, source), psnr - .01)
            self.assertEqual(report.bytes_file, os.path.getsize(name))
        np.testing.assert_allclose(v.times(), 2 + .5 * np.arange(14))
        self.assertEqual(v.info().affine[:], [1, 0, 0, 4, 0, 2, 0, 4, 0, 0, 3, 4, 0, 0, 0, 1])
        self.assertEqual((v.info().spatial_unit, v.info().time_unit), ("mm", "h"))
        self.assertEqual((v.channel_info().name, v.channel_info().unit), ("d", "K"))
        self.assertEqual(v.attributes()["run"], "7")
        with self.assertRaisesRegex(bccsplat.Error, "bound.bcc4"):
            bccsplat.save(name, self.source, psnr=40)
        bccsplat.save(name, {"a": self.source, "b": self.source * 2}, psnr=40, levels=1, store="wavelets", overwrite=True)
        v = bccsplat.open(name)
        self.assertEqual((v.info().channel_count, v.info().level_count), (2, 1))
        self.assertEqual(v.info().store, bccsplat.abi.STORE_WAVELETS)

    def decibels(self, volume, source):
        difference = np.asarray(volume) - source
        return 20 * np.log10((source.max() - source.min()) / np.sqrt((difference.astype(float) ** 2).mean()))

    @unittest.skipIf(support.TOOL is None, "NO TOOL IN THIS BUILD")
    def test_without_options_it_is_what_the_tool_imports(self):
        random = np.random.default_rng(2)
        noise = random.normal(size=(6, 20, 21, 22)).astype(np.float32)
        labels = np.kron(random.integers(0, 4, (1, 4, 4, 4)) * 7, np.ones((6, 5, 5, 5))).astype(np.uint8)
        cine = (200 * random.random((10, 12, 24, 24))).astype(np.int16)
        for name, array, exact in (("waves", self.source, False), ("noise", noise, False), ("labels", labels, True), ("cine", cine, False)):
            nt, nz, ny, nx = array.shape
            array.tofile(path("in.raw"))
            kind = {"float32": "f32", "uint8": "u8", "int16": "i16"}[array.dtype.name]
            subprocess.run([support.TOOL, "import", path("in.raw"), "--dims", "%d,%d,%d,%d" % (nx, ny, nz, nt), "--dtype", kind, "--dt", "1",
                            "-o", path("tool.bcc4"), "--overwrite", "--quiet"], check=True, stdout=subprocess.DEVNULL)
            bccsplat.save(path("own.bcc4"), array, overwrite=True)
            files = bccsplat.open(path("own.bcc4")), bccsplat.open(path("tool.bcc4"))
            values = [np.asarray(file) for file in files]
            np.testing.assert_array_equal(*values, name)
            for told in ("lattice", "store", "kernel", "bytes_values", "level_count", "layer_count"):
                self.assertEqual(getattr(files[0].info(), told), getattr(files[1].info(), told), name + " " + told)
            own, its = (file.channel_info() for file in files)
            for told in ("error_bound", "wavelet_error", "value_type", "source_type", "labels", "air"):
                self.assertEqual(getattr(own, told), getattr(its, told), name + " " + told)
            off, spread = abs(values[0] - array.astype(float)).max(), float(array.max()) - float(array.min())
            self.assertLessEqual(off, 0 if exact else .02 * spread * (1 + 1e-6), name)
            if not exact and off > 0:
                self.assertLessEqual(own.error_bound, .02 * spread * (1 + 1e-6))
                self.assertGreater(own.error_bound, 0)
            lossy = bccsplat.save(path("lossy.bcc4"), array, lattice="d4star", overwrite=True)
            self.assertGreater(lossy.bytes_file, 0)
        self.assertGreater(abs(np.asarray(bccsplat.open(path("lossy.bcc4"))) - cine).max(), .02 * 200)  # as it was asked for

    def test_no_door_replaces_a_file(self):
        name, ghost = path("kept.bcc4"), [0]

        class Ghost:  # whose frames cost
            shape = (3, 4, 5, 6)

            def __getitem__(self, key):
                ghost[0] += 1
                return np.zeros((4, 5, 6), np.float32)

        bccsplat.save(name, self.source[:2])
        picture = self.volume.show(frame=1, width=8, height=8)
        picture.save(path("kept.png"))
        device = bccsplat.default_device()
        doors = [lambda: bccsplat.save(name, Ghost()), lambda: bccsplat.save(name, Ghost(), psnr=40), lambda: bccsplat.save(name, Ghost(), abs_error=1),
                 lambda: bccsplat.save(name, Ghost(), lattice="cc"), lambda: bccsplat.Writer(device, name, (6, 5, 4, 3)),
                 lambda: bccsplat.join_parts(device, [name], name), lambda: picture.save(path("kept.png")),
                 lambda: picture.frame.save_png(path("kept.png")), lambda: picture.frame.save_exr(path("kept.png"))]
        if not without("xarray")[0]:
            import xarray as xr
            from bccsplat import accessor  # noqa: F401
            dataset = xr.Dataset({"f": (("time", "z", "y", "x"), self.source)})
            doors += [lambda: dataset.bcc4.to_file(name), lambda: dataset.bcc4.to_file(name, psnr=40)]
            if not without("dask")[0]:
                doors.append(lambda: dataset.chunk({"time": 4}).bcc4.to_file(name, parts=2))
        def held():
            with open(name, "rb") as file, open(path("kept.png"), "rb") as image:
                return file.read(), image.read()

        before = held()
        for n, door in enumerate(doors):
            with self.assertRaisesRegex(FileExistsError, "exists already: give another name, or overwrite=True", msg=str(n)):
                door()
        self.assertEqual((ghost[0], held()), (0, before))
        picture.save(path("kept.png"), overwrite=True)

    def test_a_plan(self):
        asked = []

        def frame(t, channel):
            asked.append((t, channel))
            return self.source[t]

        nt, nz, ny, nx = self.source.shape
        with bccsplat.Plan(bccsplat.default_device(), (nx, ny, nz, nt), frame, types=[self.source.dtype], density=.25) as plan:
            self.assertIn("distances", plan.text)
            self.assertTrue(asked)
            options = plan.writer_options()
            self.assertGreater(max(options.scales), 1)
            with self.assertRaisesRegex(bccsplat.Error, "nothing is left"):
                plan.refine()

        def broken(t, channel):
            raise KeyError("no such frame")

        with self.assertRaisesRegex(KeyError, "no such frame"):
            bccsplat.Plan(bccsplat.default_device(), (nx, ny, nz, nt), broken)
        with self.assertRaises(bccsplat.Cancelled):
            bccsplat.Plan(bccsplat.default_device(), (nx, ny, nz, nt), frame, types=[self.source.dtype],
                          progress=lambda fraction: True)
        self.assertEqual([n for n in os.listdir(support.SCRATCH) if n.startswith(".")], [])

    def test_nothing_has_to_be_closed(self):
        device = bccsplat.Device(threads=1)
        volume = bccsplat.open(self.name, device=device)
        field = volume.field()
        field[3]
        self.assertGreater(device.info().memory_used, 0)
        del volume, field
        gc.collect()
        self.assertEqual(device.info().memory_used, 0)

    def test_other_processes(self):
        field = FieldArray.whole(SharedFile(self.name))
        first = field[3]
        again = pickle.loads(pickle.dumps(field))
        np.testing.assert_array_equal(again[3], first)
        self.assertIs(again.volume, field.volume)  # one open file for both
        code = "import pickle, sys; print(pickle.load(sys.stdin.buffer)[3].sum())"
        run = subprocess.run([sys.executable, "-B", "-c", code], input=pickle.dumps(field), capture_output=True, check=True,
                             env={**os.environ, "PYTHONPATH": support.PYTHON})
        self.assertAlmostEqual(float(run.stdout), float(first.sum()), delta=.1)
        own = bccsplat.open(self.name, device=bccsplat.Device(threads=2))
        own[3]
        child = os.fork()
        if child == 0:  # the threads of the parent are not here to be ended
            try:
                signal.alarm(30)
                right = np.array_equal(field[3], first)
                del again, own
                gc.collect()
                os._exit(0 if right else 1)
            except BaseException:
                os._exit(2)
        self.assertEqual(os.waitpid(child, 0)[1], 0)
        bccsplat.save(path("changing.bcc4"), self.source[:2], overwrite=True)
        shared = SharedFile(path("changing.bcc4"))
        self.assertEqual(len(shared.volume), 2)
        bccsplat.save(path("changing.bcc4"), self.source[:5], overwrite=True)
        self.assertEqual(len(SharedFile(path("changing.bcc4")).volume), 5)

    def test_chunks_are_those_of_the_file(self):
        self.assertEqual(sum(chunk_frames(self.volume)), 14)
        name = path("cc.bcc4")
        bccsplat.save(name, waves(20, 6, 6, 6), lattice="cc", overwrite=True)
        self.assertEqual(chunk_frames(bccsplat.open(name)), (8, 8, 4))
        for store in {}, {"lattice": "cc"}, {"lattice": "d4star"}:  # the first of a chunk alone reads it
            bccsplat.save(name, noise := waves(40, 12, 13, 14) + np.random.default_rng(1).normal(size=(40, 12, 13, 14)), overwrite=True,
                          **store)
            v, reads = bccsplat.open(name), []
            for t in range(40):
                before = v.info().bytes_read
                v.read_frame(t)
                reads.append(v.info().bytes_read - before)
            starts = {0, *np.cumsum(chunk_frames(v))[:-1].tolist()}
            self.assertEqual({t for t, read in enumerate(reads) if read} - starts, set(), (store, reads))
            self.assertGreater(len(starts), 2)
        self.assertEqual(noise.shape, v.shape)
        bccsplat.save(name, waves(1, 6, 6, 6), overwrite=True)
        self.assertEqual(chunk_frames(bccsplat.open(name)), (1,))
        # D4*: layers stand 1 / sqrt2 frames apart; slab s begins with layer 8 s, of which two lie before frame 0.
        bccsplat.save(name, waves(30, 6, 6, 6), lattice="d4star", ends="predict", overwrite=True)
        v = bccsplat.open(name)
        starts = [int(np.ceil((8 * s - 2) * v.info().scales[3] / np.sqrt(2) - 1e-9)) for s in range(1, 6)]
        self.assertEqual(np.cumsum(chunk_frames(v))[:-1].tolist(), starts)
        self.assertEqual(chunk_samples((100, 90, 80), (23, 23, 23), 1 << 30), (100, 90, 80))
        self.assertEqual(chunk_samples((100, 90, 80), (23, 23, 23), 100 * 90 * 40), (69, 46, 80))
        self.assertEqual(chunk_samples((10, 10, 10), (23, 23, 23), 1), (10, 10, 10))


class Looking(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        support.fresh_scratch()
        cls.name = path("s.bcc4")
        cls.source = waves(5, 20, 22, 24)
        bccsplat.save(cls.name, cls.source, dt=.5, spacing=(1, 2, 3), name="<d>", unit="g", spatial_unit="mm", time_unit="s")
        cls.volume = bccsplat.open(cls.name)

    def test_pictures(self):
        picture = self.volume.show(.75, width=90, height=80, rotate_y=10, mode="maximum")
        self.assertEqual((picture.pixels.shape, picture.pixels.dtype), ((80, 90, 4), np.uint8))
        self.assertGreater(np.asarray(picture)[..., :3].max(), 50)
        png = picture._repr_png_()
        self.assertEqual((png[:8], struct.unpack(">2I", png[16:24])), (b"\x89PNG\r\n\x1a\n", (90, 80)))
        picture.save(path("p.png"))
        with open(path("p.png"), "rb") as file:
            self.assertEqual(file.read(), png)
        by_frame = self.volume.show(frame=1.5, width=90, height=80, rotate_y=10, mode="maximum")
        self.assertEqual(by_frame._repr_png_(), png)
        other = self.volume.show(frame=3, width=90, height=80, rotate_y=10, mode="maximum", background=None)
        self.assertNotEqual(other._repr_png_(), png)
        self.assertEqual(other.pixels[0, 0, 3], 0)
        cut = self.volume.slice(plane=(1, 0, 0, 0, -5))
        self.assertTrue(cut._repr_png_().startswith(b"\x89PNG"))
        html = self.volume._repr_html_()
        for text in ("24 x 22 x 20, 5 frames", "channel &lt;d&gt;", "data:image/png;base64,"):
            self.assertIn(text, html)

    def test_scans_are_seen_in_planes(self):
        bccsplat.save(path("scan.bcc4"), self.source, spacing=(2, 1.5, 3), spatial_unit="mm", abs_error=1e-3, overwrite=True,
                      attributes={"space": "right-anterior-superior"})
        volume = bccsplat.open(path("scan.bcc4"))
        pixels = volume.show(frame=2, layout="planes", width=604, height=200).pixels
        self.assertEqual(pixels.shape, (200, 604, 4))
        look, bounds = volume.look(), np.array(volume.slice(frame=2).seen_bounds()).reshape(2, 3)
        middle = np.rint(volume.world_to_index(bounds.mean(0))).clip(0, [23, 21, 19]).astype(int)
        # The axial plane: x, which is to the patient's right, falls; y, to his front, is up. 48 x 33 mm, all of it 60 mm high.
        scale = max(60, 48) / (.96 * 200)
        width, height = round(48 / scale), round(33 / scale)
        left, top = 404 + (200 - width) // 2, (200 - height) // 2
        self.assertEqual(np.flatnonzero((pixels[100, 404:, 3] > 0)).tolist(), list(range(left - 404, left - 404 + width)))
        wanted = volume.plane(frame=2, z=middle[2]).values
        for x, y in ((8, 8), (15, 9), (9, 13)):
            at = int((24 - x - .5) / 24 * width), int((22 - y - .5) / 22 * height)
            grey = np.clip((wanted[y, x] - look.range[0]) / (look.range[1] - look.range[0]), 0, 1)
            beside = np.abs(np.diff(wanted)).max() / (look.range[1] - look.range[0]) * 24 / width
            self.assertLess(abs(pixels[top + at[1], left + at[0], 0] / 255 - grey), 2 * beside + .01, (x, y))
        self.assertEqual(look.layout, bccsplat.abi.LAYOUT_BOTH)
        size = {"width": 402, "height": 302}
        both = volume.show(frame=2, layout="both", **size).pixels
        np.testing.assert_array_equal(volume.show(frame=2, **size).pixels, both)
        alone = volume.show(frame=2, layout="volume", width=199, height=149)
        np.testing.assert_array_equal(both[152:301, 202:401], alone.pixels)
        turned = volume.show(frame=2, rotate_y=31, **size)
        np.testing.assert_array_equal(turned.pixels, volume.show(frame=2, rotate_y=31, layout="volume", **size).pixels)
        self.assertEqual(volume.show().pixels.shape, (1024, 1024, 4))
        np.testing.assert_array_equal(volume.show(**size).pixels, volume.show(frame=look.frame, **size).pixels)
        with self.assertRaisesRegex(ValueError, "no room for planes"):
            volume.show(layout="planes", width=200, height=90)
        self.assertEqual(self.volume.show(**size).pixels.shape, (302, 402, 4))
        self.assertEqual(self.volume.look().layout, bccsplat.abi.LAYOUT_VOLUME)

    def test_looks_are_of_what_is_drawn(self):
        bccsplat.save(path("two.bcc4"), {"a": self.source, "b": 100 + 50 * self.source}, overwrite=True)
        volume = bccsplat.open(path("two.bcc4"))
        for mode in ("composite", "maximum"):
            of = bccsplat.TransferFunction.of(volume.look(1, "fire", mode))
            wanted = volume.show(frame=1, channel="b", width=40, height=40, mode=mode, transfer_function=of)
            named = {"width": 40, "height": 40, "mode": mode, "look": "fire"}
            for picture in (volume.show(frame=1, channel=1, **named), volume.slice(frame=1, channel="b").show(**named)):
                np.testing.assert_array_equal(picture.pixels, wanted.pixels)

    def test_planes(self):
        plane = self.volume.plane(1.25, z=7.5)
        np.testing.assert_allclose(plane.values, FieldArray(self.volume, [[2.5], [7.5], np.arange(22), np.arange(24)]).read()[0, 0])
        self.assertEqual((plane.axes, plane.extent, plane.unit), (("x", "y"), (-.5, 23.5, -1., 43.), "mm"))
        self.assertEqual(plane.title, "<d>, z = 22.5 mm, t = 1.25 s")
        along = self.volume.plane(frame=2, x=3)
        np.testing.assert_array_equal(along.values, self.volume[2, :, :, 3])
        self.assertEqual((along.axes, along.extent), (("y", "z"), (-1., 43., -1.5, 58.5)))
        np.testing.assert_array_equal(self.volume.plane(y=4).values, self.volume[2, :, 4])
        with self.assertRaisesRegex(ValueError, "one of x, y and z"):
            self.volume.plane(0)

    @unittest.skipIf(*without("matplotlib"))
    def test_matplotlib(self):
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        _, ax = pyplot.subplots()
        image = self.volume.plane(1, z=3).imshow(ax, cmap="gray")
        self.assertEqual((tuple(image.get_extent()), ax.get_xlabel(), ax.get_ylabel()), ((-.5, 23.5, -1., 43.), "x (mm)", "y (mm)"))
        np.testing.assert_array_equal(image.get_array(), self.volume[2, 3])
        self.assertEqual(ax.get_title(), "<d>, z = 9 mm, t = 1 s")


class Words(unittest.TestCase):
    def test_every_public_name_is_explained(self):
        import inspect
        silent = []
        for name in [*bccsplat.__all__, "open"]:
            thing = getattr(bccsplat, name)
            if inspect.isclass(thing) and not issubclass(thing, Exception) and name != "Status":
                members = [(name + "." + key, value) for key, value in vars(thing).items() if not key.startswith("_")]
                silent += [key for key, value in members
                           if (callable(value) or isinstance(value, (property, classmethod, staticmethod)))
                           and not inspect.getdoc(value if callable(value) or isinstance(value, property) else value.__func__)]
            if callable(thing) and not inspect.getdoc(thing):
                silent.append(name)
        self.assertEqual(silent, [])

    def test_optional_packages_are_not_loaded(self):
        code = "import sys, bccsplat; print([n for n in ('xarray', 'dask', 'zarr', 'matplotlib') if n in sys.modules])"
        run = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, check=True,
                             env={**os.environ, "PYTHONPATH": support.PYTHON})
        self.assertEqual(run.stdout, "[]\n")

    def test_contents_are_printed(self):
        run = subprocess.run([sys.executable, "-B", "-m", "bccsplat"], capture_output=True, text=True, check=True,
                             env={**os.environ, "PYTHONPATH": support.PYTHON})
        lines = dict(line.split(None, 1) for line in run.stdout.splitlines())
        self.assertEqual(lines["bccsplat"], "%d.%d.%d, ABI %d" % (*bccsplat.version(), abi.ABI_VERSION))
        self.assertEqual(lines["package"], os.path.join(support.PYTHON, "bccsplat"))
        self.assertIn("openexr", lines["image"])


if __name__ == "__main__":
    support.main()

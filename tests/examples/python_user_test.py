"""python_user_test.py TOP EXAMPLES SCRATCH: what a new user types with help() alone works, and what is wrong is said in a
sentence: of the package, of xarray's side of it where that is installed, and of the programs in examples/python."""
import ctypes
import gc
import inspect
import os
import pydoc
import signal
import subprocess
import sys
import threading
import traceback
import unittest

import python_support as support
from python_support import path, waves, without

support.need("numpy")
import numpy as np  # noqa: E402

import bccsplat  # noqa: E402
from bccsplat import Error  # noqa: E402


class User(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        support.fresh_scratch()
        cls.source = waves(14, 12, 14, 16)
        bccsplat.save(path("run.bcc4"), cls.source, dt=.5, time_unit="s", spacing=2, spatial_unit="mm", name="density")
        bccsplat.save(path("other.bcc4"), cls.source + .25, dt=.5)
        cls.volume = bccsplat.open(path("run.bcc4"))

    def refused(self, kind, text, function, *arguments, **named):
        with self.assertRaisesRegex(kind, text) as caught:
            function(*arguments, **named)
        said = str(caught.exception)
        self.assertGreater(len(said.split()), 3, said)
        self.assertNotIn("object has no attribute", said)


class TenLines(User):
    """In order: open, look, a series at a point, a slice between frames, a plane, a tilted slice, compare, write, film, ask."""

    def test_they_work(self):
        before = os.getcwd()
        self.addCleanup(os.chdir, before)
        os.chdir(support.SCRATCH)
        volume = bccsplat.open("run.bcc4")
        volume.show(3.2, look="ct-bone", width=64, height=64).save("look.png")
        series = volume[:, 6, 7, 8]
        between = volume.at(3.2)
        plane = volume.plane(3.2, z=5.5)
        tilted = volume.slice(plane=(1, 0, 0, 1, -12)).sample_grid()
        apart = np.abs(volume.at(3.2) - bccsplat.open("other.bcc4").at(3.2)).max()
        bccsplat.save("slow.bcc4", volume[np.arange(0, 13.5, .5)], dt=.25, time_unit="s")
        film = [volume.show(time, width=32, height=32).pixels for time in volume.times()]
        told = repr(volume.info()) + repr(volume.verify())

        np.testing.assert_allclose(series, self.source[:, 6, 7, 8], atol=.1)
        np.testing.assert_allclose(between, self.volume[6.4], atol=1e-5)
        self.assertEqual((plane.values.shape, plane.unit, tilted.ndim), ((14, 16), "mm", 3))
        self.assertAlmostEqual(float(apart), .25, delta=.05)
        self.assertEqual(len(bccsplat.open("slow.bcc4")), 27)
        self.assertEqual((len(film), film[0].shape), (14, (32, 32, 4)))
        self.assertRegex(told, r"VolumeInfo\(.*dims=\[16, 14, 12, 14\].*time_unit='s'.*VerifyReport\(chunks=\d+, chunks_damaged=0")
        for name in ("Volume", "Slice", "Plane"):
            shown = repr({"Volume": volume, "Slice": volume.slice(time=1), "Plane": plane}[name])
            self.assertRegex(shown, r"<bccsplat\.%s \[.*\] = \(\d+" % name)

    def test_help_tells_of_everything(self):
        for name in bccsplat.__all__ + ["open"]:
            made = getattr(bccsplat, name)
            if inspect.ismodule(made):
                continue
            self.assertTrue(inspect.getdoc(made), name)
            for key, member in vars(made).items() if inspect.isclass(made) else ():
                if not key.startswith("_") and inspect.isfunction(member):
                    self.assertTrue(inspect.getdoc(member), "%s.%s" % (name, key))
        told = pydoc.render_doc(bccsplat)
        for line in ("bccsplat.save(", "volume = bccsplat.open(", "volume[12.5]", "volume.show("):
            self.assertIn(line, told)

    def test_names_of_channels_go_everywhere(self):
        v = self.volume
        np.testing.assert_array_equal(v.evaluate([1, 2, 3, 4.5], "density"), v.evaluate([1, 2, 3, 4.5]))
        np.testing.assert_array_equal(v.plane(1, z=3, channel="density").values, v.plane(1, z=3).values)
        self.assertEqual(v.slice(time=1, channel="density").info().dims[:], v.slice(time=1).info().dims[:])
        np.testing.assert_array_equal(v.show(1, channel="density", width=16, height=16).pixels, v.show(1, width=16, height=16).pixels)
        for call in (v.at, v.show, v.slice):
            self.refused(Error, "no channel named mass", call, time=1, channel="mass")


@unittest.skipUnless(hasattr(os, "fork"), "this system does not fork")
class Motion(User):
    def test_moments_follow_it_where_they_are_asked_to(self):
        t, z, y, x = np.ogrid[0:8, 0:40, 0:40, 0:40]
        at = lambda t: np.exp(-((x - 6 - 4 * t) ** 2 + (y - 20) ** 2 + (z - 20) ** 2) / 18).astype(np.float32)  # noqa: E731
        bccsplat.save(path("mover.bcc4"), at(t))
        volume = bccsplat.open(path("mover.bcc4"))
        error = {on: np.square(volume.slice(frame=3.5, motion=on).sample_grid() - at(3.5)[0]).sum() for on in (False, True)}
        self.assertLess(error[True], .5 * error[False])
        again = volume.slice(time=3.5, motion=True)
        self.assertEqual(again.__reduce__()[1][3]["motion"], True)
        with self.assertRaises(Error):
            volume.slice(frame=3.5, motion=True, box=((1, 1, 1), (5, 5, 5)))


class Forks(User):
    def in_child(self, work):
        """Runs it in a forked process, which has 20 s."""
        child = os.fork()
        if child == 0:
            try:
                signal.alarm(20)
                work()
                os._exit(0)
            except BaseException:
                traceback.print_exc()
                os._exit(1)
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

    def test_a_child_has_threads_and_locks_of_its_own(self):
        opened, stop = bccsplat.open(path("run.bcc4"), device=bccsplat.Device(threads=4)), threading.Event()
        with open(path("run.bcc4"), "rb") as file:
            volumes = [opened, opened.reopen(), bccsplat.open(file.read())]
        cuts = [opened.slice(frame=2.5, box=((1, 1, 1), (9, 9, 9))), opened.slice(time=1.25), opened.slice(plane=(1, 0, 0, -1, 0))]
        # Tokens that nobody else has stay with what is made anew.
        cuts.append(bccsplat.Volume(opened.device, path("run.bcc4"), cancel=bccsplat.CancelToken()).slice(frame=2.5, cancel=bccsplat.CancelToken()))
        right = [cut.sample_grid() for cut in cuts], volumes[0][2.5], opened.show(1, width=16, height=16).pixels
        renderer = bccsplat.Renderer(opened.device)

        def read_on():
            while not stop.is_set():
                opened.at(6 * np.random.rand())

        def work():
            for cut, grid in zip(cuts, right[0]):
                np.testing.assert_array_equal(cut.sample_grid(), grid)
            for volume in volumes:
                np.testing.assert_array_equal(volume[2.5], right[1])
            np.testing.assert_array_equal(opened.show(1, width=16, height=16).pixels, right[2])
            self.refused(ValueError, "a renderer of the process that this one was forked from", renderer.stats)

        threads = [threading.Thread(target=read_on) for _ in range(3)]
        for thread in threads:
            thread.start()
        try:
            self.assertEqual([self.in_child(work) for _ in range(5)], [0] * 5)
        finally:
            stop.set()
            for thread in threads:
                thread.join()


class Mistakes(User):
    def test_of_opening(self):
        self.refused(Error, "cannot open", bccsplat.open, path("none.bcc4"))
        self.refused(Error, "not a .bcc4 file", bccsplat.open, __file__)
        self.refused(TypeError, "a path, its bytes, or", bccsplat.open, 3)
        self.refused(TypeError, "a bccsplat.Device, not 'cpu'", bccsplat.open, path("run.bcc4"), device="cpu")
        self.refused(Error, "Kernels are", bccsplat.open, path("run.bcc4"), kernel="bicubic")
        self.refused(TypeError, "unexpected keyword argument 'cache'", bccsplat.open, path("run.bcc4"), cache=3)
        self.refused(FileNotFoundError, "cannot open", bccsplat.open, path("none.bcc4"))
        self.refused(ValueError, "cache_bytes of VolumeOptions cannot be -1", bccsplat.open, path("run.bcc4"), cache_bytes=-1)

    def test_of_indexing(self):
        for key, text in ((99, "out of bounds for 14 frames"), ("density", r"volume.field\('density'\)"), ((0, 3.5), "whole numbers"),
                          (slice(1.5, 3), "numpy.arange"), (None, "is no frame"), (np.nan, "is no frame"), ((0, 99), "axis z of 12"),
                          (0j, "is no frame"), ((0, "a"), "whole numbers")):
            self.refused(IndexError, text, self.volume.__getitem__, key)
        self.refused(Error, "outside the series, 0 to 13", self.volume.__getitem__, 13.5)

    def test_of_places_and_times(self):
        v = self.volume
        self.refused(Error, "time 99 is outside the series, 0 to 6.5", v.at, 99)
        self.refused(TypeError, "'1' is given where a number is wanted", v.at, "1")
        self.refused(ValueError, "must be numbers, not 'abc'", v.evaluate, "abc")
        self.refused(ValueError, r"shape \[..., 4\]", v.evaluate, [1, 2, 3])
        self.refused(Error, "outside 0 to 15", v.evaluate, [100, 2, 3, 4])
        self.refused(ValueError, "five numbers", v.slice, plane=(1, 0, 0, 0))
        self.refused(ValueError, "two corners", v.slice, time=1, box=3)
        self.refused(ValueError, "one of time, frame and plane", v.slice)
        self.refused(ValueError, "and a step to them", v.slice(frame=0).sample_grid, step=(2, 2, 2))
        self.refused(TypeError, "unexpected keyword argument 'chanel'", v.slice, time=1, chanel=0)
        self.refused(TypeError, "unexpected keyword argument 'w'", v.plane, 1, w=3)
        self.refused(ValueError, "z = 99 lies outside the samples, 0 to 11", v.plane, 1, z=99)
        self.refused(ValueError, "levels 0 to 0", v.at, 1, level=3)

    def test_of_pictures(self):
        show = self.volume.show
        for named, kind, text in (({"mode": "maxi"}, ValueError, "maximum"), ({"look": "bone"}, ValueError, "ct_bone"),
                                  ({"colour": 3}, TypeError, "unexpected keyword argument 'colour'"), ({"width": 0}, ValueError, "not 0 x 512"),
                                  ({"height": -5}, ValueError, "not 512 x -5"), ({"channel": 5}, Error, "channel 5 of a file with 1"),
                                  ({"background": "black"}, ValueError, "background.*not 'black'"),
                                  ({"transfer_function": 3}, TypeError, "a TransferFunction is wanted"), ({"frame": 3}, ValueError, "one of"),
                                  ({"opacity_stop": "low"}, ValueError, "opacity_stop is a number, not 'low'"),
                                  ({"sheet_step": None}, TypeError, "sheet_step of RenderOptions cannot be None")):
            self.refused(kind, text, show, 1, **named)
        picture = show(1, width=16, height=16)
        self.refused(ValueError, "must end in .png", picture.save, path("x.jpg"))
        self.refused(Error, "cannot create", picture.save, path("none/x.png"))
        self.refused(ValueError, "rows \\(value, red, green, blue\\)", bccsplat.TransferFunction, [1, 2, 3], [(0, 1)])
        self.refused(ValueError, "-1 is given where a number from 0 on", bccsplat.Frame, bccsplat.default_device(), -1, 5)

    def test_of_saving(self):
        a = self.source
        for array, named, kind, text in (
                (a[0, 0], {}, ValueError, "not of shape"), (a.astype(complex), {}, ValueError, "numbers of 1 to 8 bytes"),
                ({}, {}, ValueError, "no channel"), (np.where(a > 2, np.nan, a), {}, Error, "treat them as holes"),
                (a, {"spacing": (1, 2, 3, 4)}, ValueError, "spacing must be numbers of shape"), (a, {"dt": 0}, Error, "times rise"),
                (a, {"dt": 0, "lattice": "cc"}, Error, "does not rise"),
                (a, {"affine": np.eye(3)}, ValueError, "affine must be"), (a, {"lattice": "fcc"}, ValueError, "d4star"),
                (a, {"compression": 3}, TypeError, "unexpected keyword argument 'compression'"), (a, {"times": "now"}, ValueError, "times must be numbers"),
                (a, {"attributes": {"a": 3}}, TypeError, "3 is given where a text"), (a, {"psnr": "high"}, TypeError, "decibels"),
                (a, {"levels": "two"}, ValueError, "levels is a number, not 'two'")):
            self.refused(kind, text, bccsplat.save, path("bad.bcc4"), array, **named)
            self.assertFalse(os.path.exists(path("bad.bcc4")))
        self.refused(Error, "exists already", bccsplat.save, path("run.bcc4"), a)
        self.refused(FileExistsError, "exists already", bccsplat.save, path("run.bcc4"), a)
        self.refused(Error, "cannot create", bccsplat.save, path("none/run.bcc4"), a)

    def test_of_writers(self):
        def add(frame):
            with bccsplat.Writer(bccsplat.default_device(), path("w.bcc4"), (16, 14, 12, 14)) as writer:
                writer.add_frame(frame, 0)

        self.refused(ValueError, r"of shape \(12, 14, 16\), not \(5, 14, 16\)", add, self.source[0, :5])
        self.refused(ValueError, "makes an array of lists", add, self.source[0].tolist())
        self.refused(ValueError, "dims are the samples", bccsplat.Writer, bccsplat.default_device(), path("w.bcc4"), (16, 14))

    def test_of_structs(self):
        abi = bccsplat.abi
        for struct, named, kind, text in (
                (abi.WriterOptions, {"wavelet_errors": 4}, TypeError, "wavelet_errors of WriterOptions is a sequence or an array of numbers, not 4"),
                (abi.WriterOptions, {"abs_errors": "abc"}, TypeError, "abs_errors .* not 'abc'"),
                (abi.WriterOptions, {"abs_errors": [1, "a"]}, TypeError, "abs_errors .* not"),
                (abi.WriterOptions, {"channels": 4}, TypeError, "a ChannelOptions, or a sequence of these, not 4"),
                (abi.WriterOptions, {"part": 4}, TypeError, "part of WriterOptions is a SeriesPart, not 4"),
                (abi.WriterOptions, {"time_unit": 4}, TypeError, "time_unit of WriterOptions is a text, not 4"),
                (abi.WriterOptions, {"cancel_token": 4}, TypeError, "cancel_token of WriterOptions is an array of numpy, or a handle, not 4"),
                (abi.WriterOptions, {"channel_count": 3, "channels": [abi.ChannelOptions()]}, ValueError, "cannot be 3: 1 are given"),
                (abi.SliceOptions, {"point": [1, 2]}, ValueError, "point of SliceOptions are 4 numbers, not"),
                (abi.TransferFunction, {"colors": [1, 2, 3, 4]}, ValueError, "colors of TransferFunction are rows of 4 numbers"),
                (abi.HostPlane, {"pixels": 4}, TypeError, "pixels of HostPlane is an array"), (abi.Box, {"data": True}, TypeError, "data of Box")):
            self.refused(kind, text, struct, **named)
        # Each pointer of each struct: a number is no address.
        structs = [kind for kind in vars(abi).values() if isinstance(kind, type) and hasattr(kind, "_fields_")]
        pointers = [(kind, name) for kind in structs for name, field, *_ in kind._fields_
                    if field in (ctypes.c_void_p, ctypes.c_char_p) or hasattr(field, "contents")]
        self.assertGreater(len(pointers), 50)
        for kind, name in pointers:
            self.refused(TypeError, "%s of %s is a" % (name, kind.__name__), setattr, kind(), name, 4)
        self.refused(ValueError, "wavelet_errors is a number, or those of all 2 channels", bccsplat.Writer, bccsplat.default_device(),
                     path("w.bcc4"), (8, 8, 8, 1), channels=[bccsplat.Channel("a"), bccsplat.Channel("b")], wavelet_errors=[1])

    def test_what_structs_look_at_lives_on(self):
        abi = bccsplat.abi
        made = abi.WriterOptions(wavelet_errors=np.arange(3)[::-1], channels=[abi.ChannelOptions(name="ä"), abi.ChannelOptions()],
                                 axes=[abi.Axis(coordinates=np.linspace(0, n, 1000), unit="m") for n in range(3)], part=abi.SeriesPart(times=range(5)))
        shown = abi.Trail(transfer_functions=[abi.TransferFunction(colors=np.full((50, 4), n)) for n in range(3)])
        gc.collect()
        other = [np.full(4000, -1.0) for _ in range(50)]  # where what was freed would be
        self.assertEqual((made.wavelet_errors[:3], made.channel_count, made.channels[0].name, made.channels[1].name), ([2, 1, 0], 2, "ä", ""))
        self.assertEqual((made.axes[2].count, made.axes[2].coordinates[999], made.axes[2].unit, made.part.contents.times[4]), (1000, 2, "m", 4))
        self.assertEqual((shown.transfer_functions[2].color_count, shown.transfer_functions[2].colors[199]), (50, 2))
        self.assertEqual(len(other), 50)
        values = np.zeros(4)
        made.abs_errors = values
        values[2] = 5  # an array of its type is looked into
        self.assertEqual(made.abs_errors[2], 5)
        values.flags.writeable = False
        made.abs_errors = values
        self.assertEqual(made.abs_errors[:4], [0, 0, 5, 0])

    def test_texts_are_str(self):
        infos = self.volume.info(), self.volume.channel_info(), self.volume.slice(frame=0).info()
        for info in infos:
            for name, field, *_ in info._fields_:
                if field is ctypes.c_char_p:
                    self.assertIs(type(getattr(info, name)), str, name)
        self.assertEqual((infos[0].time_unit, infos[0].spatial_unit, infos[1].name, infos[1].unit), ("s", "mm", "density", ""))
        self.assertEqual((self.volume.axis(0)[1], self.volume.channels), ("", ["density"]))

    def test_of_closed_things(self):
        volume = bccsplat.open(path("run.bcc4"))
        cut = volume.slice(time=1)
        for made in (volume, cut):
            made.close()
            self.assertRegex(repr(made), "closed")
        self.refused(ValueError, "a volume that was closed", volume.at, 1)
        self.refused(ValueError, "a slice that was closed", cut.sample_grid)

    def test_of_an_installation(self):
        done = subprocess.run([sys.executable, "-B", "-c", "import bccsplat"], capture_output=True, text=True,
                              env={**os.environ, "BCCSPLAT_LIBRARY": path("none.so")})
        self.assertRegex(done.stderr, "ImportError: bccsplat: the library does not load.*install a wheel")

    def test_of_programs(self):
        for name, *arguments in (("film.py",), ("probes.py", path("run.bcc4"), path("p.csv")), ("compare_runs.py", path("run.bcc4")),
                                 ("retime.py", path("run.bcc4"))):
            done = subprocess.run([sys.executable, "-B", os.path.join(support.PYTHON, name), *arguments], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr.split(" ")[0]), (1, name))
        done = subprocess.run([sys.executable, "-B", "-m", "bccsplat", path("none.bcc4"), path("x.png")], capture_output=True, text=True)
        self.assertRegex(done.stderr, "^.*none.bcc4: cannot open")
        self.assertEqual(done.returncode, 1)


@unittest.skipIf(*without("xarray"))
class MistakesOfDatasets(User):
    def test_they_are_said(self):
        import xarray as xr

        import bccsplat.accessor  # noqa: F401
        from bccsplat.xarray_backend import BccsplatBackend
        ds = xr.open_dataset(path("run.bcc4"), engine=BccsplatBackend)
        other = xr.Dataset({"f": (("time", "z", "y", "x"), self.source)})
        self.refused(ValueError, "levels 0 to 0", xr.open_dataset, path("run.bcc4"), engine=BccsplatBackend, level=2)
        self.refused(Error, "outside the series", ds.bcc4.at, 99)
        self.refused(ValueError, "does not know the date of its time 0", ds.bcc4.at, "2020-01-01")
        self.refused(ValueError, "not lat", ds.bcc4.interp, lat=3)
        self.refused(ValueError, "interpolate before you calculate", other.bcc4.at, 1)
        self.refused(ValueError, "the coordinate x must be numbers", other.assign_coords(x=list("abcdefghijklmnop")).bcc4.to_file,
                     path("d.bcc4"))
        if not without("dask")[0]:
            for parts in (0, -1, 15, 1.5):
                self.refused(ValueError, "parts must be 1 to 14", other.chunk().bcc4.to_file, path("d.bcc4"), parts=parts)
            self.refused(FileNotFoundError, "there is no folder", other.chunk().bcc4.to_file, path("none/d.bcc4"), parts=2)


if __name__ == "__main__":
    support.main()

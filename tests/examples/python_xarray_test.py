"""python_xarray_test.py TOP EXAMPLES SCRATCH TOOL: the engine "bccsplat" of xarray, the accessor dataset.bcc4, and datasets
written at once and by parts. Skips, loudly, what needs dask or distributed where these are missing."""
import os
import pickle
import signal
import subprocess
import sys
import time
import unittest
import warnings
from unittest import mock

import python_support as support
from python_support import path, waves, without

support.need("numpy", "xarray")
import numpy as np  # noqa: E402
import xarray as xr  # noqa: E402

import bccsplat  # noqa: E402
import bccsplat.accessor  # noqa: E402, F401
from bccsplat import Error, Status  # noqa: E402


def open_file(name, **options):
    return xr.open_dataset(path(name), engine="bccsplat", **options)


def computing(block, log=None, pause=0.0, block_info=None):
    """A chunk of an array, of which it is noted that it was computed; by whichever process."""
    if log is not None and block.size > 1:
        with open(log, "a", encoding="utf-8") as file:
            file.write("%d %d\n" % (os.getpid(), block_info[0]["array-location"][0][0] if block_info else -1))
        time.sleep(pause)
    return block


class Reading(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.source = waves(14, 20, 22, 24)
        bccsplat.save(path("s.bcc4"), {"d": cls.source, "e": -cls.source}, lattice="d4star", dt=.04, start=1, spacing=(1, 2, -3), origin=5,
                      unit="g", spatial_unit="mm", time_unit="s", attributes={"title": "waves"}, levels=1)
        cls.volume = bccsplat.open(path("s.bcc4"))
        cls.whole = np.asarray(cls.volume)

    def test_a_dataset(self):
        ds = open_file("s.bcc4")
        self.assertEqual((ds["d"].dims, ds["d"].shape, ds["d"].dtype), (("time", "z", "y", "x"), (14, 20, 22, 24), np.float32))
        np.testing.assert_array_equal(ds["d"].values, self.whole)
        np.testing.assert_array_equal(ds["e"][3].values, self.volume.field("e")[3])
        np.testing.assert_allclose(ds.time, 1 + .04 * np.arange(14))
        np.testing.assert_allclose(ds.z, 5 - 3 * np.arange(20))
        np.testing.assert_allclose(ds.y, 5 + 2 * np.arange(22))
        self.assertEqual((ds["d"].attrs["units"], ds["d"].attrs["long_name"], ds.x.attrs["units"], ds.x.attrs["axis"],
                          ds.time.attrs["units"], ds.time.attrs["standard_name"], ds.attrs["Conventions"], ds.attrs["title"]),
                         ("g", "d", "mm", "X", "s", "time", "CF-1.8", "waves"))
        np.testing.assert_allclose(ds["d"].attrs["actual_range"], [self.source.min(), self.source.max()])
        self.assertEqual(set(open_file("s.bcc4", drop_variables="d").data_vars), {"e"})
        self.assertEqual(set(xr.open_dataset(path("s.bcc4")).data_vars), {"d", "e"})  # by the file's name

    def test_only_what_is_indexed_is_read(self):
        bccsplat.save(path("large.bcc4"), waves(6, 96, 96, 96), lattice="d4star")
        ds = open_file("large.bcc4")
        volume, read = ds.bcc4.volume, {}

        def bytes_of(name, make):
            before = volume.info().bytes_read
            made = make()
            read[name] = volume.info().bytes_read - before
            return made

        part = bytes_of("selecting", lambda: ds.value.isel(time=2, z=slice(0, 8), y=slice(0, 8)).sel(x=slice(0, 7)))
        bytes_of("moment", lambda: ds.bcc4.at(2.5))
        corner = bytes_of("corner", part.load)
        frame = bytes_of("frame", ds.value.isel(time=2).load)
        bytes_of("another moment", lambda: ds.bcc4.at(3.5))
        self.assertEqual((read["selecting"], read["moment"], read["another moment"]), (0, 0, 0))
        self.assertGreater(read["corner"], 0)
        self.assertLess(8 * read["corner"], read["frame"], read)
        np.testing.assert_allclose(corner, frame[:8, :8, :8], atol=2e-6)
        bytes_of("again", ds.value.isel(time=2).load)
        self.assertEqual(read["again"], 0)

    def test_memory_of_what_was_read(self):
        bccsplat.save(path("cached.bcc4"), waves(6, 96, 96, 96), lattice="d4star")
        held = {}
        for size in (1 << 20, 1 << 30):
            before = bccsplat.default_device().info().memory_used
            ds = open_file("cached.bcc4", cache_bytes=size)
            ds.value.load()
            held[size] = bccsplat.default_device().info().memory_used - before
            del ds
        self.assertGreater(held[1 << 30], 4 * max(held[1 << 20], 1 << 20))

    def test_levels(self):
        ds = open_file("s.bcc4", level=1)
        self.assertEqual(ds["d"].shape, (14, 10, 11, 12))
        np.testing.assert_allclose(ds.y, 5 + 4 * np.arange(11))
        np.testing.assert_array_equal(ds["d"].values, self.volume.field(0, 1).read())
        self.assertEqual(ds.bcc4.at(1.1)["d"].shape, (10, 11, 12))
        self.assertEqual(ds.bcc4.level, 1)
        coarse = ds.bcc4.at(1.1)["d"].values
        ds.attrs = {}  # as many operations leave it
        self.assertEqual(ds.bcc4.level, 1)
        np.testing.assert_array_equal(ds.bcc4.at(1.1)["d"].values, coarse)
        with self.assertRaisesRegex(ValueError, "levels 0 to 1"):
            open_file("s.bcc4", level=2)

    def test_moments_between_frames(self):
        ds = open_file("s.bcc4")
        at = ds.bcc4.at(1.1)
        self.assertEqual((at["d"].dims, float(at.time)), (("z", "y", "x"), 1.1))
        frame = self.volume.time_to_index(1.1)
        np.testing.assert_array_equal(at["d"].values, self.volume[frame])
        np.testing.assert_array_equal(at["d"].isel(z=3, x=slice(2, 9))[4:6].values, self.volume[frame, 3, 4:6, 2:9])
        some = ds.isel(z=3, y=slice(2, 9)).bcc4.at([1.1, 1.3])
        self.assertEqual(some["e"].dims, ("time", "y", "x"))
        np.testing.assert_allclose(some["e"].values,
                                   self.volume.field("e").select((slice(0, 2), 3, slice(2, 9))).__class__(
                                       self.volume, [[frame, self.volume.time_to_index(1.3)], [3], np.arange(2, 9),
                                                     np.arange(24)], 1).read()[:, 0], atol=1e-6)
        with self.assertRaises(Error) as caught:
            ds.bcc4.at(3)
        self.assertEqual(caught.exception.status, Status.OUT_OF_DOMAIN)
        with self.assertRaisesRegex(ValueError, "interpolate before you calculate"):
            (ds + 1).bcc4.at(1.1)
        bccsplat.save(path("other.bcc4"), self.source, dt=.04, start=1, spacing=(1, 2, -3), origin=5, name="o", overwrite=True)
        with self.assertRaisesRegex(ValueError, "of several files"):
            ds.merge(open_file("other.bcc4"), compat="override").bcc4.at(1.1)
        renamed = ds.rename(d="density").chunk({"time": 5}).bcc4.at(1.1)
        np.testing.assert_array_equal(renamed["density"].values, at["d"].values)

    def test_interpolation_in_space_and_along_paths(self):
        ds = open_file("s.bcc4")
        grid = ds.bcc4.interp(time=[1.1, 1.2], x=[6.25, 9], z=5 - 3 * 4.5)
        self.assertEqual(grid["d"].dims, ("time", "y", "x"))
        t, y, x = np.meshgrid([2.5, 5], np.arange(22), [1.25, 4], indexing="ij")
        np.testing.assert_allclose(grid["d"].values, self.volume.evaluate(np.stack([x, y, np.full_like(x, 4.5), t], -1)), atol=2e-6)
        along = {"x": xr.DataArray([10., 20.5, 99], dims="s"), "y": xr.DataArray([10., 20.5, 10], dims="s"),
                 "z": xr.DataArray([-10., -20, -10], dims="s")}
        probes = ds.bcc4.interp(**along)
        self.assertEqual(probes["d"].dims, ("time", "s"))
        expected = [[self.volume.evaluate([[p - 5, (q - 5) / 2, (5 - r) / 3, k]])[0]
                     for p, q, r in ((10, 10, -10), (20.5, 20.5, -20))] for k in range(14)]
        np.testing.assert_allclose(probes["d"].values[:, :2], expected, atol=2e-6)
        self.assertTrue(np.isnan(probes["d"].values[:, 2]).all())
        with self.assertRaisesRegex(ValueError, "not lat"):
            ds.bcc4.interp(lat=3)
        with self.assertRaisesRegex(ValueError, "level 0"):
            open_file("s.bcc4", level=1).bcc4.interp(**along)

    def test_dates(self):
        dates = np.datetime64("2020-02-27T06:00", "ns") + np.arange(14) * np.timedelta64(12, "h")
        bccsplat.save(path("dates.bcc4"), self.source, dt=12, start=6, time_unit="hours",
                      attributes={"time_epoch": "2020-02-27 00:00:00"})
        ds = open_file("dates.bcc4")
        np.testing.assert_array_equal(ds.time.values, dates)
        for moment in ("2020-02-28T00:00", np.datetime64("2020-02-28T00:00"), 24.):
            np.testing.assert_array_equal(ds.bcc4.at(moment).value.values, bccsplat.open(path("dates.bcc4"))[1.5])
        self.assertEqual(ds.bcc4.at("2020-02-28T00:00").time.values, np.datetime64("2020-02-28T00:00"))
        bccsplat.save(path("h.bcc4"), self.source, times=dates, time_unit="h")  # a word that CF does not have
        np.testing.assert_array_equal(open_file("h.bcc4").bcc4.at("2020-02-28T00:00").value.values,
                                      bccsplat.open(path("h.bcc4"))[1.5])
        self.assertEqual(ds.sel(time="2020-03-01").value.shape[0], 2)
        with self.assertRaisesRegex(ValueError, "not durations"):
            ds.bcc4.at(np.timedelta64(24, "s"))
        numbers = open_file("dates.bcc4", decode_times=False)
        np.testing.assert_array_equal(numbers.time, 6 + 12. * np.arange(14))
        self.assertEqual(numbers.time.attrs["units"], "hours since 2020-02-27 00:00:00")
        bccsplat.save(path("ages.bcc4"), self.source, unit="days", time_unit="hours", attributes={"time_epoch": "2020-02-27"})
        ages = open_file("ages.bcc4").value
        self.assertEqual((ages.dtype, ages.attrs["units"], ages.time.dtype.kind), (np.float32, "days", "M"))
        with self.assertRaisesRegex(ValueError, "date of its time 0: give times as numbers of s"):
            open_file("s.bcc4").bcc4.at("2020-02-28")
        bccsplat.save(path("months.bcc4"), self.source[:3], time_unit="months", attributes={"time_epoch": "2020-01-01"})
        np.testing.assert_array_equal(open_file("months.bcc4").time, [0, 1, 2])

    @unittest.skipIf(*without("cftime"))
    def test_other_calendars(self):
        bccsplat.save(path("noleap.bcc4"), self.source, time_unit="days",
                      attributes={"time_epoch": "2020-02-27", "time_calendar": "noleap"})
        ds = open_file("noleap.bcc4")
        self.assertEqual([(day.month, day.day) for day in ds.time.values[:4]], [(2, 27), (2, 28), (3, 1), (3, 2)])
        np.testing.assert_array_equal(ds.bcc4.at(ds.time.values[3]).value.values, ds.value[3].values)
        ds.bcc4.to_file(path("noleap2.bcc4"))
        self.assertTrue((open_file("noleap2.bcc4").time.values == ds.time.values).all())
        bccsplat.save(path("360.bcc4"), self.source[:3], start=.5, time_unit="months",
                      attributes={"time_epoch": "1960-01-01", "time_calendar": "360"})
        self.assertEqual([(day.month, day.day) for day in open_file("360.bcc4").time.values], [(1, 16), (2, 16), (3, 16)])

    def test_oblique_places_are_sample_numbers(self):
        turn = np.array([[0, -2., 0, 1], [2, 0, 0, 2], [0, 0, 2, 3], [0, 0, 0, 1]])
        bccsplat.save(path("turned.bcc4"), self.source[:3], affine=turn, spatial_unit="mm")
        ds = open_file("turned.bcc4")
        np.testing.assert_array_equal(ds.x, np.arange(24))
        np.testing.assert_array_equal(np.reshape(ds.attrs["bcc4_affine"], (4, 4)), turn)
        ds.isel(x=slice(4, None, 2)).bcc4.to_file(path("turned2.bcc4"))
        found = np.reshape(open_file("turned2.bcc4").attrs["bcc4_affine"], (4, 4))
        np.testing.assert_allclose(found @ [0, 0, 0, 1], turn @ [4, 0, 0, 1])
        np.testing.assert_allclose(found @ [1, 0, 0, 1], turn @ [6, 0, 0, 1])
        again = bccsplat.open(path("turned2.bcc4"))
        self.assertEqual(again.info().spatial_unit, "mm")
        self.assertFalse([key for key in again.attributes() if key in ("axis.x", "axis.y", "axis.z")])  # numbers of samples

    def test_holes_are_nan(self):
        holes = self.source[:3].copy()
        holes[1, 2, 3, 4] = np.nan
        bccsplat.save(path("holes.bcc4"), holes, nonfinite="hole")
        np.testing.assert_array_equal(np.argwhere(np.isnan(open_file("holes.bcc4").value.values)), [[1, 2, 3, 4]])

    def test_other_processes(self):
        ds = pickle.loads(pickle.dumps(open_file("s.bcc4")))
        np.testing.assert_array_equal(ds["d"].values, self.whole)
        np.testing.assert_array_equal(ds.bcc4.at(1.04)["d"].values, self.whole[1])


class Changed(unittest.TestCase):
    """dataset.bcc4 answers from the file, and so not for a dataset that holds something else."""

    @classmethod
    def setUpClass(cls):
        cls.source = waves(14, 8, 9, 10)
        for name, offset, start in ("c.bcc4", 0, 1), ("same.bcc4", 1, 1), ("later.bcc4", 1, 8):
            bccsplat.save(path(name), {"density": cls.source + offset, "e": -cls.source}, dt=.5, start=start, spacing=(1, 2, -3))

    def setUp(self):
        self.ds = open_file("c.bcc4")

    def refused(self, ds, text="interpolate before you change values or coordinates"):
        self.assertIn("bcc4", ds["density"].encoding)  # else it is refused for that
        for _ in range(2):
            with self.assertRaisesRegex(ValueError, text):
                ds.bcc4.at(2.25)
        with self.assertRaisesRegex(ValueError, text):
            ds.bcc4.interp(time=2.25, x=[2.5], y=xr.DataArray([2., 4], dims="s"))

    def test_concatenated_along_time(self):
        for other in "same.bcc4", "later.bcc4":
            self.refused(xr.concat([self.ds, open_file(other)], "time"))

    def test_concatenated_along_a_new_dimension(self):
        for other in "c.bcc4", "same.bcc4":
            self.refused(xr.concat([self.ds, open_file(other)], "run"), "run, time, z, y, x, .*interpolate before you change dim")

    def test_shifted(self):
        self.refused(self.ds.shift(time=1))
        self.refused(self.ds.shift(x=-1))

    def test_rolled(self):
        self.refused(self.ds.roll(time=3))
        self.refused(self.ds.roll(y=1))

    def test_assigned_values(self):
        self.ds["density"][...] = 0
        self.refused(self.ds)
        loaded = open_file("c.bcc4").load()
        loaded["density"].values *= 1.01
        self.refused(loaded)

    def test_one_value_anywhere(self):
        """What no row through the middle meets, in each of the variables, and in the last block of frames."""
        for name, at in ("density", (0, 0, 0, 0)), ("density", (13, 7, 8, 9)), ("e", (13, 7, 0, 9)), ("e", (6, 0, 4, 5)):
            for block in 1, 1 << 24:
                loaded = open_file("c.bcc4").load()
                loaded[name].values[at] += .5
                with mock.patch("bccsplat.accessor._BLOCK", block):
                    self.refused(loaded, name + " are no longer those of .*c.bcc4")

    def test_one_place_anywhere(self):
        for axis in "time", "z", "y", "x":
            for n in 0, -1:
                places = self.ds[axis].values.copy()
                places[n] += .3 * (places[1] - places[0]) * (1 if n == 0 else -1)
                self.refused(open_file("c.bcc4").assign_coords({axis: places}))
                self.refused(open_file("c.bcc4").load().assign_coords({axis: places}))

    def test_assigned_variables(self):
        self.refused(self.ds.assign(density=self.ds["density"].copy(data=self.source + 1)))
        self.refused(self.ds.drop_vars("x").assign(density=self.ds["density"].drop_vars("x").copy(data=self.source + 1)))
        with self.assertRaisesRegex(ValueError, "e lies along time, z, y, not along the file's time, z, y, x"):
            self.ds.assign(e=self.ds["e"].isel(x=0, drop=True)).bcc4.at(2.25)

    def test_means(self):
        self.refused(self.ds.coarsen(time=2).mean())
        self.refused(self.ds.coarsen(z=2, x=5).mean())

    def test_assigned_coordinates(self):
        self.refused(self.ds.assign_coords(x=self.ds.x + 1))
        self.refused(self.ds.assign_coords(time=self.ds.time - .5))
        self.refused(self.ds.assign_coords(time=self.ds.time + 50))
        self.refused(self.ds.isel(z=3).assign_coords(z=0))

    def test_other_dimensions(self):
        self.refused(self.ds.transpose("x", "y", "z", "time"), "lies along x, y, z, time, not along the file's time, z, y, x")
        self.refused(self.ds.rename(x="lon"), "lies along time, z, y, lon, not along")

    def test_what_is_the_files_is_answered(self):
        holes, dates = self.source.copy(), np.datetime64("2020-02-27", "ns") + np.arange(14) * np.timedelta64(6, "h")
        holes[:, 2:6, 3:7, 2:5] = np.nan
        kinds = {"plain": {}, "holes": {"nonfinite": "hole"}, "labels": {"lattice": "cc", "labels": True},
                 "dates": {"times": dates},
                 "uneven": {"lattice": "cc", "axes": [(None, "", False), (np.arange(9.)**1.2, "", False), (None, "", False)]},
                 "periodic": {"periodic_axes": 1, "ends": "periodic"}, "coarse": {"levels": 1}, "two": {}, "bytes": {}}
        for kind, options in kinds.items():
            values = {"holes": holes, "labels": np.rint(3 * self.source), "bytes": (60 * self.source).astype(np.uint8),
                      "two": {"d": self.source, "e": 1e6 * self.source}}.get(kind, self.source)
            bccsplat.save(path(kind + ".fair.bcc4"), values, spacing=(.1, 1, -3), origin=.2, **options)
            for name, change in self.fair().items():
                with self.subTest(kind=kind, change=name):
                    ds = open_file(kind + ".fair.bcc4", level=int(kind == "coarse"))
                    changed = change(ds)
                    lost = {axis: ds[axis].values for axis in changed.dims if axis not in changed.coords}
                    for name, found in changed.bcc4.interp(**lost).data_vars.items():
                        largest = np.nanmax(abs(found.values), initial=0)
                        np.testing.assert_allclose(found, changed[name], rtol=2e-3, atol=1e-5 * largest)

    @staticmethod
    def fair():
        """What leaves the values at their coordinates as they are."""
        def third(ds, name):
            return (ds[name].values[1:] - ds[name].values[:-1]) / 3 + ds[name].values[:-1]

        def cast(ds, kind):
            small = ds.load()[[name for name in ds if float(abs(ds[name]).max()) < 6e4]]
            for variable in small.data_vars.values():
                variable.data = variable.data.astype(kind)
            return small

        fair = {"none": lambda ds: ds, "loaded": lambda ds: ds.load(), "a copy": lambda ds: ds.copy(deep=True),
                "a crop": lambda ds: ds.isel(time=slice(2, 9), y=slice(None, None, 2), x=slice(1, 4)),
                "turned": lambda ds: ds.isel(time=slice(None, None, -1), x=slice(None, None, -1)),
                "a plane": lambda ds: ds.isel(z=2).sel(y=1, method="nearest"), "a frame": lambda ds: ds.isel(time=-1),
                "a value": lambda ds: ds.isel(time=3, z=2, y=1, x=0), "nothing": lambda ds: ds.isel(time=slice(0), x=slice(0)),
                "renamed": lambda ds: ds.rename({name: name + "2" for name in ds}),
                "no coordinate": lambda ds: ds.drop_vars(["x", "time"]),
                "moments": lambda ds: ds.bcc4.at(third(ds, "time")).load(),
                "places": lambda ds: ds.bcc4.interp(x=third(ds, "x"), y=third(ds, "y")).load().isel(z=slice(0, 2)),
                "outside": lambda ds: ds.bcc4.interp(x=ds.x.values - .55).load(), "doubles": lambda ds: cast(ds, np.float64),
                "short floats": lambda ds: cast(ds, np.float16), "another coordinate": lambda ds: ds.assign_coords(member=3),
                "rolled": lambda ds: ds.roll(x=2, roll_coords=True),
                "joined": lambda ds: xr.concat([ds.isel(time=slice(0, 3)), ds.isel(time=slice(3, None))], "time")}
        return fair if without("dask")[0] else {**fair, "chunks": lambda ds: ds.chunk({"time": 5, "x": 3})}

    def test_halves_whole_numbers_and_points(self):
        """What is right but for rounding, or has lost a coordinate of a part."""
        bccsplat.save(path("half.bcc4"), np.rint(3 * self.source), lattice="cc", labels=True, spacing=.3, origin=.2)
        open_file("half.bcc4").bcc4.interp(x=.35 + .3 * np.arange(9), y=.35 + .3 * np.arange(8)).load().bcc4.at(2.25)
        whole = open_file("c.bcc4").load()
        whole["density"].values = np.rint(whole["density"].values).astype(np.int16)
        right = self.ds.bcc4.at(2.25)["density"].values
        for ds in whole, self.ds.isel(z=slice(None)).drop_vars("z").isel(x=slice(2, 5)).drop_vars("x"):
            found = ds.bcc4.interp(time=2.25, x=self.ds.x.values, z=self.ds.z.values)
            np.testing.assert_array_equal(found["density"].values, right)
        picked = self.ds.isel(y=xr.DataArray([1, 5], dims="s"), x=xr.DataArray([3, 4], dims="s")).bcc4.at(2.25)
        np.testing.assert_allclose(picked["density"], right[:, [1, 5], [3, 4]], atol=1e-5)


class Writing(unittest.TestCase):
    def setUp(self):
        self.source = waves(14, 20, 22, 24)

    def test_masks_and_fill_values_are_holes(self):
        import dask.array as da
        hidden = np.zeros(self.source.shape, bool)
        hidden[2:, 3:7, 5, 6:] = True
        filled = np.where(hidden, np.float32(-999), self.source)
        lazy = da.from_array(np.ma.array(filled, mask=hidden), chunks=(4, 20, 22, 24))
        says = {"_FillValue": np.float32(-999)}
        for n, (data, attrs) in enumerate(((lazy, {}), (filled, says), (da.from_array(filled, chunks=(4, 20, 22, 24)), says))):
            ds = xr.Dataset({"q": (("time", "z", "y", "x"), data, attrs)})
            for options in {"lattice": "cc"}, {"lattice": "cc", "parts": 2}, {"psnr": 60.}:
                if "parts" in options and n == 1:
                    continue  # of dask alone
                ds.bcc4.to_file(path("m.bcc4"), overwrite=True, **options)
                np.testing.assert_array_equal(np.isnan(open_file("m.bcc4")["q"].values), hidden, str((n, options)))

    def test_packed_numbers_are_unpacked(self):
        """Opened with mask_and_scale=False the file's integers are there, and units of what they stand for."""
        packed = np.round((self.source - 3) / .5).astype(np.int16)
        says = {"scale_factor": .5, "add_offset": 3., "_FillValue": np.int16(-999), "units": "K"}
        xr.Dataset({"q": (("time", "z", "y", "x"), packed, says)}).bcc4.to_file(path("k.bcc4"), lattice="cc", overwrite=True)
        back = open_file("k.bcc4")["q"]
        self.assertEqual(back.attrs["units"], "K")
        np.testing.assert_allclose(back.values, packed * .5 + 3, atol=.1)

    def test_there_and_back(self):
        dates = np.datetime64("2021-01-01", "ns") + np.arange(14) * np.timedelta64(6, "h")
        ds = xr.Dataset({"T": (("time", "z", "y", "x"), self.source, {"units": "K"}),
                         "q": (("z", "y", "x", "time"), np.moveaxis(self.source.astype(np.float64), 0, -1) + 1)},
                        {"time": dates, "y": ("y", np.linspace(60, 39, 22), {"units": "km"}),
                         "x": ("x", np.arange(24) * .5, {"units": "km"}), "z": ("z", np.arange(20.), {"units": "km"})},
                        {"title": "a", "number": 3})
        ds.bcc4.to_file(path("w.bcc4"), abs_error=.03)
        back = open_file("w.bcc4")
        for name, offset in (("T", 0), ("q", 1)):
            np.testing.assert_allclose(back[name].values, self.source + offset, atol=.03)
        np.testing.assert_array_equal(back.time.values, dates)
        for name in "zyx":
            np.testing.assert_allclose(back[name], ds[name], atol=1e-12)
        self.assertEqual((back["T"].attrs["units"], back.x.attrs["units"], back.attrs["title"], back.attrs["number"]),
                         ("K", "km", "a", 3))
        back.isel(time=slice(2, 9), y=slice(3, None, 2)).bcc4.to_file(path("w2.bcc4"))  # of what is read as it is written
        again = open_file("w2.bcc4")
        np.testing.assert_array_equal(again.time.values, dates[2:9])
        np.testing.assert_allclose(again.y, ds.y[3::2])
        back.attrs["labels.T"] = "yes"  # of another file, whose values they are no more
        back[["T"]].bcc4.to_file(path("w3.bcc4"))
        self.assertNotIn("labels.T", bccsplat.open(path("w3.bcc4")).attributes())
        ds[["T"]].isel(time=0).bcc4.to_file(path("one.bcc4"))
        self.assertEqual(open_file("one.bcc4")["T"].shape, (1, 20, 22, 24))
        for one in (ds, back):
            one.isel(time=3).bcc4.to_file(path("one.bcc4"), overwrite=True)
            np.testing.assert_array_equal(open_file("one.bcc4").time.values, dates[3:4])

    def test_names_of_dimensions(self):
        ds = xr.Dataset({"f": (("when", "lev", "lat", "lon"), self.source)}, {"when": [1. * n * n for n in range(14)],
                                                                               "lat": np.arange(22) * -1.})
        ds.bcc4.to_file(path("n.bcc4"), abs_error=.001)
        back = open_file("n.bcc4")
        self.assertLessEqual(float(abs(back.f - self.source).max()), .001 + 1e-6)
        self.assertEqual(back.f.dims, ds.f.dims)
        np.testing.assert_allclose(back.when, ds.when)
        np.testing.assert_allclose(back.lat, ds.lat)

    def test_what_cannot_be_written_is_said(self):
        good = xr.Dataset({"f": (("time", "z", "y", "x"), self.source)})
        for ds, text in ((xr.Dataset(), "no variable"), (good.isel(z=0, y=0), "time, x"),
                         (good.assign(g=good.f.isel(time=0)), "broadcast")):
            with self.assertRaisesRegex(ValueError, text):
                ds.bcc4.to_file(path("bad.bcc4"))
        good.bcc4.to_file(path("there.bcc4"))
        with self.assertRaisesRegex(FileExistsError, "overwrite=True"):
            good.bcc4.to_file(path("there.bcc4"))
        good.bcc4.to_file(path("there.bcc4"), overwrite=True)

    @unittest.skipIf(support.TOOL is None, "no tool was given")
    def test_a_bound_in_decibels(self):
        os.environ["BCCSPLAT_TOOL"] = support.TOOL
        ds = xr.Dataset({"f": (("time", "z", "y", "x"), self.source, {"units": "K"})}, {"x": np.arange(24) * 2.})
        ds.bcc4.to_file(path("psnr.bcc4"), psnr=55)
        back = open_file("psnr.bcc4")
        rmse = float(np.sqrt(((back.f - self.source).astype(float) ** 2).mean()))
        self.assertGreaterEqual(20 * np.log10((self.source.max() - self.source.min()) / rmse), 54.99)
        self.assertEqual(back.f.attrs["units"], "K")
        np.testing.assert_allclose(back.x, ds.x)


@unittest.skipIf(*without("dask"))
class Dask(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.source = waves(120, 16, 18, 20)
        cls.dataset = xr.Dataset({"f": (("time", "z", "y", "x"), cls.source)}, {"time": np.arange(120) * .5})
        cls.dataset.bcc4.to_file(path("whole.bcc4"), lattice="d4star", overwrite=True)  # of an array in memory: by one writer
        with open(path("whole.bcc4"), "rb") as file:
            cls.bytes = file.read()

    def chunked(self, log=None, pause=0.0):
        ds = self.dataset.chunk({"time": 10, "z": 8})
        data = ds.f.data.map_blocks(computing, log=log, pause=pause, dtype=np.float32)
        return ds.assign(f=ds.f.copy(data=data))

    def assert_whole(self, name):
        with open(path(name), "rb") as file:
            self.assertTrue(file.read() == self.bytes, name + " is not the file that one writer makes")
        self.assertEqual([n for n in os.listdir(support.SCRATCH) if ".parts" in n], [])

    def test_chunks_of_the_file(self):
        ds = xr.open_dataset(path("whole.bcc4"), engine="bccsplat", chunks={})
        from bccsplat.field_array import chunk_frames
        self.assertEqual(ds.f.chunks, (chunk_frames(bccsplat.open(path("whole.bcc4"))), (16,), (18,), (20,)))
        np.testing.assert_allclose(ds.f.mean(("z", "y", "x")).values, self.source.mean((1, 2, 3)), atol=.01)
        np.testing.assert_array_equal(ds.f.values, xr.open_dataset(path("whole.bcc4"), engine="bccsplat").f.values)

    def test_few_chunks_tell_whether_it_is_the_files(self):
        log, ds = path("rows.txt"), open_file("whole.bcc4").chunk({"time": 10, "z": 4})
        ds.f.data = ds.f.data.map_blocks(computing, log=log, dtype=np.float32)
        ds.bcc4.at(20.25)
        with open(log, encoding="utf-8") as file:
            self.assertEqual(len(file.readlines()), 2)  # of 48
        ds.f.data = ds.f.data + 1
        with self.assertRaisesRegex(ValueError, "f are no longer those of .*whole.bcc4"):
            ds.copy().bcc4.at(20.25)

    def test_by_parts(self):
        log = path("computed.txt")
        for parts, scheduler in ((1, "threads"), (3, "threads"), (4, "synchronous"), (2, "processes")):
            import dask
            with dask.config.set(scheduler=scheduler):
                self.chunked(log).bcc4.to_file(path("p.bcc4"), lattice="d4star", parts=parts, overwrite=True)
            self.assert_whole("p.bcc4")
        self.dataset.chunk({"time": 7}).bcc4.to_file(path("auto.bcc4"), lattice="d4star")
        self.assert_whole("auto.bcc4")

    def test_parts_without_a_bound_are_told(self):
        ds = self.dataset.isel(time=slice(0, 20)).chunk({"time": 10})
        with self.assertWarnsRegex(UserWarning, "bound.bcc4 is written by parts, which have no bound of the error"):
            ds.bcc4.to_file(path("bound.bcc4"), parts=2)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            ds.bcc4.to_file(path("bound.bcc4"), parts=2, abs_error=1e-3, overwrite=True)
        self.assertLessEqual(float(abs(open_file("bound.bcc4").f - ds.f).max()), 1e-3 + 1e-6)

    def test_parts_tell_and_keep_the_bound_of_each_variable(self):
        ds = self.dataset.isel(time=slice(0, 24)).chunk({"time": 8})
        ds["g"] = 100 * ds.f
        bounds = {"f": .01, "g": 2.}
        ds.bcc4.to_file(path("each.bcc4"), parts=3, abs_error=bounds)
        back, volume = open_file("each.bcc4"), bccsplat.open(path("each.bcc4"))
        for n, (name, bound) in enumerate(bounds.items()):
            told = volume.channel_info(n)
            off = float(abs(back[name] - ds[name]).max())
            self.assertEqual((back[name].attrs["bcc4_error_bound"], told.error_bound), (bound, bound))
            self.assertLessEqual(off, bound)
            self.assertTrue(0 < told.max_abs <= bound)
            self.assertAlmostEqual(told.max_abs, off, delta=1e-3 * bound)

    def test_without_options_a_bound_is_kept(self):
        for chunks in None, {"time": 10}:
            self.dataset.isel(time=slice(0, 20)).chunk(chunks or {}).bcc4.to_file(path("usual.bcc4"), overwrite=True)
            back = open_file("usual.bcc4")
            bound = back.f.attrs["bcc4_error_bound"]
            self.assertLessEqual(bound, .0201 * float(self.source.max() - self.source.min()))
            self.assertLessEqual(float(abs(back.f - self.dataset.f[:20]).max()), bound)

    def test_one_chunk_of_time_is_held(self):
        from bccsplat.dataset_writer import LazySeries
        log = path("order.txt")
        series = LazySeries(self.chunked(log).f.data, "synchronous")
        for t in range(25):
            np.testing.assert_array_equal(series[t], self.source[t])
        with open(log, encoding="utf-8") as file:
            begins = [int(line.split()[1]) for line in file]
        self.assertEqual(begins, [0, 0, 10, 10, 20, 20])  # each of two chunks along z once, in order

    def test_a_task_that_is_done_holds_nothing(self):
        from bccsplat.dataset_writer import DatasetWriter
        from bccsplat.part_task import PartTask
        made = DatasetWriter(self.chunked(), None, {})
        task = PartTask(made.plan, made.series, path("part.bcc4"), (0, 60))
        self.assertEqual(task.run([]), path("part.bcc4"))
        self.assertEqual([series._held for series in task.series], [None])

    def test_finished_parts_are_taken_over(self):
        log, broken = path("resume.txt"), [True]
        ds = self.chunked()

        def failing(block):
            if broken[0]:
                raise OSError("the disk is away")
            return block

        data = ds.f.data
        parted = xr.Dataset({"f": (ds.f.dims, data)}, ds.coords)
        late = data[90:].map_blocks(failing, dtype=np.float32, meta=np.empty((0,) * 4, np.float32))
        import dask
        import dask.array as da
        parted["f"] = (ds.f.dims, da.concatenate([data[:90].map_blocks(computing, log=log, dtype=np.float32), late]))
        with dask.config.set(scheduler="synchronous"):
            with self.assertRaisesRegex(OSError, "the disk is away"):
                parted.bcc4.to_file(path("r.bcc4"), lattice="d4star", parts=4)
            folder, = [n for n in os.listdir(support.SCRATCH) if n.startswith("r.bcc4.parts-")]
            done = len(os.listdir(path(folder)))
            self.assertGreater(done, 0)
            self.assertFalse(os.path.exists(path("r.bcc4")))
            with open(log, encoding="utf-8") as file:
                before = len(file.readlines())
            broken[0] = False
            parted.bcc4.to_file(path("r.bcc4"), lattice="d4star", parts=4, resume=True)
            with open(log, encoding="utf-8") as file:
                after = len(file.readlines())
        self.assert_whole("r.bcc4")
        self.assertLess(after - before, before)

    def test_parts_of_other_places_are_made_anew(self):
        ds = self.chunked().isel(time=slice(0, 24))

        def failing(parts, path, overwrite):
            raise OSError("the disk is away")

        with mock.patch.object(bccsplat.dataset_writer, "join_task", failing), self.assertRaises(OSError):
            ds.bcc4.to_file(path("o.bcc4"), lattice="d4star", parts=2)
        moved = ds.assign_coords(x=5. * np.arange(ds.sizes["x"]))
        moved.f.attrs["units"] = "K"
        moved.bcc4.to_file(path("o.bcc4"), lattice="d4star", parts=2, resume=True)
        back = open_file("o.bcc4")
        np.testing.assert_allclose(back.x, moved.x)
        self.assertEqual(back.f.attrs["units"], "K")

    def test_parts_that_begin_where_nothing_is(self):
        """The bytes are those of one writer, wherever frames are missing altogether."""
        import dask
        source = self.source[:24, :6, :7, :8]
        for first, end in (0, 14), (10, 15), (12, 24), (0, 24):
            ds = xr.Dataset({"f": (("time", "z", "y", "x"), source.copy()), "g": (("time", "z", "y", "x"), source + 1)})
            ds.f[first:end] = np.nan
            ds.bcc4.to_file(path("gap.bcc4"), lattice="d4star", overwrite=True)
            with open(path("gap.bcc4"), "rb") as file:
                right = file.read()
            for parts in (2, 3):
                with dask.config.set(scheduler="synchronous"):
                    ds.chunk({"time": 4}).bcc4.to_file(path("gaps.bcc4"), lattice="d4star", parts=parts, overwrite=True)
                with open(path("gaps.bcc4"), "rb") as file:
                    self.assertTrue(file.read() == right, (first, end, parts))

    @unittest.skipIf(*without("distributed"))
    def test_larger_than_memory_as_it_is_measured(self):
        script = os.path.join(support.TOP, "tests", "bench", "python_cluster.py")
        done = subprocess.run([sys.executable, "-B", script, path("cluster"), "--gib", "0.03", "--size", "24", "--workers", "2",
                               "--limit", "1"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        cells = [cell.strip() for cell in done.stdout.split("|")[1:-1]]
        made, there = map(int, cells[4].split(" of "))
        self.assertEqual((cells[0], there), ("0.03 GiB, 24^3 x 584", 73))
        self.assertTrue(there <= made < 1.3 * there, made)  # parts share frames at their ends
        self.assertTrue(50 < float(cells[3]) <= float(cells[6]) < 1024, cells)

    @unittest.skipIf(*without("distributed"))
    def test_a_killed_worker_costs_its_part(self):
        import dask
        from distributed import Client, LocalCluster
        log = path("killed.txt")
        dask.config.set({"distributed.worker.daemon": False, "distributed.comm.timeouts.connect": "30s"})
        with LocalCluster(n_workers=2, processes=True, threads_per_worker=1, dashboard_address=None,
                          local_directory=path("dask")) as cluster, Client(cluster) as client:
            import threading
            killed = []

            def kill_one():
                """The worker of the third part or a later one, as soon as a part is finished."""
                until = time.monotonic() + 120
                while time.monotonic() < until and not killed:
                    folders = [n for n in os.listdir(support.SCRATCH) if n.startswith("k.bcc4.parts-")]
                    if folders and any(n.endswith(".bcc4") for n in os.listdir(path(folders[0]))):
                        with open(log, encoding="utf-8") as file:
                            killed.append(int(file.readlines()[-1].split()[0]))
                        os.kill(killed[0], signal.SIGKILL)
                    time.sleep(.01)

            killer = threading.Thread(target=kill_one)
            killer.start()
            self.chunked(log, .05).bcc4.to_file(path("k.bcc4"), lattice="d4star", parts=5)
            killer.join()
            self.assertEqual(len(killed), 1)
            with open(log, encoding="utf-8") as file:
                computed = [tuple(map(int, line.split())) for line in file]
            held = client.persist(self.dataset.chunk({"time": 30}))
            held.bcc4.to_file(path("held.bcc4"), lattice="d4star", parts=2)  # of chunks that lie in the workers' memory
        self.assert_whole("k.bcc4")
        self.assert_whole("held.bcc4")
        pids = {pid for pid, _ in computed}
        self.assertGreaterEqual(len(pids), 2)
        # Five parts of 24 frames read at most 6 chunks of time each, of two chunks along z; the killed one once more.
        self.assertLessEqual(len(computed), 2 * 6 * (5 + 1))


if __name__ == "__main__":
    support.fresh_scratch()
    support.install_entry_points()
    support.main()

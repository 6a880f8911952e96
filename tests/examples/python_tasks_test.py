"""python_tasks_test.py TOP EXAMPLES SCRATCH: thirty things that people do with series, each in a few lines that can be copied.
Read it as a tutorial: first arrays, then a forecast and an ocean by xarray, then a heart, then training."""
import copy
import io
import os
import pickle
import unittest
from concurrent.futures import ThreadPoolExecutor

import python_support as support
from python_support import path, waves, without

support.need("numpy")
import numpy as np  # noqa: E402

import bccsplat  # noqa: E402


class Arrays(unittest.TestCase):
    """An array [t, z, y, x], a file, and back."""

    @classmethod
    def setUpClass(cls):
        cls.array = waves(14, 12, 14, 16)
        bccsplat.save(path("run.bcc4"), cls.array, dt=.5, time_unit="s", spacing=2, spatial_unit="mm", name="density", abs_error=.001)

    def setUp(self):
        self.volume = bccsplat.open(path("run.bcc4"))

    def test_01_write_an_array_and_read_it(self):
        bccsplat.save(path("mine.bcc4"), self.array, abs_error=.001)
        back = np.asarray(bccsplat.open(path("mine.bcc4")))
        self.assertLessEqual(np.abs(back - self.array).max(), .0011)

    def test_02_ask_what_it_is(self):
        v = self.volume
        self.assertEqual((v.shape, v.ndim, v.size, v.nbytes, v.dtype), ((14, 12, 14, 16), 4, 14 * 12 * 14 * 16, 4 * v.size, np.float32))
        self.assertEqual((len(v), v.channels, v.affine[0, 0], bccsplat.__version__), (14, ["density"], 2, "%d.%d.%d" % bccsplat.version()))

    def test_03_a_frame_and_a_part_of_one(self):
        np.testing.assert_allclose(self.volume[3], self.array[3], atol=.0011)
        np.testing.assert_allclose(self.volume[3, 2:5, ..., -1], self.array[3, 2:5, ..., -1], atol=.0011)

    def test_04_a_moment_between_two_frames(self):
        half = self.volume.at(1.25)  # in seconds: frame 2.5
        np.testing.assert_array_equal(half, self.volume[2.5])
        self.assertLess(np.abs(half - (self.array[2] + self.array[3]) / 2).max(), .02)

    def test_05_the_series_at_a_sample(self):
        np.testing.assert_allclose(self.volume[:, 6, 7, 8], self.array[:, 6, 7, 8], atol=.0011)

    def test_06_the_series_at_a_place_of_the_world(self):
        points = [(16.0, 14.0, 12.0, time) for time in self.volume.times()]  # x, y, z in mm
        values, slopes = self.volume.evaluate_world(points)
        np.testing.assert_allclose(values, self.array[:, 6, 7, 8], atol=.0011)
        self.assertEqual(slopes.shape, (14, 4))

    def test_07_frame_after_frame(self):
        means = [float(frame.mean()) for frame in self.volume]
        np.testing.assert_allclose(means, self.array.mean((1, 2, 3)), atol=.0011)

    def test_08_as_another_type(self):
        self.assertEqual((self.volume.astype(np.float64).dtype, self.volume.field().astype("f2").dtype), (np.float64, np.float16))

    def test_09_a_plane_with_its_coordinates(self):
        plane = self.volume.plane(1.0, z=5.5)
        self.assertEqual((plane.values.shape, plane.unit, plane.coordinates[0][1]), ((14, 16), "mm", 2))

    def test_10_a_picture(self):
        self.volume.show(1.0, width=32, height=32).save(path("run.png"))
        with open(path("run.png"), "rb") as file:
            self.assertEqual(file.read(4), b"\x89PNG")

    def test_11_missing_values(self):
        masked = np.ma.array(self.array, mask=self.array > 3.5)
        bccsplat.save(path("masked.bcc4"), masked, lattice="cc")
        np.testing.assert_array_equal(np.isnan(bccsplat.open(path("masked.bcc4"))), masked.mask)

    def test_12_two_quantities_with_their_own_bounds(self):
        bccsplat.save(path("two.bcc4"), {"T": self.array, "p": 1000 * self.array}, abs_error={"T": .001, "p": 5}, unit={"T": "K", "p": "Pa"})
        two = bccsplat.open(path("two.bcc4"))
        self.assertEqual([two.channel_info(n).error_bound for n in (0, 1)], [.001, 5])
        self.assertLessEqual(np.abs(two.field("p").read() - 1000 * self.array).max(), 5.001)

    def test_13_what_is_there_is_kept(self):
        with self.assertRaises(FileExistsError):
            bccsplat.save(path("run.bcc4"), self.array)
        bccsplat.save(path("over.bcc4"), self.array)
        bccsplat.save(path("over.bcc4"), self.array, overwrite=True)

    def test_14_what_is_not_there(self):
        with self.assertRaises(FileNotFoundError):
            bccsplat.open(path("none.bcc4"))

    def test_15_bytes_and_open_files(self):
        with open(path("run.bcc4"), "rb") as file:
            from_file = bccsplat.open(file)[3]
            file.seek(0)
            content = file.read()
        np.testing.assert_array_equal(bccsplat.open(content)[3], from_file)
        np.testing.assert_array_equal(bccsplat.open(io.BytesIO(content))[3], from_file)

    @unittest.skipIf(*without("fsspec"))
    def test_16_a_file_elsewhere(self):
        import fsspec
        with open(path("run.bcc4"), "rb") as file:
            fsspec.filesystem("memory").pipe("/run.bcc4", file.read())
        there = bccsplat.open("memory://run.bcc4")  # as s3://..., https://...
        np.testing.assert_array_equal(there[3], self.volume[3])

    def test_17_send_it_to_another_process(self):
        sent = pickle.loads(pickle.dumps(self.volume))  # as multiprocessing does
        np.testing.assert_array_equal(sent[3], self.volume[3])
        np.testing.assert_array_equal(copy.copy(self.volume)[3], self.volume[3])

    def test_18_by_threads(self):
        with ThreadPoolExecutor(4) as pool:
            frames = list(pool.map(self.volume.__getitem__, range(14)))
        np.testing.assert_array_equal(frames, np.asarray(self.volume))


@unittest.skipIf(*without("xarray"))
class Climate(unittest.TestCase):
    """A forecast at levels of pressure, by xarray."""

    @classmethod
    def setUpClass(cls):
        global xr
        import xarray as xr

        import bccsplat.accessor  # noqa: F401
        cls.ds = xr.Dataset(
            {"ta": (("time", "lev", "lat", "lon"), 250 + 5 * waves(14, 8, 9, 10), {"units": "K", "long_name": "Air Temperature"})},
            {"time": np.datetime64("2024-02-28", "ns") + np.arange(14) * np.timedelta64(6, "h"),
             "lev": ("lev", [1000., 925, 850, 700, 500, 300, 200, 100], {"units": "hPa", "positive": "down"}),
             "lat": ("lat", np.linspace(60, 40, 9), {"units": "degrees_north"}),
             "lon": ("lon", 1.5 * np.arange(10), {"units": "degrees_east"})}, {"title": "a forecast"})
        cls.ds.bcc4.to_file(path("forecast.bcc4"), abs_error=.01)

    def setUp(self):
        self.back = xr.open_dataset(path("forecast.bcc4"), engine="bccsplat")

    def test_19_there_and_back(self):
        xr.testing.assert_allclose(self.back.ta.drop_attrs() if hasattr(self.back.ta, "drop_attrs") else self.back.ta, self.ds.ta, atol=.011)
        for name in self.ds.coords:
            np.testing.assert_array_equal(self.back[name], self.ds[name])
        self.assertEqual((self.back.lev.attrs["units"], self.back.ta.attrs["units"], self.back.attrs["title"]), ("hPa", "K", "a forecast"))

    def test_20_select_by_date_and_level(self):
        part = self.back.ta.sel(time="2024-02-29", lev=[850, 500])
        np.testing.assert_allclose(part, self.ds.ta.sel(time="2024-02-29", lev=[850, 500]), atol=.011)

    def test_21_an_hour_between_two_steps(self):
        noon = self.back.bcc4.at("2024-02-28T09:00")
        self.assertEqual((noon.ta.dims, str(noon.time.values)[:13]), (("lev", "lat", "lon"), "2024-02-28T09"))

    def test_22_along_the_way_of_a_ship(self):
        way = {"lat": xr.DataArray([45., 50, 55], dims="ship"), "lon": xr.DataArray([2., 4, 6], dims="ship"), "lev": 1000.}
        self.assertEqual(self.back.bcc4.interp(**way).ta.dims, ("time", "ship"))

    def test_23_a_profile_at_any_pressure(self):
        profile = self.back.isel(time=0).bcc4.interp(lat=50., lon=4.5, lev=[950., 600., 150.])
        self.assertTrue(np.isfinite(profile.ta).all())

    def test_24_a_daily_mean(self):
        np.testing.assert_allclose(self.back.ta.resample(time="1D").mean(), self.ds.ta.resample(time="1D").mean(), atol=.011)

    @unittest.skipIf(*without("netCDF4"))
    def test_25_out_to_netcdf(self):
        self.back.to_netcdf(path("forecast.nc"))
        with xr.open_dataset(path("forecast.nc")) as out:
            np.testing.assert_allclose(out.ta, self.ds.ta, atol=.011)
            np.testing.assert_array_equal(out.lev, self.ds.lev)

    def test_26_variables_beside_the_field(self):
        weights = self.ds.assign(weight=("lat", np.cos(np.radians(self.ds.lat.values))), run=3)
        weights.bcc4.to_file(path("weights.bcc4"), lattice="cc")
        found = xr.open_dataset(path("weights.bcc4"), engine="bccsplat")
        np.testing.assert_array_equal(found.weight, weights.weight)
        self.assertEqual(int(found.run), 3)

    @unittest.skipIf(*without("dask"))
    def test_27_larger_than_memory(self):
        import dask
        with dask.config.set(scheduler="synchronous"):
            self.ds.chunk({"time": 4}).bcc4.to_file(path("lazy.bcc4"), abs_error=.01, parts=2, overwrite=True)
        lazy = xr.open_dataset(path("lazy.bcc4"), engine="bccsplat", chunks={})
        np.testing.assert_allclose(lazy.ta.mean("time").compute(), self.ds.ta.mean("time"), atol=.011)


class Heart(unittest.TestCase):
    """A cine: whole numbers, millimetres, an affine."""

    def test_28_whole_numbers_and_an_affine(self):
        cine = np.rint(300 * waves(10, 6, 20, 20)).astype(np.int16)
        affine = np.array([[-1.4, 0, 0, 90], [0, -1.4, 0, 120], [0, 0, 10, -40], [0, 0, 0, 1.]])
        bccsplat.save(path("cine.bcc4"), cine, dt=.04, time_unit="s", affine=affine, spatial_unit="mm", abs_error=2)
        volume = bccsplat.open(path("cine.bcc4"))
        np.testing.assert_allclose(volume.affine, affine)
        self.assertLessEqual(np.abs(volume.astype(int) - cine).max(), 2)
        np.testing.assert_allclose(volume.index_to_world([3, 4, 5]), affine[:3, :3] @ [3, 4, 5] + affine[:3, 3])

    def test_29_labels_stay_labels(self):
        labels = (waves(6, 6, 8, 9) > 2).astype(np.uint8) * 3
        bccsplat.save(path("labels.bcc4"), labels, lattice="cc", labels=True)
        np.testing.assert_array_equal(bccsplat.open(path("labels.bcc4")).astype(np.uint8), labels)


class Training(unittest.TestCase):
    def test_30_crops(self):
        array = waves(20, 12, 14, 16)
        bccsplat.save(path("train.bcc4"), array, abs_error=.01)
        volume, size = bccsplat.open(path("train.bcc4")), (4, 6, 7, 8)
        seen = list(volume.crops(size, seed=1, count=40))
        self.assertEqual([place for place, _ in seen], [place for place, _ in volume.crops(size, seed=1, count=40)])
        self.assertNotEqual([place for place, _ in seen], [place for place, _ in volume.crops(size, seed=2, count=40)])
        shared = [place for worker in range(3) for place, _ in volume.crops(size, seed=1, count=40, part=(worker, 3))]
        self.assertEqual((len(seen), len(shared)), (40, 40))
        for pieces in (seen, volume.crops(size, seed=5, count=10, memory=1), volume.crops(size, seed=5, count=2)):
            for (t, z, y, x), crop in pieces:
                np.testing.assert_allclose(crop, array[t:t + 4, z:z + 6, y:y + 7, x:x + 8], atol=.011)
        places = np.array([place for place, _ in volume.crops(size, count=4000, memory=20000)])
        for axis, (whole, n) in enumerate(zip(array.shape, size)):  # as likely everywhere
            share = np.bincount(places[:, axis], minlength=whole - n + 1) / 4000 * (whole - n + 1)
            self.assertTrue((np.abs(share - 1) < .45).all(), (axis, share))
        with self.assertRaisesRegex(ValueError, "at most that of the series"):
            next(volume.crops((4, 13, 7, 8)))


if __name__ == "__main__":
    support.fresh_scratch()
    support.install_entry_points()
    support.main()

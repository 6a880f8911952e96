"""python_places_test.py TOP EXAMPLES SCRATCH: where samples stand, along even and uneven axes, is one in every door; datasets
come back from a file with their dimensions, coordinates, names and attributes."""
import json
import os
import subprocess
import sys
import unittest

import python_support as support
from python_support import path, waves, without

support.need("numpy", "xarray")
import numpy as np  # noqa: E402
import xarray as xr  # noqa: E402

import bccsplat  # noqa: E402
import bccsplat.accessor  # noqa: E402, F401
from bccsplat.places import Places  # noqa: E402
from bccsplat.xarray_backend import BccsplatBackend  # noqa: E402

DEPTHS = np.array([0., 10, 20, 30, 50, 75, 100, 150, 200, 300, 500, 1000])
LATITUDES = np.degrees(np.arcsin(np.linspace(-.9, .9, 9)))
PRESSURES = np.array([1000., 925, 850, 700, 500, 300, 200, 100])


def open_file(name, **options):
    return xr.open_dataset(path(name), engine=BccsplatBackend, **options)


def rotated(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0, 3], [s, c, 0, 4], [0, 0, 1, 5], [0, 0, 0, 1]])


def depths_file(name, affine=None, **options):
    """An ocean: x even, y and z not, z counted down."""
    place = np.diag([15., (LATITUDES[-1] - LATITUDES[0]) / 8, -1000 / 11, 1])
    place[1, 3] = LATITUDES[0]
    bccsplat.save(path(name), waves(6, 12, 9, 10), affine=place if affine is None else affine, lattice="cc", time_unit="d",
                  axes=[(None, "degrees", False), (LATITUDES, "degrees", False), (DEPTHS, "m", True)], overwrite=True, **options)
    return bccsplat.open(path(name))


def atmosphere(source):
    """Temperatures at levels of pressure with all that CF says of them, and their values at [time, lev, lat, lon]."""
    nt, _, ny, nx = source.shape
    return xr.Dataset(
        {"ta": (("time", "lev", "lat", "lon"), source, {"units": "K", "long_name": "Air Temperature", "cell_methods": "time: mean",
                                                        "standard_name": "air_temperature", "realm": 3}),
         "hus": (("time", "lev", "lat", "lon"), source / 7, {"units": "kg kg-1", "long_name": "Humidity"})},
        {"time": ("time", np.datetime64("2001-02-27", "ns") + np.arange(nt) * np.timedelta64(6, "h"), {"long_name": "when"}),
         "lev": ("lev", PRESSURES, {"units": "hPa", "positive": "down", "standard_name": "air_pressure", "axis": "Z"}),
         "lat": ("lat", LATITUDES[:ny], {"units": "degrees_north", "standard_name": "latitude"}),
         "lon": ("lon", np.arange(nx) * 1.5, {"units": "degrees_east", "long_name": "Longitude"})}, {"title": "made up"})


class Reading(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.volume = depths_file("ocean.bcc4", levels=1)
        cls.ds = open_file("ocean.bcc4")

    def test_coordinates_are_the_axes_own(self):
        np.testing.assert_array_equal(self.ds.z, DEPTHS)
        np.testing.assert_array_equal(self.ds.y, LATITUDES)
        np.testing.assert_allclose(self.ds.x, 15 * np.arange(10))
        self.assertEqual([self.ds[name].attrs.get(key) for name in "xyz" for key in ("units", "positive")],
                         ["degrees", None, "degrees", None, "m", "down"])
        coarse = open_file("ocean.bcc4", level=1)
        np.testing.assert_array_equal(coarse.z, DEPTHS[::2])
        np.testing.assert_array_equal(coarse.y, LATITUDES[::2])

    def test_values_are_those_of_the_world(self):
        at = {"time": 2.5, "x": 22.5, "y": 31., "z": 240.}
        right = self.volume.evaluate_world([[at["x"], at["y"], -at["z"], at["time"]]])[0][0]
        self.assertAlmostEqual(float(self.ds.bcc4.interp(**at).value), float(right), places=5)
        path_of = {name: xr.DataArray([place, place], dims="s") for name, place in at.items()}
        np.testing.assert_allclose(self.ds.bcc4.interp(**path_of).value, right, atol=1e-5)
        picked = self.ds.value.sel(z=190, y=LATITUDES[3], method="nearest").isel(time=1)
        np.testing.assert_array_equal(picked, self.volume[1, 8, 3])
        self.assertTrue(np.isnan(float(self.ds.bcc4.interp(**{**at, "z": -240.}).value)))

    def test_there_and_back_between_samples(self):
        for volume in (self.volume, depths_file("turned.bcc4", rotated(30)), depths_file("plain.bcc4", np.eye(4))):
            places = Places(volume)
            for axis, known in (1, LATITUDES), (2, DEPTHS):
                samples = np.linspace(-.5, len(known) - .5, 41)
                found = places.at(axis, samples)
                self.assertTrue((np.diff(found) > 0).all())
                np.testing.assert_allclose(places.samples(axis, found), samples, atol=1e-9)
                np.testing.assert_array_equal(places.at(axis, np.arange(len(known))), known)
                np.testing.assert_array_equal(places.samples(axis, known), np.arange(len(known)))
        between = self.volume.index_to_world(np.linspace(0, 11, 40)[:, None] * [0, 0, 1])[:, 2]
        np.testing.assert_allclose(Places(self.volume).at(2, np.linspace(0, 11, 40)), -between, atol=1e-9)

    def test_planes(self):
        plane = self.volume.plane(2.5, x=3)
        np.testing.assert_array_equal(plane.coordinates[0], LATITUDES)
        np.testing.assert_array_equal(plane.coordinates[1], DEPTHS)
        self.assertEqual((plane.units, plane.unit, plane.title), (("degrees", "m"), "", "value, x = 45 degrees, t = 2.5 d"))
        self.assertEqual(plane.extent[2:], (-5, 1250))
        self.assertIn("z = 200 m", self.volume.plane(2.5, z=8).title)
        drawn = []

        class Axes:
            def __getattr__(self, name):
                return lambda *arguments, **named: drawn.append((name, arguments, named))

        plane.imshow(Axes())
        self.assertEqual((drawn[0][0], drawn[0][1][0] is plane.coordinates[0], drawn[1][1], drawn[2][1]),
                         ("pcolormesh", True, ("y (degrees)",), ("z (m)",)))
        bccsplat.open(path("even.bcc4")).plane(0, z=1).imshow(Axes())
        self.assertEqual(drawn[4][0], "imshow")

    @unittest.skipIf(*without("zarr"))
    def test_zarr(self):
        from bccsplat.zarr_store import Store
        attrs = json.loads(Store(path("ocean.bcc4"))[".zattrs"])
        scales, = attrs["multiscales"]
        scale, shift = scales["datasets"][1]["coordinateTransformations"]
        self.assertEqual((scale["scale"][2:], shift["translation"][2:]), ([2, 2, 30], [0, 0, 0]))  # of samples where uneven
        self.assertEqual([axis.get("unit") for axis in scales["axes"][2:]], [None, None, "degrees"])
        self.assertEqual(attrs["bcc4"]["axes"], {"y": {"coordinates": LATITUDES.tolist(), "unit": "degrees"},
                                                 "z": {"coordinates": DEPTHS.tolist(), "unit": "m"}})

    def test_to_file_keeps_the_axes(self):
        self.ds.isel(z=slice(1, None)).bcc4.to_file(path("again.bcc4"), lattice="cc", overwrite=True)
        again = bccsplat.open(path("again.bcc4"))
        for axis, known in enumerate(((), LATITUDES, DEPTHS[1:])):
            np.testing.assert_array_equal(again.axis(axis)[0], known)
            self.assertEqual(again.axis(axis)[1:], self.volume.axis(axis)[1:])
        at = [[15 * x, LATITUDES[y], -DEPTHS[z], t] for x, y, z, t in ((2, 3, 8, 1), (7, 1, 10, 4))]
        np.testing.assert_allclose(again.evaluate_world(at)[0], self.volume.evaluate_world(at)[0], atol=1e-5)
        with self.assertRaisesRegex(ValueError, "oblique in the world and are unevenly spaced"):
            depths_file("turned.bcc4", rotated(30))
            open_file("turned.bcc4").bcc4.to_file(path("bad.bcc4"))

    def run_python(self, *arguments):
        return subprocess.run([sys.executable, "-B", *arguments], capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": support.PYTHON})

    def test_programs(self):
        retime, compare = (os.path.join(support.PYTHON, name) for name in ("retime.py", "compare_runs.py"))
        self.assertEqual(self.run_python(retime, path("ocean.bcc4"), path("slow.bcc4"), "2").returncode, 0)
        slow = open_file("slow.bcc4")
        np.testing.assert_array_equal(slow.z, DEPTHS)
        self.assertEqual(slow.time.size, 11)
        self.assertEqual(self.run_python(compare, path("ocean.bcc4"), path("slow.bcc4")).returncode, 0)
        depths_file("plain.bcc4", np.eye(4))
        self.assertIn("not at the same places", self.run_python(compare, path("ocean.bcc4"), path("plain.bcc4")).stderr)
        depths_file("dated.bcc4", attributes={"time_epoch": "2000-01-01"})
        self.assertIn("from other dates: None and 2000-01-01", self.run_python(compare, path("ocean.bcc4"), path("dated.bcc4")).stderr)
        self.assertEqual(self.run_python("-m", "bccsplat", path("ocean.bcc4"), path("ocean.png")).stderr, "")

    @unittest.skipIf(*without("netCDF4"))
    def test_to_netcdf(self):
        self.ds.to_netcdf(path("ocean.nc"))
        with xr.open_dataset(path("ocean.nc")) as back:
            np.testing.assert_array_equal(back.z, DEPTHS)
            self.assertEqual((back.z.attrs["units"], back.z.attrs["positive"]), ("m", "down"))


class Writing(unittest.TestCase):
    def setUp(self):
        self.source = waves(14, 8, 9, 10)

    def assert_back(self, name, right, atol):
        """A file has the coordinates and attributes of a dataset, and its values but for atol."""
        back = open_file(name)
        self.assertEqual((back.sizes, {*back.data_vars}), (right.sizes, {*right.data_vars}))
        for key, at in right.coords.items():
            np.testing.assert_array_equal(back[key], at)
            self.assertEqual(back[key].attrs, at.attrs)
        for key, variable in right.data_vars.items():
            np.testing.assert_allclose(back[key].transpose(*variable.dims), variable, atol=atol)
            said = {of: value for of, value in back[key].attrs.items() if of not in ("actual_range", "bcc4_error_bound")}
            self.assertEqual(said, variable.attrs)
        self.assertEqual(back.attrs["title"], right.attrs["title"])

    def test_names_units_and_uneven_levels_come_back(self):
        ds = atmosphere(self.source)
        for n, options in enumerate(({"lattice": "cc"}, {"psnr": 60.})):
            ds.bcc4.to_file(path("air%d.bcc4" % n), **options)
            self.assert_back("air%d.bcc4" % n, ds, .02)
        back = open_file("air0.bcc4")
        back.bcc4.to_file(path("air2.bcc4"), lattice="cc")
        self.assert_back("air2.bcc4", ds, .001)
        right = back.bcc4.volume.evaluate_world([[3., 10., -600., 12 * 3600]])[0]
        noon = np.datetime64("2001-02-27T12:00")
        np.testing.assert_allclose(back.bcc4.interp(lon=3., lat=10., lev=600., time=noon).ta, right[0], atol=1e-5)
        np.testing.assert_array_equal(back.bcc4.at(noon).ta, back.ta[2])
        with self.assertRaisesRegex(ValueError, "coordinates time, lev, lat, lon, not x"):
            back.bcc4.interp(x=3.)

    @unittest.skipIf(*without("dask"))
    def test_parts_have_the_axes_of_the_whole(self):
        ds = atmosphere(waves(40, 8, 9, 10))
        ds.chunk({"time": 10}).bcc4.to_file(path("parts.bcc4"), parts=2, lattice="cc")
        self.assert_back("parts.bcc4", ds, .001)

    def test_dimensions_go_by_attributes_and_names(self):
        ds = atmosphere(self.source)
        plain = xr.Dataset({"f": (("time", "z", "y", "x"), self.source)}, attrs={"title": "made up"})
        for right, orders in ((plain, (("time", "x", "y", "z"), ("x", "y", "z", "time"))),
                              (ds, (("time", "lon", "lat", "lev"), ("lev", "lat", "lon", "time"), ("lat", "time", "lev", "lon")))):
            for order in orders:
                right.transpose(*order).bcc4.to_file(path("order.bcc4"), lattice="cc", overwrite=True)
                found = bccsplat.open(path("order.bcc4"))
                self.assertEqual(found.shape, self.source.shape, order)
                np.testing.assert_allclose(found, self.source, atol=.001)

    def test_one_plane_or_moment(self):
        ds = atmosphere(self.source)
        for order in ("time", "lat", "lon"), ("lon", "lat", "time"):
            ds.isel(lev=2).transpose(*order).bcc4.to_file(path("plane.bcc4"), lattice="cc", overwrite=True)
            back = open_file("plane.bcc4")
            np.testing.assert_allclose(back.ta[:, 0], self.source[:, 2], atol=.001)
            np.testing.assert_array_equal(back.time, ds.time)
            self.assertEqual((back.ta.dims, back.lev.values.tolist(), back.lev.attrs), (ds.ta.dims, [850], ds.lev.attrs))
        even = ds.isel(lev=2).assign_coords(lat=np.arange(9.))  # where the axes are not kept for unevenness
        even.bcc4.to_file(path("plane.bcc4"), lattice="cc", overwrite=True)
        self.assertEqual(open_file("plane.bcc4").lev.values.tolist(), [850])
        ds.isel(time=3).bcc4.to_file(path("moment.bcc4"), lattice="cc")
        self.assertEqual(open_file("moment.bcc4").time.values, ds.time.values[3:4])

    def test_what_cannot_be_told_is_said(self):
        ds = xr.Dataset({"f": (("time", "z", "y", "x"), self.source)})
        twice = ds.assign_coords(x=("x", np.arange(10.), {"axis": "Y"}), y=("y", np.arange(9.), {"axis": "Y"}))
        shuffled = ds.assign_coords(x=[0., 1, 2, 5, 4, 3, 6, 7, 8, 9])
        for wrong, text in ((twice, "y and x are both y"), (shuffled, r"neither rises nor falls.*sortby\('x'\)")):
            with self.assertRaisesRegex(ValueError, text):
                wrong.bcc4.to_file(path("bad.bcc4"))
        twice.bcc4.to_file(path("told.bcc4"), dims=("time", "z", "y", "x"), lattice="cc")
        np.testing.assert_allclose(bccsplat.open(path("told.bcc4")), self.source, atol=.001)

    def test_each_channel_has_its_own_unit(self):
        ds = atmosphere(self.source).drop_vars(["lev", "lat"])
        ds.bcc4.to_file(path("units.bcc4"), psnr=50)
        volume = bccsplat.open(path("units.bcc4"))
        self.assertEqual([volume.channel_info(n).unit for n in range(2)], ["K", "kg kg-1"])

    def test_axes_of_different_units(self):
        ds = xr.Dataset({"f": (("time", "z", "y", "x"), self.source)},
                        {"z": ("z", 10. * np.arange(8), {"units": "m", "positive": "down"}),
                         "y": ("y", np.arange(9.), {"units": "degrees_north"}), "x": ("x", np.arange(10.), {"units": "degrees_east"})},
                        {"title": "t"})
        ds.bcc4.to_file(path("mixed.bcc4"), lattice="cc")
        volume = bccsplat.open(path("mixed.bcc4"))
        self.assertEqual(volume.info().affine[10], -10)
        back = open_file("mixed.bcc4")
        np.testing.assert_array_equal(back.z, ds.z)
        self.assertEqual([back[name].attrs["units"] for name in "xyz"], ["degrees_east", "degrees_north", "m"])
        self.assertEqual(volume.plane(0, x=1).units, ("degrees_north", "m"))
        place = back.bcc4.interp(time=3., x=2.5, y=4.5, z=33.)
        self.assertAlmostEqual(float(place.f), float(volume.evaluate_world([[2.5, 4.5, -33., 3]])[0][0]), places=5)


@unittest.skipIf(*without("netCDF4"))
@unittest.skipUnless(support.TOOL, "NO TOOL IN THIS BUILD")
class ByTheTool(unittest.TestCase):
    """Names and attributes of datasets are the same whether Python writes the file or the tool, and whoever reads it."""

    def bcc4(self, *args):
        subprocess.run([support.TOOL, *args, "--quiet", "--overwrite"], check=True, cwd=support.SCRATCH)

    def records(self, name):
        found = bccsplat.open(path(name)).attributes()
        return {key: json.loads(text) for key, text in found.items() if key.startswith(("axis.", "channel."))}

    def test_records_are_alike(self):
        source = atmosphere(waves(6, 8, 9, 10))[["ta"]]
        source.ta.attrs.update(flags=np.array([1, 2], np.int16), limit=np.float32(.1), grid_mapping="crs", spare=np.nan)
        numbered = source.assign_coords(time=("time", 3. * np.arange(6), {"units": "hours", "long_name": "when", "axis": "T"}))
        even = source.assign_coords(lev=("lev", 10. * np.arange(8), {"units": "m", "positive": "down", "long_name": "Depth"}))
        for ds in source, numbered, even:
            ds.to_netcdf(path("r.nc"), encoding={"time": {"units": "hours since 2001-02-27"}} if ds is not numbered else None)
            self.bcc4("import", "r.nc", "--lattice", "cc", "--exact", "-o", "tool.bcc4")
            again = xr.load_dataset(path("r.nc"), decode_timedelta=False)
            again.bcc4.to_file(path("python.bcc4"), lattice="cc", overwrite=True)
            by_tool, by_python = self.records("tool.bcc4"), self.records("python.bcc4")
            for record in (*by_tool.values(), *by_python.values()):
                record.pop("spare", None)  # "nan" and "NaN"
            self.assertEqual(by_tool, by_python)
            self.assertEqual({*by_tool}, {"axis.t", "axis.z", "axis.y", "axis.x", "channel.ta"})
            back = open_file("tool.bcc4")
            self.assertEqual(back.ta.dims, ds.ta.dims)
            self.assertEqual((back.ta.attrs["long_name"], back.lev.attrs), ("Air Temperature", ds.lev.attrs))
            for name in ("time", "lev", "lat", "lon"):
                np.testing.assert_allclose(back[name].astype(float), ds[name].astype(float), err_msg=name)
            for way in ("r2.nc", "r2.nrrd"):  # what Python wrote, out by the tool
                self.bcc4("export", "python.bcc4", "--all", "-o", way)
                self.bcc4("import", way, "--lattice", "cc", "--exact", "-o", "again.bcc4")
                for key, record in self.records("again.bcc4").items():
                    self.assertEqual({**record, **by_python[key], "spare": None}, {**record, "spare": None}, (way, key))
            there = xr.load_dataset(path("r2.nc"), decode_timedelta=False)
            self.assertEqual((there.ta.dims, there.lev.attrs["units"], there.ta.attrs["standard_name"]),
                             (ds.ta.dims, ds.lev.attrs["units"], "air_temperature"))
            np.testing.assert_array_equal(there.time, ds.time)
            np.testing.assert_allclose(there.lev, ds.lev)


if __name__ == "__main__":
    support.fresh_scratch()
    bccsplat.save(path("even.bcc4"), waves(2, 4, 5, 6))
    support.main()

"""python_round_test.py TOP EXAMPLES SCRATCH: xr.open_dataset(nc) -> to_file -> open_dataset(engine="bccsplat") gives names,
coordinates, attributes and units back, and values within the bound: of made-up series, and of real ones where these are:
in the folder BCCSPLAT_DATA, or shared/data beside the project."""
import os
import unittest
import warnings

import python_support as support
from python_support import path, waves, without

support.need("numpy", "xarray")
import numpy as np  # noqa: E402
import xarray as xr  # noqa: E402

import bccsplat  # noqa: E402
import bccsplat.accessor  # noqa: E402, F401

DATA = os.environ.get("BCCSPLAT_DATA") or os.path.join(support.TOP, "..", "shared", "data")
# What a file says of itself, and what is true of the source's bytes alone.
ADDED = {"actual_range", "bcc4_error_bound", "bcc4_level", "bcc4_affine", "bcc4_spatial_unit", "Conventions"}
OF_BYTES = {"valid_range"}


def open_file(name, **options):
    return xr.open_dataset(path(name), engine="bccsplat", **options)


def said(attrs):
    return {key: value.tolist() if hasattr(value, "tolist") else value for key, value in attrs.items() if key not in ADDED | OF_BYTES}


class Round(unittest.TestCase):
    def assert_round(self, ds, bounds, **options):
        ds.bcc4.to_file(path("round.bcc4"), abs_error=bounds, overwrite=True, **options)
        back = open_file("round.bcc4")
        self.assertEqual((back.sizes, list(back.data_vars), {*back.coords}), (ds.sizes, list(ds.data_vars), {*ds.coords}))
        self.assertEqual(said(back.attrs), said(ds.attrs))
        for name, right in ds.variables.items():
            found = back[name].variable
            self.assertEqual((found.dims, said(found.attrs)), (right.dims, said(right.attrs)), name)
            if name not in bounds:
                np.testing.assert_array_equal(found.values, right.values, name)
                self.assertEqual(found.dtype.kind, right.dtype.kind, name)
                continue
            np.testing.assert_array_equal(np.isnan(found), np.isnan(right), name)
            off, rounding = float(np.nanmax(abs(found.astype(float) - right))), float(np.nanmax(abs(right))) * 2.0**-23
            self.assertLessEqual(off, bounds[name] + rounding, name)
        return back


def hourly(frames=30):
    """An hourly series by the calendar noleap over the end of a February, with variables beside it."""
    return xr.Dataset(
        {"tas": (("time", "height", "lat", "lon"), 280 + waves(frames, 3, 9, 10), {"units": "K", "standard_name": "air_temperature",
                                                                                      "cell_methods": "time: mean"}),
         "hus": (("time", "height", "lat", "lon"), waves(frames, 3, 9, 10) / 500, {"units": "1", "realm": 3, "levels": [1., 2.]}),
         "weight": ("lat", np.cos(np.linspace(-1, 1, 9)).astype(np.float32), {"units": "1", "long_name": "weights of rows"}),
         "run": ((), 4, {"long_name": "number of the run"}), "flux": ("time", np.where(np.arange(frames) % 7, 1.5, np.nan)),
         "begun": ((), np.datetime64("1999-12-31T06:00", "ns"))},
        {"time": ("time", 24 * 58 + np.arange(float(frames)), {"units": "hours since 2004-01-01 00:00:00", "calendar": "noleap",
                                                                 "long_name": "hour", "standard_name": "time"}),
         "height": ("height", [2., 10, 50], {"units": "m", "positive": "up", "axis": "Z"}),
         "lat": ("lat", np.linspace(60, 40, 9), {"units": "degrees_north"}), "lon": ("lon", 1.25 * np.arange(10), {"units": "degrees_east"}),
         "station": ("lon", ["row %d" % n for n in range(10)], {"long_name": "names"}), "member": 7},
        {"title": "made up", "version": 3, "tolerance": .25, "sizes": np.array([1, 2])})


class MadeUp(Round):
    @unittest.skipIf(*without("cftime"))
    def test_an_hourly_series_of_a_calendar_without_leap_days(self):
        ds = xr.decode_cf(hourly())
        self.assertEqual((ds.time.values[23].month, ds.time.values[24].day), (2, 1))  # no 29 February
        back = self.assert_round(ds, {"tas": .01, "hus": 1e-5})
        self.assertEqual(type(back.time.values[0]), type(ds.time.values[0]))
        self.assertEqual([back[name].attrs["bcc4_error_bound"] for name in ("tas", "hus")], [.01, 1e-5])

    @unittest.skipIf(*without("netCDF4"))
    def test_by_files_of_netcdf(self):
        hourly().to_netcdf(path("hourly.nc"))
        with xr.open_dataset(path("hourly.nc")) as ds:
            back = self.assert_round(ds, {"tas": .01, "hus": 1e-5})
            back.to_netcdf(path("again.nc"))
            with xr.open_dataset(path("again.nc")) as again:
                xr.testing.assert_allclose(again.drop_vars(["tas", "hus"]), ds.drop_vars(["tas", "hus"]))

    def test_what_lies_beside_goes_along(self):
        ds = hourly()
        ds.bcc4.to_file(path("round.bcc4"), lattice="cc", overwrite=True)
        back = open_file("round.bcc4", decode_times=False)
        part = back.isel(time=slice(2, 9), lat=slice(1, None)).bcc4.interp(lon=[2.5, 3])
        np.testing.assert_array_equal(part.weight, ds.weight[1:])
        self.assertEqual((part.run, part.member, "station" in part), (4, 7, False))
        back.isel(time=slice(0, 9)).bcc4.to_file(path("part.bcc4"), overwrite=True)
        np.testing.assert_array_equal(open_file("part.bcc4", decode_times=False).flux, ds.flux[:9])
        self.assertEqual(open_file("round.bcc4", drop_variables=["run", "tas"]).data_vars.keys(), {"hus", "weight", "flux", "begun"})

    def test_what_is_large_is_refused_by_name(self):
        ds = hourly()
        ds["mask"] = ("lat", "lon"), np.ones((9, 10))
        with self.assertRaisesRegex(ValueError, r"mask has the dimensions lat, lon: only small.*drop_vars\(\['mask'\]\)"):
            ds.bcc4.to_file(path("no.bcc4"))
        with self.assertRaisesRegex(ValueError, "abs_error has tos, which is no channel: there are tas, hus"):
            hourly().bcc4.to_file(path("no.bcc4"), abs_error={"tos": 1})

    def test_durations(self):
        ds = hourly(6)[["tas"]].assign_coords(time=("time", np.arange(6) * np.timedelta64(90, "m").astype("m8[ns]"), {"long_name": "lead"}))
        back = self.assert_round(ds, {"tas": .01})
        np.testing.assert_array_equal(back.bcc4.at(np.timedelta64(90, "m")).tas, back.tas[1])
        np.testing.assert_array_equal(back.isel(time=slice(1, 4)).bcc4.at(np.timedelta64(180, "m")).tas, back.tas[2])


@unittest.skipIf(*without("netCDF4"))
class Real(Round):
    def opened(self, name):
        if not os.path.exists(os.path.join(DATA, name)):
            self.skipTest("%s IS NOT THERE" % name)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            ds = xr.open_dataset(os.path.join(DATA, name))
        self.addCleanup(ds.close)
        return ds

    def test_a_forecast(self):
        ds = self.opened("ncep_forecast_36x33x10x7_f32.nc")
        with self.assertRaisesRegex(ValueError, "Psl has.*grib_center has.*grib_model has"):
            ds.bcc4.to_file(path("whole.bcc4"))
        back = self.assert_round(ds[["T", "Z"]], {"T": .05, "Z": 2})
        self.assertEqual((back.frtime.dtype.kind, back.level.values[0], back.level.attrs["units"]), ("m", 1000, "millibars"))

    def test_an_ocean_of_uneven_depths(self):
        back = self.assert_round(self.opened("cases/uneven_depths.nc"), {"temp": .01})
        self.assertEqual(back.depth.attrs, {"units": "m", "positive": "down"})

    def test_days_of_a_calendar(self):
        back = self.assert_round(self.opened("cases/days_noleap.nc"), {"temp": .1})
        self.assertEqual(back.time.values[2].month, 3)


if __name__ == "__main__":
    support.fresh_scratch()
    support.install_entry_points()
    support.main()

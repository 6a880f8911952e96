"""python_examples_test.py TOP EXAMPLES SCRATCH: the short programs of examples/python do what they say."""
import importlib.util
import os
import shutil
import subprocess
import sys
import unittest

import python_support as support
from python_support import path, waves, without

support.need("numpy")
import numpy as np  # noqa: E402

import bccsplat  # noqa: E402

# Lines of code that a short example has at most, without its description, imports and blank lines.
SHORT = 14


def run(name, *arguments):
    script = os.path.join(support.PYTHON, name)
    done = subprocess.run([sys.executable, "-B", script, *map(str, arguments)], capture_output=True, text=True, cwd=support.SCRATCH)
    assert done.returncode == 0, (name, done.stdout, done.stderr)
    return done.stdout


def bench(name, *arguments):
    return run(os.path.join(support.TOP, "tests", "bench", name), *arguments)


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        support.fresh_scratch()
        cls.source = waves(14, 20, 22, 24)
        bccsplat.save(path("a.bcc4"), cls.source, dt=.5, start=1, spacing=2, name="d", unit="g", time_unit="s", spatial_unit="mm")
        bccsplat.save(path("b.bcc4"), cls.source + .25, dt=.25, start=2, spacing=2)

    def test_they_are_short(self):
        for name in ("numpy_to_picture", "retime", "compare_runs", "probes", "film"):
            with open(os.path.join(support.PYTHON, name + ".py"), encoding="utf-8") as file:
                lines = file.read().split('"""', 2)[2].splitlines()
            code = [line for line in lines if line.strip() and not line.startswith(("import", "from"))]
            self.assertLessEqual(len(code), SHORT, name)

    def test_numpy_to_picture(self):
        told = run("numpy_to_picture.py", support.SCRATCH)
        self.assertRegex(told, "largest value is (0.9|1.0)")
        with open(path("blob.png"), "rb") as file:
            self.assertGreater(len(file.read()), 2000)

    @unittest.skipIf(*without("netCDF4"))
    @unittest.skipIf(*without("scipy"))
    def test_a_field_between_samples_is_measured(self):
        told = bench("python_speed.py", path("speed"), "--size", 20, "--frames", 16, "--points", 500)
        rows = [line.split("|") for line in told.splitlines() if line.startswith("| ")][1:]
        self.assertEqual(len(rows), 6)
        names = [name for name in os.listdir(path("speed")) if name.endswith(".bcc4")]
        self.assertEqual((len(names), "waves-no-options.bcc4" in names), (16, True))

    @unittest.skipIf(*without("h5py"))
    @unittest.skipIf(*without("zarr"))
    def test_crops_are_measured(self):
        told = bench("python_loader.py", path("loader"), "--size", 33, "--frames", 5, "--crops", 4, "--workers", 2)
        rows = {line.split("|")[1].strip(): line.split("|")[4] for line in told.splitlines() if line.startswith("| ")}
        self.assertEqual([float(rows["bccsplat, " + name]) <= .0101 for name in ("crops()", "any order", "read_frame()")], [True] * 3)
        spec = importlib.util.spec_from_file_location("loader", os.path.join(support.TOP, "tests", "bench", "python_loader.py"))
        loader = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(loader)
        sums = [loader.READERS["bccsplat, " + name](path("loader/a.bcc4"), (5, 33, 33, 33), 3, 1, None) for name in ("any order", "read_frame()")]
        self.assertAlmostEqual(*sums, delta=1)

    def test_retime(self):
        self.assertEqual(run("retime.py", path("a.bcc4"), path("slow.bcc4"), 3), "14 frames became 40\n")
        slow, volume = bccsplat.open(path("slow.bcc4")), bccsplat.open(path("a.bcc4"))
        np.testing.assert_allclose(slow.times(), 1 + np.arange(40) / 6, atol=1e-12)
        for n in (0, 4, 20, 39):
            self.assertLess(abs(slow[n] - volume[n / 3]).max(), .02 * 4.1)  # what a file without options keeps, of the range
        self.assertEqual((slow.info().affine[:], slow.channel_info().unit, slow.info().time_unit),
                         (volume.info().affine[:], "g", "s"))

    def test_compare_runs(self):
        rows = [line.split() for line in run("compare_runs.py", path("a.bcc4"), path("b.bcc4")).splitlines()[1:]]
        self.assertEqual([float(row[0]) for row in rows], [2, 2.5, 3, 3.5, 4, 4.5, 5])
        for row in rows:
            first, second = (bccsplat.open(path(name)).at(float(row[0])) for name in ("a.bcc4", "b.bcc4"))
            self.assertAlmostEqual(float(row[1]), float(np.sqrt(((first - second) ** 2).mean())), delta=1e-3)
            self.assertAlmostEqual(float(row[2]), float(abs(first - second).max()), delta=1e-3)

    def test_probes(self):
        told = run("probes.py", path("a.bcc4"), path("p.csv"), "10,12,14", "3,4.5,5", "99,0,0")
        table = np.genfromtxt(path("p.csv"), delimiter=",", skip_header=1)
        self.assertEqual(table.shape, (53, 4))
        volume = bccsplat.open(path("a.bcc4"))
        np.testing.assert_allclose(table[::4, 1], volume[:, 7, 6, 5], atol=1e-5)
        np.testing.assert_allclose(table[:, 2], volume.evaluate([[1.5, 2.25, 2.5, n / 4] for n in range(53)]), atol=1e-5)
        self.assertTrue(np.isnan(table[:, 3]).all())
        self.assertIn("fastest change", told)

    @unittest.skipIf(shutil.which("ffmpeg") is None, "THIS MACHINE HAS NO FFMPEG")
    def test_film(self):
        run("film.py", path("a.bcc4"), path("a.mp4"), 8)
        probe = subprocess.run(["ffprobe", "-loglevel", "error", "-count_frames", "-show_entries",
                                "stream=nb_read_frames,width,height", "-of", "csv=p=0", path("a.mp4")], check=True,
                               capture_output=True, text=True)
        self.assertEqual(probe.stdout.strip(), "480,360,8")

    @unittest.skipIf(*without("xarray"))
    @unittest.skipIf(*without("dask"))
    def test_xarray_dask(self):
        support.install_entry_points()
        told = run("xarray_dask.py", path("a.bcc4"), path("anomaly.bcc4"))
        mean = bccsplat.open(path("a.bcc4")).at(4.25).mean()
        self.assertIn("%.3f" % mean, told)
        expected = self.source - self.source.mean(0)
        self.assertLess(abs(np.asarray(bccsplat.open(path("anomaly.bcc4"))) - expected).max(), .02 * (np.ptp(self.source) + np.ptp(expected)))


if __name__ == "__main__":
    support.main()

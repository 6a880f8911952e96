"""What the tests of the Python package share. They are called with TOP EXAMPLES SCRATCH [TOOL]; the library is that of
BCCSPLAT_LIBRARY. Exits with 77 where a package that a test is about is missing, and says so."""
import os
import shutil
import sys
import unittest
from importlib.util import find_spec

TOP, EXAMPLES, SCRATCH = sys.argv[1:4]
TOOL = sys.argv[4] if len(sys.argv) > 4 else None
PYTHON = os.path.join(TOP, "examples", "python")
sys.path.insert(0, PYTHON)
sys.dont_write_bytecode = True


def need(*packages):
    """Ends the test where one of these packages is not installed."""
    for package in packages:
        if find_spec(package) is None:
            print("skipped: THIS PYTHON HAS NO %s, nothing of it was tested" % package.upper())
            sys.exit(77)


def without(package):
    """For unittest.skipIf: whether a package is missing, and the reason in words."""
    return find_spec(package) is None, "THIS PYTHON HAS NO %s" % package.upper()


def path(name):
    return os.path.join(SCRATCH, name)


def main():
    """Runs the tests of the program, and says what was skipped and why."""
    ran = unittest.main(argv=sys.argv[:1], verbosity=1, exit=False)  # sys.argv stays: spawned processes look at it
    for test, reason in ran.result.skipped:
        print("SKIPPED: %s: %s" % (test.id(), reason), file=sys.stderr)
    sys.exit(not ran.result.wasSuccessful())


def install_entry_points():
    """Makes the file of entry points that is installed findable, here and in processes to come; needs a scratch folder."""
    folder = path("site/bccsplat-0.0.dist-info")
    os.makedirs(folder)
    shutil.copy(os.path.join(TOP, "src", "cmake", "python_entry_points.txt"), os.path.join(folder, "entry_points.txt"))
    with open(os.path.join(folder, "METADATA"), "w", encoding="utf-8") as target:
        target.write("Metadata-Version: 2.1\nName: bccsplat\nVersion: 0.0\n")
    sys.path.insert(0, path("site"))
    os.environ["PYTHONPATH"] = os.pathsep.join([path("site"), PYTHON])


def fresh_scratch():
    shutil.rmtree(SCRATCH, ignore_errors=True)
    os.makedirs(SCRATCH)


def waves(frames, nz, ny, nx):
    """Smooth values [t, z, y, x], float32, about 2."""
    import numpy as np
    t, z, y, x = np.ogrid[0:frames, 0:nz, 0:ny, 0:nx]
    return (2 + np.sin(.2 * x + .1 * t) + np.cos(.15 * y) * np.sin(.1 * z - .07 * t)).astype(np.float32)

"""paraview_pipeline_test.py TOP EXAMPLES SCRATCH TOOL PVPYTHON: examples/paraview_plugin.py in the real ParaView: pvpython
loads it, opens files and draws (paraview_pipeline.py); what it shows is held against what the tool and the package read. Takes
half a minute, and is no test of ctest: .ci/nightly paraview unpacks a ParaView and runs it."""
import os
import subprocess
import sys

import python_support as support

support.need("numpy")
import numpy as np  # noqa: E402

import bccsplat  # noqa: E402

PVPYTHON = sys.argv[5]
SCRIPT = os.path.join(support.TOP, "tests", "examples", "paraview_pipeline.py")
FRAMES, SIZE = 12, 48
MOMENT = 11.3  # between frames, which are at 11 and 11.5


def tool(*arguments):
    subprocess.run([support.TOOL, *arguments, "--quiet"], check=True)


def save_smoke():
    """One channel as an import without options stores it; two with a unit of time; and what is read of these."""
    subprocess.run([os.path.join(support.EXAMPLES, "simulate_smoke"), "--size", str(SIZE), "--steps", str(FRAMES), "--raw",
                    "--heat", "-o", support.path("raw")], check=True, stdout=subprocess.DEVNULL)
    files = {"density": "smoke", "heat": "heat"}
    named = {name: [support.path("raw/%s.%04d.raw" % (file, n)) for n in range(FRAMES)] for name, file in files.items()}
    tool("import", *named["density"], "--dims", ",".join([str(SIZE)] * 3), "--dtype", "f32", "--dt", ".5", "-o",
         support.path("default.bcc4"))
    channels = {name: np.stack([np.fromfile(file, np.float32).reshape([SIZE] * 3) for file in of]) for name, of in named.items()}
    two = support.path("two.bcc4")
    bccsplat.save(two, channels, dt=.5, start=10, time_unit="s", spacing=2.0, origin=(1.0, 2.0, 3.0))
    volume = bccsplat.open(two)
    for name in channels:
        np.save(support.path(name + ".npy"), volume.slice(time=MOMENT, channel=name).sample_grid())
        tool("export", two, "--channel", name, "--time", str(MOMENT), "-o", support.path(name + ".raw"))
    tool("export", two, "--channel", "heat", "--time", str(MOMENT), "--roi", "12-29,20-20,5-40", "-o", support.path("region.raw"))
    tool("export", two, "--channel", "density", "--time", str(MOMENT), "-o", support.path("density.vti"))


def save_others():
    """A blob about (6, 7, 6) whose axes are turned, or oblique, in the world; labels; missing data; and a file that is none."""
    z, y, x = np.mgrid[0:12, 0:14, 0:16].astype(np.float32)
    blob = np.exp(-((x - 6) ** 2 + (y - 7) ** 2 + (z - 6) ** 2) / 12)
    turned = np.array([[0, -2.0, 0, 10], [1.5, 0, 0, 20], [0, 0, 3, 30], [0, 0, 0, 1]])
    oblique = np.array([[.8, -.6, 0, 0], [.6, .8, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    for name, affine in (("turned", turned), ("oblique", oblique)):
        with bccsplat.Device() as device, bccsplat.Writer(device, support.path(name + ".bcc4"), (16, 14, 12, 2), affine=affine,
                                                          channels=[bccsplat.Channel("blob")]) as writer:
            writer.add_frame(blob, 0)
            writer.add_frame(blob, 1)
    missing = np.stack([blob, blob])
    missing[:, 1:4, :, 12:] = np.nan
    bccsplat.save(support.path("missing.bcc4"), missing, nonfinite="hole")
    labels = np.add.outer(np.arange(4), np.arange(16) // 8)[:, None, None, :] * np.ones((12, 14, 1))
    bccsplat.save(support.path("labels.bcc4"), labels.astype(np.uint8), labels=True)
    with open(support.path("none.bcc4"), "w", encoding="utf-8") as file:
        file.write("nothing of the kind")


def pvpython(part):
    """What ParaView says of a part of paraview_pipeline.py."""
    own = {"PYTHONPATH": support.PYTHON, "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([PVPYTHON, SCRIPT, part, support.TOP, support.SCRATCH], env={**os.environ, **own}, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode or "DONE " + part not in done.stdout:
        sys.exit("pvpython, %s: %d\n%s" % (part, done.returncode, done.stdout))
    print("\n".join(line for line in done.stdout.splitlines() if line.startswith(part)))
    return done.stdout


def hold_told(part, words):
    """That a part says these words."""
    said = pvpython(part)
    if words not in said:
        sys.exit("%s: nowhere is said: %s\n%s" % (part, words, said))
    print("%s: holds: said is: %s" % (part, words))


support.fresh_scratch()
save_smoke()
save_others()
for quiet in ("values", "kinds", "stopped", "picture"):
    if "oblique" in pvpython(quiet):
        sys.exit("%s: a warning of oblique axes, where none are" % quiet)
hold_told("oblique", "oblique.bcc4: its axes are oblique in the world")
hold_told("refused", "none.bcc4: not a .bcc4 file")

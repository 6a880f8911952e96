"""blender_volumes_test.py TOP EXAMPLES SCRATCH TOOL: Blender without a screen installs the add-on of examples/blender and renders
moments of smoke with Cycles (blender_scene.py), through the package and, where that does not load, through the tool; pictures
are held against those of files that the tool exports. Takes a minute, and is no test of ctest: .ci/nightly blender runs it.
Exits with 77 without Blender."""
import os
import shutil
import subprocess
import sys

import python_support as support

support.need("numpy")
import numpy as np  # noqa: E402

BLENDER = shutil.which("blender")
if BLENDER is None:
    print("skipped: THIS MACHINE HAS NO BLENDER, nothing of the add-on was tested")
    sys.exit(77)
import bccsplat  # noqa: E402

SCENE = os.path.join(support.TOP, "tests", "examples", "blender_scene.py")
FRAMES, SIZE = 20, 64


def export(source, frame, name):
    subprocess.run([support.TOOL, "export", source, "--channel", "density", "--time", str(frame), "--index", "-o",
                    support.path(name), "--quiet"], check=True)


def make_files():
    """Two channels of smoke, frames half a second apart; the same at uneven times; labels; and a file that is none."""
    subprocess.run([os.path.join(support.EXAMPLES, "simulate_smoke"), "--size", str(SIZE), "--steps", str(FRAMES), "--raw",
                    "--heat", "-o", support.path("raw")], check=True, stdout=subprocess.DEVNULL)
    channels = {name: np.stack([np.fromfile(support.path("raw/%s.%04d.raw" % (file, n)), np.float32).reshape([SIZE] * 3)
                                for n in range(FRAMES)]) for name, file in (("density", "smoke"), ("heat", "heat"))}
    options = {"lattice": "d4star", "air_threshold": .004, "spacing": 2.0, "origin": (1.0, 2.0, 3.0)}
    bccsplat.save(support.path("smoke.bcc4"), channels, dt=.5, start=10, time_unit="s", levels=2, **options)
    bccsplat.save(support.path("uneven.bcc4"), channels["density"], times=[n * n for n in range(FRAMES)], **options)
    blocks = np.add.outer(np.arange(4), np.arange(16) // 8)[:, None, None, :] * np.ones((16, 16, 1))
    bccsplat.save(support.path("labels.bcc4"), blocks.astype(np.uint8), lattice="cc", labels=True)
    with open(support.path("none.bcc4"), "w", encoding="utf-8") as file:
        file.write("nothing of the kind")
    for frame in (12.37, 12, 13):
        export(support.path("smoke.bcc4"), frame, "export-%s.vdb" % frame)
    shutil.make_archive(support.path("bcc4_volumes"), "zip", os.path.join(support.TOP, "examples", "blender"), "bcc4_volumes")


def blender(part, *arguments, script=SCENE, **environment):
    """Runs a part of blender_scene.py in a Blender that has no settings but its own, or another script."""
    own = {"BLENDER_USER_CONFIG": support.path("config"), "BLENDER_USER_SCRIPTS": support.path("scripts"),
           "PYTHONPATH": support.PYTHON, "PYTHONDONTWRITEBYTECODE": "1", **environment}
    done = subprocess.run([BLENDER, "-b", "--factory-startup", "-noaudio", "--python-use-system-env", "--python-exit-code", "1",
                           "--python", script, "--", *(arguments or (part, support.SCRATCH))], env={**os.environ, **own}, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    lines = [line for line in done.stdout.splitlines() if not line.startswith(("Fra:", "Saved:", " Time:"))]
    if done.returncode or (script == SCENE and "DONE " + part not in done.stdout):
        sys.exit("blender, %s: %d\n%s" % (part, done.returncode, "\n".join(lines)))
    print("\n".join(line for line in lines if line.startswith(part)))


support.fresh_scratch()
make_files()
blender("package")
blender("reopened")
blender("render.py", support.path("smoke.bcc4"), "12.37", support.path("render.png"), "64", "4",
        script=os.path.join(support.TOP, "examples", "blender", "render.py"))
assert os.path.getsize(support.path("render.png")) > 1000, "render.py made no picture"
blender("tool", BCCSPLAT_LIBRARY="/nowhere/libbccsplat.so", BCCSPLAT_TOOL=support.TOOL)
blender("neither", BCCSPLAT_LIBRARY="/nowhere/libbccsplat.so", BCCSPLAT_TOOL="/nowhere/bcc4")

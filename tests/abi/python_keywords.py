"""python_keywords.py PACKAGE: mypy --strict takes keywords that are right and finds every one that is misspelt. Exits with 77
without mypy."""
import ast
import os
import re
import shutil
import subprocess
import sys
import tempfile

# What hands keywords on to others, or takes names that are the data's.
FREE = {"interp": "coordinates of the file", "imshow": "matplotlib's", "plane_of": "x, y and z", "evaluate_or_nan": "of two classes",
        "writer": "parts", "save_planned": "of Plan", "Struct.__init__": "named by each struct", "given": "those of its caller",
        "refuse_both": "those of its callers"}

NAMES = """
import bccsplat
import bccsplat.accessor
import bccsplat.zarr_store
import numpy as np
a = np.zeros((2, 3, 4, 5))
device = bccsplat.Device()
v = bccsplat.open("a.bcc4")
cut = v.slice(frame=1)
renderer = bccsplat.Renderer(device)
scene = bccsplat.Scene(device)
accessor: bccsplat.accessor.Bcc4Accessor
copy: bccsplat.Volume = v.share()
""".strip()

RIGHT = """
bccsplat.open("a.bcc4", kernel="fine", cache_bytes=1 << 20, salvage=1, device=device, shape=(1, 1, 2))
bccsplat.save("b.bcc4", a, dt=0.5, abs_error={"value": 0.1}, levels=1, lattice="cc", overwrite=True, psnr=50, unit="K", measure="all")
bccsplat.save("b.bcc4", a, start=1, spacing=2, origin=0, name="T", density=.5, exact=True, faces="mirror", ends="periodic", lowpass=1)
bccsplat.Volume(device, "a.bcc4", kernel="fine", cache_bytes=1, salvage=1)
v.show(1.0, width=64, look="ct_bone", rotate_x=10, background=None, mode="maximum", quality="draft", shading="none")
v.slice(time=1.0, channel=0, spacing=0.5, kernel="fine", level=1, space="even", thickness=2.0, bandwidth=(1, 1, 1, 1))
v.plane(1.0, z=3.5, level=0)
v.ranges(frame=1, missing=True, level=1, box=None, spacing=1.0, kernel="fine")
v.crops((1, 2, 3, 4), seed=1, count=3)
v.reopen(source=None)
cut.show(64, 64, mode="maximum", quality="draft", sheet_step=.5, look="mr", tile=None)
bccsplat.Slice(v, 0, 0, 0, 1, -1, level=1, slab="mean", method="merged", thickness=2.0)
bccsplat.Slice.at(v, 1.5, level=1, spacing=0.5, channel="T")
bccsplat.Slice.at_time(v, 1.5, level=1, lattice="cc")
bccsplat.Slice.along(v, (0, 0, 0, 0), np.eye(3, 4), level=1, interval=(0, 1))
cut.bricks(grid="samples", dtype=np.uint8, edge=16, border=1)
bccsplat.draw(cut, 64, 64, mode="isosurface", iso_value=.5, opacity_stop=.9, surfaces=(), background=None)
renderer.set_options(mode="maximum", quality="draft", sheet_step=.5, reference=1, depth_opacity=.5)
renderer.set_trail((-2, 0), samples=3, combine="interleaved", content="mean", weights=(1, 2), unlit=True)
renderer.set_lights(ambient=.5, shadow=True)
bccsplat.RenderOptions(quality="fine", tile_size=32, deep_tolerance=.1, disable_skips=1)
scene.add(v, placement=None, time_scale=2.0, time_offset=1.0, density=.5, channel="T", hidden=True)
scene.set_instance(1, time_scale=2.0, outside="loop", mask_labels=(1,))
bccsplat.Writer(device, "b.bcc4", (5, 4, 3, 2), abs_error=.1, levels=1, live=2, measure="some", faces="mirror", part=(0, 1), psnr=40)
bccsplat.Plan(device, (5, 4, 3, 2), lambda t, c: a, abs_error=.1, nonfinite="hole", scale=(1, 1, 2), density=.5, store="wavelets")
bccsplat.Channel(name="T", unit="K", air=0, labels=True)
bccsplat.zarr_store.Store("a.bcc4", kernel="fine", cache_bytes=1)
bccsplat.SharedFile("a.bcc4", kernel="fine", salvage=1)
accessor.to_file("b.bcc4", dims=("t", "z", "y", "x"), abs_error=.1, nonfinite="hole", lattice="cc", parts=2, levels=1, scale=2.0)
bccsplat.abi.Camera(projection=1)
bccsplat.abi.RenderOptions(sheet_step=.5, mode="maximum")
bccsplat.join_parts(device, ["a", "b"], "c", overwrite=True, compare_levels=True)
""".strip().splitlines()


def open_keywords(package):
    """Public functions that take any keyword, but for those of FREE."""
    found = []
    for name in sorted(os.listdir(package)):
        if not name.endswith(".py") or name == "_abi.py":
            continue
        with open(os.path.join(package, name), encoding="utf-8") as file:
            tree = ast.parse(file.read())
        owners = {child: node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef) for child in node.body}
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef) and node.args.kwarg and (node.name == "__init__" or not node.name.startswith("_")):
                full = "%s.%s" % (owners.get(node, ""), node.name)
                if not FREE.keys() & {node.name, full}:
                    found.append("%s: %s takes any keyword" % (name, full))
    return found


def misspelt(statement):
    """The statement once for each of its keywords, which is misspelt in it."""
    for node in ast.walk(ast.parse(statement)):
        for keyword in node.keywords if isinstance(node, ast.Call) else ():
            yield statement[:keyword.col_offset] + keyword.arg + "x" + statement[keyword.col_offset + len(keyword.arg):]


def errors_of(package, lines, folder):
    """What mypy says of a program, by its lines."""
    with open(os.path.join(folder, "use.py"), "w", encoding="utf-8") as file:
        file.write("\n".join([NAMES, *lines]) + "\n")
    done = subprocess.run(["mypy", "--strict", "--cache-dir", os.path.join(folder, "cache"), "use.py"], cwd=folder, capture_output=True,
                          text=True, env={**os.environ, "MYPYPATH": os.path.dirname(os.path.abspath(package))})
    before = NAMES.count("\n") + 1
    found = re.findall(r"^use\.py:(\d+): error: (.*)$", done.stdout, re.M)
    return {int(line) - before: text for line, text in found}, done.stdout + done.stderr


def main(package):
    if shutil.which("mypy") is None:
        print("skipped: no mypy")
        return 77
    wrong = open_keywords(package)
    with tempfile.TemporaryDirectory() as folder:
        found, said = errors_of(package, RIGHT, folder)
        if found or "Success" not in said:
            wrong.append("mypy does not take what is right: " + said)
        lines = [line for statement in RIGHT for line in misspelt(statement)]
        found, said = errors_of(package, lines, folder)
        for number, line in enumerate(lines, 1):
            if not re.search("Unexpected keyword argument|No overload|incompatible type|Extra key", found.get(number, "")):
                wrong.append("mypy takes %s: %s" % (line, found.get(number, "nothing is said")))
    print("\n".join(wrong) or "%d misspelt keywords are found" % len(lines))
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))

"""python_host_test.py TOP EXAMPLES SCRATCH: the ctypes host agrees with the C hosts and with the ABI lists."""
import ctypes
import os
import re
import subprocess
import sys

top, examples, scratch = sys.argv[1:]
sys.path.insert(0, os.path.join(top, "examples", "python"))
sys.dont_write_bytecode = True
import bccsplat  # noqa: E402

# Struct for struct and field for field as the compiler lays them out.
layout = {}
for line in open(os.path.join(top, "tests", "abi", "layout.txt")):
    if match := re.match(r"bccsplat_(\w+)\.(\w+) offset (\d+) size (\d+)", line):
        layout.setdefault(match[1], {})[match[2]] = (int(match[3]), int(match[4]))
    elif match := re.match(r"struct bccsplat_(\w+) size (\d+)", line):
        layout[match[1]][""] = int(match[2])
for struct, name in [(bccsplat.VolumeInfo, "volume_info"), (bccsplat.Hyperplane, "hyperplane"),
                     (bccsplat.SliceInfo, "slice_info"), (bccsplat.Plane, "plane"),
                     (bccsplat.ImageOptions, "image_options")]:
    fields = {field: (getattr(struct, field).offset, getattr(struct, field).size) for field, _ in struct._fields_}
    assert fields | {"": ctypes.sizeof(struct)} == layout[name], name

os.makedirs(scratch, exist_ok=True)
file, from_c, from_python = (os.path.join(scratch, name) for name in ("blobs.bcc4", "c.png", "python.png"))
subprocess.run([os.path.join(examples, "write_in_situ"), file], check=True)
subprocess.run([os.path.join(examples, "render_frame"), file, from_c, "4.5"], check=True)
bccsplat.main(file, from_python, "4.5")
assert open(from_c, "rb").read() == open(from_python, "rb").read()

device = bccsplat.Device()
volume = bccsplat.Volume(device, file)
assert list(volume.info().dims) == [49, 49, 49, 17]
cut = bccsplat.Slice.at(volume, 4.5)
box = cut.sample_grid()
assert box.shape == (49, 49, 49)
points = [(x, y, z, 4.5) for x, y, z in [(24, 24, 24), (31, 33, 24), (20, 16, 25), (0, 0, 0)]]
for (x, y, z, t), value in zip(points, volume.evaluate(points)):
    assert abs(box[z, y, x] - value) <= 1e-6, (x, y, z, box[z, y, x], value)
assert max(volume.evaluate(points)) > 0.5

try:
    bccsplat.Volume(device, os.path.join(scratch, "missing.bcc4"))
    raise AssertionError("a missing file opens")
except bccsplat.Error as error:
    assert error.name == "BCCSPLAT_ERROR_FILE_NOT_FOUND" and "missing.bcc4" in str(error)

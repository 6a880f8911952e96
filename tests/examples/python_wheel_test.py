"""python_wheel_test.py TOP EXAMPLES SCRATCH BUILD [EMULATOR...]: the wheel of a build folder is whole and says what is in it, and
runs in an environment of its own that has neither the sources nor a compiler; of a build for 64-bit ARM its tool and its package
run under an emulator, the package by the Python of EMULATOR's folder. Exits with 77 without patchelf or venv."""
import base64
import csv
import glob
import hashlib
import io
import os
import re
import shutil
import signal
import subprocess
import sys
import urllib.request
import zipfile

top, _examples, scratch, build, *emulator = sys.argv[1:]
for tool in ("patchelf", "readelf", "dpkg"):
    if shutil.which(tool) is None:
        print("skipped: THIS MACHINE HAS NO %s, no wheel was made" % tool.upper())
        sys.exit(77)
try:
    if not emulator:
        import ensurepip  # noqa: F401  of python3-venv
        import venv  # noqa: F401

        import numpy  # noqa: F401
except ImportError as error:
    print("skipped: THIS PYTHON LACKS %s (python3-venv, python3-numpy), no wheel was made" % error.name)
    sys.exit(77)

LIBRARIES = "libbccsplat libOpenEXR libpng16 libdeflate"
PYTHON_CODE = """
import os
import numpy, bccsplat
here = os.path.dirname(bccsplat.__file__)
assert here.startswith(os.environ["VENV"]), here
array = numpy.fromfunction(lambda t, z, y, x: numpy.sin(.2 * x + .1 * t) + numpy.cos(.2 * y), (14, 12, 14, 16))
bccsplat.save("a.bcc4", array, dt=.5)
volume = bccsplat.open("a.bcc4")
assert abs(volume[3] - array[3]).max() < .081 and volume[3.5].shape == (12, 14, 16)
assert volume.show(1, width=64, height=64)._repr_png_().startswith(bytes([0x89]) + b"PNG")
bccsplat.save("b.bcc4", array, psnr=45)
mapped = open("/proc/self/maps").read()
for name in os.environ["LIBRARIES"].split():
    files = {line.split()[-1] for line in mapped.splitlines() if name in line}
    assert len(files) == 1 and next(iter(files)).startswith(here), files
from importlib.metadata import entry_points
assert [point.value for point in entry_points(group="xarray.backends") if point.name == "bccsplat"] == \\
    ["bccsplat.xarray_backend:BccsplatBackend"]
"""


def told(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def made(output):
    script = os.path.join(top, "examples", "python", "build_wheel.sh")
    wheel = told("bash", script, output, build).split()[-1]
    machine = "aarch64" if emulator else "x86_64"
    assert re.fullmatch(r"bccsplat-\d+\.\d+\.\d+-py3-none-manylinux_2_36_%s\.whl" % machine, os.path.basename(wheel)), wheel
    return wheel


def check_record(archive):
    """Each file is in RECORD with its digest and size, and nothing else is."""
    info, = {name.split("/")[0] for name in archive.namelist() if ".dist-info/" in name}
    rows = list(csv.reader(io.StringIO(archive.read(info + "/RECORD").decode())))
    assert sorted(row[0] for row in rows) == sorted(archive.namelist())
    for name, digest, size in rows:
        content = archive.read(name)
        if name == info + "/RECORD":
            assert (digest, size) == ("", "")
            continue
        expected = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        assert (digest, int(size)) == ("sha256=" + expected, len(content)), name
    return info


def check_contents(archive, info, folder):
    """The package, the tool, every library that is needed and not everywhere, with its licence; no module of a reader."""
    names = archive.namelist()
    sources = [name for name in os.listdir(os.path.join(top, "examples", "python", "bccsplat")) if name.endswith(".py")]
    for name in [*sources, "py.typed", "bin/bcc4", "lib/libbccsplat.so.0"]:
        assert "bccsplat/" + name in names, name
    assert not [name for name in names if "netcdf" in name or "openvdb" in name or name.endswith(".pyc")]
    metadata = archive.read(info + "/METADATA").decode()
    licences = [name.removeprefix(info + "/licenses/") for name in names if "/licenses/" in name]
    assert sorted(re.findall("License-File: (.*)", metadata)) == sorted(licences)
    assert "LICENSE" in licences and "Root-Is-Purelib: false" in archive.read(info + "/WHEEL").decode()
    for package in ("libhwy-dev", "libcli11-dev", "nlohmann-json3-dev", "libstb-dev", "fonts-dejavu-core"):  # compiled in
        assert package + ".copyright" in licences, (package, licences)
    for licence in licences:
        text = archive.read(info + "/licenses/" + licence).decode()
        assert len(text) > 500 and "opyright" in text, licence
        for name in re.findall(r"/usr/share/common-licenses/([\w.-]*\w)", text):  # is not on other systems
            assert name + ".txt" in licences, (licence, name)
    archive.extractall(folder)
    binaries = [name for name in names if name.startswith(("bccsplat/lib/", "bccsplat/bin/"))]
    inside = {os.path.basename(name) for name in binaries}
    sys.path.insert(0, os.path.join(top, "examples", "python"))
    from assemble_wheel import ALLOWED
    for name in binaries:
        path = os.path.join(folder, name)
        needed = set(told("patchelf", "--print-needed", path).split())
        assert needed <= ALLOWED | inside, (name, needed - ALLOWED - inside)
        rpath = told("patchelf", "--print-rpath", path).strip()
        assert rpath == ("$ORIGIN/../lib" if "/bin/" in name else "$ORIGIN"), (name, rpath)
        assert (archive.getinfo(name).external_attr >> 16) & 0o111, name
        library = re.match(r"lib([A-Za-z]+)", os.path.basename(name))
        if library and library[1] != "bccsplat":
            package = {"Iex": "openexr", "IlmThread": "openexr"}.get(library[1], library[1].lower())
            assert any(package in licence.replace("-", "") for licence in licences), (name, licences)


def check_viewer(bcc4, environment, folder):
    """`bcc4 view` serves the viewer that the wheel has, or that of a folder."""
    def view(*arguments):
        return subprocess.Popen([bcc4, "view", "b.bcc4", *arguments], env=environment, cwd=folder, text=True, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE)

    page = os.path.join(folder, "page")
    os.makedirs(page, exist_ok=True)
    for name in ("core.wasm", "index.html"):
        with open(os.path.join(page, name), "w", encoding="utf-8") as file:
            file.write("the page")
    has_viewer = os.path.isdir(os.path.join(top, "build-web", "site"))
    if not has_viewer:
        assert "no viewer is installed" in view().communicate(timeout=60)[1]
    with view(*(() if has_viewer else ("--page", page))) as running:
        link = running.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?url=file\.bcc4", link), link
        with urllib.request.urlopen(link.replace("?url=", "")) as answer, open(os.path.join(folder, "b.bcc4"), "rb") as file:
            assert answer.read() == file.read()
        running.send_signal(signal.SIGINT)
        assert running.wait(20) == 0, running.stderr.read()


def check_installed(wheel, folder):
    environment = os.path.join(folder, "venv")
    subprocess.run([sys.executable, "-m", "venv", "--system-site-packages", environment], check=True)
    binaries = os.path.join(environment, "bin")
    alone = {"PATH": binaries, "VENV": environment, "HOME": folder, "LIBRARIES": LIBRARIES + " libhwy"}

    def run(*command, code=0):
        done = subprocess.run([os.path.join(binaries, command[0]), *command[1:]], env=alone, cwd=folder, capture_output=True,
                              text=True)
        assert done.returncode == code, (command, done.returncode, done.stdout, done.stderr)
        return done.stdout + done.stderr

    run("pip", "install", "--quiet", "--no-index", "--no-deps", wheel)
    printed = run("python", "-I", "-m", "bccsplat")
    for text in ("package            " + environment, "bcc4 ", "inside", "libOpenEXR", "optional packages"):
        assert text in printed, printed
    run("python", "-I", "-c", PYTHON_CODE)
    assert run("bcc4", "--version").startswith("bcc4 ")
    assert "samples" in run("bcc4", "info", "b.bcc4")
    run("bcc4", "render", "a.bcc4", "--time", "1", "-o", "a.exr", "--size", "64x64")
    with open(os.path.join(folder, "a.nc"), "wb") as file:
        file.write(b"CDF\1" + bytes(40))
    said = run("bcc4", "import", "a.nc", "-o", "x.bcc4", code=3)
    assert "a wheel has no module for NetCDF" in said and "xarray" in said, said
    check_viewer(os.path.join(binaries, "bcc4"), alone, folder)
    run("pip", "uninstall", "--quiet", "--yes", "bccsplat")
    packages, = glob.glob(os.path.join(environment, "lib", "python3*", "site-packages"))
    left = [name for name in os.listdir(packages) if "bccsplat" in name]
    assert not left and not os.path.exists(os.path.join(binaries, "bcc4")), left


def check_emulated(folder):
    """Package and tool with the libraries of the wheel. The tool's loader is called by its name: qemu 7.2 itself does not load
    programs that patchelf has changed."""
    loader = [*emulator, os.path.join(emulator[-1], "lib", "ld-linux-aarch64.so.1")]
    bcc4 = [*loader, os.path.join(folder, "bccsplat", "bin", "bcc4")]
    inside = told(*loader, "--list", bcc4[-1])
    for name in ("libbccsplat", "libOpenEXR", "libpng16", "libdeflate", "libpugixml"):
        assert re.search(r"\b%s[^ ]* => %s/" % (name, re.escape(os.path.join(folder, "bccsplat"))), inside), (name, inside)
    assert told(*bcc4, "--version").startswith("bcc4 ")
    raw, stored, picture = (os.path.join(folder, "tool." + kind) for kind in ("raw", "bcc4", "exr"))
    with open(raw, "wb") as file:
        file.write(bytes(i * i % 251 for i in range(16 ** 3 * 4)))
    told(*bcc4, "import", raw, "--dims", "16,16,16,4", "--dtype", "u8", "-o", stored)
    told(*bcc4, "render", stored, "--time", "1", "-o", picture, "--size", "64x64")
    assert os.path.getsize(picture) > 1000
    python = [*emulator, os.path.join(emulator[-1], "usr", "bin", "python3")]
    alone = {"PATH": os.environ["PATH"], "PYTHONPATH": folder, "VENV": folder, "LIBRARIES": LIBRARIES}
    assert told(*python, "-c", "import platform; print(platform.machine())").strip() == "aarch64"
    subprocess.run([*python, "-c", PYTHON_CODE], env=alone, cwd=folder, check=True)


shutil.rmtree(scratch, ignore_errors=True)
os.makedirs(scratch)
first = made(os.path.join(scratch, "first"))
with zipfile.ZipFile(first) as archive:
    check_contents(archive, check_record(archive), os.path.join(scratch, "unpacked"))
with open(first, "rb") as one, open(made(os.path.join(scratch, "second")), "rb") as two:
    assert one.read() == two.read(), "two wheels of one build differ"
if emulator:
    check_emulated(os.path.join(scratch, "unpacked"))
else:
    check_installed(first, scratch)
shutil.rmtree(scratch)

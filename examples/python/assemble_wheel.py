"""assemble_wheel.py STAGE LICENSE OUTPUT: a wheel of what `cmake --install` put into STAGE; prints its name.

Inside are the package, the library in bccsplat/lib, the tool in bccsplat/bin, and copies of the shared libraries that the
policy manylinux_2_36 does not count on, under names of their own so that they do not meet those of other packages in one
process. Their licences are those of Debian's packages. The same input gives the same bytes.
"""
import base64
import glob
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile

TAG = "py3-none-manylinux_2_36_x86_64"
# What every system of the policy has (PEP 600): the C and C++ runtimes and zlib.
ALLOWED = {"ld-linux-x86-64.so.2", "libc.so.6", "libm.so.6", "libdl.so.2", "librt.so.1", "libpthread.so.0", "libgcc_s.so.1",
           "libstdc++.so.6", "libz.so.1"}
# The newest versions of symbols that it has.
NEWEST = {"GLIBC": (2, 36), "GLIBCXX": (3, 4, 30), "CXXABI": (1, 3, 13), "GCC": (12, 0, 0)}
# Packages of which code or data are in the binaries without a shared library.
COMPILED_IN = ["libhwy-dev", "libcli11-dev", "nlohmann-json3-dev", "libstb-dev", "fonts-dejavu-core"]
ENTRY_POINTS = "[console_scripts]\nbcc4 = bccsplat.tool:main\n\n"
COMMON = "/usr/share/common-licenses"
EPOCH = (1980, 1, 1, 0, 0, 0)


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def needed(binary):
    return run("patchelf", "--print-needed", binary).split()


def resolved(binary, folder):
    """What the loader takes for each library that a binary needs, directly or not."""
    found = {}
    for line in run("env", "LD_LIBRARY_PATH=" + folder, "ldd", binary).splitlines():
        if match := re.match(r"\s*(\S+) => (/\S+)", line):
            found[match[1]] = match[2]
        elif "not found" in line:
            sys.exit("assemble_wheel.py: %s: %s" % (binary, line.strip()))
    return found


def check_versions(binary):
    """That nothing newer than the policy is needed."""
    for family, version in re.findall(r"\b(GLIBC|GLIBCXX|CXXABI|GCC)_([\d.]+)\b", run("objdump", "-T", binary)):
        if tuple(map(int, version.split("."))) > NEWEST[family]:
            sys.exit("assemble_wheel.py: %s needs %s_%s, which %s does not have: build on Debian 12" %
                     (os.path.basename(binary), family, version, TAG))


def debian_package(library):
    """The name of the package that a file came with."""
    path = os.path.realpath(library)
    for pattern in (path, path.removeprefix("/usr"), "*/" + os.path.basename(path)):
        asked = subprocess.run(["dpkg", "-S", pattern], capture_output=True, text=True)
        if asked.returncode == 0:
            return asked.stdout.split(":")[0]
    sys.exit("assemble_wheel.py: no Debian package has %s, so that its licence is unknown: build on Debian 12" % library)


def bundle(tree):
    """Copies what library and tool need beside them, and returns the packages that it came from."""
    lib = os.path.join(tree, "bccsplat", "lib")
    programs = [os.path.join(lib, name) for name in sorted(os.listdir(lib))] + [os.path.join(tree, "bccsplat", "bin", "bcc4")]
    own = {os.path.basename(program) for program in programs}
    sources, packages = {}, set()
    for program in programs:
        sources |= {name: path for name, path in resolved(program, lib).items() if name not in ALLOWED | own}
    renamed = {}
    for name, path in sorted(sources.items()):
        with open(path, "rb") as file:
            digest = hashlib.sha256(file.read()).hexdigest()[:8]
        stem, dot, rest = name.partition(".so")
        renamed[name] = "%s-%s%s%s" % (stem, digest, dot, rest)
        target = os.path.join(lib, renamed[name])
        shutil.copyfile(path, target)
        run("patchelf", "--set-soname", renamed[name], target)
        packages.add(debian_package(path))
        programs.append(target)
    for program in programs:
        for name in sorted(set(needed(program)) & set(renamed)):
            run("patchelf", "--replace-needed", name, renamed[name], program)
        run("patchelf", "--set-rpath", "$ORIGIN" if os.path.dirname(program) == lib else "$ORIGIN/../lib", program)
        os.chmod(program, 0o755)
        check_versions(program)
    return sorted(packages)


def common_licences(folder):
    """Names of the licences that the files of a folder do not quote but say where Debian has them."""
    names = set()
    for name in os.listdir(folder):
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            names |= set(re.findall(COMMON + r"/([\w.-]*\w)", file.read()))
    return names


def licences(packages, own, folder):
    os.makedirs(folder)
    shutil.copyfile(own, os.path.join(folder, "LICENSE"))
    for package in packages:
        source = "/usr/share/doc/%s/copyright" % package
        if not os.path.exists(source):
            sys.exit("assemble_wheel.py: %s is missing, which says how %s may be passed on: install the package with its "
                     "documentation" % (source, package))
        shutil.copyfile(source, os.path.join(folder, package + ".copyright"))
    for name in sorted(common_licences(folder)):
        shutil.copyfile(os.path.join(COMMON, name), os.path.join(folder, name + ".txt"))
    return sorted(os.listdir(folder))


def lay_out(stage, tree):
    """The files of the stage where a wheel has them; returns the name of the folder of metadata."""
    package, = glob.glob(os.path.join(stage, "lib", "python3", "dist-packages", "bccsplat"))
    info, = glob.glob(os.path.join(os.path.dirname(package), "bccsplat-*.dist-info"))
    shutil.copytree(package, os.path.join(tree, "bccsplat"), ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(info, os.path.join(tree, os.path.basename(info)))
    for folder in ("lib", "bin"):
        os.makedirs(os.path.join(tree, "bccsplat", folder))
    library, = glob.glob(os.path.join(stage, "lib*", "libbccsplat.so.[0-9]")) or \
        glob.glob(os.path.join(stage, "lib*", "*", "libbccsplat.so.[0-9]"))
    shutil.copyfile(library, os.path.join(tree, "bccsplat", "lib", os.path.basename(library)))
    shutil.copyfile(os.path.join(stage, "bin", "bcc4"), os.path.join(tree, "bccsplat", "bin", "bcc4"))
    with open(os.path.join(tree, "bccsplat", "library_path"), "w", encoding="utf-8") as file:
        file.write("lib\n")
    return os.path.basename(info)


def record(tree, info):
    """Each file with its digest and size, in order."""
    rows, files = [], []
    for folder, _, names in os.walk(tree):
        files += [os.path.relpath(os.path.join(folder, name), tree) for name in names]
    for name in sorted(files):
        with open(os.path.join(tree, name), "rb") as file:
            content = file.read()
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        rows.append("%s,sha256=%s,%d" % (name, digest, len(content)))
    own = info + "/RECORD"
    with open(os.path.join(tree, own), "w", encoding="utf-8") as file:
        file.write("\n".join([*rows, own + ",,"]) + "\n")
    return [*sorted(files), own]


def pack(tree, files, path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name in files:
            source = os.path.join(tree, name)
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if os.access(source, os.X_OK) else 0o100644) << 16
            with open(source, "rb") as file:
                wheel.writestr(entry, file.read())


def add_metadata(folder, names):
    with open(os.path.join(folder, "METADATA"), "a", encoding="utf-8") as file:
        file.write("".join("License-File: %s\n" % name for name in names))
    with open(os.path.join(folder, "WHEEL"), "w", encoding="utf-8") as file:
        file.write("Wheel-Version: 1.0\nGenerator: bccsplat\nRoot-Is-Purelib: false\nTag: %s\n" % TAG)
    entries = os.path.join(folder, "entry_points.txt")
    with open(entries, encoding="utf-8") as file:
        text = file.read()
    with open(entries, "w", encoding="utf-8") as file:
        file.write(ENTRY_POINTS + text)


def main(stage, licence, output):
    with tempfile.TemporaryDirectory() as tree:
        info = lay_out(stage, tree)
        packages = bundle(tree) + COMPILED_IN
        names = licences(packages, licence, os.path.join(tree, info, "licenses"))
        add_metadata(os.path.join(tree, info), names)
        name = "%s-%s.whl" % (info.removesuffix(".dist-info"), TAG)
        pack(tree, record(tree, info), os.path.join(output, name))
    print(os.path.join(output, name))


if __name__ == "__main__":
    main(*sys.argv[1:])

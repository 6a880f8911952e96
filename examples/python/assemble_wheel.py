"""assemble_wheel.py STAGE LICENSE OUTPUT [ROOT]: a wheel of what `cmake --install` put into STAGE; prints its name. ROOT is where
the root of the system is that it was built for, /.

Inside are the package, the library in bccsplat/lib, the tool in bccsplat/bin, the viewer for browsers in bccsplat/web where
examples/web/build.sh has made it, and copies of the shared libraries that the
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

POLICY = "manylinux_2_36"
# The numbers that ELF files have for machines.
MACHINES = {62: "x86_64", 183: "aarch64"}
# What every system of the policy has (PEP 600): the C and C++ runtimes and zlib.
ALLOWED = {"ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1", "libc.so.6", "libm.so.6", "libdl.so.2", "librt.so.1", "libpthread.so.0", "libgcc_s.so.1",
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


def machine(binary):
    with open(binary, "rb") as file:
        return MACHINES[int.from_bytes(file.read(20)[18:], "little")]


def resolved(binary, folder, root):
    """The file of each library that a binary needs, directly or not, but for those of the policy: in a folder, or where Debian
    has it."""
    found, left = {}, [binary]
    places = [folder, *(os.path.join(root, lib, machine(binary) + "-linux-gnu") for lib in ("usr/lib", "lib"))]
    while left:
        for name in set(needed(left.pop())) - ALLOWED - set(found):
            files = [path for place in places if os.path.exists(path := os.path.join(place, name))]
            if not files:
                sys.exit("assemble_wheel.py: %s: %s not found" % (binary, name))
            found[name] = files[0]
            left.append(files[0])
    return found


def check_versions(binary):
    """That nothing newer than the policy is needed."""
    for family, version in re.findall(r"\b(GLIBC|GLIBCXX|CXXABI|GCC)_([\d.]+)\b", run("readelf", "--dyn-syms", "-W", binary)):
        if tuple(map(int, version.split("."))) > NEWEST[family]:
            sys.exit("assemble_wheel.py: %s needs %s_%s, which %s does not have: build on Debian 12" %
                     (os.path.basename(binary), family, version, POLICY))


def debian_package(library):
    """The name of the package that a file came with."""
    path = os.path.realpath(library)
    for pattern in (path, path.removeprefix("/usr"), "*/" + os.path.basename(path)):
        asked = subprocess.run(["dpkg", "-S", pattern], capture_output=True, text=True)
        if asked.returncode == 0:
            return asked.stdout.split(":")[0]
    sys.exit("assemble_wheel.py: no Debian package has %s, so that its licence is unknown: build on Debian 12" % library)


def bundle(tree, root):
    """Copies what library and tool need beside them, and returns the packages that it came from."""
    lib = os.path.join(tree, "bccsplat", "lib")
    programs = [os.path.join(lib, name) for name in sorted(os.listdir(lib))] + [os.path.join(tree, "bccsplat", "bin", "bcc4")]
    own = {os.path.basename(program) for program in programs}
    sources, packages = {}, set()
    for program in programs:
        sources |= {name: path for name, path in resolved(program, lib, root).items() if name not in own}
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
    site = os.path.join(stage, "share", "bccsplat", "web")
    if os.path.isdir(site):
        shutil.copytree(site, os.path.join(tree, "bccsplat", "web"))
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


def add_metadata(folder, names, tag):
    with open(os.path.join(folder, "METADATA"), "a", encoding="utf-8") as file:
        file.write("".join("License-File: %s\n" % name for name in names))
    with open(os.path.join(folder, "WHEEL"), "w", encoding="utf-8") as file:
        file.write("Wheel-Version: 1.0\nGenerator: bccsplat\nRoot-Is-Purelib: false\nTag: %s\n" % tag)
    entries = os.path.join(folder, "entry_points.txt")
    with open(entries, encoding="utf-8") as file:
        text = file.read()
    with open(entries, "w", encoding="utf-8") as file:
        file.write(ENTRY_POINTS + text)


def main(stage, licence, output, root="/"):
    with tempfile.TemporaryDirectory() as tree:
        info = lay_out(stage, tree)
        tag = "py3-none-%s_%s" % (POLICY, machine(os.path.join(tree, "bccsplat", "bin", "bcc4")))
        packages = bundle(tree, root) + COMPILED_IN
        names = licences(packages, licence, os.path.join(tree, info, "licenses"))
        add_metadata(os.path.join(tree, info), names, tag)
        name = "%s-%s.whl" % (info.removesuffix(".dist-info"), tag)
        pack(tree, record(tree, info), os.path.join(output, name))
    print(os.path.join(output, name))


if __name__ == "__main__":
    main(*sys.argv[1:])

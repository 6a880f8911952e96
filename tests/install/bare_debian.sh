#!/bin/bash
# bare_debian.sh FOLDER: makes the Python wheel in a Debian 12 that has nothing but git, and runs it in another one that has
# no compiler: package, tool and every program of examples/python. As root, with debootstrap and a network; takes the time of
# a whole build and 4 GB in FOLDER, where the systems stay. A system that is there already is used as it is.
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mkdir -p "${1:?usage: bare_debian.sh FOLDER}" && cd "$1" && pwd)
mirror=${BCCSPLAT_DEBIAN_MIRROR:-http://deb.debian.org/debian}

# A system with nothing but what every Debian has; made once and copied.
bare() {
  if [[ ! -e $folder/base/etc/debian_version ]]; then
    debootstrap --variant=minbase bookworm "$folder/base" "$mirror" >"$folder/debootstrap.log" 2>&1 ||
      { tail -n 5 "$folder/debootstrap.log" && exit 1; }
  fi
  [[ -e $folder/$1 ]] || cp -a "$folder/base" "$folder/$1"
  cp /etc/resolv.conf "$folder/$1/etc/resolv.conf"
}

# inside SYSTEM COMMAND...: with nothing of this system's environment; /proc is mounted for as long as it runs.
inside() {
  local system=$folder/$1
  shift
  # shellcheck disable=SC2016  # expanded by the inner shell
  unshare --mount --pid --fork bash -c 'mount -t proc proc "$1/proc" && exec chroot "$@"' inside "$system" /usr/bin/env -i \
    PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    "CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" "$@"
}

get() { # get SYSTEM PACKAGE...
  local system=$1
  shift
  inside "$system" apt-get -q -o Acquire::Retries=3 update
  inside "$system" apt-get -q -y -o Acquire::Retries=3 --no-install-recommends install "$@" </dev/null
}

echo "== a wheel, in a system that has git"
bare build
get build git
rm -rf "$folder/build/bccsplat" "$folder/build/dist"
git -C "$top" bundle create "$folder/build/source.bundle" HEAD 2>/dev/null
inside build git clone -q /source.bundle /bccsplat
inside build bash /bccsplat/examples/python/build_wheel.sh /dist
wheel=$(basename "$folder"/build/dist/*.whl)

echo "== its installation, in a system that has Python and no compiler"
bare use
get use python3-venv python3-numpy python3-xarray python3-dask ffmpeg
for program in cc c++ gcc g++ clang cmake make git patchelf; do
  if inside use bash -c "command -v $program"; then
    echo "bare_debian.sh: $program is in the system that should have no compiler" >&2
    exit 1
  fi
done
rm -rf "$folder"/use/{dist,programs,venv,work}
mkdir "$folder"/use/{dist,programs,work}
cp "$folder/build/dist/$wheel" "$folder/use/dist"
cp "$top"/examples/python/*.py "$top/tests/install/bare_debian_use.sh" "$folder/use/programs"
inside use bash /programs/bare_debian_use.sh "/dist/$wheel"
echo "bare_debian.sh: $wheel, $(du -k "$folder/use/dist/$wheel" | cut -f1) KiB"

# Sourced by examples/quickstart.sh and tests/run.sh: Debian 12 packages, installed only where missing.

# What the library, the tool and the examples are built from. libboost-dev: OpenVDB's headers include it, its package
# does not depend on it.
build_packages=(build-essential cmake ninja-build pkg-config zlib1g-dev libdeflate-dev libhwy-dev libpng-dev
  libopenexr-dev libimath-dev libopenvdb-dev libtbb-dev libboost-dev libnetcdf-dev libtiff-dev libcli11-dev nlohmann-json3-dev
  libpugixml-dev libmicrohttpd-dev libstb-dev fonts-dejavu-core libepoxy-dev libegl-dev)
# Python's tests of matplotlib are skipped where that is not installed; the others are small.
test_packages=(libgtest-dev libbenchmark-dev libzfp-dev python3 gnuplot-nox python3-numpy mypy
  python3-venv python3-xarray python3-dask python3-distributed python3-zarr python3-fsspec python3-aiohttp python3-h5py patchelf
  universal-ctags locales abigail-tools dpkg-dev lintian doxygen libsdl2-dev libimgui-dev xvfb xauth xdotool python3-vtk9 tesseract-ocr
  ffmpeg python3-nibabel python3-netcdf4 python3-tifffile jupyter-nbconvert python3-ipykernel libegl1 libgl1-mesa-dri
  libopengl0 libopenmpi-dev openmpi-bin)

# install_missing PACKAGE...: asks apt for those that are not installed; as root or through sudo.
install_missing() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "Not a Debian system: make sure that the equivalents of these are installed: $*" >&2
    return
  fi
  local missing=() package as_root=()
  for package in "$@"; do
    if [[ $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) != installed ]]; then
      missing+=("$package")
    fi
  done
  ((${#missing[@]})) || return 0
  if ((EUID != 0)); then
    if ! command -v sudo >/dev/null; then
      echo "Missing packages; as root: apt-get install ${missing[*]}" >&2
      return 1
    fi
    as_root=(sudo)
  fi
  echo "Installing ${missing[*]}"
  "${as_root[@]}" apt-get -o Acquire::Retries=3 -q update
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o Acquire::Retries=3 -q -y \
    --no-install-recommends install "${missing[@]}" </dev/null
}

# Compiler launchers for cmake, when ccache is there. What one clone compiled serves others.
launchers=()
if command -v ccache >/dev/null; then
  launchers=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  CCACHE_BASEDIR=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
  export CCACHE_BASEDIR CCACHE_NOHASHDIR=1
fi

#!/bin/bash
# build_wheel.sh OUTPUT_FOLDER [BUILD]: a wheel of the Python package for Debian 12 and later, and what is as new: package,
# library and tool with what they need, without the tool's modules (OpenVDB, NetCDF, TIFF, the server of `bcc4 view`). Installs
# what is missing with apt and builds in build-wheel/, or takes a build folder that is there; that of
# `tests/aarch64.sh --build`, build-aarch64, gives a wheel for 64-bit ARM. `pip install OUTPUT_FOLDER/*.whl` then needs no compiler.
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
output=${1:?usage: build_wheel.sh OUTPUT_FOLDER [BUILD]} build=${2:-}
# shellcheck source=tests/packages.sh
source "$top/tests/packages.sh"

if [[ -z $build ]]; then
  install_missing "${build_packages[@]}" python3 patchelf
  build=$top/build-wheel
  cmake -S "$top" -B "$build" -G Ninja "${launchers[@]}" -DCMAKE_BUILD_TYPE=Release -DBCCSPLAT_BUILD_TESTS=OFF \
    -DBCCSPLAT_BUILD_BENCH=OFF -DBCCSPLAT_BUILD_EXAMPLES=OFF -DBCCSPLAT_BUILD_TOOL=ON -DBCCSPLAT_WITH_OPENVDB=ON \
    -DBCCSPLAT_WITH_NETCDF=ON -DBCCSPLAT_TOOL_MODULES=ON -DBCCSPLAT_WITH_IMAGE=ON -DCMAKE_UNITY_BUILD=ON
  cmake --build "$build" --target bccsplat bcc4
else
  install_missing patchelf
fi

root=$(sed -n 's/^BCCSPLAT_AARCH64_ROOT:[A-Z]*=//p' "$build/CMakeCache.txt")
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
for component in runtime tools python; do
  cmake --install "$build" --prefix "$stage" --component $component --strip >/dev/null
done
mkdir -p "$output"
python3 -B "$top/examples/python/assemble_wheel.py" "$stage" "$top/LICENSE" "$output" "${root:-/}"

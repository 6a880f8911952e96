#!/bin/bash
# run.sh [--build]: installs what is missing (Debian 12), builds everything with warnings as errors, and runs all tests,
# none with --build.
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
# shellcheck source=tests/packages.sh
source "$top/tests/packages.sh"
install_missing "${build_packages[@]}" "${test_packages[@]}"

build=$top/build-tests
cmake -S "$top" -B "$build" -G Ninja "${launchers[@]}" -DCMAKE_BUILD_TYPE=Release -DBCCSPLAT_WERROR=ON \
  -DBCCSPLAT_BUILD_TESTS=ON -DBCCSPLAT_BUILD_TOOL=ON -DBCCSPLAT_WITH_OPENVDB=ON -DBCCSPLAT_WITH_IMAGE=ON \
  -DBCCSPLAT_BUILD_EXAMPLES=ON -DBCCSPLAT_BUILD_BENCH=ON -DBCCSPLAT_SANITIZE= -DCMAKE_UNITY_BUILD=ON
cmake --build "$build"
[[ ${1:-} != --build ]] || exit 0
cd "$build"
exec ctest --output-on-failure -j "$(nproc)"

#!/bin/bash
# The library without its writer, its splatter, its cuts and motion: it builds, a host in C reads golden files by it, and nothing of what was
# left out is in it. Builds for the machine's own vectors, in build-reading.
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
# shellcheck source=tests/packages.sh
source "$top/tests/packages.sh"
install_missing "${build_packages[@]}"
build=${1:-$top/build-reading}
cmake -S "$top" -B "$build" -G Ninja "${launchers[@]}" -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON \
  -DCMAKE_CXX_FLAGS="-DHWY_COMPILE_ONLY_STATIC" -DCMAKE_CXX_FLAGS_RELEASE="-O1 -DNDEBUG" \
  -DBCCSPLAT_WITH_WRITER=OFF -DBCCSPLAT_WITH_SPLAT=OFF -DBCCSPLAT_WITH_CUTS=OFF -DBCCSPLAT_WITH_MOTION=OFF \
  -DBCCSPLAT_WITH_IMAGE=OFF -DBCCSPLAT_BUILD_TESTS=OFF -DBCCSPLAT_BUILD_BENCH=OFF -DBCCSPLAT_BUILD_TOOL=OFF -DBCCSPLAT_BUILD_EXAMPLES=OFF >/dev/null
cmake --build "$build" --target bccsplat
cc -std=c99 -Wall -Wextra -Werror -I "$top/include" "$top/tests/reading/host.c" -L "$build/src" -lbccsplat \
  -Wl,-rpath,"$build/src" -o "$build/reading_host"
for file in v5_d4star_u8 v5_levels v5_corrections; do
  "$build/reading_host" "$top/tests/golden/$file.bcc4"
done
if nm -C "$build/src/libbccsplat.so" | grep -E 'bccsplat::(VolumeWriter|SheetDrawer|RayDrawer|Bcc4Writer|ThickField)::|motion::follow_ways'; then
  echo "FAILED: what was left out is in the library" >&2
  exit 1
fi

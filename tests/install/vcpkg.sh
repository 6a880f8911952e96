#!/bin/bash
# vcpkg.sh SCRATCH [CMAKE_OPTION...]: runs the steps of the port in examples/packages/vcpkg by functions of our own that stand
# for vcpkg's (vcpkg/functions.cmake), looks at what is installed as vcpkg's last checks do, and builds and runs a host against
# it from where it was moved to, in both build types. Not tried: vcpkg itself, its triplets, and its builds of what the port
# depends on, whose names vcpkg.json has; the system's libraries stand for these. Exits with 77 where it is not due (due.sh).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
top=$(cd "$here/../.." && pwd)
# shellcheck source=tests/install/due.sh
source "$here/due.sh"
scratch=${1:?usage: vcpkg.sh SCRATCH [CMAKE_OPTION...]}
shift
rm -rf "$scratch"
mkdir -p "$scratch"
scratch=$(cd "$scratch" && pwd)
# What reads files, not optimised, and for the machine's own vectors alone: the steps are tested here, not the library. Both
# build types have the same flags, so that a compiler's cache has the objects of the second.
options="-DCMAKE_UNITY_BUILD=ON;-DBCCSPLAT_WITH_WRITER=OFF;-DBCCSPLAT_WITH_SPLAT=OFF;-DBCCSPLAT_WITH_CUTS=OFF;-DBCCSPLAT_WITH_MOTION=OFF"
options+=";-DCMAKE_CXX_FLAGS=-DHWY_COMPILE_ONLY_STATIC;-DCMAKE_CXX_FLAGS_RELEASE=-O0 -DNDEBUG;-DCMAKE_CXX_FLAGS_DEBUG=-O0 -DNDEBUG"
for option in "$@"; do options+=";$option"; done
cmake -DPORT_DIR="$top/examples/packages/vcpkg/bccsplat" -DSCRATCH="$scratch" -DFEATURES=images \
  -DVCPKG_CMAKE_CONFIGURE_OPTIONS="$options" -P "$here/vcpkg/functions.cmake" || { tail -n 40 "$scratch/log" && exit 1; }
installed=$scratch/installed
mv "$scratch/packages" "$installed"
rm -rf "$scratch/buildtrees"

failed() { echo "FAILED: $*" >&2 && exit 1; }
for file in include/bccsplat.h include/bccsplat.hpp lib/libbccsplat.so debug/lib/libbccsplat.so lib/pkgconfig/bccsplat.pc \
  share/bccsplat/{copyright,usage,bccsplatConfig.cmake,bccsplatConfigVersion.cmake,bccsplatTargets.cmake}; do
  [[ -s $installed/$file ]] || failed "$file is missing"
done
for folder in debug/include debug/share lib/cmake debug/lib/cmake lib/python3 bin; do
  [[ ! -e $installed/$folder ]] || failed "$folder is left"
done
find "$installed" -type d -empty | grep . && failed "empty folders"
grep -rlF "$scratch" --include='*.cmake' --include='*.pc' "$installed" && failed "paths of the build"
cmp "$top/LICENSE" "$installed/share/bccsplat/copyright"
for target in $(grep -oE '\bbccsplat::[a-z]+' "$installed/share/bccsplat/usage"); do
  grep -qF "$target" "$here/host/CMakeLists.txt" || failed "the host does not use $target, which usage names"
done

for type in Release Debug; do
  cmake -S "$here/host" -B "$scratch/host_$type" -DCMAKE_BUILD_TYPE=$type -DCMAKE_PREFIX_PATH="$installed" >"$scratch/host.log"
  cmake --build "$scratch/host_$type" >>"$scratch/host.log"
  "$scratch/host_$type/host"
done
# Whole outputs: a grep that ends early would end ldd with an error.
[[ $(ldd "$scratch/host_Release/host") == *" $installed/lib/libbccsplat.so"* ]] || failed "the host takes another library"
[[ $(ldd "$scratch/host_Debug/host") == *" $installed/debug/lib/libbccsplat.so"* ]] || failed "the debug host takes another library"
rm -rf "$scratch"

#!/bin/bash
# doors.sh [page | windows | aarch64]...: opens what no other part of run opens, a little. The viewer is built for browsers (32
# bits, the half that reads) with its page type-checked, and one moment of each kind of file is drawn in chromium and compared with
# the tool's picture. What changed last (sources.sh) is compiled for Windows and for 64-bit ARM, but for what needs libraries of the
# system, and nothing is linked: a whole build takes eight minutes for each, and nightly has it.
set -uo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
cd "$top" || exit 1
# shellcheck source=tests/cross/cross.sh
source tests/cross/cross.sh

# objects BUILD TOOLCHAIN OPTION...: compiles what changed last of all that BUILD is configured for, 40 files. It is asked whether
# these compile: without optimisation, the loops for one instruction set.
objects() {
  local build=$1 toolchain=$2 log objects
  log=$(mktemp)
  cmake -S . -B "$build" -G Ninja "${launchers[@]}" -DCMAKE_TOOLCHAIN_FILE="$toolchain" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_C_FLAGS_RELEASE="-O0" -DCMAKE_CXX_FLAGS_RELEASE="-O0 -DHWY_COMPILE_ONLY_STATIC" -DBCCSPLAT_WERROR=ON \
    -DCMAKE_UNITY_BUILD=OFF -DBCCSPLAT_WITH_GPU=OFF -DBCCSPLAT_WITH_OPENVDB=OFF -DBCCSPLAT_WITH_NETCDF=OFF \
    -DBCCSPLAT_WITH_MICROHTTPD=OFF -DBCCSPLAT_BUILD_TESTS=OFF -DBCCSPLAT_BUILD_BENCH=OFF -DBCCSPLAT_BUILD_EXAMPLES=OFF "${@:3}" >"$log" 2>&1 ||
    { cat "$log"; rm "$log"; return 1; }
  rm "$log"
  mapfile -t objects < <(bash .ci/sources.sh --one | while read -r file; do
    if grep -qF "\"file\": \"$top/$file\"" "$build/compile_commands.json"; then echo "$top/$file^"; fi
  done | head -n 40)
  echo "$(basename "$build"): ${#objects[@]} files"
  ((${#objects[@]} == 0)) || ninja -C "$build" --quiet -k 0 "${objects[@]}"
}

windows() {
  install_missing g++-mingw-w64-x86-64-posix libz-mingw-w64-dev googletest dpkg-dev || return
  local folder
  folder=$(libraries windows) || return
  objects build-doors/windows "$top/src/cmake/x86_64-w64-mingw32.cmake" -DBCCSPLAT_WINDOWS_LIBRARIES="$folder" \
    -DBCCSPLAT_WITH_TIFF=OFF -DBCCSPLAT_TOOL_MODULES=OFF
}
aarch64() {
  install_missing g++-aarch64-linux-gnu dpkg-dev || return
  local folder
  folder=$(libraries aarch64) || return
  objects build-doors/aarch64 "$top/src/cmake/aarch64-linux-gnu.cmake" -DBCCSPLAT_AARCH64_ROOT="$folder/root"
}
page() {
  [[ -x build-tests/importers/bcc4 ]] || bash tests/run.sh --build || return
  bash tests/web/run.sh --one-moment
}

(($#)) || set -- page windows aarch64
failed=()
for door in "$@"; do
  case $door in page | windows | aarch64) ;; *) echo "usage: doors.sh [page | windows | aarch64]..." >&2 && exit 2 ;; esac
  start=$SECONDS
  "$door" || failed+=("$door")
  echo "$door: $((SECONDS - start)) s"
done
((${#failed[@]} == 0)) || { echo "FAILED: ${failed[*]}" >&2 && exit 1; }

#!/bin/bash
# windows.sh [--build | --all | --sixth_N]: bccsplat.dll, bcc4.exe and the tests for Windows, cross-compiled by mingw-w64, and
# run by Wine: the vector loops against their reference, files, names and interruptions as Windows has them, hosts in C, one of
# which loads the library, and eleven imports byte for byte against this machine's; with --all every unit, API and stability test,
# with --sixth_N a sixth of them. Installs what is missing (Debian 12). OpenVDB, NetCDF, TIFF and the GPU are off.
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
# shellcheck source=tests/cross/cross.sh
source "$top/tests/cross/cross.sh"
check_words windows.sh "$@"
install_missing "${build_packages[@]}" g++-mingw-w64-x86-64-posix libz-mingw-w64-dev wine wine64 googletest python3 dpkg-dev
build=$top/build-windows
libraries=$(libraries windows)
export WINEPREFIX=$build/wine WINEDEBUG=-all WINEDLLOVERRIDES="mscoree,mshtml=" LC_ALL=C.UTF-8
configure "$build" x86_64-w64-mingw32 "${1:-}" -DBCCSPLAT_WINDOWS_LIBRARIES="$libraries" \
  -DBCCSPLAT_WITH_TIFF=OFF -DBCCSPLAT_TOOL_HERE="$(tool_here)"
build "$build" "${1:-}" bccsplat_load_host
run_tests "$build" "$@"

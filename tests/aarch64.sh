#!/bin/bash
# aarch64.sh [--build | --all | --sixth_N]: library, tool and tests for 64-bit ARM, cross-compiled, and run by qemu-user: the
# vector loops against their reference (NEON), the host in C, eleven imports byte for byte against this machine's, and a wheel;
# with --all every unit, API and stability test, with --sixth_N a sixth of them. Installs what is missing (Debian 12).
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
# shellcheck source=tests/cross/cross.sh
source "$top/tests/cross/cross.sh"
check_words aarch64.sh "$@"
install_missing "${build_packages[@]}" g++-aarch64-linux-gnu qemu-user python3 dpkg-dev patchelf
build=$top/build-aarch64
libraries=$(libraries aarch64)
configure "$build" aarch64-linux-gnu "${1:-}" -DBCCSPLAT_AARCH64_ROOT="$libraries/root" -DBCCSPLAT_TOOL_HERE="$(tool_here)" \
  -DBCCSPLAT_TOOL_MODULES=ON
build "$build" "${1:-}" bccsplat_plugin_host bccsplat_budget_host
run_tests "$build" "$@"

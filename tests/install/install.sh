#!/bin/bash
# install.sh BUILD SCRATCH: installs into a staged prefix, moves it, and builds and runs a C host against it, once with
# find_package and once with pkg-config; the installed tool must start from there too.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
build=${1:?usage: install.sh BUILD SCRATCH} scratch=${2:?}
rm -rf "$scratch"
mkdir -p "$scratch"
cmake --install "$build" --prefix "$scratch/first" >"$scratch/install.log"
mv "$scratch/first" "$scratch/moved"

cmake -S "$here/host" -B "$scratch/host" -DCMAKE_PREFIX_PATH="$scratch/moved" >"$scratch/host.log"
cmake --build "$scratch/host" >>"$scratch/host.log"
"$scratch/host/host"

export PKG_CONFIG_PATH
PKG_CONFIG_PATH=$(dirname "$(find "$scratch/moved" -name bccsplat.pc)")
read -ra flags <<<"$(pkg-config --cflags --libs bccsplat)"
cc -std=c99 "$here/host/host.c" -o "$scratch/host_pc" "${flags[@]}"
LD_LIBRARY_PATH=$(pkg-config --variable=libdir bccsplat) "$scratch/host_pc"

if [[ -x $scratch/moved/bin/bcc4 ]]; then
  "$scratch/moved/bin/bcc4" --version
fi
rm -rf "$scratch"

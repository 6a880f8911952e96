#!/bin/bash
# install.sh BUILD SCRATCH: installs into a staged prefix, moves it, and builds and runs a C host against it, once with
# find_package and once with pkg-config, shared and, where it was built, static; the installed tool and the installed
# Python package must start from there too.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
build=${1:?usage: install.sh BUILD SCRATCH} scratch=${2:?}
rm -rf "$scratch"
mkdir -p "$scratch"
cmake --install "$build" --prefix "$scratch/first" >"$scratch/install.log"
mv "$scratch/first" "$scratch/moved"
static=$(find "$scratch/moved" -name libbccsplat.a)
soname=$(readelf -d "$(find "$scratch/moved" -name 'libbccsplat.so' | head -1)" | sed -n 's/.*SONAME.*\[\(.*\)\]/\1/p')
[[ $soname == libbccsplat.so.[0-9]* ]]

cmake -S "$here/host" -B "$scratch/host" -DCMAKE_PREFIX_PATH="$scratch/moved" -DHOST_STATIC="${static:+ON}" \
  >"$scratch/host.log"
cmake --build "$scratch/host" >>"$scratch/host.log"
"$scratch/host/host"

export PKG_CONFIG_PATH
PKG_CONFIG_PATH=$(dirname "$(find "$scratch/moved" -name bccsplat.pc)")
read -ra flags <<<"$(pkg-config --cflags --libs bccsplat)"
cc -std=c99 "$here/host/host.c" -o "$scratch/host_pc" "${flags[@]}"
LD_LIBRARY_PATH=$(pkg-config --variable=libdir bccsplat) "$scratch/host_pc"

if [[ -n $static ]]; then
  # Nothing but the interface is global in it, and a host of it needs no libbccsplat.so.
  foreign=$(nm -g --defined-only --format=posix "$static" | awk 'NF > 1 && $1 !~ /^bccsplat_/ { print $1 }')
  [[ -z $foreign ]] || { echo "foreign symbols: $foreign" && exit 1; }
  "$scratch/host/host_static"
  read -ra flags <<<"$(pkg-config --static --cflags --libs bccsplat | sed "s|-lbccsplat|$static|")"
  cc -std=c99 "$here/host/host.c" -o "$scratch/host_static_pc" "${flags[@]}"
  "$scratch/host_static_pc"
  for host in "$scratch"/host/host_static "$scratch/host_static_pc"; do
    if ldd "$host" | grep bccsplat; then exit 1; fi
  done
fi

if [[ -x $scratch/moved/bin/bcc4 ]]; then
  "$scratch/moved/bin/bcc4" --version
  bash "$here/reads.sh" "$scratch/moved/bin/bcc4" "$scratch/reads"
fi
for python in python3 /usr/bin/python3; do
  if command -v $python >/dev/null && $python -c 'import numpy' 2>/dev/null; then
    PYTHONPATH=$(dirname "$(find "$scratch/moved" -type d -name bccsplat -path '*packages*')") \
      $python -B -c 'import bccsplat, bccsplat._library as l
assert "/moved/" in l.native._name, l.native._name
print("python", bccsplat.version())'
    break
  fi
done
rm -rf "$scratch"

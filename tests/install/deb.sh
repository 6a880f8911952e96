#!/bin/bash
# deb.sh BUILD SCRATCH: makes the Debian packages, looks at what is in them and what they depend on, and runs the tool
# and the library from an unpacked set of all of them. Exits with 77 without dpkg and
# where it is not due (due.sh).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
# shellcheck source=tests/install/due.sh
source "$here/due.sh"
build=${1:?usage: deb.sh BUILD SCRATCH} scratch=${2:?}
command -v dpkg-deb >/dev/null && command -v dpkg-shlibdeps >/dev/null ||
  { echo "skipped: no dpkg-dev" && exit 77; }
rm -rf "$scratch"
mkdir -p "$scratch/root"
cpack --config "$build/CPackConfig.cmake" -B "$scratch/packages" >"$scratch/cpack.log" 2>&1 ||
  { cat "$scratch/cpack.log" && exit 1; }
shopt -s nullglob
packages=("$scratch"/packages/*.deb)
((${#packages[@]} >= 3))

contents() { dpkg-deb -c "$scratch"/packages/"$1"_*.deb | awk '{ print $6 }'; }
field() { dpkg-deb -f "$scratch"/packages/"$1"_*.deb "$2"; }
has() { contents "$1" | grep -E "$2" >/dev/null || { echo "$1 lacks $2" && contents "$1" && exit 1; }; }
has libbccsplat0 '/libbccsplat\.so\.0\.[0-9]+\.[0-9]+$'
has libbccsplat-dev '/include/bccsplat\.h$'
has libbccsplat-dev '/libbccsplat\.so$'
has libbccsplat-dev '/bccsplatConfig\.cmake$'
has libbccsplat-dev '/bccsplat\.pc$'
has python3-bccsplat '/dist-packages/bccsplat/__init__\.py$'
has python3-bccsplat '/dist-packages/bccsplat/library_path$'
# Each file in one package only, everything under /usr, owned by root, and no header in the runtime.
for package in "${packages[@]}"; do
  if dpkg-deb -c "$package" | awk '$6 !~ /^\.\/usr\// && $6 != "./" || $2 != "root/root"' | grep .; then exit 1; fi
  dpkg-deb -c "$package" | awk '$6 !~ /\/$/ { print $6 }'
done | sort | uniq -d | grep . && exit 1
if contents libbccsplat0 | grep -E '\.h$|\.so$'; then exit 1; fi

# The runtime's dependencies were read off the library: OpenEXR only where images are written.
field libbccsplat0 Depends
field libbccsplat0 Depends | grep -q 'libc6'
field libbccsplat0 Depends | grep -q 'zlib1g'
field libbccsplat-dev Depends | grep -q 'libbccsplat0 (= '
[[ $(field python3-bccsplat Architecture) == all ]]

for package in "${packages[@]}"; do dpkg-deb -x "$package" "$scratch/root"; done
library=$(find "$scratch/root" -name 'libbccsplat.so.0.*')
if ldd "$library" | grep 'not found'; then exit 1; fi
if readelf -d "$library" | grep -E 'RPATH|RUNPATH'; then exit 1; fi
if readelf -S "$library" | grep -q '\.symtab'; then echo "not stripped" && exit 1; fi
if [[ -x $scratch/root/usr/bin/bcc4 ]]; then
  "$scratch/root/usr/bin/bcc4" --version
  bash "$here/reads.sh" "$scratch/root/usr/bin/bcc4" "$scratch/reads"
  # What the tool opens when a file needs it is a dependency, too.
  for reader in openvdb netcdf tiff microhttpd; do
    if grep -q "^BCCSPLAT_WITH_${reader^^}:BOOL=ON" "$build/CMakeCache.txt"; then
      field bccsplat-tools Depends | grep "lib$reader"
    fi
  done
fi
if command -v lintian >/dev/null; then
  # What a package outside Debian need not have: changelog, copyright and manual page.
  lintian --allow-root --fail-on error --suppress-tags \
    no-changelog,no-copyright-file,no-manual-page,undocumented-manual-page "${packages[@]}"
fi
rm -rf "$scratch"

#!/bin/bash
# From nothing to pictures on Debian 12: installs what is missing, builds, simulates smoke as a 4D data set, stores it on
# the D4* lattice and draws it. Everything it makes is in build/ and out/.
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
# shellcheck source=tests/packages.sh
source "$top/tests/packages.sh"
install_missing "${build_packages[@]}"

build=$top/build out=$top/out
cmake -S "$top" -B "$build" -G Ninja "${launchers[@]}" -DCMAKE_BUILD_TYPE=Release -DBCCSPLAT_BUILD_TESTS=OFF \
  -DBCCSPLAT_BUILD_BENCH=OFF
cmake --build "$build"
bcc4=$(find "$build" -name bcc4 -type f -perm -u+x)

echo "Simulating 48 frames of smoke on 96^3 cells"
rm -rf "$out"
"$build/examples/simulate_smoke" --size 96 --steps 48 -o "$out/smoke"

# Values within 1/256 of the air's are not stored.
echo "Storing them on the D4* lattice"
"$bcc4" import "$out"/smoke/smoke.*.raw --dims 96,96,96 --dtype f32 --air-threshold 0.004 -o "$out/smoke.bcc4"
"$bcc4" import "$out"/smoke/smoke.*.vdb --grid density --air-threshold 0.004 -o "$out/smoke-vdb.bcc4"

json_number() { # FILE KEY: the first number of that name
  "$bcc4" info "$1" --json | tr ',{}' '\n\n\n' | sed -n "s/^ *\"$2\": *\([0-9.]*\).*/\1/p" | sed -n 1p
}
row() { # NAME FILE SOURCE...
  local name=$1 file=$2
  shift 2
  cat "$@" | wc -c | awk -v name="$name" -v samples="$(json_number "$file" cc_samples)" \
    -v sites="$(json_number "$file" sites_total)" -v kept="$(json_number "$file" sites_kept)" \
    -v bytes="$(stat -c %s "$file")" '{ printf "%-12s %14.0f %12.0f %12.0f %10.0f %8.2f %12.0f %8.2f\n",
      name, $1, samples, sites, kept, 100 * kept / samples, bytes, 100 * bytes / $1 }'
}
echo
printf '%-12s %14s %12s %12s %10s %8s %12s %8s\n' \
  source "source bytes" "CC samples" "D4* sites" kept "% of CC" ".bcc4 bytes" "% of it"
row "48 raw" "$out/smoke.bcc4" "$out"/smoke/smoke.*.raw
row "48 OpenVDB" "$out/smoke-vdb.bcc4" "$out"/smoke/smoke.*.vdb
echo

# Times are frame numbers here and may be fractional.
render() { "$bcc4" render "$out/smoke.bcc4" --size 640x640 --background 0.01,0.012,0.02 "$@"; }
render --time 36.5 --camera persp -o "$out/still.png"
render --plane 1,0,0,0,-47.5 -o "$out/through-time.png"
render --time 36.5 --camera persp --trail -6,8 -o "$out/motion-blur.png"
ls -l "$out"/*.png

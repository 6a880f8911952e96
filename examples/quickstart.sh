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
  -DBCCSPLAT_BUILD_BENCH=OFF -DBCCSPLAT_BUILD_TOOL=ON -DBCCSPLAT_WITH_OPENVDB=ON -DBCCSPLAT_WITH_IMAGE=ON \
  -DCMAKE_UNITY_BUILD=ON
cmake --build "$build"
bcc4=$build/importers/bcc4

printf '\n== 48 frames of smoke on 96^3 cells, as raw floats and as an OpenVDB sequence\n'
rm -rf "$out"
"$build/examples/simulate_smoke" --size 96 --steps 48 -o "$out/smoke"

# Values within 1/256 of the air's are not stored.
printf '\n== Onto the lattice that fits\n'
"$bcc4" import "$out/smoke/smoke.%04d.raw" --dims 96,96,96 --dtype f32 --air-threshold 0.004 -o "$out/smoke-raw.bcc4"
"$bcc4" import "$out/smoke/smoke.%04d.vdb" --grid density --air-threshold 0.004 -o "$out/smoke.bcc4"

number() { # FILE KEY: a number of that name in the file's description
  "$bcc4" info "$1" --json | sed -n "s/^ *\"$2\": *\([0-9][0-9]*\),*$/\1/p" | sed -n 1p
}
row() { # NAME FILE SOURCE...
  cat "${@:3}" | wc -c | awk -v name="$1" -v samples="$(number "$2" cc_samples)" -v sites="$(number "$2" sites_total)" \
    -v kept="$(number "$2" sites_kept)" -v bytes="$(stat -c %s "$2")" '{
      printf "%-10s %13d %12d %12d %10d %8.2f%% %12d %8.2f%%\n",
        name, $1, samples, sites, kept, 100 * kept / samples, bytes, 100 * bytes / $1 }'
}
printf '\n%-10s %13s %12s %12s %10s %9s %12s %9s\n' source "source bytes" "CC samples" "sites" kept "of CC" \
  ".bcc4 bytes" "of source"
row raw "$out/smoke-raw.bcc4" "$out"/smoke/smoke.*.raw
row OpenVDB "$out/smoke.bcc4" "$out"/smoke/smoke.*.vdb

printf '\n== Pictures\n'
render() {
  "$bcc4" render "$out/smoke.bcc4" --overwrite --camera persp --rotate-x 10 --zoom 1.1 --size 800x800 --colormap fire --range 0,1 \
    --background 0.02,0.02,0.03 "$@"
}
render --time 44.5 --rotate-y 15 -o "$out/still.png"
# A fixed z: x, y and time become the volume, and each puff a strand.
render --plane 0,0,1,0,-31 --rotate-y 30 -o "$out/through-time.png"
# What was there during the six frames before.
render --time 44.5 --rotate-y 15 --trail 6 -o "$out/motion-blur.png"
ls -l "$out"/*.png

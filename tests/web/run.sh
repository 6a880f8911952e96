#!/bin/bash
# The example's server by itself, and the viewer in real browsers: chromium by its own rasteriser, firefox-esr under Xvfb by
# Mesa's. Installs what is missing, builds the viewer, makes the data and the tool's pictures of it, and has both compared:
# run.sh [--one-moment] [SITE] [BCC4]; with --one-moment one picture of each kind of file, in chromium.
set -euo pipefail
one_moment=
[[ ${1:-} != --one-moment ]] || { one_moment=yes && shift; }
top=$(cd "$(dirname "$0")/../.." && pwd)
# shellcheck source=tests/packages.sh
source "$top/tests/packages.sh"
work=$top/build-web
site=${1:-$work/site}
bcc4=${2:-$top/build-tests/importers/bcc4}
[[ -x $bcc4 ]] || { echo "There is no $bcc4: build it first (tests/run.sh)" >&2; exit 1; }
install_missing python3 python3-numpy chromium
[[ $one_moment ]] || install_missing firefox-esr xvfb xauth libgl1-mesa-dri
[[ $# -gt 0 ]] || "$top/examples/web/build.sh" "$site"
bytes=$(stat -c %s "$site/core.wasm") most=945000
echo "core.wasm: $bytes bytes, at most $most; $(gzip -9c "$site/core.wasm" | wc -c) with gzip"
((bytes <= most)) || { echo "FAILED: the module has grown" >&2; exit 1; }
npm=$work/test-npm
if [[ ! -d $npm/node_modules/puppeteer-core ]]; then
  mkdir -p "$npm"
  npm install --prefix "$npm" --no-fund --no-audit --loglevel=error puppeteer-core
fi

data=$(mktemp -d)
trap 'rm -rf "$data"' EXIT
/usr/bin/python3 "$top/tests/web/make_series.py" "$data"
drops() { "$bcc4" import "$data/drops.raw" --dims 48,40,32,24 --dtype f32 --dt 0.5 --air-threshold 0.004 --quiet "$@"; }
drops -o "$data/drops.bcc4"
drops -o "$data/waves.bcc4" --store wavelets
drops -o "$data/levels.bcc4" --levels 2
drops -o "$data/round.bcc4" --periodic x
"$bcc4" import "$data/classes.nrrd" --quiet -o "$data/classes.bcc4"
"$bcc4" import "$data/large.raw" --dims 128,128,128,12 --dtype u8 --dt 0.5 --air-threshold 2 --quiet -o "$data/large.bcc4"
render() { # NAME CASE OPTIONS...
  "$bcc4" render "$data/$1.bcc4" --gpu off --time 4.3 --fit domain --size 200x200 --background 0,0,0 --quiet "${@:3}" -o "$data/$1-$2.png"
}
in_browser() { # BROWSER SCRIPT [WRAPPER...]
  BCCSPLAT_PUPPETEER=$npm/node_modules/puppeteer-core "${@:3}" node "$top/tests/web/$2" "$1" "$site" "$data"
}
render drops composite
render waves composite
if [[ $one_moment ]]; then
  in_browser chromium one_moment.mjs
  exit
fi
render round composite
render round cut --box 0,0,0,48,39,15.5
render drops surface --mode iso --iso 0.4 --smooth-edges off
render drops maximum --mode mip
render drops xray --mode xray
render drops turned --camera persp --rotate-x 35 --rotate-y -50 --zoom 1.5
head -c 20000 "$data/drops.bcc4" >"$data/cut.bcc4"
# Zeros from 8 KiB on: up to the end, which tells what the file holds, or in the values alone.
size=$(stat -c %s "$data/drops.bcc4")
zeros() { head -c 8192 "$data/drops.bcc4" && head -c "$1" /dev/zero && tail -c +$((8192 + $1 + 1)) "$data/drops.bcc4"; }
zeros $((size - 8192)) >"$data/damaged.bcc4"
zeros $((size * 4 / 5)) >"$data/torn.bcc4"

mkdir "$data/serving"
node "$top/tests/web/serving.mjs" "$data/serving"
if [[ $# -eq 0 ]]; then # else nothing was built here
  "$work/npm/node_modules/.bin/esbuild" "$top/examples/web/src/page/format.ts" --format=esm --log-level=warning --outfile="$data/format.mjs"
  node "$top/tests/web/numbers.mjs" "$data/format.mjs"
  "$work/npm/node_modules/.bin/esbuild" "$top/examples/web/src/page/colors.ts" --bundle --format=esm --log-level=warning --outfile="$data/colors.mjs"
  node "$top/tests/web/colors.mjs" "$data/colors.mjs"
fi

status=0
in_browser chromium browsers.mjs || status=1
in_browser firefox browsers.mjs xvfb-run -a -s "-screen 0 1400x1000x24" || status=1
exit "$status"

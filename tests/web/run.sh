#!/bin/bash
# The viewer in real browsers: chromium by its own rasteriser, firefox-esr under Xvfb by Mesa's. Installs what is missing,
# builds the viewer, makes the data and the tool's pictures of it, and has both compared: run.sh [SITE] [BCC4]
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
# shellcheck source=tests/packages.sh
source "$top/tests/packages.sh"
work=$top/build-web
site=${1:-$work/site}
bcc4=${2:-$top/build-tests/importers/bcc4}
[[ -x $bcc4 ]] || { echo "There is no $bcc4: build it first (tests/run.sh)" >&2; exit 1; }
install_missing python3 python3-numpy chromium firefox-esr xvfb xauth libgl1-mesa-dri
[[ $# -gt 0 ]] || "$top/examples/web/build.sh" "$site"
bytes=$(stat -c %s "$site/core.wasm") most=960000
echo "core.wasm: $bytes bytes, at most $most; $(gzip -9c "$site/core.wasm" | wc -c) with gzip"
((bytes <= most)) || { echo "FAILED: the module has grown" >&2; exit 1; }
npm=$work/test-npm
if [[ ! -d $npm/node_modules/puppeteer-core ]]; then
  mkdir -p "$npm"
  npm install --prefix "$npm" --no-fund --no-audit --loglevel=error puppeteer-core
fi

data=$(mktemp -d)
trap 'rm -rf "$data"' EXIT
/usr/bin/python3 "$top/tests/web/make_series.py" "$data/drops.raw"
"$bcc4" import "$data/drops.raw" --dims 48,40,32,24 --dtype f32 --dt 0.5 --air-threshold 0.004 -o "$data/drops.bcc4" --quiet
render() { "$bcc4" render "$data/drops.bcc4" --gpu off --time 4.3 --fit domain --size 200x200 --background 0,0,0 --quiet "$@"; }
render -o "$data/composite.png"
render --mode iso --iso 0.4 --smooth-edges off -o "$data/surface.png"
render --mode mip -o "$data/maximum.png"
render --mode xray -o "$data/xray.png"
render --camera persp --rotate-x 35 --rotate-y -50 --zoom 1.5 -o "$data/turned.png"
head -c 20000 "$data/drops.bcc4" >"$data/cut.bcc4"

status=0
BCCSPLAT_PUPPETEER=$npm/node_modules/puppeteer-core node "$top/tests/web/browsers.mjs" chromium "$site" "$data" || status=1
BCCSPLAT_PUPPETEER=$npm/node_modules/puppeteer-core xvfb-run -a -s "-screen 0 1400x1000x24" \
  node "$top/tests/web/browsers.mjs" firefox "$site" "$data" || status=1
exit "$status"

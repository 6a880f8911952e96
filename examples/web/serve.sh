#!/bin/bash
# Serves the viewer and the .bcc4 files of a folder on this machine, and prints a link to each: serve.sh [DATA] [PORT]. DATA
# is the quickstart's out/ where nothing is given.
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
site=${BCCSPLAT_WEB_BUILD:-$top/build-web}/site
data=${1:-$top/out} port=${2:-8000}
[[ -f $site/core.wasm ]] || { echo "There is no viewer in $site: run examples/web/build.sh first" >&2; exit 1; }
[[ -d $data ]] || { echo "There is no folder $data: run examples/quickstart.sh, or name a folder of .bcc4 files" >&2; exit 1; }
for file in "$data"/*.bcc4; do
  [[ -f $file ]] && echo "http://127.0.0.1:$port/?url=$(basename "$file")"
done
exec node "$top/examples/web/serve.mjs" "$site" "$data" "$port"

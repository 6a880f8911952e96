#!/bin/bash
# docs.sh FOLDER: Doxygen reads the header without a warning, and the pages hold what a host looks for first.
set -euo pipefail
command -v doxygen >/dev/null && [[ -e $1/Doxyfile ]] || { echo "skipped: no doxygen" && exit 77; }
cd "$1"
rm -rf html
doxygen Doxyfile
grep -qi "premultiplied" html/index.html
grep -qi "bytes this device's objects may hold" html/structbccsplat__device__options.html
grep -qi "a call out of order" html/bccsplat_8h.html

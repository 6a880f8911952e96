#!/bin/bash
# floors_test.sh SCRATCH: floors.sh accepts a small house in order and reports each made-up violation.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
scratch=${1:?usage: floors_test.sh SCRATCH}

house() {
  rm -rf "$scratch"
  mkdir -p "$scratch"/{src/{base,kernel,points,splat,render,api},formats,include,importers,examples,tests/api}
  echo '#include <stdint.h>' >"$scratch/include/bccsplat.h"
  printf '#include <vector>\n#include <thread>\n' >"$scratch/src/base/tasks.h"
  printf '#include "base/tasks.h"\n#include "kernel/kernel.h"\n' >"$scratch/src/kernel/prefilter.cpp"
  printf '#include "kernel/kernel.h"\n#include "lattice/lattice.h"\n' >"$scratch/src/points/volume.cpp"
  printf '#include "points/brick.h"\n#include <png.h>\n' >"$scratch/formats/png.cpp"
  printf '#include "splat/sheet.h"\n#include <hwy/highway.h>\n' >"$scratch/src/splat/sheet.cpp"
  printf '#include <bccsplat.h>\n#include "render/frame.h"\n' >"$scratch/src/api/api.cpp"
  printf '#include <openvdb/openvdb.h>\n#include "bccsplat.h"\n#include "raw.h"\n' >"$scratch/importers/vdb.cpp"
  echo '#include <bccsplat.h>' >"$scratch/examples/render_frame.c"
}

house
bash "$here/floors.sh" "$scratch"

failures=0
violation() { # FILE INCLUDE-LINE
  house
  echo "$2" >>"$scratch/$1"
  if out=$(bash "$here/floors.sh" "$scratch"); then
    echo "FAILED: $1 may not say: $2" && failures=$((failures + 1))
  elif [[ $out != *"$1"* ]]; then
    echo "FAILED: the report does not name $1: $out" && failures=$((failures + 1))
  fi
}
violation src/base/tasks.h '#include "kernel/kernel.h"'
violation src/kernel/prefilter.cpp '#include "points/brick.h"'
violation src/kernel/prefilter.cpp '  #  include "src/points/brick.h"'
violation src/kernel/prefilter.cpp '#include <points/brick.h>'
violation src/points/volume.cpp '#include "slice/slice.h"'
violation formats/png.cpp '#include "render/frame.h"'
violation src/splat/sheet.cpp '#include "render/frame.h"'
violation src/splat/sheet.cpp '#include "../render/frame.h"'
violation src/splat/sheet.cpp '#include <bccsplat.h>'
violation src/splat/sheet.cpp '#include <thread>'
violation src/splat/sheet.cpp '#include <png.h>'
violation formats/png.cpp '#include <openvdb/openvdb.h>'
violation include/bccsplat.h '#include <stdbool.h>'
violation include/bccsplat.h '#include <openvdb/openvdb.h>'
violation importers/vdb.cpp '#include "formats/bcc4.h"'
violation importers/vdb.cpp '#include "src/base/error.h"'
violation examples/render_frame.c '#include "render/frame.h"'

rm -rf "${scratch:?}"/* && mkdir -p "$scratch/src"
if bash "$here/floors.sh" "$scratch" >/dev/null; then
  echo "FAILED: an empty house passes" && failures=$((failures + 1))
fi
rm -rf "$scratch"
[[ $failures == 0 ]] && echo "floors_test: all violations are found"

#!/bin/bash
# floors_test.sh SCRATCH: floors.sh accepts a small house in order and reports each made-up violation, saying why.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
scratch=${1:?usage: floors_test.sh SCRATCH}

file() { # PATH INCLUDED...: a file that includes these
  local path=$scratch/$1
  mkdir -p "${path%/*}"
  shift
  printf '#include %s\n' "$@" >"$path"
}

build_house() {
  file include/bccsplat.h '<stdint.h>'
  file src/base/tasks.h '<vector>' '<thread>'
  file src/kernel/prefilter.cpp '"base/tasks.h"' '"kernel/kernel.h"'
  file src/lattice/lattice.cpp '"kernel/kernel.h"'
  file src/points/volume.cpp '"kernel/kernel.h"' '"lattice/lattice.h"'
  file formats/image/png.cpp '"points/brick.h"' '<png.h>'
  file formats/bcc4/read/reader.cpp '"formats/bcc4/read/reader.h"' '"formats/bcc4/coding/chunk.h"'
  file formats/bcc4/write/writer.cpp '"formats/bcc4/read/reader.h"' '"formats/bcc4/encode/encode_chunk.h"'
  file formats/bcc4/coding/chunk.cpp '"formats/bcc4/coding/chunk.h"' '"points/runs.h"'
  file src/field/evaluate.cpp '"field/footprint/footprint.h"' '"field/coefficients/coefficients.h"'
  file src/field/coefficients/prefilter.cpp '"field/footprint/hole.h"' '"points/mask_source.h"'
  file src/field/footprint/footprint.cpp '"points/brick.h"'
  file src/fit/kept/layer.cpp '"field/evaluate.h"'
  file src/slice/time_slice.cpp '"field/evaluate.h"'
  file src/view/view.cpp '"points/volume.h"'
  file src/shade/surface.cpp '"view/view.h"'
  file src/draw/shot.h '"shade/surface.h"'
  file src/volume/open_volume.cpp '"slice/time_slice.h"' '"formats/bcc4/read/reader.h"'
  file src/splat/loop/loops.h '"view/view.h"'
  file src/splat/raise/raise.cpp '"splat/points/points.h"'
  file src/splat/sheet/sheet.cpp '"splat/loop/loops.h"' '<hwy/highway.h>'
  file src/splat/plan/plan.h '"splat/sheet/sheet.h"'
  file src/splat/tile/tile.cpp '"splat/plan/plan.h"'
  file src/splat/splat.cpp '"splat/tile/tile.h"' '"draw/shot.h"'
  file src/rays/rays.cpp '"draw/shot.h"'
  file src/reference/splat.cpp '"draw/shot.h"'
  file src/scene/picture.cpp '"splat/splat.h"' '"rays/rays.h"' '"volume/open_volume.h"' '"formats/image/png.h"'
  file src/store/pipeline.cpp '"fit/fit.h"' '"slice/time_slice.h"'
  file src/plan/plan.cpp '<bccsplat.h>' '"choose/choose.h"' '"api/api.h"' '"kernel/kernel.h"'
  file src/choose/choose.cpp '"bccsplat.hpp"' '"choose/choose.h"' '"series/library.h"'
  file src/series/library.h '"bccsplat.hpp"' '"series/frame_reader.h"'
  file src/series/frame_reader.h '"base/half.h"'
  file importers/readers/raw.cpp '"series/frame_reader.h"' '"base/error.h"' '"readers/raw.h"'
  file importers/tool/import.cpp '"series/frame_reader.h"' '"readers/raw.h"'
  file src/api/api.cpp '<bccsplat.h>' '"scene/picture.h"' '"store/pipeline.h"'
  file importers/vdb.cpp '<openvdb/openvdb.h>' '"bccsplat.h"' '"raw.h"'
  file importers/tool/cli.cpp '<CLI/CLI.hpp>'
  file examples/render_frame.c '<bccsplat.h>'
}

rm -rf "$scratch"
build_house
bash "$here/floors.sh" "$scratch"

failures=0
kept=$(mktemp -d)
trap 'rm -rf "$kept"' EXIT
cp -r "$scratch/." "$kept"
house() { rm -rf "$scratch" && cp -r "$kept" "$scratch"; }
violation() { # FILE INCLUDE-LINE [WHY]: the report names the file, its line and why
  house
  mkdir -p "$(dirname "$scratch/$1")"
  echo "$2" >>"$scratch/$1"
  local line
  line=$1:$(wc -l <"$scratch/$1"):$2
  if out=$(bash "$here/floors.sh" "$scratch"); then
    echo "FAILED: $1 may not say: $2" && failures=$((failures + 1))
  elif [[ $out != *"$line"*"${3:-}"* ]]; then
    echo "FAILED: the report does not say \"$line ... ${3:-}\": $out" && failures=$((failures + 1))
  fi
}
# From floor to floor.
violation src/base/tasks.h '#include "kernel/kernel.h"' 'base is on rung 1, kernel on rung 2'
violation src/kernel/prefilter.cpp '#include "points/brick.h"'
violation src/kernel/prefilter.cpp '  #  include "src/points/brick.h"'
violation src/kernel/prefilter.cpp '#include <points/brick.h>'
violation src/points/volume.cpp '#include "slice/slice.h"'
violation src/points/volume.cpp '#include "formats/bcc4/info.h"' 'points is on rung 3, formats on rung 4'
violation formats/image/png.cpp '#include "scene/picture.h"'
violation src/field/evaluate.cpp '#include "slice/time_slice.h"' 'field is on rung 4, slice on rung 5'
violation src/splat/sheet/sheet.cpp '#include "scene/picture.h"' 'splat is on rung 8, scene on rung 9'
violation src/splat/sheet/sheet.cpp '#include "../scene/picture.h"' 'write includes from src/ or the top'
violation src/draw/shot.h '#include "splat/splat.h"' 'draw is on rung 7, splat on rung 8'
violation src/view/view.cpp '#include "shade/surface.h"' 'view is on rung 5, shade on rung 6'
violation src/store/pipeline.cpp '#include "api/handles.h"' 'store is on rung 7, api on rung 10'
violation src/scene/picture.cpp '#include "api/handles.h"' 'scene is on rung 9, api on rung 10'
violation src/api/api.cpp '#include "draw/shot.h"' 'api asks scene, volume and store'
violation src/slice/time_slice.cpp '#include "base/would_block.h"' 'waits for none'
violation src/cellar/wine.cpp '#include "base/tasks.h"' 'src/cellar is on no floor'
# On one floor: rooms that do not know each other, and circles of two rooms or more.
violation formats/bcc4/read/reader.cpp '#include "field/evaluate.h"' 'formats and field do not know each other'
violation src/field/evaluate.cpp '#include "formats/bcc4/read/reader.h"' 'field and formats do not know each other'
violation src/fit/kept/layer.cpp '#include "slice/time_slice.h"' 'fit and slice do not know each other'
violation src/slice/time_slice.cpp '#include "fit/kept/layer.h"' 'slice and fit do not know each other'
violation src/rays/rays.cpp '#include "splat/splat.h"' 'rays and splat do not know each other'
violation src/reference/splat.cpp '#include "rays/rays.h"' 'reference and rays do not know each other'
violation src/volume/open_volume.cpp '#include "store/pipeline.h"' 'volume and store do not know each other'
violation src/splat/points/points.cpp '#include "splat/raise/raise.h"' 'close a circle'
violation src/kernel/prefilter.cpp '#include "lattice/lattice.h"' 'close a circle'
# Ladders inside rooms.
violation src/splat/loop/loops.h '#include "splat/sheet/sheet.h"' 'splat/loop is on rung 1, splat/sheet on rung 2'
violation src/splat/sheet/sheet.cpp '#include "splat/plan/plan.h"'
violation src/splat/plan/plan.h '#include "splat/tile/tile.h"'
violation src/splat/plan/plan.h '#include "splat/splat.h"' 'splat/plan is on rung 3, a file directly in splat on rung 5'
violation src/splat/tile/tile.cpp '#include "splat/splat.h"'
violation src/splat/splat.cpp '#include "splat/attic/box.h"' 'splat/attic is on no rung'
violation src/field/footprint/footprint.cpp '#include "field/coefficients/coefficients.h"'
violation src/field/footprint/footprint.cpp '#include "field/evaluate.h"'
violation src/field/coefficients/prefilter.cpp '#include "field/evaluate.h"'
violation src/fit/kept/layer.cpp '#include "fit/beyond/ends.h"' 'fit/kept is on rung 1, fit/beyond on rung 2'
violation src/fit/kept/layer.cpp '#include "fit/axis/filter.h"' 'do not know each other'
violation src/fit/beyond/ends.cpp '#include "fit/fit.h"'
violation formats/bcc4/coding/chunk.cpp '#include "formats/bcc4/info.h"' \
  'formats/bcc4/coding is on rung 2, a file directly in formats/bcc4 on rung 3'
violation formats/bcc4/read/reader.cpp '#include "formats/image/png.h"' 'do not know each other'
violation formats/image/png.cpp '#include "formats/bcc4/read/reader.h"' 'do not know each other'
# The public header, its clients and the libraries of others.
violation src/splat/sheet/sheet.cpp '#include <bccsplat.h>'
violation src/series/frame_reader.h '#include "bccsplat.hpp"'
violation src/store/pipeline.cpp '#include "series/library.h"' 'calls the library'
violation src/splat/sheet/sheet.cpp '#include <thread>'
violation src/splat/sheet/sheet.cpp '#include <png.h>'
violation formats/image/png.cpp '#include <openvdb/openvdb.h>'
violation include/bccsplat.h '#include <stdbool.h>'
violation include/bccsplat.h '#include <openvdb/openvdb.h>'
violation importers/vdb.cpp '#include "formats/bcc4.h"'
violation importers/vdb.cpp '#include "src/base/files.h"'
violation examples/render_frame.c '#include "scene/picture.h"'
violation src/api/api.cpp '#include "choose/choose.h"' 'api is on rung 10, choose on rung 11'
violation src/api/api.cpp '#include "plan/host_series.h"' 'api asks scene, volume and store'
violation src/choose/choose.cpp '#include "tool/cli.h"' 'write includes from src/ or the top'
violation src/choose/choose.cpp '#include <nlohmann/json.hpp>' 'belongs to importers/'
violation src/choose/choose.cpp '#include <cstdio>' 'prints nothing'
violation importers/readers/raw.cpp '#include "choose/choose.h"' 'is a client'
violation importers/tool/import.cpp '#include "choose/choose.h"' 'is a client'
violation importers/readers/raw.cpp '#include "tool/cli.h"' 'knows nothing of the tool'
violation importers/tool/main.cpp '#include <CLI/CLI.hpp>' 'include tool/cli.h'

# The sizes that classes.sh checks.
too_large() { # FILE WHY: the house with what stands on standard input in that file
  house
  cat >>"$scratch/$1"
  if out=$(bash "$here/floors.sh" "$scratch"); then
    echo "FAILED: passes, but $2" && failures=$((failures + 1))
  elif [[ $out != *"$2"* ]]; then
    echo "FAILED: the report does not say \"$2\": $out" && failures=$((failures + 1))
  fi
}
printf 'auto %s = Bcc4Reader::open(source);\n' a b | too_large src/store/pipeline.cpp 'opened in one place'
if ctags --version 2>/dev/null | grep -q Universal; then
  { echo 'class Large {' && printf 'void f%d();\n' {1..31} && echo '};'; } |
    too_large src/store/pipeline.h 'has 31 methods, not at most 30'
fi

rm -rf "${scratch:?}"/* && mkdir -p "$scratch/src"
if bash "$here/floors.sh" "$scratch" >/dev/null; then
  echo "FAILED: an empty house passes" && failures=$((failures + 1))
fi
rm -rf "$scratch"
[[ $failures == 0 ]] && echo "floors_test: all violations are found"

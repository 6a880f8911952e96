#!/bin/bash
# floors.sh TOP: checks the includes below TOP against the floors of the house and prints each that does not hold.
# A room includes only its own floor or lower ones, and no circle closes among the rooms of one floor; the folders of some
# rooms are ladders of their own. src/api, src/choose and src/plan alone include the public header, and series/library.h, which they
# and the tool share; src/api asks no room that draws, src/choose does not print; what reads by a plan of its bytes waits for none. Importers and examples know nothing but
# the public header and their own files; importers besides what is known of a series, src/series, and errors. Readers know nothing of the tool and of JSON; the operating system is called
# in src/base only, CLI11 in importers/tool/cli.cpp. Then classes.sh checks how large classes are.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
cd "${1:?usage: floors.sh TOP}"

folders=()
for folder in src formats include importers examples tests/api; do
  [[ ! -d $folder ]] || folders+=("$folder")
done
find "${folders[@]}" -type f \
  \( -name '*.h' -o -name '*.c' -o -name '*.cpp' -o -name '*.inc' -o -name '*.inl' \) -print0 |
  sort -z | xargs -0 -r grep -HnE '^[[:space:]]*#[[:space:]]*include[[:space:]]*[<"]' | awk '
# The rungs of a place from the lowest to the highest. Rooms on one rung stand between bars where one may include another,
# between slashes where they do not know each other. Paths are written without src/, the house itself is the place "", and a
# dot means the files directly in a place.
BEGIN {
  ladder("", "base < lattice | kernel | series < points < formats / field < slice / fit / view < motion / shade < draw / volume / store < splat / rays / gpu / reference < scene < api < choose < plan")
  ladder("formats", "bcc4 / image")
  ladder("formats/bcc4", "wavelet < coding < . / encode < read < write")
  ladder("field", "footprint < coefficients < .")
  ladder("fit", "frame / axis / kept < beyond < resample < .")
  ladder("splat", "raise | points | loop < sheet < plan < tile < .")
}
function ladder(place, rungs, levels, rooms, i, j) {
  order[place] = rungs
  for (i = split(rungs, levels, / < /); i > 0; i--) {
    if (levels[i] ~ / \/ /) apart[place, i] = 1
    for (j = split(levels[i], rooms, / [|\/] /); j > 0; j--) rung[place, rooms[j]] = i
  }
}
# The room of `place` that holds `path`; none when it lies elsewhere.
function room_of(place, path, rest) {
  if (place != "" && index(path, place "/") != 1) return ""
  rest = place == "" ? path : substr(path, length(place) + 2)
  if (!index(rest, "/")) return "."
  sub(/\/.*/, "", rest)
  return rest
}
function name_of(place, room) {
  return room == "." ? "a file directly in " place : place == "" ? room : place "/" room
}
function wrong(why) { print $0; print "  -> " why; bad++ }
function check_ladder(place, from, to) {
  from = room_of(place, path)
  to = room_of(place, target)
  if (from == "" || to == "" || from == to) return
  if (!((place, from) in rung) || !((place, to) in rung))
    wrong(name_of(place, (place, from) in rung ? to : from) " is on no rung of: " order[place])
  else if (rung[place, to] > rung[place, from])
    wrong(name_of(place, from) " is on rung " rung[place, from] ", " name_of(place, to) " on rung " rung[place, to] \
      " of: " order[place])
  else if (rung[place, to] == rung[place, from]) {
    if ((place, rung[place, to]) in apart) wrong(name_of(place, from) " and " name_of(place, to) " do not know each other")
    else beside[place, from, to] = beside[place, from, to] $0 "\n"
  }
}
# Whether includes on one rung lead from a room to another in at most so many steps.
function leads(place, from, to, steps, e, p) {
  if ((place, from, to) in beside) return 1
  if (steps > 1)
    for (e in beside) {
      split(e, p, SUBSEP)
      if (p[1] == place && p[2] == from && leads(place, p[3], to, steps - 1)) return 1
    }
  return 0
}
{
  path = $0; sub(/:.*/, "", path)
  target = $0; sub(/^[^:]*:[0-9]*:[[:space:]]*#[[:space:]]*include[[:space:]]*/, "", target)
  quoted = substr(target, 1, 1) == "\""
  sub(/^[<"]/, "", target); sub(/[>"].*$/, "", target)
  in_src = sub(/^src\//, "", path)
  sub(/^src\//, "", target)
  home = room_of("", path)
  core = ("", home) in rung
  ours = ("", room_of("", target)) in rung
  public = target ~ /(^|\/)bccsplat\.h(pp)?$/
  checked++

  if (home == "include") {
    if (target != "stddef.h" && target != "stdint.h") wrong("the public header includes <stddef.h> and <stdint.h> only")
  } else if (core) {
    if (public && home !~ /^(api|choose|plan)$/ && path != "series/library.h")
      wrong("only src/api, src/choose and src/plan include the public header")
    else if (target == "series/library.h" && home !~ /^(series|choose|plan)$/) wrong("series/library.h calls the library")
    else if (quoted && !public && !ours) wrong("write includes from src/ or the top, as \"folder/file.h\"")
    else if (ours) {
      if (target == "base/would_block.h" && path !~ /^(base|volume|api|formats)\// &&
          path !~ /^(field\/(corrections|evaluate|masks)|slice\/corrected_cut)\.cpp$/) # which have no plan to read by
        wrong("what reads by a plan of its bytes waits for none: formats, volume and api know would_block.h")
      if (home == "api" && target !~ /^(api|scene|volume|store|view|base)\//)
        wrong("api asks scene, volume and store, and knows view and base")
      for (place in order) check_ladder(place)
    }
    else if (target ~ /^(openvdb|nanovdb|CLI|nlohmann|tbb|netcdf|nifti)/) wrong("belongs to importers/, not to the library")
    else if (home == "choose" && target ~ /^(cstdio|stdio\.h|iostream)$/) wrong("src/choose prints nothing: it tells a Watch")
    else if (home != "base" && target ~ /^(windows\.h|unistd\.h|fcntl\.h|dlfcn\.h|pthread\.h|sys\/.*|thread|fstream|filesystem)$/)
      wrong("the operating system is called in src/base only")
    else if (target ~ /^(epoxy|EGL|GL|GLES[23])\// && home != "gpu") wrong("OpenGL is called in src/gpu only")
    else if (target ~ /^(OpenEXR|Imf|Imath|ImathV|png\.h|libpng)/ && home != "formats") wrong("image files are written in formats/ only")
  } else if (in_src) {
    wrong("src/" home " is on no floor of: " order[""])
  } else if (ours && !(home == "importers" && target ~ /^(series\/|base\/(error|utf8)\.h$)/)) {
    wrong(path " is a client: the public header and its own files only")
  } else if (path ~ /^importers\/readers\// && target ~ /^(tool|CLI|nlohmann)\// &&
             path " " target !~ /^importers\/readers\/records\.h nlohmann/) { # who needs JSON asks records.h
    wrong("what reads knows nothing of the tool")
  } else if (target ~ /^CLI\// && path != "importers/tool/cli.cpp") {
    wrong("CLI11 takes three seconds to compile: include tool/cli.h, which does without")
  }
}
END {
  if (!checked) { print "floors: no include found, wrong folder?"; exit 2 }
  for (e in beside) {
    split(e, p, SUBSEP)
    if (!leads(p[1], p[3], p[2], 4)) continue
    printf "%s  -> %s and %s, both on rung %d of: %s, close a circle\n", beside[e], name_of(p[1], p[2]), name_of(p[1], p[3]),
      rung[p[1], p[2]], order[p[1]]
    bad++
  }
  if (bad) print "floors: " bad " violations in " checked " includes"
  else print "floors: " checked " includes hold"
  exit bad > 0
}'
bash "$here/classes.sh" .

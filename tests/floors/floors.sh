#!/bin/bash
# floors.sh TOP: checks the includes below TOP against the floors of the house and prints each violation.
# A file includes only its own floor or lower; src/api alone includes the public header; importers and examples know
# nothing but the public header and their own files; the operating system is called in src/base only.
set -euo pipefail
cd "${1:?usage: floors.sh TOP}"

folders=()
for folder in src formats include importers examples tests/api; do
  [[ ! -d $folder ]] || folders+=("$folder")
done
find "${folders[@]}" -type f \
  \( -name '*.h' -o -name '*.c' -o -name '*.cpp' -o -name '*.inc' -o -name '*.inl' \) -print0 |
  sort -z | xargs -0 -r grep -HnE '^[[:space:]]*#[[:space:]]*include[[:space:]]*[<"]' | awk '
BEGIN {
  floor["base"] = 0
  floor["lattice"] = floor["kernel"] = 1
  floor["points"] = 2
  floor["formats"] = 3
  floor["field"] = 4
  floor["fit"] = floor["slice"] = floor["splat"] = 5
  floor["render"] = floor["store"] = 6
  floor["api"] = 7
}
function wrong(why) { print $0; print "  -> " why; bad = 1 }
{
  file = $0; sub(/:.*/, "", file)
  text = $0; sub(/^[^:]*:[0-9]*:[[:space:]]*#[[:space:]]*include[[:space:]]*/, "", text)
  quoted = substr(text, 1, 1) == "\""
  target = text; sub(/^[<"]/, "", target); sub(/[>"].*$/, "", target)
  split(file, f, "/")
  home = f[1] == "src" ? f[2] : f[1]
  split(target, t, "/")
  to = t[1] == "src" ? t[2] : t[1]
  core = home in floor
  public = target ~ /(^|\/)bccsplat\.h$/
  checked++

  if (home == "include") {
    if (target != "stddef.h" && target != "stdint.h") wrong("the public header includes <stddef.h> and <stdint.h> only")
  } else if (core) {
    if (public && home != "api") wrong("only src/api includes the public header")
    else if (quoted && !public && !(to in floor)) wrong("write includes from src/ or the top, as \"folder/file.h\"")
    else if ((to in floor) && index(target, "/") && floor[to] > floor[home])
      wrong(home " is floor " floor[home] ", " to " is floor " floor[to])
    else if (target ~ /^(openvdb|nanovdb|CLI|nlohmann|tbb|netcdf|nifti)/) wrong("belongs to importers/, not to the library")
    else if (home != "base" && target ~ /^(unistd\.h|fcntl\.h|dlfcn\.h|pthread\.h|sys\/.*|thread|fstream|filesystem)$/)
      wrong("the operating system is called in src/base only")
    else if (target ~ /^(OpenEXR|Imf|Imath|ImathV|png\.h|libpng)/ && home != "formats") wrong("image files are written in formats/ only")
  } else if ((to in floor) && index(target, "/")) {
    wrong(file " is a client: the public header and its own files only")
  }
}
END {
  if (!checked) { print "floors: no include found, wrong folder?"; exit 2 }
  if (!bad) print "floors: " checked " includes hold"
  exit bad
}'

#!/bin/bash
# prose.sh TOP: checks what can be checked of the prose below TOP and prints each line that does not hold. Every source names
# its licence in its first line, and of more than 120 lines it says in a comment below what it does. Numbers in comments and in
# the notes of the benchmark have a leading zero; what commands print, in the indented and fenced parts of the notes, is left as
# it is.
set -euo pipefail
cd "${1:?usage: prose.sh TOP}"

# Folders and files that do not follow yet: the list is to shrink, and nothing may be added to it.
later=(
  include/bccsplat.h src/api src/field src/store formats/bcc4 importers/tool
  tests/api tests/bench tests/faults tests/fuzz tests/stability tests/tool/vdb_probe.cpp tests/unit/field tests/unit/formats
  tests/bench/notes/lattice-fit.md tests/bench/notes/moments.md
)

places=()
for place in src formats include importers examples tests; do
  [[ ! -d $place ]] || places+=("$place")
done
find "${places[@]}" -type f \( -name '*.h' -o -name '*.c' -o -name '*.cpp' -o -name '*.inc' -o -path '*/bench/notes/*.md' \) \
  -print0 | sort -z | xargs -0 awk -v later="${later[*]}" '
BEGIN { waiting = split(later, place, " ") }
function is_later(i) {
  for (i = 1; i <= waiting; i++)
    if (FILENAME == place[i] || (place[i] !~ /\.md$/ && !notes && index(FILENAME, place[i] "/") == 1)) return 1
  return 0
}
function wrong(where, why) { print where; print "  -> " why; bad++ }
function end_file() {
  if (file && !skipped && !notes && lines > 120 && !headed) wrong(file, "has " lines " lines and does not open with a comment")
}
FNR == 1 {
  end_file()
  file = FILENAME; notes = file ~ /\.md$/; skipped = is_later(); headed = fenced = in_block = 0
  files++
  if (!notes && file !~ /\.inc$/ && $0 !~ /^\/[\/*] SPDX-License-Identifier: Apache-2\.0( \*\/)?$/) wrong(file, "does not name its licence in its first line")
}
FNR == 2 || (FNR == 1 && FILENAME ~ /\.inc$/) { headed = $0 ~ /^\/[\/*]/ }
{ lines = FNR }
skipped { next }
# The prose of a line: in notes all but what commands print, in sources what is behind the slashes or in a block of C.
{
  text = $0
  if (notes) {
    if (text ~ /^```/) fenced = !fenced
    if (fenced || text ~ /^    [^ |-]/) next
    gsub(/`[^`]*`/, "", text)
  } else {
    gsub(/"([^"\\]|\\.)*"/, "", text)
    if (in_block) in_block = text !~ /\*\//
    else if (match(text, /\/\*/)) { in_block = text !~ /\*\//; text = substr(text, RSTART + 2) }
    else if (match(text, /\/\//)) text = substr(text, RSTART + 2)
    else next
  }
  if (text ~ /(^|[^A-Za-z0-9._)\]\/])\.[0-9]/) wrong(FILENAME ":" FNR ":" $0, "numbers have a leading zero")
}
END {
  end_file()
  if (!files) { print "prose: no source found, wrong folder?"; exit 2 }
  if (bad) print "prose: " bad " violations in " files " files"
  else print "prose: " files " files hold"
  exit bad > 0
}'

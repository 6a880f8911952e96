#!/bin/bash
# prose.sh TOP: checks what can be checked of the prose below TOP and prints each line that does not hold. Every source names
# its licence in its first line, and of more than 120 lines it says in a comment below what it does. Numbers in comments and in
# the notes of the benchmark have a leading zero; what commands print, in the indented and fenced parts of the notes, is left as
# it is.
set -euo pipefail
cd "${1:?usage: prose.sh TOP}"

places=()
for place in src formats include importers examples tests; do
  [[ ! -d $place ]] || places+=("$place")
done
find "${places[@]}" -type f \( -name '*.h' -o -name '*.c' -o -name '*.cpp' -o -name '*.inc' -o -path '*/bench/notes/*.md' \) \
  -print0 | sort -z | xargs -0 awk '
function wrong(where, why) { print where; print "  -> " why; bad++ }
function end_file() {
  if (file && !notes && lines > 120 && !headed) wrong(file, "has " lines " lines and does not open with a comment")
}
FNR == 1 {
  end_file()
  file = FILENAME; notes = file ~ /\.md$/; headed = fenced = in_block = 0
  files++
  if (!notes && file !~ /\.inc$/ && $0 !~ /^\/[\/*] SPDX-License-Identifier: Apache-2\.0( \*\/)?$/) wrong(file, "does not name its licence in its first line")
}
FNR == 2 || (FNR == 1 && FILENAME ~ /\.inc$/) { headed = $0 ~ /^\/[\/*]/ }
{ lines = FNR }
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

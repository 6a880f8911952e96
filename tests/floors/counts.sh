#!/bin/bash
# counts.sh TOP [--write]: counts what grows unseen below TOP and prints what the table there does not tell,
# tests/floors/counts.tsv (number, tab, of what): lines of each room, which may be fewer; calls of the public header, fields of
# its structs, and comments that begin with "Of", "Those", "What of", "That of" or "By what", where their noun belongs, which
# are as many; and by name the calls that neither an example nor an importer makes. A change that needs more edits the table,
# and its commit says why; --write lowers the numbers to what is there.
set -euo pipefail
cd "${1:?usage: counts.sh TOP [--write]}"
table=tests/floors/counts.tsv
header=include/bccsplat.h

sources() { find "$@" -type f \( -name '*.h' -o -name '*.c' -o -name '*.cpp' -o -name '*.inc' -o -name '*.inl' \) -print0; }

counted() {
  local room lines
  for room in {src,formats,importers}/*/; do
    lines=$(sources "$room" | xargs -0r cat | wc -l)
    ((lines == 0)) || printf '%s\tlines of %s\n' "$lines" "${room%/}"
  done
  printf '%s\tcalls\n' "$(grep -cE '^BCCSPLAT_API' "$header")"
  printf '%s\tfields\n' "$(awk '/^typedef struct .*\{/ { inside = 1 } inside && /;/ { n++ } /^\}/ { inside = 0; n-- } END { print n + 0 }' "$header")"
  printf '%s\tcomments without a noun in front\n' \
    "$(sources src formats include importers examples | xargs -0 grep -hE '(//|/\*) (Of|Those|What of|That of|By what) ' | wc -l)"
  # Each object is retained and released. Python's table of declarations makes no call; the package leaves the prefix out
  # where it does.
  comm -23 <(grep -E '^BCCSPLAT_API' -A1 "$header" | grep -oE 'bccsplat_[a-z0-9_]+\(' | tr -d '(' | grep -vE '_(retain|release)$' | sort -u) \
    <({
      grep -rhoE --exclude=_abi.py --exclude-dir=node_modules 'bccsplat_[a-z0-9_]+' examples importers
      grep -rhoE --include='*.py' '"[a-z0-9]+_[a-z0-9_]+"' examples | sed 's/"//g; s/^/bccsplat_/'
    } | sort -u) | sed 's/^/0\tuses of /'
}

counts=$(counted)
grep -q $'\tlines of ' <<<"$counts" || { echo "counts: no room found, wrong folder?" && exit 2; }
awk -F'\t' -v write="${2:+1}" '
FILENAME != "-" { most[$2] = $1; next }
{ found[$2] = $1 }
!($2 in most) { printf "%s: %s, not in the table\n", $2, $1; bad++; next }
$1 > most[$2] { printf "%s: %s, where the table says %s\n", $2, $1, most[$2]; bad++; next }
$1 < most[$2] && $2 !~ /^lines/ && !write { printf "%s: only %s, where the table says %s; counts.sh TOP --write tells it\n", $2, $1, most[$2]; bad++ }
END {
  for (what in most) if (!(what in found) && !write) { printf "%s: in the table, but no more; counts.sh TOP --write tells it\n", what; bad++ }
  if (bad) print "counts: " bad " are not as the table says"
  else print "counts: all are as the table says"
  exit bad > 0
}' "$table" - <<<"$counts"
[[ ! ${2:-} ]] || printf '%s\n' "$counts" >"$table"

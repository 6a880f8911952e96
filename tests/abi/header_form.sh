#!/bin/bash
# header_form.sh HEADER: the public header can be read: no line is longer than 100 columns, no declaration is torn between
# its type and its name, and a comment that stands beside a declaration ends on that line. Prints each line that is not so.
set -euo pipefail
LC_ALL=C.UTF-8 awk '
function wrong(why) { print FILENAME ":" FNR ": " why ": " $0; bad = 1 }
length($0) > 100 { wrong("longer than 100 columns") }
/^ *#/ || /\\$/ { next }
{
  code = $0
  if (inside) {
    if (!index(code, "*/")) next
    sub(/.*\*\//, "", code)
    inside = 0
  }
  gsub(/\/\*([^*]|\*+[^*\/])*\*+\//, "", code)
  if (match(code, /\/\*/)) {
    inside = 1
    if (substr(code, 1, RSTART - 1) ~ /[^ ]/) wrong("a comment beside a declaration goes on below")
    code = substr(code, 1, RSTART - 1)
  }
  sub(/ +$/, "", code)
  if (code == "") next
  # Only the last name of a list may stand without a mark behind it.
  if (torn && code !~ /^ *}/) { print FILENAME ":" torn ": torn: " torn_line; bad = 1 }
  torn = code ~ /[;,{}()"]$/ ? 0 : FNR
  torn_line = $0
}
END { exit bad }' "${1:?usage: header_form.sh HEADER}"

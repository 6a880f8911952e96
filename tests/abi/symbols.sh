#!/bin/bash
# symbols.sh LIBRARY LIST [--update]: compares what the library exports with the checked-in list.
# A new function is added with --update; a symbol that is gone or renamed breaks hosts that are already built.
set -euo pipefail
library=${1:?usage: symbols.sh LIBRARY LIST [--update]} list=${2:?}
export LC_ALL=C

# Absolute symbols are the version names themselves.
exported=$(nm -D --defined-only --format=posix "$library" | awk '$2 != "A" { sub(/@.*/, "", $1); print $1 }' | sort)
if [[ ${3:-} == --update ]]; then
  echo "$exported" >"$list"
  echo "$list: $(wc -l <"$list") symbols"
elif ! diff -u --label "$list" --label "exported by $library" "$list" <(echo "$exported"); then
  echo "The exported symbols differ. If that is meant: bash $0 $library $list --update"
  exit 1
fi

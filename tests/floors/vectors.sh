#!/bin/bash
# vectors.sh TOP: checks that files below TOP with loops for several instruction sets are of the one form that
# src/README.md tells ("Loops for several instruction sets") and prints each line that is not.
set -euo pipefail
cd "${1:?usage: vectors.sh TOP}"

mapfile -t files < <(grep -rlF '<hwy/foreach_target.h>' --include='*.cpp' src formats | sort)
if ((${#files[@]} == 0)); then
  echo "vectors: no file includes hwy/foreach_target.h, wrong folder?"
  exit 2
fi
awk '
function wrong(why) { printf "%s:%d: %s\n", FILENAME, FNR, why; bad++ }
function close_file() { if (name != "" && unnamed != 1) { printf "%s: one unnamed namespace holds what is compiled for a target\n", name; bad++ } }
FNR == 1 { close_file(); name = FILENAME; sub(/^src\//, "", name); unnamed = inside = once = after_once = 0 }
/^#define HWY_TARGET_INCLUDE / && $3 != "\"" name "\"" { wrong("HWY_TARGET_INCLUDE is this file: \"" name "\"") }
/^#include <hwy\/highway.h>/ { highway = FILENAME }
/^#include/ && $0 !~ /foreach_target|highway|cache_control/ && highway != FILENAME { wrong("included before hwy/highway.h") }
# Where the linker puts a table depends on all others.
!after_once && /^ *(inline |static )*constexpr (auto [a-z_]+ = \[|std::array|[a-z0-9_]+ [a-z_]+\[)/ {
  wrong("a table that does not say its alignment: alignas(64)")
}
/^HWY_BEFORE_NAMESPACE/ { inside = 1; behind = FILENAME }
/^HWY_AFTER_NAMESPACE/ { inside = 0 }
/^#include/ && behind == FILENAME { wrong("included behind the loops") }
inside && /^namespace \{/ { unnamed++ }
/^#if HWY_ONCE/ { once = after_once = 1; next }
/^HWY_EXPORT/ && !once { wrong("HWY_EXPORT stands first behind HWY_ONCE") }
!/^(HWY_EXPORT.*|namespace [a-z0-9]+ \{|)$/ { once = 0 }
END {
  close_file()
  if (bad) print "vectors: " bad " lines are of another form"
  else print "vectors: " ARGC - 1 " files are of one form"
  exit bad > 0
}' "${files[@]}"

#!/bin/bash
# abidiff.sh HEADER CC DUMP [--update]: the binary interface the header declares against that of the last release. Every
# function gets an empty body, so that the dump holds the public types and nothing else. New functions and new fields at
# the end of structs pass; whatever would break a host that is already built does not. Exits with 77 without libabigail.
set -euo pipefail
header=${1:?usage: abidiff.sh HEADER CC DUMP [--update]} cc=$2 dump=$3
command -v abidw >/dev/null && command -v abidiff >/dev/null || { echo "skipped: no abigail-tools" && exit 77; }
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

{
  echo '#include "bccsplat.h"'
  "$cc" -std=c99 -E -P -DBCCSPLAT_BUILDING -D'__attribute__(x)=EXPORTED' "$header" | tr '\n' ' ' | sed 's/[{};]/&\n/g' |
    awk '/EXPORTED/ { sub(/.*EXPORTED/, ""); sub(/; *$/, "")
      print $0 ($0 ~ /^ *void +bccsplat/ ? " {}" : " { return 0; }") }'
} >"$scratch/declared.c"
(cd "$scratch" && cp "$header" bccsplat.h &&
  "$cc" -std=c99 -g -shared -fPIC -w -DBCCSPLAT_BUILDING -Wl,-soname,libbccsplat.so.0 declared.c -o libbccsplat.so.0 &&
  abidw --no-corpus-path --no-comp-dir-path --no-show-locs libbccsplat.so.0 --out-file now.abi)
if [[ ${4:-} == --update ]]; then
  cp "$scratch/now.abi" "$dump"
  echo "$dump: $(wc -c <"$dump") bytes"
  exit
fi
code=0
abidiff --no-added-syms "$dump" "$scratch/now.abi" >"$scratch/report" || code=$?
# Bits of the code: 1 and 2 failure of the tool, 4 a change, 8 one that abidiff itself holds to be incompatible. A
# suppression for growing structs would let members change their type: look at what the change is instead.
harmful="offset changed|data member deletion|[1-9][0-9]* Removed|return type changed|type of '|name of '"
harmful+="|parameter [0-9]+ of type .* changed|parameter [0-9]+ .*was (added|removed)"
# A reserved field is there to be used one day.
sed -i "/name of '.*::reserved' changed/d; /type of '.* reserved' changed/d" "$scratch/report"
if ((code & 11)) || grep -qE "$harmful" "$scratch/report"; then
  cat "$scratch/report"
  echo "A built host would break. If that is a new major version: bash $0 $header $cc $dump --update"
  exit 1
fi

#!/bin/bash
# layout.sh HEADER CC LIST [--update]: compares offset and size of every field of every public struct, and the value of
# every constant, with the checked-in list. New fields at the end of a struct and new constants are added with --update;
# anything that moves breaks hosts that are already built.
set -euo pipefail
header=${1:?usage: layout.sh HEADER CC LIST [--update]} cc=$2 list=$3
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# From the preprocessed header, one declaration per line, to a program that prints what the compiler made of it.
"$cc" -std=c99 -E -P "$header" | tr '\n' ' ' | sed 's/[{};]/&\n/g' | awk -v header="$header" '
  BEGIN { print "#include <stddef.h>\n#include <stdio.h>\n#include \"" header "\"\nint main(void) {" }
  /typedef struct bccsplat_[a-z_]+ *{/ { inside = $3; sub(/{.*/, "", inside); fields = 0; next }
  /enum *{/ { constants = 1; next }
  constants {
    sub(/}.*/, "")
    n = split($0, names, ",")
    for (i = 1; i <= n; i++) if (match(names[i], /BCCSPLAT_[A-Z0-9_]+/)) {
      name = substr(names[i], RSTART, RLENGTH)
      printf "  printf(\"%s %%d\\n\", (int)%s);\n", name, name
    }
    constants = 0
    next
  }
  inside && /}/ {
    printf "  printf(\"struct %s size %%zu\\n\", sizeof(%s));\n", inside, inside
    inside = ""
    next
  }
  inside {
    sub(/;.*/, "")
    n = split($0, names, ",")
    for (i = 1; i <= n; i++) {
      sub(/\[.*/, "", names[i])
      if (match(names[i], /[a-z0-9_]+ *$/)) {
        field = substr(names[i], RSTART, RLENGTH)
        sub(/ *$/, "", field)
        printf "  printf(\"%s.%s offset %%zu size %%zu\\n\", offsetof(%s, %s), sizeof(((%s*)0)->%s));\n", \
          inside, field, inside, field, inside, field
      }
    }
  }
  END { print "  return 0;\n}" }' >"$scratch/layout.c"
"$cc" -std=c99 "$scratch/layout.c" -o "$scratch/layout"
"$scratch/layout" >"$scratch/layout.txt"

if [[ ${4:-} == --update ]]; then
  cp "$scratch/layout.txt" "$list"
  echo "$list: $(wc -l <"$list") lines"
elif ! diff -u --label "$list" --label "compiled from $header" "$list" "$scratch/layout.txt"; then
  echo "Struct layout or constants differ. If that is meant: bash $0 $header $cc $list --update"
  exit 1
fi

#!/bin/bash
# prose_test.sh SCRATCH: prose.sh accepts a small tree in order and reports each made-up violation, saying why.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
scratch=${1:?usage: prose_test.sh SCRATCH}

lines() { # COUNT: so many lines of code
  local n
  for ((n = 0; n < $1; n++)); do echo "int number_$n = $n;"; done
}

licence='// SPDX-License-Identifier: Apache-2.0'

tree() {
  rm -rf "$scratch"
  mkdir -p "$scratch/src/base" "$scratch/examples" "$scratch/tests/bench/notes"
  { echo "$licence" && echo '// Holds what it says.' && lines 120; } >"$scratch/src/base/long.cpp"
  { echo "$licence" && lines 119; } >"$scratch/src/base/short.cpp"
  printf '%s\n' '/* SPDX-License-Identifier: Apache-2.0 */' '/* A host in C: 0.5, 1.5 and 3 .. 4. */' >"$scratch/examples/host.c"
  printf '%s\n' "$licence" 'float half = .5f; // 0.5, from 0..1, x.0, "(a).5", and ".5" between quotes' >"$scratch/src/base/numbers.h"
  printf '%s\n' 'Half is 0.5, as `print .5` says:' '' '    .5 of it' '```' '.5 of it' '```' '| 0.5 | 1..2 |' \
    >"$scratch/tests/bench/notes/page.md"
}

tree
bash "$here/prose.sh" "$scratch"

failures=0
violation() { # FILE LINE WHY: the report names the file and says why
  tree
  printf '%s\n' "$2" >>"$scratch/$1"
  if out=$(bash "$here/prose.sh" "$scratch"); then
    echo "FAILED: $1 may not say: $2" && failures=$((failures + 1))
  elif [[ $out != *"$1"*"$3"* ]]; then
    echo "FAILED: the report does not say \"$1 ... $3\": $out" && failures=$((failures + 1))
  fi
}
violation src/base/short.cpp 'int one_more = 1;' 'has 121 lines and does not open with a comment'
tree
sed -i 1d "$scratch/src/base/short.cpp"
if out=$(bash "$here/prose.sh" "$scratch"); then
  echo "FAILED: a file may not be without its licence" && failures=$((failures + 1))
elif [[ $out != *src/base/short.cpp*licence* ]]; then
  echo "FAILED: the report does not say whose licence is missing: $out" && failures=$((failures + 1))
fi
violation src/base/short.cpp '// A comment at the end opens nothing.' 'does not open with a comment'
violation src/base/numbers.h '// .5 of a sample' 'leading zero'
violation src/base/numbers.h 'int x = 1; // waves of rho .3' 'leading zero'
violation src/base/numbers.h '// the pole is -.17' 'leading zero'
violation src/base/numbers.h '// a step (.25 T)' 'leading zero'
violation examples/host.c '/* it takes .3 ms */' 'leading zero'
violation examples/host.c $'/* a block\n   of .3 ms */' 'leading zero'
violation tests/bench/notes/page.md 'It takes .3 of the time.' 'leading zero'
violation tests/bench/notes/page.md '| smoke | .3 |' 'leading zero'

rm -rf "${scratch:?}"/* && mkdir -p "$scratch/src"
if bash "$here/prose.sh" "$scratch" >/dev/null; then
  echo "FAILED: an empty tree passes" && failures=$((failures + 1))
fi
rm -rf "$scratch"
[[ $failures == 0 ]] && echo "prose_test: all violations are found"

#!/bin/bash
# header.sh HEADER CC CXX: the public header compiles alone, as the first and only include, in every language it promises.
set -euo pipefail
header=${1:?usage: header.sh HEADER CC CXX}
cc=$2 cxx=$3

check() { # COMPILER LANGUAGE STANDARD [FLAGS]
  echo "$1 -x $2 -std=$3 $header"
  printf '#include "%s"\n#include "%s"\ntypedef int translation_unit_is_not_empty;\n' "$header" "$header" |
    "$1" -x "$2" "-std=$3" -Wall -Wextra -pedantic -Werror ${4:-} -fsyntax-only -
}
for standard in c99 c11 c17; do check "$cc" c $standard -Wpadded; done
for standard in c++11 c++17 c++20; do check "$cxx" c++ $standard -Wpadded; done

# The one for C++ hosts stands beside it.
header=${header%.h}.hpp
for standard in c++17 c++20; do check "$cxx" c++ $standard; done

#!/bin/bash
# vectors_test.sh SCRATCH: vectors.sh accepts a file of the one form and reports each departure from it.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
scratch=${1:?usage: vectors_test.sh SCRATCH}
file=$scratch/src/base/sum.cpp

good() {
  rm -rf "$scratch"
  mkdir -p "${file%/*}" "$scratch/formats"
  cat >"$file" <<'CPP'
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "base/sum.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {
void Sum() {}
} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Sum);

void sum() { HWY_DYNAMIC_DISPATCH(Sum)(); }
} // namespace bccsplat
#endif
CPP
}

good
bash "$here/vectors.sh" "$scratch"

failures=0
departure() { # SED-COMMAND WHY: the report says why
  good
  sed -i "$1" "$file"
  if out=$(bash "$here/vectors.sh" "$scratch"); then
    echo "FAILED: accepted after $1" && failures=$((failures + 1))
  elif [[ $out != *"$2"* ]]; then
    echo "FAILED: the report does not say \"$2\": $out" && failures=$((failures + 1))
  fi
}
departure 's,"base/sum.cpp","base/product.cpp",' 'sum.cpp:2: HWY_TARGET_INCLUDE is this file: "base/sum.cpp"'
departure '3i #include <array>' 'sum.cpp:3: included before hwy/highway.h'
departure '/HWY_ONCE/a #include <array>' 'included behind the loops'
departure '/^namespace {/d; /^} .. namespace$/d' 'one unnamed namespace'
departure 's,^void Sum,} // namespace\nnamespace {\n&,' 'one unnamed namespace'
departure 's,^void Sum,constexpr float weights[4] = {1\, 2\, 3\, 4};\n&,' 'does not say its alignment'
departure 's,^void Sum,inline constexpr auto weights = [] { return std::array{1}; }();\n&,' 'does not say its'
departure 's,^HWY_EXPORT,void other();\n&,' 'HWY_EXPORT stands first'
exit $((failures > 0))

#!/bin/bash
# tidy.sh [BASE | --all]: clang-tidy with the checks of .clang-tidy on what changed since BASE (sources.sh). At most
# BCCSPLAT_TIDY_SECONDS (180) of files are begun; those left out, the longest unchanged, do not count as failures.
set -uo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
cd "$top" || exit 1
# shellcheck source=tests/packages.sh
source tests/packages.sh
install_missing clang-tidy-14 "${build_packages[@]}" || exit 1

if [[ ${1:-} == --all ]]; then
  mapfile -t files < <(git ls-files 'src/*.cpp' 'formats/*.cpp' 'importers/*.cpp')
else
  mapfile -t files < <(bash .ci/sources.sh "${1:-}")
fi
if ((${#files[@]} == 0)); then
  echo "clang-tidy: no source changed"
  exit 0
fi

build="build-tidy"
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Debug -DBCCSPLAT_BUILD_TESTS=OFF -DBCCSPLAT_BUILD_BENCH=OFF \
  -DBCCSPLAT_BUILD_EXAMPLES=OFF >/dev/null || exit 1
# Files of another build, as for browsers, are not in this one.
mapfile -t files < <(for file in "${files[@]}"; do grep -qF "/$file\"" "$build/compile_commands.json" && echo "$file"; done)
sed -i 's/ -fno-gnu-unique//g; s/ -Wno-restrict//g' "$build/compile_commands.json" # options of GCC alone

# one FILE: what is wrong with it, and a file of its name under failed or left
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
mkdir "$results/failed" "$results/left"
end=$(($(date +%s) + ${BCCSPLAT_TIDY_SECONDS:-180}))
export build results end
one() {
  local name=${1//\//+}
  if (($(date +%s) > end)); then
    touch "$results/left/$name"
  elif ! clang-tidy-14 --quiet --extra-arg=-w -p "$build" "$1" >"$results/$name" 2>"$results/$name.err"; then
    cat "$results/$name" "$results/$name.err"
    touch "$results/failed/$name"
  fi
}
export -f one
# shellcheck disable=SC2016
printf '%s\0' "${files[@]}" | xargs -0 -n1 -P "$(nproc)" bash -c 'one "$1"' one
left=$(find "$results/left" -type f | wc -l) failed=$(find "$results/failed" -type f | wc -l)
echo "clang-tidy: ${#files[@]} files, $failed with findings, $left left out for want of time"
((failed == 0))

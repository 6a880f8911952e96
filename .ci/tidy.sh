#!/bin/bash
# tidy.sh [BASE | --all]: clang-tidy with the checks of .clang-tidy on the sources of src, formats and importers that differ
# from BASE, or include a header that does. BASE: the merge base with main, or the commit before where HEAD is on main.
# At most BCCSPLAT_TIDY_SECONDS (240) of files are begun; those left out are named and do not count as failures.
set -uo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
cd "$top" || exit 1
# shellcheck source=tests/packages.sh
source tests/packages.sh
install_missing clang-tidy-14 "${build_packages[@]}" || exit 1

if [[ ${1:-} == --all ]]; then
  mapfile -t files < <(git ls-files 'src/*.cpp' 'formats/*.cpp' 'importers/*.cpp')
else
  base=${1:-}
  for main in origin/main main; do
    if [[ -z $base ]]; then base=$(git merge-base HEAD "$main" 2>/dev/null); fi
  done
  if [[ -z $base || $(git rev-parse "$base") == $(git rev-parse HEAD) ]]; then base=HEAD~; fi
  git rev-parse -q --verify "$base^{commit}" >/dev/null || base=$(git hash-object -t tree /dev/null)
  mapfile -t changed < <(git diff --name-only --diff-filter=d "$base" -- src formats importers)
  files=()
  for file in "${changed[@]}"; do
    case $file in
    *.cpp) files+=("$file") ;;
    *.h | *.inc)
      # Includes are written from src/ or from the top, in importers/ from there.
      name=${file#src/} && name=${name#importers/}
      mapfile -t -O ${#files[@]} files < <(git grep -lF "#include \"$name\"" -- 'src/*.cpp' 'formats/*.cpp' 'importers/*.cpp')
      ;;
    esac
  done
fi
if ((${#files[@]} == 0)); then
  echo "clang-tidy: no source changed"
  exit 0
fi
mapfile -t files < <(printf '%s\n' "${files[@]}" | sort -u)

build="build-tidy"
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Debug -DBCCSPLAT_BUILD_TESTS=OFF -DBCCSPLAT_BUILD_BENCH=OFF \
  -DBCCSPLAT_BUILD_EXAMPLES=OFF >/dev/null || exit 1
sed -i 's/ -fno-gnu-unique//g; s/ -Wno-restrict//g' "$build/compile_commands.json" # options of GCC alone

# one FILE: what is wrong with it, and a file of its name under failed or left
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
mkdir "$results/failed" "$results/left"
end=$(($(date +%s) + ${BCCSPLAT_TIDY_SECONDS:-240}))
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
find "$results/left" -type f -printf '  left out: %f\n' | tr + /
((failed == 0))

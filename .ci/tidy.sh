#!/bin/bash
# tidy.sh [BASE | --all]: clang-tidy with the checks of .clang-tidy on the sources of src, formats and importers whose code
# changed since BASE, the latest change first, then on those that include a header whose code did. Moves, include lines and
# whole lines of comment are no change of code. At most BCCSPLAT_TIDY_SECONDS (240) of files are begun; those left out, the
# longest unchanged, do not count as failures.
# BASE is the merge base with main. Where HEAD is on main, as in a fresh clone, it is the newest ancestor a day older: one
# commit back would let everything but the last of a day's commits through, and more than a day does not fit the time.
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
    [[ -n $base ]] || base=$(git merge-base HEAD "$main" 2>/dev/null)
  done
  if [[ -z $base || $(git rev-parse "$base") == $(git rev-parse HEAD) ]]; then
    base=$(git rev-list -1 --min-age=$(($(git show -s --format=%ct HEAD) - 86400)) HEAD)
  fi
  changes=(-M -U0 --diff-filter=d)
  # From the newest commit to the oldest, so that a file is known under its name of today.
  mapfile -t changed < <({
    git diff "${changes[@]}" HEAD -- src formats importers
    git log -p "${changes[@]}" --format= "${base:+$base..}HEAD" -- src formats importers
  } | awk '
    /^rename from / { from = substr($0, 13) }
    /^rename to / { to = substr($0, 11); today[from] = to in today ? today[to] : to }
    /^(---|\+\+\+) / { file = substr($0, 7); if (file in today) file = today[file]; next }
    /^[-+]/ && !/^[-+][ \t]*(#[ \t]*(include|define HWY_TARGET_INCLUDE).*|\/\/.*)?$/ && !seen[file]++ { print file }')
  files=() headers=()
  for file in "${changed[@]}"; do
    case $file in
    *.cpp) [[ ! -f $file ]] || files+=("$file") ;;
    *.h | *.inc) headers+=("$file") ;;
    esac
  done
  for file in "${headers[@]}"; do
    # Includes are written from src/ or from the top, in importers/ from there.
    name=${file#src/} && name=${name#importers/}
    mapfile -t -O ${#files[@]} files < <(git grep -lF "#include \"$name\"" -- 'src/*.cpp' 'formats/*.cpp' 'importers/*.cpp')
  done
fi
if ((${#files[@]} == 0)); then
  echo "clang-tidy: no source changed"
  exit 0
fi
mapfile -t files < <(printf '%s\n' "${files[@]}" | awk '!seen[$0]++')

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
((failed == 0))

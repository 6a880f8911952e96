#!/bin/bash
# sources.sh [--one] [BASE]: the sources of src, formats and importers whose code changed since BASE (changed.sh), the latest
# change first, then those that include a header whose code did; with --one, of each such header one alone. After a day of
# changes these are hundreds: what takes seconds for each takes the first ones.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1
most=100000
if [[ ${1:-} == --one ]]; then most=1 && shift; fi
mapfile -t changed < <(bash .ci/changed.sh "${1:-}" | grep -v '^tests/')
for file in "${changed[@]}"; do
  if [[ $file == *.cpp && -f $file ]]; then echo "$file"; fi
done | cat - <(for file in "${changed[@]}"; do
  case $file in
  *.h | *.inc)
    # Includes are written from src/ or from the top, in importers/ from there.
    name=${file#src/} && name=${name#importers/}
    git grep -lF "#include \"$name\"" -- 'src/*.cpp' 'formats/*.cpp' 'importers/*.cpp' | head -n "$most"
    ;;
  esac
done) | awk '!seen[$0]++'

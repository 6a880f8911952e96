#!/bin/bash
# changed.sh [BASE]: the files of src, formats, importers and tests whose code changed since BASE, the latest change first.
# Moves, include lines and whole lines of comment are no change of code, nor is what was taken back. BASE is that of base.sh.
set -euo pipefail
cd "$(dirname "$0")/.."
base=${1:-$(bash .ci/base.sh)}
changes=(-M -U0 --diff-filter=d)
folders=(src formats importers tests)
# From the newest commit to the oldest, so that a file is known under its name of today.
{
  git diff "${changes[@]}" HEAD -- "${folders[@]}"
  git log -p "${changes[@]}" --format= "${base:+$base..}HEAD" -- "${folders[@]}"
} | awk '
  /^rename from / { from = substr($0, 13) }
  /^rename to / { to = substr($0, 11); today[from] = to in today ? today[to] : to }
  /^(---|\+\+\+) / { file = substr($0, 7); if (file in today) file = today[file]; next }
  /^[-+]/ && !/^[-+][ \t]*(#[ \t]*(include|define HWY_TARGET_INCLUDE).*|\/\/.*)?$/ && !seen[file]++ { print file }' |
  if [[ $base ]]; then grep -Fxf <(git diff --name-only --diff-filter=d "$base" -- "${folders[@]}") || true; else cat; fi

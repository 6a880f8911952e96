#!/bin/bash
# changed.sh [BASE]: the files of src, formats, importers and tests whose code changed since BASE, the latest change first.
# Moves, include lines and whole lines of comment are no change of code, nor is what was taken back.
# BASE is the merge base with main. Where HEAD is on main, as in a fresh clone, it is the newest ancestor a day older: one
# commit back would let everything but the last of a day's commits through, and more than a day does not fit the time.
set -euo pipefail
cd "$(dirname "$0")/.."
base=${1:-}
for main in origin/main main; do
  [[ -n $base ]] || base=$(git merge-base HEAD "$main" 2>/dev/null) || true
done
if [[ -z $base || $(git rev-parse "$base") == $(git rev-parse HEAD) ]]; then
  base=$(git rev-list -1 --min-age=$(($(git show -s --format=%ct HEAD) - 86400)) HEAD)
fi
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

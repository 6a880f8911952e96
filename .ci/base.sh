#!/bin/bash
# base.sh: the commit that a change begins at, the merge base with main. Where HEAD is on main, as in a fresh clone, it is the
# newest ancestor a day older: one commit back would let everything but the last of a day's commits through, and more than a
# day does not fit the time. Nothing where history is shorter.
set -euo pipefail
cd "$(dirname "$0")/.."
base=
for main in origin/main main; do
  [[ -n $base ]] || base=$(git merge-base HEAD "$main" 2>/dev/null) || true
done
if [[ -z $base || $(git rev-parse "$base") == $(git rev-parse HEAD) ]]; then
  base=$(git rev-list -1 --min-age=$(($(git show -s --format=%ct HEAD) - 86400)) HEAD)
fi
echo "$base"

#!/bin/bash
# nightly_test.sh TOP: of a table of a made-up history, .ci/nightly names what is due in the right order, and refuses what it
# does not know.
set -euo pipefail
top=${1:?usage: nightly_test.sh TOP}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "FAILED: $1" >&2 && exit 1; }
export GIT_CONFIG_GLOBAL=/dev/null GIT_AUTHOR_NAME=a GIT_AUTHOR_EMAIL=a@b GIT_COMMITTER_NAME=a GIT_COMMITTER_EMAIL=a@b

mkdir -p "$work/.ci" "$work/tests"
cp "$top/.ci/nightly" "$top/.ci/parts.sh" "$work/.ci/"
cp "$top/tests/packages.sh" "$work/tests/"
cd "$work"
git init -q .
commits=()
for n in 0 1 2 3 4; do
  git commit -q --allow-empty -m "$n"
  commits+=("$(git rev-parse --short HEAD)")
done
day=$(date -u -d '2 days ago' +%F)
{
  printf '%s\twindows\t%s\t33\tpassed\n' "$day" "${commits[3]}"
  printf '%s\tbrowsers\t%s\t7\tpassed\n' "$day" "${commits[0]}"
  printf '%s\tbrowsers\t%s\t9\tfailed\n' "$day" "${commits[4]}"
  printf '%s\tslurm\t%s\t3\tfailed\n' "$day" "${commits[2]}"
  printf '%s\tlong\t%s\t6\tpassed\n' "$day" 0123456789ab
} >.ci/nightly.tsv

due=$(bash .ci/nightly --due)
line() { awk -v part="$1" '$4 == part { print NR ":" $1 " " $2 " " $3 }' <<<"$due"; }
last=$(wc -l <<<"$due")
[[ $(line windows) == "$last:1 2 33" ]] || fail "windows passed one commit and two days ago: $(line windows)"
[[ $(line browsers) == "$((last - 1)):4 2 9" ]] || fail "browsers passed four commits ago, whatever failed since: $(line browsers)"
[[ $(line slurm) =~ ^[0-9]+:never\ -\ 3$ ]] || fail "what only failed never passed: $(line slurm)"
[[ $(line long) =~ ^[0-9]+:never\ -\ 6$ ]] || fail "a commit of no history says nothing: $(line long)"

for words in '' '--due now' '--next' '--next soon' '--next 5 6' 'no_such_part' '--nothing'; do
  status=0
  # shellcheck disable=SC2086
  said=$(bash .ci/nightly $words 2>&1) || status=$?
  [[ $status == 2 && $said == usage:* ]] || fail "nightly $words: $status, $said"
done
[[ $(bash .ci/nightly --next 0 2>&1) == "no part fits into 0 minutes" ]] || fail "nothing fits into no time"

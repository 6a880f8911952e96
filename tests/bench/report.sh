#!/bin/bash
# report.sh BCCSPLAT_BENCH FOLDER [--quick] [--data DIR]: every suite of the benchmark into FOLDER/report.md, with its plots
# beside it. DIR: real data sets for the suites that can use them. A suite that fails is named, the others still run.
set -uo pipefail
bench=${1:?usage: report.sh BCCSPLAT_BENCH FOLDER [--quick] [--data DIR]} out=${2:?}
shift 2
quick=() data=
while (($#)); do
  case $1 in
  --quick) quick=(--quick) ;;
  --data) data=${2:?--data needs a folder} && shift ;;
  *) echo "report.sh: unknown option $1" >&2 && exit 2 ;;
  esac
  shift
done
mkdir -p "$out/plots"
suites=$("$bench" 2>&1 | sed -n 's/^suites: *//p')
failed=()
{
  echo "# Benchmark report"
  for suite in $suites; do
    printf '\n## %s\n\n' "$suite"
    options=("${quick[@]}" --plots "$out/plots")
    if [[ $suite =~ ^(motion|paper|pictures)$ && -n $data ]]; then options+=(--data "$data"); fi
    start=$SECONDS
    "$bench" "$suite" "${options[@]}" || { failed+=("$suite"); printf '\nThis suite failed.\n'; }
    for plot in "$out/plots/$suite"-*.png; do
      if [[ -e $plot ]]; then printf '\n![%s](plots/%s)\n' "$(basename "$plot" .png)" "$(basename "$plot")"; fi
    done
    echo "$suite: $((SECONDS - start)) s" >&2
  done
} >"$out/report.md"
if ((${#failed[@]})); then
  echo "failed: ${failed[*]}" >&2
  exit 1
fi

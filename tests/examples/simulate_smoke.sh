#!/bin/bash
# simulate_smoke.sh EXAMPLES SCRATCH: the files are there, of the right size, not empty, and the same for any thread count.
set -euo pipefail
simulate=$1/simulate_smoke scratch=$2
rm -rf "$scratch"
mkdir -p "$scratch"

"$simulate" --size 32 --steps 3 --threads 1 --raw -o "$scratch/one"
"$simulate" --size 32 --steps 3 --threads 3 -o "$scratch/three"
for frame in 0000 0001 0002; do
  cmp "$scratch"/{one,three}/smoke.$frame.raw
  [[ $(stat -c %s "$scratch/one/smoke.$frame.raw") == $((32 * 32 * 32 * 4)) ]]
done
# Heat comes with the same smoke, is hottest where it comes in, and none is where no smoke has been.
"$simulate" --size 32 --steps 3 --raw --heat -o "$scratch/hot"
cmp "$scratch"/{one,hot}/smoke.0002.raw
[[ $(stat -c %s "$scratch/hot/heat.0002.raw") == $((32 * 32 * 32 * 4)) && ! -e $scratch/one/heat.0002.raw ]]
od -An -v -tf4 -w4 "$scratch/hot/heat.0002.raw" | awk '
  $1 > 0.5 { hot++ } $1 < 0.001 { cold++ } $1 < 0 || $1 > 1.0001 { wrong++ } END { exit !(hot > 10 && cold > 10000 && !wrong) }'
cmp -s "$scratch"/one/smoke.000{0,2}.raw && echo "nothing moves" && exit 1
# More than half of the box is air, stored as exactly 0, and not all of it.
bytes=$(tr -d '\0' <"$scratch/one/smoke.0002.raw" | wc -c)
((bytes > 1000 && bytes < 32 * 32 * 32 * 2))
if [[ $("$simulate" --help) == *'not built in'* ]]; then
  [[ ! -e $scratch/three/smoke.0000.vdb ]]
else
  [[ $(head -c 4 "$scratch/three/smoke.0002.vdb") == " BDV" ]]
fi

for bad in "--size 17" "--size 8" "--size x" "--steps 0" "--steps" "--nonsense" "-o"; do
  code=0
  # shellcheck disable=SC2086 # an option and its value
  "$simulate" -o "$scratch/bad" $bad 2>/dev/null || code=$?
  [[ $code == 2 ]] || { echo "'$bad' exits $code, not 2" && exit 1; }
done
[[ ! -e $scratch/bad ]]
rm -rf "$scratch"

#!/bin/bash
# gallery.sh EXAMPLES SCRATCH BCC4: the script draws what is there, says what is not, and fails where nothing is. The page
# in the repository has a picture of every set.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
gallery=$here/../../examples/gallery scratch=$2 bcc4=$3
rm -rf "$scratch"
mkdir -p "$scratch"/{data,out,empty}

# A ball of bytes, softer outside, instead of the nucleon: of one value it would be a mask.
awk 'BEGIN { for (z = -20; z <= 20; z++) for (y = -20; y <= 20; y++) for (x = -20; x <= 20; x++) {
  r = x * x + y * y + z * z; printf "%c", r < 144 ? int(120 - r / 3) : 1 } }' | tr '\001' '\000' > "$scratch/data/nucleon_41x41x41_u8.raw"
[[ $(stat -c %s "$scratch/data/nucleon_41x41x41_u8.raw") == $((41 * 41 * 41)) ]]
bash "$gallery/gallery.sh" "$bcc4" "$scratch/data" "$scratch/out" 2> "$scratch/said"
grep -q 'engine is left out' "$scratch/said"
[[ $(ls "$scratch/out") == $'README.md\nnucleon.png' ]]
grep -q '^    bcc4 import nucleon_41x41x41_u8.raw --dims 41,41,41 --dtype u8 -o nucleon.bcc4$' "$scratch/out/README.md"
grep -q '^    bcc4 render nucleon.bcc4 -o nucleon.png    # air .* transparent$' "$scratch/out/README.md"

if bash "$gallery/gallery.sh" "$bcc4" "$scratch/empty" "$scratch/out" 2> "$scratch/said"; then exit 1; fi
grep -q 'none of the sets' "$scratch/said"

grep -v '^#' "$gallery/sets.txt" | while IFS='|' read -r name file _; do
  [[ -s $gallery/$name.png ]]
  grep -q "^    bcc4 import $file " "$gallery/README.md"
done

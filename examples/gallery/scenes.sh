#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Draws the pictures of scenes.md beside this script: two channels of a plume, labels in the CT that they are of, a cloud in
# its own shadow. The plume is simulated, the head made up, the cloud is smoke.vdb of a folder.
#   scenes.sh BCC4 SIMULATE_SMOKE DATA [FOLDER]    FOLDER: of the pictures; the one of this script without it
set -eu
here=$(cd "$(dirname "$0")" && pwd)
bcc4=$1 simulate=$2 data=$3 out=${4:-$here}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

draw() { # FILE PICTURE OPTION...
  file=$1 picture=$2
  shift 2
  "$bcc4" render "$work/$file" --overwrite --quiet --camera persp -o "$out/$picture" "$@"
}

"$simulate" --size 96 --steps 34 --raw --heat -o "$work/plume" 2>"$work/told"
cat "$work/plume/smoke.0033.raw" "$work/plume/heat.0033.raw" >"$work/plume.raw"
"$bcc4" import "$work/plume.raw" --dims 96,96,96 --dtype f32 --count 2 -o "$work/plume.bcc4" --quiet
draw plume.bcc4 plume.png --size 340x380 --zoom 1.35 --rotate-x 10 --rotate-y 15 --opacity 2 --background 0.02,0.02,0.03 \
  --color-channel 1 --color-colormap fire --color-range 0,0.6

python3 "$here/phantom.py" "$work"
for name in ct:i16 labels:u8; do
  "$bcc4" import "$work/${name%:*}.raw" --dims 96,120,112 --dtype "${name#*:}" --spacing 2,2,2 -o "$work/${name%:*}.bcc4" --quiet
done
draw ct.bcc4 labels.png --size 340x380 --zoom 1.35 --rotate-x 12 --rotate-y 25 --background 0.02,0.02,0.03 \
  --range=-200,1400 --colormap gray --opacity 0.25 --with "$work/labels.bcc4,look=labels,opacity=0.3"

if [ -f "$data/smoke.vdb" ]; then
  "$bcc4" import "$data/smoke.vdb" -o "$work/cloud.bcc4" --quiet
  draw cloud.bcc4 cloud.png --size 340x420 --zoom 1.2 --rotate-x 8 --rotate-y 30 --background 0.25,0.32,0.42 \
    --colormap gray --range=-3,1 --opacity 6 --shadow --ao
else
  echo "scenes: $data/smoke.vdb is not there: the cloud is left out" >&2
fi

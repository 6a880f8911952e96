#!/bin/sh
# The pictures of README.md beside this script, from the smoke that examples/quickstart.sh makes: its file smoke-raw.bcc4.
#   pictures.sh BCC4 SMOKE.bcc4 FOLDER
set -eu
here=$(cd "$(dirname "$0")" && pwd)
bcc4=$1 smoke=$2 out=$3

render() {
  "$bcc4" render "$smoke" --overwrite --camera persp --size 600x520 --zoom 1.3 --background 0.02,0.02,0.03 "$@"
}
# The head of the README: the 48 frames.
"$bcc4" render "$smoke" --overwrite --camera persp --rotate-x 10 --rotate-y 15 --zoom 1.25 --size 480x480 --colormap fire --range 0,1 \
  --background 0.02,0.02,0.03 --fps 12 -o "$out/smoke.webp"
# What the plane x = 48 held over time: y to the right, z up, time into the picture.
render --plane 1,0,0,0,-48 --rotate-y 40 --colormap inferno --range 0,0.9 --opacity 3 --no-shading -o "$out/x-slice.png"
# A hyperplane across three axes.
render --plane 0.4,0.2,0,0.6,-34 --rotate-y 40 --colormap inferno --range 0,0.9 --opacity 3 --no-shading -o "$out/oblique-slice.png"
# Solid smoke and where it was during the sixteen frames before: in one space, and as two pictures, one over the other.
moving() {
  render --time 46 --rotate-x 10 --rotate-y 15 --tf "$here/solid.json" --trail-tf "$here/thin.json" "$@"
}
moving --trail 16f -o "$out/trail.png"
# Five parts of twenty frames, from blue to orange.
moving --trail 20f,5 -o "$out/trail-colours.png"
# A surface, and where the smoke was before it, in a function for each of five parts, which nothing lights.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
part=0 parts=
for color in 0.05,0.2,1 0.1,0.55,0.9 0.75,0.8,0.75 0.95,0.65,0.2 1,0.3,0.02; do
  part=$((part + 1)) parts=$parts${parts:+,}$work/part-$part.json
  printf '[{"ColorSpace": "RGB", "Name": "part", "RGBPoints": [0, %s, 1, %s], "Points": [0, 0, 0.5, 0, 0.25, 0, 0.5, 0, 0.3, 0.5, 0.5, 0, 1, 0.5, 0.5, 0]}]' \
    "$color" "$color" > "$work/part-$part.json"
done
render --time 46 --rotate-x 10 --rotate-y 15 --mode iso --iso 0.35 --colormap gray --range=-1,0.6 --trail 20f,5 --trail-tf "$parts" \
  --trail-unlit -o "$out/surface-trail.png"
# Four shells thinner than the steps between the sheets, by one entry of the function per step and pre-integrated.
for how in off on; do
  render --time 46 --rotate-x 10 --rotate-y 15 --tf "$here/shells.json" --preintegrate $how -o "$out/shells-$how.png"
done

#!/bin/bash
# The figures of Neophytou & Mueller 2002 again, with data of our own, on one sheet; after examples/quickstart.sh:
#   paper_figures.sh BUILD OUT SHEET.png [DATA]
# BUILD, OUT: the quickstart's folders build/ and out/. DATA: a folder with the sets of `bccsplat_bench paper`; those that
# are there are drawn below. Needs ImageMagick and python3-numpy.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
# shellcheck source=tests/packages.sh
source "$here/../../tests/packages.sh"
install_missing imagemagick fonts-dejavu-core python3-numpy
build=$(realpath "$1") out=$(realpath "$2") sheet=$3 data=${4:-}
bcc4=$build/importers/bcc4
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export BCCSPLAT_LIBRARY=$build/src/libbccsplat.so.0 PYTHONPATH=$here/../python PYTHONDONTWRITEBYTECODE=1
wide=1200 slate='#0b0e14' slate_values=0.043,0.055,0.078

# Pictures that are compared have one camera.
draw() { "$bcc4" render --fit domain --overwrite --quality fine --quiet "$@"; }
number() { "$bcc4" info "$1" --json | sed -n "s/^ *\"$2\": *\([0-9][0-9]*\),*$/\1/p" | sed -n 1p; }
share() { awk -v a="$1" -v b="$2" 'BEGIN { printf "%.0f %%%%", 100 * a / b }'; }
millions() { awk -v n="$1" 'BEGIN { if (n < 1e6) printf "%.1f k", n / 1e3; else printf "%.2f M", n / 1e6 }'; }
psnr() { compare -metric PSNR "$1" "$2" null: 2>&1 | awk '{ printf "%.1f dB", $1 }'; }

# framed FILE...: all cut to what any of them shows, then to the size of a panel
framed() {
  local box file
  box=$(convert "$@" -fuzz 4% -evaluate-sequence max -format '%@' info:)
  for file in "$@"; do
    convert "$file" -crop "$box" +repage -resize 278x284 -background "$slate" -gravity center -extent 294x300 "$file"
  done
}
# panel FILE TEXT: its text below it
panel() {
  convert "$1" -gravity south -background white -splice 0x24 -font DejaVu-Sans -pointsize 13 -fill '#333' \
    -annotate +0+5 "$2" -bordercolor white -border 3x2 "$work/panel-$(basename "$1")"
}
# row TITLE FILE...: panels side by side
row() {
  local title=$1 files=() file
  shift
  for file in "$@"; do files+=("$work/panel-$file"); done
  rows=$((rows + 1))
  convert "${files[@]}" +append -gravity northwest -background white -extent "${wide}x" -splice 0x30 -font DejaVu-Sans-Bold \
    -pointsize 16 -fill '#222' -annotate +4+8 "$title" "$(printf '%s/row-%02d.png' "$work" "$rows")"
}
rows=0

# Figure 3: one isosurface of the test signal.
/usr/bin/python3 "$here/marschner_lobb.py" "$work/signal"
for signal in published ball; do
  for lattice in fine cc bcc; do
    kernel=default
    if [[ $lattice == fine ]]; then kernel=fine; fi
    draw "$work/signal/$signal-$lattice.bcc4" --iso 0.5 --tf "$here/sand.json" --range 0,1 --kernel $kernel --size 194x180 \
      --rotate-x 40 --rotate-y 20 --zoom 1.5 --background 1,1,1 -o "$work/$signal-$lattice.png"
  done
  case $signal in published) name="as published" ;; ball) name="limited to a ball" ;; esac
  panel "$work/$signal-fine.png" "$name"
  for lattice in cc bcc; do
    panel "$work/$signal-$lattice.png" "${lattice^^}, $(millions "$(number "$work/signal/$signal-$lattice.bcc4" sites_kept)")"
  done
done
row "Figure 3   The signal of Marschner and Lobb on 41³ samples, CC and BCC" {published,ball}-{fine,cc,bcc}.png

# Figures 6 to 9: the smoke on both lattices, slices that are not moments, trails.
smoke=$out/smoke-raw.bcc4
"$bcc4" import "$out/smoke/smoke.%04d.raw" --dims 96,96,96 --dtype f32 --air-threshold 0.004 --lattice cc --quiet \
  -o "$work/smoke-cc.bcc4"
smoke() { draw "$1" --camera persp --size 600x600 --background $slate_values "${@:2}"; }
still() { smoke "$1" --time 44.5 --zoom 1.6 --rotate-x 10 --rotate-y 15 --colormap fire --range 0,1 "${@:2}"; }
still "$work/smoke-cc.bcc4" -o "$work/still-cc.png"
still "$smoke" -o "$work/still-d4.png"
still "$smoke" --kernel paper -o "$work/still-paper.png"
framed "$work"/still-{cc,d4,paper}.png
convert "$work/still-cc.png" "$work/still-d4.png" -compose difference -composite -evaluate multiply 32 \
  "$work/still-difference.png"
cc=$(number "$work/smoke-cc.bcc4" sites_kept) d4=$(number "$smoke" sites_kept)
panel "$work/still-cc.png" "CC: $(millions "$cc") points"
panel "$work/still-d4.png" "D4*: $(millions "$d4") points, $(share "$d4" "$cc")"
panel "$work/still-difference.png" "32 x their difference, $(psnr "$work/still-cc.png" "$work/still-d4.png")"
panel "$work/still-paper.png" "D4*, the Gaussian of the paper"
row "Figure 6   A moment between two frames" still-{cc,d4,difference,paper}.png

across() { smoke "$smoke" --colormap inferno --range 0,0.9 --opacity 3 --no-shading --rotate-y 40 "$@"; }
across --plane 1,0,0,0,-48 -o "$work/slice-x.png"
across --plane 0,1,0,0,-40 -o "$work/slice-y.png"
across --plane 0,0,1,0,-48 -o "$work/slice-z.png"
across --plane 0.4,0.2,0,0.6,-34 -o "$work/slice-oblique.png"
for slice in x y z oblique; do framed "$work/slice-$slice.png"; done
panel "$work/slice-x.png" "x = 48: y, z and time"
panel "$work/slice-y.png" "y = 40: x, z and time"
panel "$work/slice-z.png" "z = 48: x, y and time"
panel "$work/slice-oblique.png" "0.4 x + 0.2 y + 0.6 t = 34"
row "Figure 7   Volumes with time as an axis, and oblique to it" slice-{x,y,z,oblique}.png

moving() { smoke "$smoke" --time 46 --zoom 1.4 --rotate-x 10 --rotate-y 15 --tf "$here/solid.json" "$@"; }
moving -o "$work/trail-none.png"
moving --trail-tf "$here/thin.json" --trail 16f -o "$work/trail.png"
moving --trail-tf "$here/thin.json" --trail 16f --trail-mode post -o "$work/trail-post.png"
moving --trail-tf "$here/thin.json" --trail 20f,5 -o "$work/trail-colours.png"
framed "$work"/trail{-none,,-post,-colours}.png
panel "$work/trail-none.png" "frame 46"
panel "$work/trail.png" "with the 16 frames before, in the sheets"
panel "$work/trail-post.png" "the same, laid over the picture"
panel "$work/trail-colours.png" "20 frames in five colours"
row "Figures 8 and 9   Where it was before" trail{-none,,-post,-colours}.png

# Real sets on both lattices, two sets to a row. name|file|options of the import|of the pictures
sets=('neghip|neghip_64x64x64_u8.raw|--dims 64,64,64 --dtype u8|'
  'fuel|fuel_64x64x64_u8.vti||'
  'tooth|tooth_103x94x161_u8.nrrd||--rotate-x 15 --mode mip --range 40,255'
  'engine|engine_256x256x128_u8.raw.gz|--dims 256,256,128 --dtype u8|--rotate-x 20 --range 60,255'
  'bonsai|bonsai_256x256x256_u8_zlib.vti||--rotate-x 15 --range 45,200'
  'viscous fingers, step 60.5|viscous_fingers_run01_64x64x64x99_u16.nrrd||--index --time 60.5 --rotate-x -75'
  'forecast, frame 2.5|ncep_forecast_36x33x10x7_f32.nc|--channel T|--index --time 2.5 --rotate-y 0'
  'perfusion, frame 4.5|pcasl_52x68x20x10_f32.nii.gz||--index --time 4.5')
pair=()
for set in "${sets[@]}"; do
  IFS='|' read -r name file reading drawing <<<"$set"
  if [[ -z $data || ! -e $data/$file ]]; then continue; fi
  read -ra reading <<<"$reading" && read -ra drawing <<<"$drawing"
  at=$work/${file%%_*}
  "$bcc4" import "$data/$file" "${reading[@]}" --quiet -o "$at.bcc4"
  "$bcc4" import "$data/$file" "${reading[@]}" --lattice cc --quiet -o "$at-cc.bcc4"
  for lattice in "" -cc; do smoke "$at$lattice.bcc4" --colormap viridis "${drawing[@]}" -o "$at-on$lattice.png"; done
  framed "$at"-on{,-cc}.png
  cc=$(number "$at-cc.bcc4" sites_kept) bcc=$(number "$at.bcc4" sites_kept)
  panel "$at-on-cc.png" "$name, CC: $(millions "$cc")"
  panel "$at-on.png" "$(millions "$bcc"), $(share "$bcc" "$cc"); $(psnr "$at-on-cc.png" "$at-on.png")"
  pair+=("${file%%_*}-on-cc.png" "${file%%_*}-on.png")
  if ((${#pair[@]} == 4)); then row "Real sets on CC and BCC or D4*" "${pair[@]}" && pair=(); fi
done
if ((${#pair[@]})); then row "Real sets on CC and BCC or D4*" "${pair[@]}"; fi

convert "$work"/row-*.png -append -bordercolor white -border 6x4 -dither FloydSteinberg -colors 255 -strip \
  -define png:compression-level=9 "PNG8:$sheet"

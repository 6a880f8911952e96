#!/bin/bash
# The figures 3 and 6 to 9 of Neophytou & Mueller 2002 again, composed as theirs from sets of our own, on one sheet:
#   paper_figures.sh BUILD OUT SHEET.png [DATA]
# BUILD, OUT: the quickstart's folders build/ and out/ (examples/quickstart.sh makes them). DATA: a folder with the sets of
# `bccsplat_bench paper`; those that are not there are left out of figure 6, and without the viscous fingers
# and the hurricane the others are of the quickstart's smoke. Needs ImageMagick and python3-numpy.
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
psnr() { { compare -metric PSNR "$1" "$2" null: 2>&1 || true; } | awk '{ printf "%.1f dB", $1 }'; }

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
# row TITLE FILE...: panels side by side; no title: they go on with the row above
row() {
  local title=$1 files=() file
  shift
  for file in "$@"; do files+=("$work/panel-$file"); done
  rows=$((rows + 1))
  local heading=()
  if [[ -n $title ]]; then
    heading=(-splice 0x30 -font DejaVu-Sans-Bold -pointsize 16 -fill '#222' -annotate +4+8 "$title")
  fi
  convert "${files[@]}" +append -gravity northwest -background white -extent "${wide}x" "${heading[@]}" \
    "$(printf '%s/row-%02d.png' "$work" "$rows")"
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

# both NAME FILE IMPORT...: the file on CC and on BCC or D4*, at the source's distances
both() {
  local name=$1 file=$2
  shift 2
  "$bcc4" import "$file" "$@" --lattice cc --quiet -o "$work/$name-cc.bcc4"
  "$bcc4" import "$file" "$@" --lattice d4star --quiet -o "$work/$name-bcc.bcc4"
}
# above_below NAME TEXT RENDER...: the same picture of both, panels NAME-cc and NAME-bcc; volumes $of-cc, $of-bcc
above_below() {
  local name=$1 text=$2
  shift 2
  smoke "$work/$of-cc.bcc4" "$@" -o "$work/$name-cc.png"
  smoke "$work/$of-bcc.bcc4" "$@" -o "$work/$name-bcc.png"
  framed "$work/$name"-{cc,bcc}.png
  local db
  db=$(psnr "$work/$name-cc.png" "$work/$name-bcc.png")
  panel "$work/$name-cc.png" "$text, CC"
  panel "$work/$name-bcc.png" "$lattice, $(share "$(number "$work/$of-bcc.bcc4" sites_kept)" \
    "$(number "$work/$of-cc.bcc4" sites_kept)") of the points, $db"
}
smoke() { draw "$1" --camera persp --size 600x600 --background $slate_values "${@:2}"; }

# Figure 6: volumes, CC above and BCC below. name|file|options of the import|of the pictures
sets=('engine|engine_256x256x128_u8.raw.gz|--dims 256,256,128 --dtype u8|--rotate-x 20 --range 60,255'
  'tooth|tooth_103x94x161_u8.nrrd||--rotate-x 15 --mode mip --range 40,255'
  'bonsai|bonsai_256x256x256_u8_zlib.vti||--rotate-x 15 --range 45,200'
  'neghip|neghip_64x64x64_u8.raw|--dims 64,64,64 --dtype u8|'
  'fuel|fuel_64x64x64_u8.vti||')
drawn=() lattice=BCC
for set in "${sets[@]}"; do
  IFS='|' read -r name file reading drawing <<<"$set"
  if [[ -z $data || ! -e $data/$file ]]; then
    echo "paper_figures.sh: left out of figure 6 for want of its file: $name" >&2
    continue
  fi
  if ((${#drawn[@]} == 4)); then break; fi
  read -ra reading <<<"$reading" && read -ra drawing <<<"$drawing"
  of=$name
  both "$name" "$data/$file" "${reading[@]}"
  above_below "$name" "$name" --colormap viridis "${drawing[@]}"
  drawn+=("$name")
done
if ((${#drawn[@]})); then
  row "Figure 6   Volumes on CC (above) and on BCC (below)" "${drawn[@]/%/-cc.png}"
  row "" "${drawn[@]/%/-bcc.png}"
fi

# The series of figures 7 and 8: salt fingers that sink like jets; without DATA the quickstart's smoke.
lattice='D4*' of=series
fingers=${data:+$data/viscous_fingers_run01_64x64x64x99_u16.nrrd}
if [[ -e $fingers ]]; then
  both series "$fingers"
  title="viscous fingers" view=(--index --rotate-x -75 --rotate-y 20 --colormap viridis)
  moments=(12.5 28.5 44.5 76.5)
  planes=("1,0,0,0,-32|x = 32" "0,1,0,0,-32|y = 32" "0,0,1,0,-30|z = 30" "0.4,0,-0.6,0.5,-20|0.4 x - 0.6 z + 0.5 t = 20")
else
  echo "paper_figures.sh: figures 7 and 8 are of the quickstart's smoke: no viscous fingers" >&2
  "$bcc4" import "$out/smoke/smoke.%04d.raw" --dims 96,96,96 --dtype f32 --air-threshold 0.004 --lattice cc --quiet \
    -o "$work/series-cc.bcc4"
  cp "$out/smoke-raw.bcc4" "$work/series-bcc.bcc4"
  title="smoke" view=(--index --rotate-x 10 --rotate-y 15 --colormap fire --range '0,1')
  moments=(8.5 20.5 32.5 44.5)
  planes=("1,0,0,0,-48|x = 48" "0,1,0,0,-40|y = 40" "0,0,1,0,-48|z = 48" "0.4,0.2,0,0.6,-34|0.4 x + 0.2 y + 0.6 t = 34")
fi

n=0
for plane in "${planes[@]}"; do
  above_below "plane-$((++n))" "${plane#*|}" --plane "${plane%|*}" --colormap inferno --rotate-y 40
done
row "Figure 7   Hyperslices of $title: volumes with time as an axis, and oblique to it, CC above" plane-{1,2,3,4}-cc.png
row "" plane-{1,2,3,4}-bcc.png

n=0
for moment in "${moments[@]}"; do above_below "jet-$((++n))" "step $moment" --time "$moment" "${view[@]}"; done
row "Figure 8   Moments between the steps of $title, CC above" jet-{1,2,3,4}-cc.png
row "" jet-{1,2,3,4}-bcc.png

# Figure 9: time steps, and the last of them with what it was before, joined by equation (8); below by extinctions along
# the ray, and with a transfer function for each of four sub-intervals. The eye of a hurricane, else the smoke.
# one_colour NAME R,G,B LOW,HIGH OPACITY: one colour, of an opacity that rises from LOW to HIGH
one_colour() {
  local low=${3%,*} high=${3#*,}
  printf '[{"Name": "%s", "ColorSpace": "RGB", "RGBPoints": [%s, %s, %s, %s], "Points": [%s, 0, 0.5, 0, %s, %s, 0.5, 0]}]' \
    "$1" "$low" "$2" "$high" "$2" "$low" "$high" "$4" >"$work/$1.json"
}
hurricane=${data:+$data/isabel_windspeed_125x125x25x12_u16.nrrd}
if [[ -e $hurricane ]]; then
  moving=$work/hurricane.bcc4 title="a hurricane's eye" view=(--index --rotate-x 10 --rotate-y 0 --zoom 1.1)
  steps=(1 5 9) level=42000 seen=42000,50000
  "$bcc4" import "$hurricane" --lattice d4star --quiet -o "$moving"
else
  moving=$work/series-bcc.bcc4 title="smoke" view=(--index --rotate-x 10 --rotate-y 15 --zoom 1.4)
  steps=(30 38 46) level=0.25 seen=0.15,0.5
fi
one_colour now "0.95, 0.8, 0.3" "$level,${seen#*,}" 1
one_colour past "0.35, 0.6, 0.9" "$seen" 0.5
one_colour part-1 "0.2, 0.3, 0.95" "$seen" 0.8
one_colour part-2 "0.3, 0.7, 0.7" "$seen" 0.8
one_colour part-3 "0.5, 0.8, 0.3" "$seen" 0.8
one_colour part-4 "0.9, 0.45, 0.2" "$seen" 0.8
surface() { smoke "$moving" "${view[@]}" --tf "$work/now.json" --mode iso --iso "$level" "$@"; }
first=${steps[0]} last=${steps[2]}
back=$((last - first))
for step in "${steps[@]}"; do surface --time "$step" -o "$work/step-$step.png"; done
surface --time "$last" --trail "${back}f" --trail-tf "$work/past.json" --trail-mode interleaved -o "$work/trail-equation.png"
surface --time "$last" --trail "${back}f" --trail-tf "$work/past.json" -o "$work/trail-physical.png"
surface --time "$last" --trail "${back}f,4" --trail-tf "$(printf "$work/part-%d.json," 1 2 3)$work/part-4.json" \
  -o "$work/trail-functions.png"
framed "$work"/step-*.png "$work"/trail-{equation,physical,functions}.png
for step in "${steps[@]}"; do panel "$work/step-$step.png" "step $step"; done
panel "$work/trail-equation.png" "step $last and the $back before, equation (8)"
panel "$work/trail-physical.png" "the same, extinctions along the ray"
panel "$work/trail-functions.png" "a function for each of four sub-intervals"
row "Figure 9   Steps of $title, and the last one with its trail" "step-$first.png" "step-${steps[1]}.png" \
  "step-$last.png" trail-equation.png
row "" trail-physical.png trail-functions.png

convert "$work"/row-*.png -append -bordercolor white -border 6x4 -dither FloydSteinberg -colors 255 -strip \
  -define png:compression-level=9 "PNG8:$sheet"

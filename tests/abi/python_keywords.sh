#!/bin/bash
# python_keywords.sh PACKAGE: mypy finds keywords that are misspelt, and takes those that are right. Exits with 77 without mypy.
set -euo pipefail
command -v mypy >/dev/null || { echo "skipped: no mypy" && exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
right='import bccsplat
import numpy as np
v = bccsplat.open("a.bcc4", kernel="fine", cache_bytes=1 << 20, salvage=1)
v.show(1.0, width=64, look="ct_bone", rotate_x=10, background=None, mode="maximum", quality="draft", shading="none")
v.slice(time=1.0, channel=0, spacing=0.5, kernel="fine", level=1, space="even", thickness=2.0)
v.plane(1.0, z=3.5, level=0)
bccsplat.save("b.bcc4", np.zeros((2, 3, 4, 5)), dt=0.5, abs_error={"value": 0.1}, levels=1, lattice="cc", overwrite=True)
for place, crop in v.crops((1, 2, 3, 4), seed=1, count=3): print(place, crop.sum())
copy: bccsplat.Volume = v.share()'
check() { (cd "$folder" && MYPYPATH=$(dirname "$1") mypy --strict --cache-dir="$folder/cache" use.py); }
printf '%s\n' "$right" > "$folder/use.py"
check "$1"
for wrong in 'cache_bytes=:cache_byte=' 'look=:looks=' 'rotate_x=:rotatex=' 'mode=:mod=' 'quality=:qualty=' 'spacing=:spaceing=' \
  'space=:spac=' 'thickness=:thicknes=' 'level=1:levl=1' 'abs_error=:abs_eror=' 'levels=:level=' 'lattice=:latice=' 'seed=:sead='; do
  printf '%s\n' "${right/"${wrong%%:*}"/"${wrong#*:}"}" > "$folder/use.py"
  ! cmp -s <(printf '%s\n' "$right") "$folder/use.py"
  found=$(check "$1") && { echo "mypy takes ${wrong#*:}" >&2 && exit 1; }
  grep -q "Unexpected keyword argument\|No overload\|incompatible type" <<<"$found" || { echo "$found" >&2 && exit 1; }
done

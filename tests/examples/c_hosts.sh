#!/bin/bash
# c_hosts.sh EXAMPLES SCRATCH: one host samples the lattice and writes a volume, the other draws it.
set -euo pipefail
examples=$1 scratch=$2
rm -rf "$scratch"
mkdir -p "$scratch"
cd "$scratch"

"$examples/write_in_situ" blobs.bcc4
"$examples/render_frame" blobs.bcc4 first.png 0
"$examples/render_frame" blobs.bcc4 again.png 0
"$examples/render_frame" blobs.bcc4 middle.png
"$examples/render_frame" blobs.bcc4 between.png 8.5
# A PNG of 512 x 512: signature, then the header chunk with both sizes.
for picture in first middle between; do
  head=$(od -A n -t x1 -N 24 $picture.png | tr -d ' \n')
  [[ $head == 89504e470d0a1a0a0000000d494844520000020000000200 ]]
done
cmp first.png again.png
for other in middle between; do
  if cmp -s first.png $other.png; then echo "nothing moves" && exit 1; fi
done
if cmp -s middle.png between.png; then echo "half a frame makes no difference" && exit 1; fi

"$examples/scene_host" blobs.bcc4 scene.png 4 >report
grep -q "^right eye: level 0, 0.0 ms to cut" report
"$examples/scene_host" blobs.bcc4 later.png 8 >report
head=$(od -A n -t x1 -N 24 scene.png | tr -d ' \n')
[[ $head == 89504e470d0a1a0a0000000d49484452000003c0000001e0 ]] # 960 x 480
if cmp -s scene.png later.png; then echo "nothing moves in the scene" && exit 1; fi

if "$examples/render_frame" missing.bcc4 none.png 2>message; then exit 1; fi
grep -q missing.bcc4 message
if "$examples/render_frame" blobs.bcc4 none.png 99 2>message; then exit 1; fi
grep -q OUT_OF_DOMAIN message
if "$examples/write_in_situ" no-such-folder/blobs.bcc4 2>message; then exit 1; fi
grep -q no-such-folder message
[[ ! -e none.png ]]
cd /
rm -rf "$scratch"

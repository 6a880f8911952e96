#!/bin/bash
# texture_host.sh EXAMPLES SCRATCH: a host draws a volume into its own texture, by whatever OpenGL there is. Exits with 77
# where there is none.
set -euo pipefail
examples=$1 scratch=$2
rm -rf "$scratch"
mkdir -p "$scratch"
cd "$scratch"
"$examples/write_in_situ" blobs.bcc4 >/dev/null
if ! "$examples/texture_host" blobs.bcc4 first.ppm 4 >told 2>message; then
  grep -q 'no EGL\|no context' message && echo "skipped: no OpenGL: $(<message)" && exit 77
  cat message && exit 1
fi
"$examples/texture_host" blobs.bcc4 again.ppm 4
"$examples/texture_host" blobs.bcc4 later.ppm 8
cmp first.ppm again.ppm
if cmp -s first.ppm later.ppm; then echo "nothing moves in the texture" && exit 1; fi
# The volume is in the middle, over the sky that the host has drawn: its upper corner is as it was.
python3 - first.ppm <<'PYTHON'
import sys
data = open(sys.argv[1], 'rb').read()
assert data.startswith(b'P6\n320 240\n255\n') and len(data) == 15 + 3 * 320 * 240
pixel = lambda x, y: tuple(data[15 + 3 * (320 * y + x):][:3])
sky, rows = pixel(0, 0), [pixel(x, y) for y in range(240) for x in range(320)]
assert all(abs(a - b) <= 1 for a, b in zip(sky, (39, 89, 149))), sky
seen = sum(max(abs(a - b) for a, b in zip(p, pixel(0, n // 320))) > 8 for n, p in enumerate(rows))
assert 320 * 240 // 50 < seen < 320 * 240, seen
PYTHON
if "$examples/texture_host" missing.bcc4 none.ppm 2>message; then exit 1; fi
grep -q missing.bcc4 message
[[ ! -e none.ppm ]]
cd /
rm -rf "$scratch"

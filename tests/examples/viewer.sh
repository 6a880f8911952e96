#!/bin/bash
# viewer.sh EXAMPLES SCRATCH: the viewer on a virtual screen, moved by a real mouse: orbit, time, tilt, trail. The window
# is saved. A second time the series is played, others cut it open and show isosurfaces. Exits with 77 where the viewer was not built or Xvfb or xdotool are missing.
set -euo pipefail
examples=$1 scratch=$2
[[ -x $examples/viewer ]] && command -v xvfb-run >/dev/null && command -v xdotool >/dev/null ||
  { echo "skipped: no viewer, Xvfb or xdotool" && exit 77; }
rm -rf "$scratch"
mkdir -p "$scratch"
cd "$scratch"
"$examples/write_in_situ" blobs.bcc4 >/dev/null

mkdir bin
printf '#!/bin/bash\nwc -c >"${@: -1}"\n' >bin/ffmpeg
chmod +x bin/ffmpeg

cat >session.sh <<'SESSION'
set -euo pipefail
at_rest() { timeout 100 xdotool search --sync --name 'at rest' >/dev/null; }
open() { # what is told goes to $2; then options
  "$1/viewer" blobs.bcc4 "${@:3}" window.bmp >"$2" &
  viewer=$!
  window=$(timeout 60 xdotool search --sync --onlyvisible --name 'bccsplat viewer' | head -1)
  xdotool windowmove --sync "$window" 0 0 || true
  at_rest
}
close() {
  xdotool key --window "$window" q
  for _ in $(seq 100); do
    kill -0 $viewer 2>/dev/null || break
    sleep 0.2
  done
  wait $viewer
}
trap 'kill $viewer 2>/dev/null || true' EXIT
open "$1" told
drag() { # X Y, then steps DX DY
  xdotool mousemove "$1" "$2"
  sleep 0.2
  xdotool mousedown 1
  sleep 0.3
  for _ in 1 2 3 4 5 6 7 8; do
    xdotool mousemove_relative -- "$3" "$4"
    sleep 0.05
  done
  xdotool mouseup 1
  sleep 0.3
}
drag 600 300 15 8   # orbit
drag 120 35 12 0    # the frame slider
at_rest
xdotool mousemove 18 350 click 1 # the trail
xdotool windowfocus "$window" || true
sleep 1
at_rest
# There and back faster than any picture of the trail is drawn: each wish cancels the one before.
hurry=(mousemove 600 300 mousedown 1 sleep 0.3)
for step in 2 2 2 2 2 2 2 2 -2 -2 -2 -2 -2 -2 -2 -2; do
  hurry+=(mousemove_relative -- $step 0 sleep 0.01)
done
xdotool "${hurry[@]}" sleep 0.3 mouseup 1
sleep 0.5
at_rest
close
# 16 frames, four a second, and round again, recorded by a program that counts what it gets; at rest when it is stopped.
PATH=$PWD/bin:$PATH open "$1" played
xdotool mousemove 600 300
xdotool key --window "$window" r
xdotool key --window "$window" space
sleep 6
xdotool key --window "$window" space
sleep 1
at_rest
close
# The same by an OpenGL of any kind, where there is one.
if [[ -x $1/texture_host ]] && "$1/texture_host" blobs.bcc4 texture.ppm; then
  open "$1" by_gpu --gpu on
  xdotool key --window "$window" space
  sleep 6
  xdotool key --window "$window" space
  sleep 1
  at_rest
  close
fi
open "$1" pictures
xdotool key --window "$window" r
sleep 1
close
cp window.bmp whole.bmp
# Cut open along x, a twentieth beyond the middle.
open "$1" cut
xdotool mousemove 600 300
xdotool key --window "$window" x
xdotool key --window "$window" bracketright
sleep 1
at_rest
close
cp window.bmp cut.bmp
# Isosurfaces by a key, moved by another, and given.
open "$1" iso
xdotool mousemove 600 300
xdotool key --window "$window" i
sleep 1
at_rest
xdotool key --window "$window" Up
xdotool key --window "$window" Up
xdotool key --window "$window" Down
xdotool key --window "$window" Up
sleep 1
at_rest
close
cp window.bmp palette.bmp
open "$1" given --iso '.35:.5:#0000ff,.7'
close
SESSION
xvfb-run -a -s "-screen 0 1000x680x24" bash session.sh "$examples"
cat told played
read -r _ drafts _ fine _ cancelled _ rotate_x rotate_y _ frame _ rounds _ <told
((rounds == 0))
# Drafts while the mouse moved, one fine picture at rest before and after, and drawing was cancelled for newer wishes.
((drafts >= 3 && fine >= 2 && cancelled >= 1))
# The picture turned by the mouse's way, 0.4 degrees a pixel, and the slider went on from the middle.
awk -v x="$rotate_x" -v y="$rotate_y" -v f="$frame" \
  'BEGIN { exit !(x > 30 && x < 50 && y > 50 && y < 90 && f > 8.5 && f <= 16) }'
[[ $(stat -c %s window.bmp) -gt 2000000 ]]
# Played: drafts alone while it ran.
read -r _ drafts _ fine _ _ _ _ _ _ _ _ rounds _ <played
((drafts >= 5 && fine <= 3 && rounds >= 1))
# What moments needed was read before they were drawn, in another thread.
grep -q ' waited for 0 B by ' played
if [[ -e by_gpu ]]; then
  cat by_gpu
  grep -q ' waited for 0 B by gpu$' by_gpu
fi
# A film as long as it was played, of whole pictures.
bytes=$(<viewer-1.mp4) picture=$((670 * 680 * 4))
((bytes % picture == 0 && bytes / picture > 150))
# Without ffmpeg the pictures themselves.
if command -v ffmpeg >/dev/null; then
  ffprobe -v error -count_frames -show_entries stream=width,height,nb_read_frames -of csv viewer-2.mp4 | tee film
  grep -q '^stream,670,680,' film
else
  [[ $(head -c 4 viewer-2.0001.png) == *PNG ]]
fi
# The value of the file's look, and two hundredths of the range more; that range is 1 here, or nearly.
surface() { sed -n 's/.* iso \([01]\) value \([^ ]*\) .*/\1 \2/p' "$1"; }
cat iso given
read -r shown value < <(surface pictures)
((shown == 0))
read -r moved_shown moved < <(surface iso)
((moved_shown == 1))
awk -v a="$value" -v b="$moved" 'BEGIN { exit !(b > a + .015 && b < a + .025) }'
[[ $(surface given) == "1 0.35" ]]
# The colours of the palette are red rather than blue, the surface that was given is blue.
blue_over_red() { # of the window right of the panel
  python3 - "$1" <<'PYTHON'
import struct, sys
data = open(sys.argv[1], 'rb').read()
start, width, height = struct.unpack_from('<I', data, 10)[0], *struct.unpack_from('<ii', data, 18)
step = struct.unpack_from('<H', data, 28)[0] // 8
pitch = (width * step + 3) // 4 * 4
rows = [data[start + y * pitch + 330 * step:start + (y * pitch + width * step)] for y in range(abs(height))]
blue, red = (sum(sum(row[c::step]) for row in rows) for c in (0, 2))
print(blue > red, blue + red > 10 ** 6)
PYTHON
}
[[ $(blue_over_red palette.bmp) == "False True" && $(blue_over_red window.bmp) == "True True" ]]
# Much of the light is cut away, and much stays.
grep -q 'open 000 to 0.50 ' pictures
grep -q 'open 100 to 0.55 ' cut
light() { # of the window right of the panel
  python3 - "$1" <<'PYTHON'
import struct, sys
data = open(sys.argv[1], 'rb').read()
start, width, height = struct.unpack_from('<I', data, 10)[0], *struct.unpack_from('<ii', data, 18)
step = struct.unpack_from('<H', data, 28)[0] // 8
pitch = (width * step + 3) // 4 * 4
print(sum(sum(data[start + y * pitch + 330 * step:start + (y * pitch + width * step)]) for y in range(abs(height))))
PYTHON
}
black=$(((1000 - 330) * 680 * 255)) # opacity is a fourth byte
awk -v whole="$(light whole.bmp)" -v cut="$(light cut.bmp)" -v black="$black" \
  'BEGIN { part = (cut - black) / (whole - black); print "of the light", part; exit !(part > .1 && part < .9) }'
# What makes no sense is refused before a window opens.
if "$examples/viewer" blobs.bcc4 --gpu maybe 2>words; then exit 1; fi
grep -q 'auto, on or off is expected' words
for wrong in 'x' '.5:2' '.5:1:red' '.5,' ''; do
  if "$examples/viewer" blobs.bcc4 --iso "$wrong" 2>words; then exit 1; fi
  grep -q 'is expected' words
done
code=0
"$examples/viewer" blobs.bcc4 --isos 2>words || code=$?
((code == 2)) && grep -q -- '--iso' words

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Draws the gallery anew, README.md and its pictures beside this script, from the sets of sets.txt that are in a folder.
#   gallery.sh BCC4 DATA [FOLDER]    FOLDER: of the pictures and the page; the one of this script without it
set -eu
here=$(cd "$(dirname "$0")" && pwd)
bcc4=$1 data=$2 out=${3:-$here}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat "$here/head.md" > "$out/README.md"
drawn=0
while IFS='|' read -r name file arguments what; do
  case $name in '' | '#'*) continue ;; esac
  [ -f "$data/$file" ] || { echo "gallery: $data/$file is not there: $name is left out" >&2; continue; }
  # Arguments are words without spaces.
  # shellcheck disable=SC2086
  "$bcc4" import "$data/$file" $arguments -o "$work/$name.bcc4" --quiet
  told=$("$bcc4" render "$work/$name.bcc4" --overwrite -o "$out/$name.png" --size 320x320 2>&1 >/dev/null | sed '/^render  /d; s/^bcc4: [^:]*: //; s/; --tf.*//' |
    paste -sd ';' - | sed 's/; */; /g')
  rm "$work/$name.bcc4"
  drawn=$((drawn + 1))
  cat >> "$out/README.md" <<END

### $what

![$name]($name.png)

    bcc4 import $file${arguments:+ $arguments} -o $name.bcc4
    bcc4 render $name.bcc4 -o $name.png${told:+    # $told}
END
done < "$here/sets.txt"
[ "$drawn" -gt 0 ] || { echo "gallery: none of the sets is in $data" >&2; exit 1; }

#!/bin/bash
# seeds.sh unpack TARGET FOLDER | pack TARGET FOLDER: the seeds of a fuzz target, corpus/TARGET.tar.xz, as files in a folder
# and back. Equal files make an equal archive, whoever packs it and when.
set -euo pipefail
usage="usage: seeds.sh unpack|pack TARGET FOLDER"
archive=$(cd "$(dirname "$0")" && pwd)/corpus/${2:?$usage}.tar.xz folder=${3:?$usage}
case $1 in
unpack)
  mkdir -p "$folder"
  tar -xJf "$archive" -C "$folder"
  ;;
pack)
  cd "$folder"
  find . -type f -printf '%P\n' | LC_ALL=C sort |
    tar -c --format=ustar --owner=0 --group=0 --numeric-owner --mtime=@0 --mode=644 --verbatim-files-from -T - |
    xz -9e >"$archive"
  ;;
*) echo "$usage" >&2 && exit 2 ;;
esac

#!/bin/bash
# host.sh SCRATCH NAME HOST...: one test of the C host, in a folder of its own, with a locale whose decimal point is a
# comma where one can be made.
set -euo pipefail
scratch=$1 name=$2
shift 2
rm -rf "$scratch"
mkdir -p "$scratch"
if command -v localedef >/dev/null && [[ -e /usr/share/i18n/locales/de_DE ]]; then
  localedef -i de_DE -f UTF-8 "$scratch/bccsplat_comma" >/dev/null 2>&1 || true
fi
[[ -d $scratch/bccsplat_comma ]] && export LOCPATH=$scratch
"$@" "$scratch" "$name"
rm -rf "$scratch"

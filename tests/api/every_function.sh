#!/bin/bash
# every_function.sh SYMBOLS FOLDER: every exported function is called by the C hosts in FOLDER, and every fallible one
# is refused something.
set -euo pipefail
symbols=$1 folder=$2
code=$(cat "$folder"/*.c)
missing=0
while read -r symbol; do
  if ! grep -q "$symbol(\|, $symbol," <<<"$code"; then
    echo "$symbol is not called" && missing=1
  fi
  case $symbol in
  *_retain | *_release | *_version | *_name | *_info | *_error) continue ;;
  *_save_*) continue ;; # through a pointer, both alike
  esac
  if ! tr '\n' ' ' <<<"$code" | grep -q "REFUSED([^;]*$symbol("; then
    echo "$symbol is never refused anything" && missing=1
  fi
done <"$symbols"
exit "$missing"

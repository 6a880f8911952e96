#!/bin/sh
# check.sh DUMP FILE: a good file prints what stands beside it in NAME.txt, a bad one (bad_*) is refused.
set -eu
dump=$1
file=$2
case ${file##*/} in
bad_*)
  status=0
  "$dump" "$file" >/dev/null || status=$?
  if [ "$status" -ne 1 ]; then
    echo "exit code $status, 1 expected" >&2
    exit 1
  fi
  ;;
*) "$dump" "$file" | diff - "${file%.bcc4}.txt" ;;
esac

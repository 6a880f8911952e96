#!/bin/bash
# python_types.sh PACKAGE: its annotations are complete and right. Exits with 77 without mypy.
set -euo pipefail
command -v mypy >/dev/null || { echo "skipped: no mypy" && exit 77; }
exec mypy --strict --cache-dir=/dev/null "$1"

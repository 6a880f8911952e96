#!/bin/bash
# aligned_moves.sh FILE.dll: no move of 32 or 64 bytes wants an address aligned to as much. Windows aligns stacks to 16
# bytes, where GCC takes them for aligned to what it spills.
set -euo pipefail
code=$(mktemp)
trap 'rm -f "$code"' EXIT
x86_64-w64-mingw32-objdump -d --no-show-raw-insn "${1:?usage: aligned_moves.sh FILE.dll}" >"$code"
wide=$(grep -cE 'vmov[a-z0-9]+ .*%[yz]mm' "$code" || true)
echo "$wide moves of wide vectors"
((wide > 0)) || { echo "FAILED: none, so that nothing was looked at" >&2; exit 1; }
if grep -E 'vmov(ap[sd]|dqa(32|64)?) .*\(.*%[yz]mm|vmov(ap[sd]|dqa(32|64)?) +%[yz]mm[0-9]+,.*\(' "$code" | head -5 | grep .; then
  echo "FAILED: these fault where the stack is aligned to 16 bytes" >&2
  exit 1
fi

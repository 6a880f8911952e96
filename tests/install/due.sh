# Sourced by tests of packages, which take minutes: goes on where something changed that packages are made of since the change
# began (.ci/base.sh), where that is not known, and with BCCSPLAT_LONG=1; else ends the test as skipped, with 77.
# shellcheck shell=bash
due_top=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
made_of=(CMakeLists.txt src/cmake '*/CMakeLists.txt' '*/modules.cmake' LICENSE examples/packages examples/python tests/install ':!tests/[!i]*')
if [[ -z ${BCCSPLAT_LONG:-} ]] && due_base=$(bash "$due_top/.ci/base.sh" 2>/dev/null) && [[ -n $due_base ]] &&
  git -C "$due_top" diff --quiet "$due_base" -- "${made_of[@]}" 2>/dev/null &&
  [[ -z $(git -C "$due_top" ls-files --others --exclude-standard -- "${made_of[@]}") ]]; then
  echo "SKIPPED: NOTHING THAT PACKAGES ARE MADE OF CHANGED since ${due_base:0:8}; BCCSPLAT_LONG=1 runs this test all the same"
  exit 77
fi

#!/bin/bash
# coverage.sh [LEAST]: which lines of src and formats the unit, api, stability and fault tests reach: a table by file, the
# least covered last, and the share of all; fails when that is under LEAST per cent (90). About 20 minutes of CPU time, so no part
# of .ci/run; its build stays in build-coverage.
set -uo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
cd "$top" || exit 1
# shellcheck source=tests/packages.sh
source tests/packages.sh
install_missing gcovr "${build_packages[@]}" libgtest-dev || exit 1

# Counters are shared by threads, so updates are atomic. Libraries that are not instrumented are left out, as
# for the sanitizers.
flags="-O1 -g1 --coverage -fprofile-update=atomic"
cmake -S . -B build-coverage -G Ninja "${launchers[@]}" -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG="$flags" \
  -DCMAKE_CXX_FLAGS_DEBUG="$flags" -DBCCSPLAT_WITH_OPENVDB=OFF -DBCCSPLAT_BUILD_TOOL=OFF -DBCCSPLAT_BUILD_BENCH=OFF \
  -DBCCSPLAT_BUILD_EXAMPLES=OFF || exit 1
find build-coverage -name '*.gcda' -delete
cmake --build build-coverage --target bccsplat_unit bccsplat_api bccsplat_stability bccsplat_faults bccsplat_c_host || exit 1
# Tests of reaction times mean nothing here, and a test that fails is a matter of .ci/run.
ctest --test-dir build-coverage -L 'unit|stability|^api$|faults' -E 'Reaction|plugin|budget' -j "$(nproc)" | tail -12

report=$(mktemp)
trap 'rm -f "$report"' EXIT
gcovr -r . build-coverage --filter 'src/' --filter 'formats/' --fail-under-line "${1:-90}" --sort-percentage -j "$(nproc)" \
  --txt "$report"
status=$?
cat "$report"
exit "$status"

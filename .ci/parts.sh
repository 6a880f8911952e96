# Sourced by run and nightly, in the top folder: the parts that both have.
# shellcheck source=tests/packages.sh
source tests/packages.sh

# part NAME COMMAND...: into failed, when it did, with the lines that say what: of a long log often the end alone is kept.
part() {
  local start=$SECONDS log
  log=$(mktemp)
  printf '\n==== %s\n' "$1"
  "${@:2}" 2>&1 | tee "$log" || failed+=("$1$(reasons "$log")")
  rm "$log"
  echo "==== $1: $((SECONDS - start)) s"
}
reasons() {
  grep -E '\[  FAILED  \]|\*\*\*|(error|warning|performance|portability): |runtime error|AddressSanitizer: |ThreadSanitizer: ' "$1" |
    tail -n 8 | cut -c 1-200 | awk '{ printf "\n  %s", $0 }'
}

# cpp_checked SOURCE...: cppcheck on sources, or on all in folders
cpp_checked() {
  cppcheck --quiet --std=c++20 --language=c++ --enable=warning,performance,portability --inline-suppr --error-exitcode=1 \
    --suppress=missingIncludeSystem --suppress=unknownMacro --suppressions-list=.ci/cppcheck.txt -j "$(nproc)" -I src -I . -I include -I importers \
    "$@"
}

# Address space layout randomisation is off where that is allowed: thread sanitizer does not start under the many bits of
# recent kernels.
fixed() {
  if setarch "$(uname -m)" -R true 2>/dev/null; then setarch "$(uname -m)" -R "$@"; else "$@"; fi
}

# sanitized_build FOLDER SANITIZERS TEST-FILES SHARDS TARGET...
# Without OpenVDB and the tool, whose libraries are not instrumented. In batches (src/cmake/unity.cmake), for the time; without
# warnings, which the plain build gives: GCC 12 has false ones for what it instruments.
sanitized_build() {
  cmake -S . -B "$1" -G Ninja "${launchers[@]}" -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG="-O1 -g1" \
    -DCMAKE_CXX_FLAGS_DEBUG="-O1 -g1 -w" -DCMAKE_UNITY_BUILD=ON -DBCCSPLAT_SANITIZE="$2" -DBCCSPLAT_TEST_FILES="$3" \
    -DBCCSPLAT_TEST_SHARDS="$4" \
    -DBCCSPLAT_WITH_OPENVDB=OFF -DBCCSPLAT_BUILD_TOOL=OFF -DBCCSPLAT_BUILD_BENCH=OFF -DBCCSPLAT_BUILD_EXAMPLES=OFF &&
    fixed cmake --build "$1" --target "${@:5}"
}
sanitized_tests() { # FOLDER CTEST-ARGUMENT...
  fixed ctest --test-dir "$1" --output-on-failure --no-tests=error -j "$(nproc)" "${@:2}"
}

# Of float-*, which undefined leaves out, the stability tests alone must be clean. The tests are dealt out to shards, of
# which three thirds are made.
# address_build [SANITIZERS]: with more of them
address_build() {
  sanitized_build build-asan "address,undefined,float-divide-by-zero,float-cast-overflow${1:+,$1}" "" 33 \
    bccsplat_unit bccsplat_api bccsplat_stability bccsplat_c_host
}
# address_third THIRD [FILTER]: every third test of the C API, the stability and the units, of these only what FILTER leaves.
address_third() {
  local others
  others="third_$((($1 + 1) % 3))|third_$((($1 + 2) % 3))"
  sanitized_tests build-asan -L 'stability|^api$' -LE "$others" &&
    GTEST_FILTER=${2:-*} sanitized_tests build-asan -L unit -LE "$others"
}

# test_names FOLDER LABELS: the tests with such labels, by name, from another one on with every commit.
test_names() {
  ctest --test-dir "$1" -N -L "$2" | sed -n 's/^ *Test *#[0-9]*: //p' |
    awk -v first="$(git rev-list --count HEAD)" '{ name[NR] = $0 } END { for (i = 1; i <= NR; ++i) print name[(i + first) % NR + 1] }'
}

# run_until END FOLDER MEMORY FILTER < NAMES: runs tests of FOLDER by name, with GTEST_FILTER=FILTER, as many at a time as there
# are cores, and begins none when SECONDS is END. MEMORY is a file that tells when each passed: those that did not for
# longest come first; "" takes them as they come. Says which were left out; without any name it fails.
run_until() {
  local end=$1 folder=$2 memory=$3 filter=$4 results name names=0 status=0
  results=$(mktemp -d)
  while read -r name; do
    names=$((names + 1))
    while (($(jobs -rp | wc -l) >= $(nproc))); do wait -n || true; done
    if ((SECONDS >= end)); then
      echo "$name" >>"$results/left"
    else
      GTEST_FILTER=$filter run_one "$folder" "$name" "$memory" "$results" &
    fi
  done < <(if [[ $memory ]]; then longest_ago "$memory"; else cat; fi)
  wait
  echo "$(find "$results" -name '*.passed' | wc -l) passed; left out for want of time: $(paste -sd' ' "$results/left" 2>/dev/null)"
  if ((names == 0)) || compgen -G "$results/*.failed" >/dev/null; then status=1; fi
  rm -rf "$results"
  return "$status"
}
longest_ago() { # MEMORY < NAMES
  mkdir -p "$(dirname "$1")" && touch "$1"
  awk -v memory="$1" '
    BEGIN { while ((getline line <memory) > 0) { split(line, part, "\t"); at[part[1]] = part[2] } }
    { print at[$0] + 0 "\t" $0 }' | sort -s -n -k1,1 | cut -f2-
}
run_one() { # FOLDER NAME MEMORY RESULTS
  local log=$4/$2.log
  if fixed ctest --test-dir "$1" --output-on-failure --no-tests=error -R "^${2//./\\.}\$" >"$log" 2>&1; then
    [[ ! $3 ]] || printf '%s\t%s\n' "$2" "$(date +%s)" >>"$3"
    touch "$4/$2.passed"
  else
    cat "$log"
    touch "$4/$2.failed"
  fi
}

# unit_suites ROOM...: the suites of these rooms' unit tests as a filter of GoogleTest.
unit_suites() {
  local files=() room
  for room in "$@"; do
    mapfile -t -O ${#files[@]} files < <(git ls-files "tests/unit/$room/*.cpp")
  done
  ((${#files[@]} == 0)) ||
    sed -nE 's/^(TYPED_)?TEST(_F|_P)?\(([A-Za-z0-9_]+),.*/\3/p' "${files[@]}" | sort -u |
    awk '{ printf "%s%s.*:%s/*:*/%s.*", (NR > 1 ? ":" : ""), $0, $0, $0 }'
}

# Runs every suite of the benchmark on small inputs to its end; its times mean nothing here.
benchmarked() {
  install_missing gnuplot-nox || return
  local out
  out=$(mktemp -d)
  tests/bench/report.sh build-tests/tests/bccsplat_bench "$out" --quick
  local status=$?
  rm -rf "$out"
  return "$status"
}

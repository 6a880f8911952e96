# shellcheck shell=bash disable=SC2154
# Sourced by tests/aarch64.sh and tests/windows.sh: what both do. Builds for another system lie in folders of their own; tests
# are dealt out to processes, for an emulator takes longer to start than most tests.
# shellcheck source=tests/packages.sh
source "$top/tests/packages.sh"

# check_words NAME WORD...: ends with what the script takes, unless its words are that.
check_words() {
  local name=$1
  shift
  if (($# > 1)) || [[ ${1:-} && ! $1 =~ ^--(build|all|sixth_[0-5])$ ]]; then
    echo "usage: $name [--build | --all | --sixth_0 .. --sixth_5]" >&2
    exit 2
  fi
}

# Prints the tool of this machine, whose files those of the others must equal; builds it where there is none.
tool_here() {
  local build=$top/build-tests
  if [[ ! -f $build/build.ninja ]]; then
    build=$top/build-here
    cmake -S "$top" -B "$build" -G Ninja "${launchers[@]}" -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON \
      -DBCCSPLAT_WITH_GPU=OFF -DBCCSPLAT_WITH_OPENVDB=OFF -DBCCSPLAT_WITH_NETCDF=OFF -DBCCSPLAT_WITH_TIFF=OFF \
      -DBCCSPLAT_BUILD_TESTS=OFF -DBCCSPLAT_BUILD_BENCH=OFF -DBCCSPLAT_BUILD_EXAMPLES=OFF >&2
  fi
  cmake --build "$build" --target bcc4 >&2
  echo "$build/importers/bcc4"
}

# libraries NAME: makes what NAME_libraries.sh makes and prints where: a folder that all clones share, another one for
# another text of the script.
libraries() {
  local script=$top/tests/cross/$1_libraries.sh folder
  folder=${XDG_CACHE_HOME:-$HOME/.cache}/bccsplat/$1-$(sha256sum "$script" | head -c 12)
  bash "$script" "$folder" >&2 && echo "$folder"
}

# is_quick [WORD]: whether a script's word asks for the loops' tests alone, which then alone are built.
is_quick() { [[ ! ${1:-} ]]; }

# configure BUILD TOOLCHAIN "WORD" OPTION...: without what has no package there.
configure() {
  local build=$1 toolchain=$2 files=
  is_quick "$3" && files=$(files_of_loops | tr '\n' '|')
  shift 3
  cmake -S "$top" -B "$build" -G Ninja "${launchers[@]}" -DCMAKE_TOOLCHAIN_FILE="$top/src/cmake/$toolchain.cmake" \
    -DCMAKE_BUILD_TYPE=Release -DBCCSPLAT_WERROR=ON -DCMAKE_UNITY_BUILD=ON -DBCCSPLAT_TEST_SHARDS=24 \
    -DBCCSPLAT_WITH_GPU=OFF -DBCCSPLAT_WITH_OPENVDB=OFF -DBCCSPLAT_WITH_NETCDF=OFF -DBCCSPLAT_WITH_MICROHTTPD=OFF \
    -DBCCSPLAT_TOOL_MODULES=OFF \
    -DBCCSPLAT_BUILD_BENCH=OFF -DBCCSPLAT_BUILD_EXAMPLES=OFF -DBCCSPLAT_TEST_FILES="${files%|}" "$@"
}

# build BUILD "WORD" TARGET...: library, tool, the host in C and unit tests, what else is named, and all tests where they are
# asked for.
build() {
  local build=$1 targets=(bccsplat bcc4 bccsplat_c_host bccsplat_unit)
  is_quick "$2" || targets+=(bccsplat_api bccsplat_stability)
  shift 2
  cmake --build "$build" --target "${targets[@]}" "$@"
}

# The tests of the vector loops, which are compared with their reference, and of the calls of the system: their files, and the
# suites in them.
files_of_loops() { cd "$top" && grep -rlE 'support/targets\.h|base/os/' tests/unit | sort; }
suites_of_loops() {
  local files
  mapfile -t files < <(files_of_loops)
  (cd "$top" && sed -nE 's/^(TYPED_)?TEST(_F|_P)?\(([A-Za-z0-9_]+),.*/\3/p' "${files[@]}") | sort -u |
    awk '{ printf "%s%s.*:%s/*:*/%s.*", (NR > 1 ? ":" : ""), $0, $0, $0 }'
}

# run_tests BUILD [WORD]: the loops, or all tests, or a sixth of them; and always those of tests/cross and the host in C.
run_tests() {
  local build=$1 kinds='^(unit|api|stability|cross)$' part=.
  case ${2:-} in
  --build) return ;;
  --all) ;;
  --sixth_*) part="^(${2#--}|cross)$" ;;
  *) GTEST_FILTER=$(suites_of_loops) && export GTEST_FILTER && kinds='^(unit|cross)$' ;;
  esac
  ctest --test-dir "$build" --output-on-failure --no-tests=error -j "$(nproc)" -L "$kinds" -L "$part"
}

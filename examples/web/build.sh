#!/bin/bash
# Builds the viewer for browsers into a folder of static files (default: build-web/site). Installs what is missing: emscripten
# and zlib's source from Debian, esbuild and typescript from npm. build.sh [FOLDER]
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
# shellcheck source=tests/packages.sh
source "$top/tests/packages.sh"
work=${BCCSPLAT_WEB_BUILD:-$top/build-web}
site=${1:-$work/site}
mkdir -p "$work" "$site"
install_missing emscripten libhwy-dev zlib1g-dev ninja-build cmake pkg-config dpkg-dev bzip2 ca-certificates ||
  [[ -x $(command -v emcc) ]]
command -v npm >/dev/null || install_missing npm

# The packages of the page; acorn serves emscripten where Debian's own is not installed.
if [[ ! -d $work/npm/node_modules/esbuild ]]; then
  mkdir -p "$work/npm"
  cp "$top/examples/web/package.json" "$work/npm/"
  npm install --prefix "$work/npm" --no-fund --no-audit --loglevel=error
fi
export NODE_PATH=$work/npm/node_modules${NODE_PATH:+:$NODE_PATH}

# zlib as Debian has it, for WebAssembly. The list of sources is a private one.
zlib() {
  local apt=(-o "Dir::Etc::sourcelist=$work/apt/src.sources" -o Dir::Etc::sourceparts=- -o "Dir::State::lists=$work/apt/lists"
    -o Acquire::Retries=3 -q)
  mkdir -p "$work/apt/lists/partial" "$work/zlib"
  printf 'Types: deb-src\nURIs: http://deb.debian.org/debian\nSuites: bookworm\nComponents: main\nSigned-By: %s\n' \
    /usr/share/keyrings/debian-archive-keyring.gpg >"$work/apt/src.sources"
  apt-get "${apt[@]}" update
  (cd "$work/apt" && apt-get "${apt[@]}" source --download-only zlib)
  tar -xf "$work"/apt/zlib_*.orig.tar.* -C "$work/zlib" --strip-components=1
  local file
  for file in adler32 compress crc32 deflate inffast inflate inftrees trees uncompr zutil; do
    emcc -O2 -c "$work/zlib/$file.c" -o "$work/zlib/$file.o"
  done
  emar rcs "$work/zlib/libz.a" "$work"/zlib/*.o
}
[[ -f $work/zlib/libz.a ]] || zlib

# Highway's headers alone: the system's other headers must not be seen.
mkdir -p "$work/include"
ln -sfn /usr/include/hwy "$work/include/hwy"
emcmake cmake -S "$top" -B "$work/core" -G Ninja "${launchers[@]}" -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON \
  -DCMAKE_CXX_FLAGS_RELEASE="-Oz -DNDEBUG" -DCMAKE_CXX_FLAGS="${CXXFLAGS:--w}" \
  -DBCCSPLAT_WITH_WRITER=OFF -DBCCSPLAT_WITH_SPLAT=OFF -DBCCSPLAT_WITH_CUTS=OFF -DBCCSPLAT_WITH_MOTION=OFF \
  -DBCCSPLAT_WITH_IMAGE=OFF -DBCCSPLAT_BUILD_TESTS=OFF -DBCCSPLAT_BUILD_BENCH=OFF -DBCCSPLAT_BUILD_TOOL=OFF -DBCCSPLAT_HWY_INCLUDE="$work/include" \
  -DBCCSPLAT_BUILD_EXAMPLES=OFF -DZLIB_INCLUDE_DIR="$work/zlib" -DZLIB_LIBRARY="$work/zlib/libz.a" >"$work/configure.log" 2>&1 ||
  { cat "$work/configure.log"; exit 1; }
cmake --build "$work/core" --target bccsplat_web

here=$top/examples/web
"$work/npm/node_modules/.bin/tsc" --noEmit -p "$here"
esbuild=$work/npm/node_modules/.bin/esbuild
common=(--bundle --format=esm --target=es2022 --minify --log-level=warning)
"$esbuild" "$here/src/worker.ts" "${common[@]}" --outfile="$site/worker.mjs"
"$esbuild" "$here/src/page/viewer.ts" "${common[@]}" --outfile="$site/viewer.mjs"
"$esbuild" "$here/src/page/main.ts" "${common[@]}" --outfile="$site/page.mjs"
cp "$here"/src/*.css "$here/src/index.html" "$work/core/examples/web/core/core.mjs" "$work/core/examples/web/core/core.wasm" "$site/"
printf 'core.wasm: %d bytes, %d with gzip\n' "$(stat -c %s "$site/core.wasm")" "$(gzip -9c "$site/core.wasm" | wc -c)"
echo "The viewer is in $site"

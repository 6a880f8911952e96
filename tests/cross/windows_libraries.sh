#!/bin/bash
# windows_libraries.sh FOLDER: what a build for Windows is linked with and Debian has no package of, made of Debian's own
# sources: Highway, libdeflate, libpng, OpenEXR with Imath, pugixml and GoogleTest; headers that know no system are linked to.
# What is there stays, so that a second call takes no time.
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
mkdir -p "${1:?usage: windows_libraries.sh FOLDER}"
out=$(cd "$1" && pwd)
sources=$out/sources

# Debian's sources by a list of this folder: the system's own lists stay as they are.
fetch() {
  [[ ! -d $sources/lists ]] || return 0
  mkdir -p "$sources/lists/partial"
  echo "deb-src http://deb.debian.org/debian bookworm main" >"$sources/sources.list"
  as_apt update
}
as_apt() {
  apt-get -q -o Acquire::Retries=3 -o Dir::Etc::sourcelist="$sources/sources.list" -o Dir::Etc::sourceparts=- \
    -o Dir::State::lists="$sources/lists" -o APT::Sandbox::User=root "$@"
}

# build PACKAGE FOLDER OPTION...: unpacks a source package, builds FOLDER in it by CMake, and installs that.
build() {
  local package=$1 folder=$2
  shift 2
  [[ ! -f $out/$package.done ]] || return 0
  fetch
  (cd "$sources" && as_apt source "$package")
  install_by_cmake "$package" "$(echo "$sources/$package"-[0-9]*/)$folder" "$@"
}
install_by_cmake() {
  local package=$1 source=$2
  shift 2
  [[ ! -f $out/$package.done ]] || return 0
  cmake -S "$source" -B "$out/build/$package" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_TOOLCHAIN_FILE="$top/src/cmake/x86_64-w64-mingw32.cmake" -DBCCSPLAT_WINDOWS_LIBRARIES="$out" \
    -DCMAKE_INSTALL_PREFIX="$out" -DBUILD_SHARED_LIBS=OFF "$@"
  cmake --build "$out/build/$package"
  cmake --install "$out/build/$package"
  touch "$out/$package.done"
}

build highway . -DBUILD_TESTING=OFF -DHWY_ENABLE_EXAMPLES=OFF -DHWY_ENABLE_CONTRIB=OFF -DHWY_ENABLE_INSTALL=ON
if [[ ! -d $out/include/hwy/contrib/math ]]; then # of what its build installs with a sort that takes long to compile
  mkdir -p "$out/include/hwy/contrib"
  cp -r "$sources"/highway-[0-9]*/hwy/contrib/math "$out/include/hwy/contrib/"
fi
build pugixml .
build libpng1.6 . -DPNG_SHARED=OFF -DPNG_TESTS=OFF -DPNG_EXECUTABLES=OFF
build imath . -DBUILD_TESTING=OFF
build openexr . -DBUILD_TESTING=OFF -DOPENEXR_BUILD_TOOLS=OFF -DOPENEXR_INSTALL_EXAMPLES=OFF -DOPENEXR_FORCE_INTERNAL_IMATH=OFF
install_by_cmake googletest /usr/src/googletest -DBUILD_GMOCK=OFF

# libdeflate 1.14 has a Makefile alone.
if [[ ! -f $out/libdeflate.done ]]; then
  fetch
  (cd "$sources" && as_apt source libdeflate)
  make -C "$(echo "$sources"/libdeflate-[0-9]*/)" CC=x86_64-w64-mingw32-gcc-posix AR=x86_64-w64-mingw32-ar \
    CFLAGS="-O2 -Wa,-muse-unaligned-vector-move" libdeflatestatic.lib
  cp "$sources"/libdeflate-[0-9]*/libdeflatestatic.lib "$out/lib/libdeflate.a"
  cp "$sources"/libdeflate-[0-9]*/libdeflate.h "$out/include/"
  mkdir -p "$out/lib/pkgconfig"
  printf 'Name: libdeflate\nDescription: deflate, as a whole\nVersion: 1.14\nCflags: -I%s/include\nLibs: -L%s/lib -ldeflate\n' \
    "$out" "$out" >"$out/lib/pkgconfig/libdeflate.pc"
  touch "$out/libdeflate.done"
fi

for headers in CLI nlohmann stb; do
  ln -sfn "/usr/include/$headers" "$out/include/$headers"
done
mkdir -p "$out/share/cmake"
for package in CLI11 nlohmann_json; do
  [[ -d $out/share/cmake/$package ]] || cp -r "/usr/share/cmake/$package" "$out/share/cmake/"
done

#!/bin/bash
# aarch64_libraries.sh FOLDER: unpacks Debian's libraries for 64-bit ARM into a folder that stands for the root of such a
# system, and a Python for the wheel. The machine's own packages stay as they are: some of them exclude those of another
# architecture. What is there stays, so that a second call takes no time.
set -euo pipefail
packages=(libc6-dev libstdc++-12-dev zlib1g-dev libdeflate-dev libhwy-dev libpng-dev libopenexr-dev libimath-dev libtiff-dev
  libpugixml-dev libgtest-dev python3-minimal python3-numpy)
mkdir -p "${1:?usage: aarch64_libraries.sh FOLDER}/apt/lists/partial" "$1/apt/cache/archives/partial" "$1/root"
out=$(cd "$1" && pwd)
[[ $(cat "$out/done" 2>/dev/null) != "${packages[*]}" ]] || exit 0
: >"$out/apt/status" # nothing is installed there
{
  echo "deb http://deb.debian.org/debian bookworm main"
  echo "deb http://deb.debian.org/debian-security bookworm-security main"
} >"$out/apt/sources.list"
as_apt() {
  apt-get -q -o Acquire::Retries=3 -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Sandbox::User=root \
    -o Dir::Etc::sourcelist="$out/apt/sources.list" -o Dir::Etc::sourceparts=- -o Dir::State="$out/apt" \
    -o Dir::State::status="$out/apt/status" -o Dir::State::lists="$out/apt/lists" -o Dir::Cache="$out/apt/cache" \
    -o Dir::Etc::preferencesparts=- -o Dir::Etc::preferences=- "$@"
}
as_apt update
as_apt -y --no-install-recommends --download-only install "${packages[@]}"
for package in "$out"/apt/cache/archives/*.deb; do
  dpkg-deb -x "$package" "$out/root"
done
for headers in CLI nlohmann stb; do # which know no architecture
  ln -sfn "/usr/include/$headers" "$out/root/usr/include/$headers"
done
for package in CLI11 nlohmann_json; do
  mkdir -p "$out/root/usr/share/cmake"
  cp -r "/usr/share/cmake/$package" "$out/root/usr/share/cmake/"
done
# Some links are absolute.
find "$out/root" -type l -lname '/*' -not -path '*/include/*' -print0 | while IFS= read -r -d '' link; do
  ln -sfn "$out/root$(readlink "$link")" "$link"
done
for library in blas lapack; do # where the system's alternatives would choose them
  ln -sfn "$library/lib$library.so.3" "$out/root/usr/lib/aarch64-linux-gnu/lib$library.so.3"
done
echo "${packages[*]}" >"$out/done"

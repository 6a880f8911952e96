// SPDX-License-Identifier: Apache-2.0
// make_seeds FOLDER FILE...: seeds of bcc4_file and drawn from .bcc4 files, to be packed by seeds.sh.
// Blocks of the index are stored raw, so that mutations reach their fields.
#include <gtest/gtest.h> // for the helpers

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/unit/formats/rebuild.h"

int main(int argc, char** argv) {
  using namespace bccsplat;
  for (int i = 2; i < argc; ++i) {
    const std::filesystem::path path(argv[i]);
    std::ifstream in(path, std::ios::binary);
    const std::vector<char> text{std::istreambuf_iterator<char>(in), {}};
    const auto from = std::as_bytes(std::span(text));
    test::Bytes bytes(from.begin(), from.end());
    try {
      test::Edit edit{};
      edit.raw_blocks = true;
      bytes = test::rebuild(bytes, edit);
    } catch (const Error&) {
      // A bad file is a seed as it is.
    }
    if (bytes.size() < preamble_bytes) continue;
    std::ofstream out(std::filesystem::path(argv[1]) / path.stem(), std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  return 0;
}

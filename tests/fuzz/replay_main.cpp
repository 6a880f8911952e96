// SPDX-License-Identifier: Apache-2.0
// Runs a fuzz target on files, or on all files of folders, so that what libFuzzer found stays found with any
// compiler, and where the target has a mutator of its own on FUZZ_MUTATIONS changes of them, the same ones in
// every run. Prints the number of inputs; fails without any, and where one takes far more memory than others.
#ifdef __linux__
#include <sys/resource.h>
#endif

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "fuzz_target.h"

namespace fs = std::filesystem;

namespace {

// Names the input first, should the target crash.
void run(const std::string& name, const std::vector<uint8_t>& bytes) {
  std::printf("%s\n", name.c_str());
  std::fflush(stdout);
  LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
#ifdef __linux__
  constexpr long most = 2 << 20; // KiB, as libFuzzer is told
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  fuzz::expect(used.ru_maxrss < most, "more than 2 GiB of memory");
#endif
}

} // namespace

#ifdef FUZZ_MUTATIONS
extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t most, unsigned seed);
#endif

int main(int argc, char** argv) {
  std::vector<fs::path> files;
  for (int i = 1; i < argc; ++i) {
    if (!fs::is_directory(argv[i])) {
      files.emplace_back(argv[i]);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(argv[i]))
      if (entry.is_regular_file()) files.push_back(entry.path());
  }
  if (files.empty()) {
    std::fprintf(stderr, "replay: no files\n");
    return 2;
  }
  std::sort(files.begin(), files.end());
  std::vector<std::vector<uint8_t>> inputs;
  for (const fs::path& path : files) {
    std::ifstream in(path, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    if (!in && !in.eof()) {
      std::fprintf(stderr, "replay: %s cannot be read\n", path.c_str());
      return 2;
    }
    run(path.string(), inputs.back());
  }
  size_t count = inputs.size();
#ifdef FUZZ_MUTATIONS
  for (unsigned n = 0; n < FUZZ_MUTATIONS; ++n, ++count) {
    const size_t from = n % inputs.size();
    std::vector<uint8_t> changed = inputs[from];
    changed.resize(LLVMFuzzerCustomMutator(changed.data(), changed.size(), changed.size(), n));
    run(files[from].string() + ", change " + std::to_string(n), changed);
  }
#endif
  std::printf("%zu inputs\n", count);
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/fit/tool_import.h"

#include <sys/resource.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

#include "base/error.h"
#include "base/files.h"
#include "base/text.h"

namespace bccsplat::bench {
namespace {

#ifdef BCCSPLAT_BENCH_TOOL
constexpr const char* tool = BCCSPLAT_BENCH_TOOL;
#else
constexpr const char* tool = nullptr;
#endif

const char* type_name(SourceType type) {
  if (type == SourceType::u8) return "u8";
  if (type == SourceType::u16) return "u16";
  return type == SourceType::i16 ? "i16" : "f32";
}

} // namespace

bool has_tool() { return tool != nullptr; }

ToolImport::ToolImport(const FitSource& source)
    : folder_((std::filesystem::temp_directory_path() / "bccsplat-import-XXXXXX").string()) {
  if (!tool)
    fail(Code::unsupported,
         "this runs bcc4, which is not built here: configure with -DBCCSPLAT_BUILD_TOOL=ON");
  if (!::mkdtemp(folder_.data())) fail(Code::io_error, "cannot make a folder ", folder_);
  const std::string raw = folder_ + "/source.raw";
  std::ofstream file(raw, std::ios::binary);
  file.write(reinterpret_cast<const char*>(source.bytes.data()), source.bytes.size());
  if (!file) fail(Code::io_error, raw, ": cannot write the source");
  const auto& d = source.dims;
  arguments_ = concat("'", raw, "' --dims ", d[0], ",", d[1], ",", d[2], ",", d[3], " --dtype ",
                      type_name(source.type), " -o '", this->file(), "' --overwrite ");
}

ToolImport::~ToolImport() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::string ToolImport::run(const std::string& options) const {
  const std::string command = concat("'", tool, "' import ", arguments_, "--measure all --json ", options);
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
  if (!pipe) fail(Code::io_error, "cannot run ", command);
  std::string text;
  std::array<char, 4096> part{};
  while (const size_t got = std::fread(part.data(), 1, part.size(), pipe.get()))
    text.append(part.data(), got);
  if (text.empty()) fail(Code::io_error, "no report of ", command);
  return text;
}

double ToolImport::seconds(const std::string& options) const {
  const auto spent = [] {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  };
  const std::string command = concat("'", tool, "' import ", arguments_, "--threads 1 --quiet ", options);
  const double before = spent();
  if (std::system(command.c_str()) != 0) fail(Code::io_error, "cannot run ", command);
  return spent() - before;
}

double ToolImport::export_seconds(std::vector<std::byte>& frames) const {
  const auto spent = [] {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    return static_cast<double>(usage.ru_utime.tv_sec) + 1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
  };
  const std::string raw = folder_ + "/back.raw",
                    command = concat("'", tool, "' export '", file(),
                                     "' --all --threads 1 --quiet --overwrite -o '", raw, "'");
  const double before = spent();
  if (std::system(command.c_str()) != 0) fail(Code::io_error, "cannot run ", command);
  const double seconds = spent() - before;
  const auto source = open_file_source(raw);
  frames.resize(source->size());
  source->read_at(0, frames);
  return seconds;
}

} // namespace bccsplat::bench

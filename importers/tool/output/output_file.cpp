// SPDX-License-Identifier: Apache-2.0
#include "tool/output/output_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "readers/error.h"

namespace bcc4 {
namespace fs = std::filesystem;

void refuse_existing(const std::string& path, bool overwrite) {
  std::error_code ignored;
  if (!overwrite && fs::exists(path, ignored)) fail_usage(path, ": exists already; --overwrite replaces it");
  if (fs::is_directory(path, ignored)) fail_usage(path, ": is a folder");
  // Its name would be taken away by the rename.
  if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored))
    fail_usage(path, ": is no regular file");
}

void require_writable_folder(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  if (::access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) != 0)
    fail_input(path, ": cannot be written (", std::strerror(errno), ")");
}

void refuse_source_as_output(const std::string& output, const std::string& source) {
  std::error_code error;
  if (fs::equivalent(output, source, error)) fail_usage(output, ": is an input; write to another file");
}

std::string partial_path(const std::string& path) {
  const fs::path p(path);
  return (p.parent_path() / concat(".", p.filename().string(), ".", getpid(), ".partial")).string();
}

void rename_finished(const std::string& partial, const std::string& path) {
  std::error_code error;
  fs::rename(partial, path, error);
  if (!error) return;
  std::error_code ignored;
  fs::remove(partial, ignored);
  fail_input(path, ": cannot take its name (", error.message(), ")");
}

OutputFile::OutputFile(std::string path, bool overwrite)
    : path_(std::move(path)), partial_(partial_path(path_)) {
  refuse_existing(path_, overwrite);
  errno = 0;
  stream_.open(partial_, std::ios::binary | std::ios::trunc);
  if (!stream_) fail_writing();
}

OutputFile::~OutputFile() {
  if (partial_.empty()) return;
  stream_.close();
  std::error_code ignored;
  fs::remove(partial_, ignored);
}

void OutputFile::fail_writing() const {
  const int reason = errno;
  fail(reason == ENOSPC || reason == EDQUOT || reason == EFBIG ? Exit::no_resources : Exit::bad_input, path_,
       ": cannot be written (", reason ? std::strerror(reason) : "unknown reason", ")");
}

void OutputFile::write(std::span<const std::byte> bytes) {
  errno = 0;
  stream_.write(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!stream_) fail_writing();
}

void OutputFile::finish() {
  errno = 0;
  stream_.close();
  if (!stream_) fail_writing();
  rename_finished(partial_, path_);
  partial_.clear();
}

} // namespace bcc4

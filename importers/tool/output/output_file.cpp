// SPDX-License-Identifier: Apache-2.0
#include "tool/output/output_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "readers/error.h"
#include "readers/system.h"
#include "tool/system.h"

namespace bcc4 {
namespace fs = std::filesystem;

void refuse_existing(const std::string& path, bool overwrite) {
  std::error_code ignored;
  const fs::path file = to_path(path);
  if (!overwrite && fs::exists(file, ignored)) fail_usage(path, ": exists already; --overwrite replaces it");
  if (fs::is_directory(file, ignored)) fail_usage(path, ": is a folder");
  // Its name would be taken away by the rename.
  if (fs::exists(file, ignored) && !fs::is_regular_file(file, ignored))
    fail_usage(path, ": is no regular file");
}

void require_writable_folder(const std::string& path) {
  if (!folder_is_writable(to_path(path).parent_path()))
    fail_input(path, ": cannot be written (", std::strerror(errno), ")");
}

void refuse_source_as_output(const std::string& output, const std::string& source) {
  std::error_code error;
  if (fs::equivalent(to_path(output), to_path(source), error))
    fail_usage(output, ": is an input; write to another file");
}

std::string partial_path(const std::string& path) {
  const fs::path p = to_path(path);
  const std::string name = concat(".", to_text(p.filename()), ".", process_number(), ".partial");
  return to_text(p.parent_path() / to_path(name));
}

void rename_finished(const std::string& partial, const std::string& path) {
  std::error_code error;
  fs::rename(to_path(partial), to_path(path), error);
  if (!error) return;
  std::error_code ignored;
  fs::remove(to_path(partial), ignored);
  fail_input(path, ": cannot take its name (", error.message(), ")");
}

OutputFile::OutputFile(std::string path, bool overwrite)
    : path_(std::move(path)), partial_(partial_path(path_)) {
  refuse_existing(path_, overwrite);
  errno = 0;
  stream_.open(to_path(partial_), std::ios::binary | std::ios::trunc);
  if (!stream_) fail_writing();
}

OutputFile::~OutputFile() {
  if (partial_.empty()) return;
  stream_.close();
  std::error_code ignored;
  fs::remove(to_path(partial_), ignored);
}

void OutputFile::fail_writing() const {
  const int reason = errno;
  throw Error(is_disk_full(reason) ? Code::no_space : Code::io_error,
              concat(path_, ": cannot be written (", reason ? std::strerror(reason) : "unknown reason", ")"));
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

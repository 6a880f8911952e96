// SPDX-License-Identifier: Apache-2.0
// A file that takes its name only when it is complete.
#pragma once

#include <cstddef>
#include <fstream>
#include <span>
#include <string>

#include "tool/output/byte_sink.h"

namespace bcc4 {

// An existing `path` is refused unless `overwrite`, and what is no regular file always.
void refuse_existing(const std::string& path, bool overwrite);
// What long work will be written to: a missing or read-only folder is told before it.
void require_writable_folder(const std::string& path);
// Nothing is written over what is read, whatever `overwrite` says: refused where both are one file.
void refuse_source_as_output(const std::string& output, const std::string& source);
// Returns the path to write to meanwhile: a hidden neighbour of `path`.
[[nodiscard]] std::string partial_path(const std::string& path);
void rename_finished(const std::string& partial, const std::string& path);

class OutputFile : public ByteSink {
 public:
  OutputFile(std::string path, bool overwrite);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile() override; // removes what was written unless finished
  void write(std::span<const std::byte> bytes) override;
  // For what writes into a stream; finish() tells what went wrong there, too.
  [[nodiscard]] std::ostream& stream() { return stream_; }
  void finish() override;

 private:
  [[noreturn]] void fail_writing() const;
  std::string path_, partial_;
  std::ofstream stream_;
};

} // namespace bcc4

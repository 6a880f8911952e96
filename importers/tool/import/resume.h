// SPDX-License-Identifier: Apache-2.0
// Unfinished imports: what stays of them, and going on.
#pragma once

#include <cstdint>
#include <string>

#include "tool/handles.h"
#include "tool/options.h"

namespace bcc4 {

struct ResumeArguments {
  bool resume = false, append = false;
  uint32_t live = 0; // slabs
};
// --resume and --append.
void add_resume_options(const Command& import, ResumeArguments& arguments);
void add_live_option(const Command& import, ResumeArguments& arguments);
// BCCSPLAT_PARTIAL_... for the writer; refuses both at once.
[[nodiscard]] int32_t partial_mode(const ResumeArguments& arguments);

// What an import that was killed left behind, in words, as far as --resume could go on with it; "" where
// there is nothing.
[[nodiscard]] std::string unfinished_work(const Device& device, const std::string& output);

// Watches over one import, once its writer has the file. When it ends early, work worth going on from stays
// and a line says how; else nothing stays: what misses its bound would miss it again.
class UnfinishedImport {
 public:
  UnfinishedImport(std::string output, bool quiet) : output_(std::move(output)), quiet_(quiet) {}
  UnfinishedImport(const UnfinishedImport&) = delete;
  UnfinishedImport& operator=(const UnfinishedImport&) = delete;
  ~UnfinishedImport();
  void begun() { begun_ = true; } // before that, what is there may be another's
  void finished() { finished_ = true; }
  void missed_its_bound() { worthless_ = true; }

 private:
  std::string output_;
  bool quiet_, begun_ = false, finished_ = false, worthless_ = false;
};

} // namespace bcc4

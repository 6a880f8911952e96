// SPDX-License-Identifier: Apache-2.0
// Shows the work of the choosing as a line of progress, and ends it when the tool is interrupted.
#pragma once

#include <optional>
#include <string>

#include "series/watch.h"
#include "tool/interrupt.h"
#include "tool/progress.h"

namespace bcc4 {

class RunWatch : public Watch {
 public:
  // shown: is there a line of progress?
  explicit RunWatch(bool shown) : shown_(shown) {}
  [[nodiscard]] bool ends() override { return interrupted(); }
  [[nodiscard]] bccsplat_cancel_token* token() override { return interrupt_token(); }
  void show(const WorkDone& work) override {
    if (!shown_) return;
    if (!line_ || label_ != work.label) line_.emplace(label_ = work.label, work.total, work.total > 0, false);
    line_->update(work.done, work.detail);
  }
  // Takes the line away, before something else is printed.
  void clear() { line_.reset(); }

 private:
  bool shown_;
  std::string label_;
  std::optional<Progress> line_;
};

} // namespace bcc4

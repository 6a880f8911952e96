// SPDX-License-Identifier: Apache-2.0
#include "tool/import/part_argument.h"

#include "tool/options.h"

namespace bcc4 {

FrameSpan parse_part(const std::string& text, uint64_t frames) {
  if (const size_t slash = text.find('/'); slash != std::string::npos) {
    const auto k = option_number<uint64_t>("--part", text.substr(0, slash));
    const auto n = option_number<uint64_t>("--part", text.substr(slash + 1));
    if (k < 1 || k > n) fail_usage("--part ", text, ": the first of ", n, " parts is 1/", n);
    if (n > frames) fail_usage("--part ", text, ": the series has ", frames, " frames");
    return {frames / n * (k - 1) + frames % n * (k - 1) / n, frames / n * k + frames % n * k / n};
  }
  const size_t dash = text.find('-');
  FrameSpan span;
  span.first = option_number<uint64_t>("--part", text.substr(0, dash));
  const uint64_t last =
      dash == std::string::npos ? span.first : option_number<uint64_t>("--part", text.substr(dash + 1));
  if (last < span.first || last >= frames)
    fail_usage("--part ", text, ": frames A-B from 0 to ", frames - 1, ", or K/N");
  span.end = last + 1;
  return span;
}

} // namespace bcc4

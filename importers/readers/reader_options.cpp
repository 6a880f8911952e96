// SPDX-License-Identifier: Apache-2.0
#include "readers/reader_options.h"

#include "readers/error.h"
#include "readers/system.h"

namespace bcc4 {

FrameSelection parse_frame_selection(std::string_view text) {
  const auto refuse = [&]() { fail_usage("--frames ", text, ": write A-B or A-BxS, such as 1001-1100x2"); };
  FrameSelection s;
  s.given = true;
  std::string_view range = text;
  if (const size_t x = text.find('x'); x != std::string_view::npos) {
    const auto step = parse_number<int64_t>(text.substr(x + 1));
    if (!step || *step < 1) refuse();
    s.step = *step;
    range = text.substr(0, x);
  }
  const size_t dash = range.find('-');
  const auto number = [&](std::string_view part, int64_t open) {
    if (part.empty()) return open;
    const auto value = parse_number<int64_t>(part);
    if (!value) refuse();
    return *value;
  };
  if (range.empty() || range == "-") refuse();
  s.first = number(range.substr(0, dash), INT64_MIN);
  s.last = dash == std::string_view::npos ? s.first : number(range.substr(dash + 1), INT64_MAX);
  if (s.last < s.first) refuse();
  return s;
}

uint64_t memory_limit(const ReaderOptions& options) {
  if (options.max_memory > 0) return options.max_memory;
  const uint64_t all = machine_memory();
  return all > 0 ? all / 2 : uint64_t{1} << 32;
}

void refuse_raw_options(const ReaderOptions& options, const std::string& path, const char* format,
                        bool axes_allowed) {
  const char* option = options.dims                    ? "--dims"
                       : options.dtype                 ? "--dtype"
                       : options.big_endian            ? "--endian"
                       : options.skip                  ? "--skip"
                       : options.count                 ? "--count"
                       : options.axes && !axes_allowed ? "--axes"
                                                       : nullptr;
  if (option)
    fail_usage(option, " describes raw files, but ", path, " is ", format,
               " and says so itself: leave it out");
}

void refuse_grid_option(const ReaderOptions& options, const std::string& path, const char* format) {
  if (!options.grids.empty())
    fail_usage("--grid names a grid of an OpenVDB file, but ", path, " is ", format, ": try --channel");
  if (options.level_set_fog)
    fail_usage("--level-set tells how OpenVDB level sets are read, but ", path, " is ", format);
}

void refuse_channel_option(const ReaderOptions& options, const std::string& path, const char* format) {
  if (!options.channels.empty())
    fail_usage("--channel: ", path, " is ", format, " and has one value per sample");
}

} // namespace bcc4

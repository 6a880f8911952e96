// SPDX-License-Identifier: Apache-2.0
// What an import tells when it is done, in words and as JSON with stable keys.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "tool/import/report.h"
#include "tool/json_fwd.h"

namespace bcc4 {

struct ImportResult {
  bccsplat_writer_report report = sized<bccsplat_writer_report>();
  FrameSpan given; // frames read: of a part more than its own
  MeasuredErrors errors;
  std::vector<std::map<uint64_t, uint64_t>> nonfinite; // values, by channel, of frames that have any
};

void print_summary(const SeriesDescription& s, const ImportResult& import, double seconds,
                   const std::string& output, const std::string& command_line);
[[nodiscard]] Json summary_json(const SeriesDescription& s, const ImportResult& import, double seconds);
// {source, file, runs, values, index, corrections}
[[nodiscard]] Json bytes_json(const bccsplat_writer_report& report);

} // namespace bcc4

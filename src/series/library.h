// SPDX-License-Identifier: Apache-2.0
// The library as those call it who have a series: statuses as errors, names and numbers of the C ABI, and
// what a series says in the options of its writer.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/error.h"
#include "bccsplat.hpp"
#include "series/frame_reader.h"

namespace bccsplat::series {

using client::Device;
using client::sized;
using client::Slice;
using client::Volume;
using client::Writer;

// Throws an Error of the library's text, with `what` before it, unless status is OK.
inline void check(bccsplat_status status, const std::string& what) {
  if (status == BCCSPLAT_OK) return;
  if (status == BCCSPLAT_CANCELLED) throw Error(Code::cancelled, "interrupted");
  const std::string text = bccsplat_last_error();
  const std::string subject = what.empty() || text.find(what) != std::string::npos ? "" : what + ": ";
  throw Error(static_cast<Code>(status), subject + (text.empty() ? bccsplat_status_name(status) : text));
}

[[nodiscard]] inline const char* lattice_name(int32_t lattice) {
  static constexpr const char* names[] = {"default", "d4star", "bcc", "cc"};
  return lattice >= 0 && lattice < 4 ? names[lattice] : "unknown";
}

// The number of a type in the C ABI, and the type of such a number; f32 where it tells none.
[[nodiscard]] int32_t library_type(Type type);
[[nodiscard]] Type type_of(int32_t number);

// A stream whose bytes go nowhere.
[[nodiscard]] bccsplat_write_stream nowhere();

// The options of a writer and what they point to. The series must outlive them.
struct SeriesOptions {
  // settings: all but what the series says. errors: by channel, wavelet_errors and abs_errors; or of none.
  SeriesOptions(const SeriesDescription& series, const bccsplat_writer_options& settings,
                std::vector<bccsplat_channel_options> of_channels, std::string of_kernel,
                const std::vector<double>& mean_errors, const std::vector<double>& largest_errors);
  SeriesOptions(const SeriesOptions&) = delete;
  SeriesOptions& operator=(const SeriesOptions&) = delete;

  bccsplat_writer_options options;
  std::vector<bccsplat_channel_options> channels;
  std::string kernel;

 private:
  std::array<bccsplat_axis, 3> axes_{};
  std::array<std::string, 3> axis_units_;
  std::string spatial_unit_, time_unit_;
};

} // namespace bccsplat::series

// SPDX-License-Identifier: Apache-2.0
#include "tool/import/block_result.h"

#include <filesystem>
#include <fstream>
#include <utility>

#include "readers/system.h"

namespace bcc4 {
namespace {

// First and last in the file: it is whole, and its reports are of this size.
constexpr uint64_t kMark = uint64_t{0x4b4c4234} << 32 | sizeof(bccsplat_error_report);

std::filesystem::path result_path(const std::string& block) { return to_path(block + ".result"); }

template<class T> void put_value(std::ofstream& out, const T& value) {
  out.write(reinterpret_cast<const char*>(&value), sizeof value);
}
// 0 behind the end.
template<class T> T take_value(std::ifstream& in) {
  T value{};
  if (!in.read(reinterpret_cast<char*>(&value), sizeof value)) return T{};
  return value;
}

} // namespace

void keep_block_result(const ImportResult& result, const std::string& block) {
  const MeasuredErrors& errors = result.errors;
  std::ofstream out(result_path(block), std::ios::binary);
  put_value(out, kMark);
  put_value<uint64_t>(out, errors.series.size());
  for (size_t c = 0; c < errors.series.size(); ++c) {
    put_value(out, errors.series[c]);
    put_value<uint64_t>(out, errors.frames[c].size());
    for (const bccsplat_error_report& frame : errors.frames[c]) put_value(out, frame);
  }
  for (const auto& counts : result.nonfinite) {
    put_value<uint64_t>(out, counts.size());
    for (const auto& [frame, count] : counts)
      put_value<uint64_t>(out, frame), put_value<uint64_t>(out, count);
  }
  put_value(out, kMark);
}

bool read_block_result(const std::string& block, size_t channels, ImportResult& result) {
  MeasuredErrors errors;
  decltype(result.nonfinite) nonfinite(channels);
  std::ifstream in(result_path(block), std::ios::binary);
  if (take_value<uint64_t>(in) != kMark) return false;
  const auto measured = take_value<uint64_t>(in);
  if (measured != 0 && measured != channels) return false;
  for (uint64_t c = 0; c < measured; ++c) {
    errors.series.push_back(take_value<bccsplat_error_report>(in));
    auto& frames = errors.frames.emplace_back();
    for (auto n = take_value<uint64_t>(in); n > 0 && in; --n)
      frames.push_back(take_value<bccsplat_error_report>(in));
  }
  for (auto& counts : nonfinite)
    for (auto n = take_value<uint64_t>(in); n > 0 && in; --n) {
      const auto frame = take_value<uint64_t>(in);
      counts[frame] = take_value<uint64_t>(in);
    }
  if (take_value<uint64_t>(in) != kMark) return false;
  result.errors = std::move(errors), result.nonfinite = std::move(nonfinite);
  return true;
}

void remove_block_result(const std::string& block) {
  std::error_code ignored;
  std::filesystem::remove(result_path(block), ignored);
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// Each block is a part of the series with a writer of its own; samples come from products of tables, so that
// making them costs next to nothing.
#include "tests/bench/scale/scale_blocks.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <vector>

#include <sys/resource.h>

#include "base/error.h"
#include "base/text.h"
#include "tests/bench/scale/scale_host.h"

namespace bccsplat::bench {
namespace {

using host::sized;
using Corner = std::array<uint64_t, 3>;

constexpr float kLeast = 8; // what is less is air

// What a sample is a product of, along each axis, at a frame.
class Blob {
 public:
  Blob(const BlockSeries& s, uint32_t frame) {
    for (size_t a = 0; a < 3; ++a) {
      bump_[a].resize(s.n), wave_[a].resize(s.n);
      const double centre = s.n * (.45 + .004 * frame * (static_cast<double>(a) + 1)), width = .15 * s.n;
      for (uint32_t i = 0; i < s.n; ++i) {
        const double off = (i - centre) / width;
        bump_[a][i] = static_cast<float>(std::exp(-.5 * off * off));
        wave_[a][i] = static_cast<float>(std::sin(i * (.31 + .09 * static_cast<double>(a)) + .4 * frame));
      }
    }
  }
  void fill(const Corner& begin, const Corner& end, std::vector<uint8_t>& values) const {
    values.resize((end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]));
    uint8_t* to = values.data();
    for (uint64_t z = begin[2]; z < end[2]; ++z)
      for (uint64_t y = begin[1]; y < end[1]; ++y) {
        const float bump = 190 * bump_[1][y] * bump_[2][z], wave = .3f * wave_[1][y] * wave_[2][z];
        if (1.3f * bump < kLeast) {
          std::fill_n(to, end[0] - begin[0], uint8_t{0});
          to += end[0] - begin[0];
          continue;
        }
        for (uint64_t x = begin[0]; x < end[0]; ++x) {
          const float v = bump * bump_[0][x] * (1 + wave * wave_[0][x]);
          *to++ = v < kLeast ? uint8_t{0} : static_cast<uint8_t>(v);
        }
      }
  }

 private:
  std::array<std::vector<float>, 3> bump_, wave_;
};

// Writes one block; returns how many samples of a frame it was made of.
uint64_t write_block(const BlockSeries& s, const Corner& begin, const Corner& end, const std::string& path) {
  const auto device = make_api_device(0);
  std::vector<double> times(s.frames);
  for (uint32_t f = 0; f < s.frames; ++f) times[f] = f;
  auto part = sized<bccsplat_series_part>();
  part.end = s.frames, part.times = times.data();
  std::copy(begin.begin(), begin.end(), part.box_begin);
  std::copy(end.begin(), end.end(), part.box_end);
  auto channel = sized<bccsplat_channel_options>();
  channel.source_type = BCCSPLAT_TYPE_U8;
  auto options = sized<bccsplat_writer_options>();
  for (size_t a = 0; a < 3; ++a) options.dims[a] = s.n;
  options.dims[3] = s.frames, options.levels = s.levels;
  options.channels = &channel, options.channel_count = 1;
  options.fixed_predictions = 1, options.overwrite = 1, options.part = &part;
  bccsplat_writer* w = nullptr;
  api(bccsplat_writer_create(device.get(), path.c_str(), &options, &w));
  const Handle<bccsplat_writer> writer(w);
  Corner first{}, last{};
  api(bccsplat_writer_get_part_box(w, first.data(), last.data()));
  std::vector<uint8_t> values;
  for (uint32_t f = 0; f < s.frames; ++f) {
    Blob(s, f).fill(first, last, values);
    auto box = sized<bccsplat_box>();
    box.type = BCCSPLAT_TYPE_U8, box.data = values.data();
    for (size_t a = 0; a < 3; ++a)
      box.begin[a] = static_cast<int64_t>(first[a]), box.dims[a] = static_cast<int64_t>(last[a] - first[a]);
    api(bccsplat_writer_add_frame(w, 0, f, &box, 1));
  }
  api(bccsplat_writer_finish(w, nullptr));
  return values.size();
}

double mib_held() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

} // namespace

BlockSeries parse_block_series(const std::string& text) {
  BlockSeries s;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (uint32_t* number : {&s.n, &s.frames, &s.levels, &s.pieces}) {
    const auto [next, wrong] = std::from_chars(at, end, *number);
    const bool last = number == &s.pieces;
    if (wrong != std::errc() || (last ? next != end : next == end || *next != ','))
      fail(Code::invalid_argument, "scale --blocks ", text, ": N,FRAMES,LEVELS,PIECES");
    at = last ? next : next + 1;
  }
  if (s.n < 16 || s.frames == 0 || s.pieces == 0 || s.pieces > s.n)
    fail(Code::invalid_argument, "scale --blocks ", text, ": at least 16 samples, a frame and a piece");
  return s;
}

void write_block_series(const Report& report, const BlockSeries& s, const std::string& path) {
  const uint64_t along_y = std::max(1u, s.pieces / 2);
  std::vector<std::string> names;
  uint64_t given = 0;
  const double cpu = cpu_seconds([&] {
    for (uint64_t z = 0; z < s.pieces; ++z)
      for (uint64_t y = 0; y < along_y; ++y) {
        names.push_back(concat(path, ".block", names.size()));
        const Corner begin{0, s.n * y / along_y, s.n * z / s.pieces};
        const Corner end{s.n, s.n * (y + 1) / along_y, s.n * (z + 1) / s.pieces};
        given += write_block(s, begin, end, names.back());
      }
  });
  const double held = mib_held();
  auto joined = sized<bccsplat_writer_report>();
  const double join = cpu_seconds([&] {
    std::vector<const char*> paths;
    for (const std::string& name : names) paths.push_back(name.c_str());
    auto options = sized<bccsplat_join_options>();
    options.overwrite = 1, options.compare_levels = 1;
    const auto device = make_api_device(0);
    api(bccsplat_join_parts(device.get(), paths.size(), paths.data(), path.c_str(), &options, &joined));
  });
  for (const std::string& name : names) std::filesystem::remove(name);
  const double frame = 1.0 * s.n * s.n * s.n;
  report.table("a series in blocks of space, made while it is written",
               {{word("samples", concat(s.n, "^3 x ", s.frames, " u8, ", s.levels, " levels")),
                 figure("blocks", static_cast<double>(names.size()), 0),
                 figure("samples made / those of a frame", static_cast<double>(given) / frame, 2),
                 figure("CPU s", cpu, 1), figure("join CPU s", join, 1), figure("MiB held", held, 0),
                 figure("sites kept M", static_cast<double>(joined.sites_kept) / 1e6, 1),
                 figure("file MiB", static_cast<double>(joined.bytes_file) / 0x1p20, 1)}});
}

} // namespace bccsplat::bench

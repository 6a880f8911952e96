// SPDX-License-Identifier: Apache-2.0
// A file does not depend on the machine that writes it: parts of a series may come from several.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include <unistd.h>

#include "store/join.h"
#include "store/volume_writer.h"
#include "tests/support/targets.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat {
namespace {

using test::Bench;
using test::Series;

struct Case {
  const char* name;
  std::function<void(WriterSettings&)> change;
};

std::vector<std::byte> written(const Series& series, const WriterSettings& settings, int threads) {
  Bench bench(threads);
  std::vector<std::byte> bytes;
  VolumeWriter writer(settings, create_memory_sink(bytes), bench.context);
  for (uint32_t t = 0; t < series.dims[3]; ++t) {
    const FrameBox box = series.box(t);
    writer.add_frame(0, t, {&box, 1});
  }
  (void)writer.finish();
  return bytes;
}

TEST(SameBytes, OnEveryTargetAndForAnyThreads) {
  const std::array<uint32_t, 4> dims{41, 19, 22, 9};
  const Series series = test::noise(dims, 3);
  const std::vector<Case> cases{
      {"samples", [](WriterSettings&) {}},
      {"bytes", [](WriterSettings& s) { s.channels[0].value_type = ValueType::u8; }},
      {"wavelets",
       [](WriterSettings& s) {
         s.wavelets = true, s.channels[0].wavelet_error = 0.01, s.channels[0].value_type = ValueType::u16;
       }},
      {"predicted, coarse, low-pass",
       [](WriterSettings& s) {
         s.ends = Ends::predict, s.scales = {1.3, 1.3, 1.3, 1}, s.lowpass = true;
       }},
      {"a distance per axis",
       [](WriterSettings& s) {
         s.ends = Ends::predict, s.scales = {1.3, 0.8, 1, 2.1}, s.lowpass = true;
       }},
      {"Cartesian bytes",
       [](WriterSettings& s) { s.lattice = LatticeKind::cc, s.channels[0].value_type = ValueType::u8; }},
      {"bounded",
       [](WriterSettings& s) { s.channels[0].abs_error = 0.2, s.channels[0].value_type = ValueType::u16; }}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    WriterSettings settings;
    settings.dims = dims;
    settings.channels[0].range = Range{-8, 8};
    c.change(settings);
    const auto one = written(series, settings, 1);
    ASSERT_GT(one.size(), 20000u);
    EXPECT_EQ(written(series, settings, 3), one);
    test::for_targets([&] { EXPECT_EQ(written(series, settings, 1), one); });
  }
}

// Parts, each made on an instruction set of its own, and a series that goes on on another.
class SeveralTargets : public testing::Test {
 protected:
  static constexpr std::array<uint32_t, 4> dims{23, 19, 18, 41};

  SeveralTargets() {
    std::filesystem::create_directories(folder_);
    test::for_targets([&] { ++targets_; });
  }
  ~SeveralTargets() override { std::filesystem::remove_all(folder_); }

  static WriterSettings settings_of(bool wavelets) {
    WriterSettings settings;
    settings.dims = dims, settings.wavelets = wavelets;
    ChannelSettings& c = settings.channels[0];
    c.range = Range{-8, 8}, c.value_type = ValueType::u16, c.wavelet_error = wavelets ? 0.01 : 0;
    return settings;
  }
  [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }

  // Writes what the settings ask for on the machine's target of this number.
  void write(WriterSettings settings, const std::string& name, size_t number) {
    size_t at = 0;
    settings.path = file(name), settings.overwrite = true;
    test::for_targets([&] {
      if (at++ != number % targets_) return;
      Bench bench(2);
      VolumeWriter writer(settings, nullptr, bench.context);
      const auto [first, end] = writer.given_frames();
      for (auto t = static_cast<uint32_t>(first); t < end; ++t) {
        const FrameBox box = series_.box(t);
        writer.add_frame(0, t, {&box, 1});
      }
      (void)writer.finish();
    });
  }
  static PartSettings part(uint32_t first, uint32_t end) {
    PartSettings part{SeriesBlock::of_frames(first, end), 0, {}};
    for (uint32_t t = 0; t < dims[3]; ++t) part.times.push_back(t);
    return part;
  }
  [[nodiscard]] std::vector<char> bytes(const std::string& name) const {
    std::ifstream in(file(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

 private:
  const Series series_ = test::noise(dims, 3);
  size_t targets_ = 0;
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("bccsplat-targets-" + std::to_string(getpid()));
};

TEST_F(SeveralTargets, PartsJoined) {
  for (const bool wavelets : {false, true}) {
    SCOPED_TRACE(wavelets);
    write(settings_of(wavelets), "whole", 0);
    for (const size_t turn : {0, 2}) {
      std::vector<std::string> names;
      for (const uint32_t first : {0u, 7u, 8u, 24u}) {
        WriterSettings settings = settings_of(wavelets);
        settings.part = part(first, first == 0 ? 7 : first == 7 ? 8 : first == 8 ? 24 : dims[3]);
        names.push_back("part" + std::to_string(first));
        write(settings, names.back(), turn + names.size());
      }
      Bench bench(1);
      for (std::string& name : names) name = file(name);
      (void)join_parts(open_parts(names), file("joined"), true, false, bench.context);
      EXPECT_EQ(bytes("joined"), bytes("whole"));
    }
  }
}

TEST_F(SeveralTargets, ASeriesThatGoesOn) {
  for (const bool wavelets : {false, true}) {
    SCOPED_TRACE(wavelets);
    write(settings_of(wavelets), "whole", 0);
    for (const size_t turn : {0, 2}) {
      WriterSettings settings = settings_of(wavelets);
      settings.dims[3] = 34;
      write(settings, "series", turn);
      settings.dims = dims, settings.continuity = Continuity::append;
      settings.part = part(34, dims[3]);
      write(settings, "series", turn + 1);
      EXPECT_EQ(bytes("series"), bytes("whole"));
    }
  }
}

} // namespace
} // namespace bccsplat

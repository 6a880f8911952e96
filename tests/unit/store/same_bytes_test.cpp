// A file does not depend on the machine that writes it: parts of a series may come from several.
#include <gtest/gtest.h>

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
  VolumeWriter writer(settings, create_memory_sink(bytes), bench.context());
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
      {"coefficients", [](WriterSettings& s) { s.coefficients = true; }},
      {"coefficients in steps",
       [](WriterSettings& s) { s.coefficients = true, s.channels[0].value_type = ValueType::u16; }},
      {"predicted, coarse, low-pass",
       [](WriterSettings& s) { s.ends = Ends::predict, s.scale = 1.3, s.lowpass = true; }},
      {"Cartesian steps",
       [](WriterSettings& s) {
         s.lattice = LatticeKind::cc, s.coefficients = true, s.channels[0].value_type = ValueType::u8;
       }},
      {"bounded", [](WriterSettings& s) { s.abs_error = 0.2, s.channels[0].value_type = ValueType::u16; }}};
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

} // namespace
} // namespace bccsplat

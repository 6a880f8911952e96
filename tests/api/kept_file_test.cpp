// SPDX-License-Identifier: Apache-2.0
// What a writer that is not finished keeps, and who goes on with it.
#include "host_streams.h"

namespace host {
namespace {

NoiseSeries series_of(uint32_t frames) {
  NoiseSeries series;
  series.nx = 24, series.ny = 20, series.nz = 18, series.nt = frames;
  return series;
}

struct Kept {
  Folder folder;
  Device device = make_device();
  NoiseSeries series = series_of(40);
  std::string path = folder.file("s.bcc4");

  [[nodiscard]] Writer writer(bccsplat_partial partial) const {
    auto o = series.options();
    o.partial = partial;
    bccsplat_writer* w = nullptr;
    EXPECT_OK(bccsplat_writer_create(device.get(), path.c_str(), &o, &w));
    return Writer(w);
  }
  void add(const Writer& writer, uint32_t frames) const {
    for (uint32_t t = 0; t < frames; ++t) {
      const std::vector<float> values = series.frame(t);
      auto box = sized<bccsplat_box>();
      box.type = BCCSPLAT_TYPE_F32, box.data = values.data();
      box.dims[0] = series.nx, box.dims[1] = series.ny, box.dims[2] = series.nz;
      ASSERT_OK(bccsplat_writer_add_frame(writer.get(), 0, t, &box, 1));
    }
  }
  [[nodiscard]] bool is_there(const char* end) const { return std::filesystem::exists(path + end); }
};

// Small and quick enough never to be committed meanwhile.
TEST(KeptFile, HoldsAllThatWasCodedWhenItsWriterWasLetGo) {
  const Kept kept;
  kept.add(kept.writer(BCCSPLAT_PARTIAL_KEEP), 33);
  ASSERT_TRUE(kept.is_there(".partial") && kept.is_there(".journal"));
  const Writer writer = kept.writer(BCCSPLAT_PARTIAL_RESUME);
  kept.add(writer, 40);
  auto report = sized<bccsplat_writer_report>();
  ASSERT_OK(bccsplat_writer_finish(writer.get(), &report));
  EXPECT_GE(report.slabs_reused, 5u); // of eight layers each
  EXPECT_FALSE(kept.is_there(".partial") || kept.is_there(".journal"));
}

TEST(KeptFile, GoesWithAWriterThatBeginsAnew) {
  const Kept kept;
  kept.add(kept.writer(BCCSPLAT_PARTIAL_KEEP), 33);
  {
    const Writer anew = kept.writer(BCCSPLAT_PARTIAL_DEFAULT);
    EXPECT_FALSE(kept.is_there(".journal"));
  }
  EXPECT_FALSE(kept.is_there(".partial"));
}

} // namespace
} // namespace host

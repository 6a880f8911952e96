// SPDX-License-Identifier: Apache-2.0
// What a stream fails to read is neither sound nor damaged: verify tells it apart, and a salvaged volume
// takes it for a hole only where it is asked to.
#include "host_streams.h"

namespace host {
namespace {

// A file in which the chunks that the slice of one moment reads fail or are damaged.
struct BadFile {
  Device device = make_device();
  FarFile file;
  std::vector<Range> chunks; // read for the moment, behind all tables

  explicit BadFile(double abs_error = 0) : file(make(device, abs_error)) {
    const Volume volume = open(0);
    const auto plane = plane_of(0, 0, 0, 1, -4.4);
    uint64_t count = 0;
    EXPECT_OK(bccsplat_volume_get_ranges(volume.get(), &plane, nullptr, 0, nullptr, 0, &count));
    file.forget();
    EXPECT_OK(cut(volume, 4.4));
    chunks = file.reads;
    file.forget();
  }
  static std::vector<char> make(const Device& device, double abs_error) {
    NoiseSeries series;
    series.nx = 36, series.ny = 20, series.nz = 18;
    auto o = series.options();
    o.abs_error = abs_error;
    return written(device, series, o);
  }
  [[nodiscard]] Volume open(int32_t salvage) {
    auto o = sized<bccsplat_volume_options>();
    o.salvage = salvage;
    const bccsplat_read_stream stream = file.stream();
    bccsplat_volume* v = nullptr;
    EXPECT_OK(bccsplat_volume_open_stream(device.get(), &stream, &o, &v));
    return Volume(v);
  }
  // Whether some of the slice is missing stands in `holes`.
  bccsplat_status cut(const Volume& volume, double frame, bool* holes = nullptr) {
    const auto plane = plane_of(0, 0, 0, 1, -frame);
    bccsplat_slice* s = nullptr;
    const bccsplat_status status = bccsplat_slice_create(volume.get(), &plane, nullptr, &s);
    const Slice slice(s);
    if (status != BCCSPLAT_OK || !holes) return status;
    std::vector<float> values(36 * 20 * 18);
    EXPECT_OK(bccsplat_slice_sample_grid(s, nullptr, values.data()));
    *holes = std::any_of(values.begin(), values.end(), [](float v) { return std::isnan(v); });
    return status;
  }
  void fail() { file.failing = chunks; }
  void damage() {
    for (const auto& [offset, size] : chunks) file.bytes[offset + size / 2] ^= 0x55;
  }
};

[[nodiscard]] bccsplat_verify_report verified(const Volume& volume, bccsplat_status expected) {
  auto report = sized<bccsplat_verify_report>();
  EXPECT_EQ(bccsplat_volume_verify(volume.get(), nullptr, nullptr, &report), expected)
      << bccsplat_last_error();
  return report;
}

TEST(Unreadable, VerifyTellsItFromDamage) {
  BadFile bad;
  const Volume volume = bad.open(0);
  const bccsplat_verify_report sound = verified(volume, BCCSPLAT_OK);
  EXPECT_EQ(sound.unreadable, 0u);
  EXPECT_EQ(sound.first_unreadable_offset, 0u);
  bad.fail();
  bccsplat_verify_report report = verified(volume, BCCSPLAT_ERROR_IO);
  EXPECT_EQ(report.damages, 0u);
  EXPECT_EQ(report.chunks_damaged, 0u);
  EXPECT_EQ(report.chunks, sound.chunks);
  EXPECT_GE(report.unreadable, bad.chunks.size());
  EXPECT_EQ(report.first_unreadable_offset, std::min_element(bad.chunks.begin(), bad.chunks.end())->first);
  EXPECT_LT(report.bytes_checked, sound.bytes_checked);
  EXPECT_NE(std::string(bccsplat_last_error()).find("could not"), std::string::npos);
  // Damage beside it is still found.
  bad.damage();
  ASSERT_GE(bad.chunks.size(), 2u);
  bad.file.failing = {bad.chunks.back()};
  report = verified(volume, BCCSPLAT_ERROR_IO);
  EXPECT_GE(report.damages, 1u);
  EXPECT_EQ(report.chunks_damaged, report.damages);
  EXPECT_GE(report.unreadable, 1u);
  const uint64_t damages = report.damages;
  bad.file.failing.clear();
  report = verified(volume, BCCSPLAT_OK);
  EXPECT_GT(report.damages, damages);
  EXPECT_EQ(report.unreadable, 0u);
}

// Of each byte in turn: what fails is never damage.
TEST(Unreadable, VerifyFailsWhereverItIs) {
  for (const double bound : {0.0, 3.0}) { // with corrections, whose tables the root counts
    SCOPED_TRACE(bound);
    BadFile bad(bound);
    const Volume volume = bad.open(0);
    int failed = 0;
    for (uint64_t at = 0; at < bad.file.bytes.size(); at += 97) {
      bad.file.failing = {{at, 97}};
      auto report = sized<bccsplat_verify_report>();
      const bccsplat_status status = bccsplat_volume_verify(volume.get(), nullptr, nullptr, &report);
      EXPECT_EQ(report.damages, 0u) << at;
      EXPECT_EQ(status == BCCSPLAT_OK, report.unreadable == 0) << at;
      EXPECT_TRUE(status == BCCSPLAT_OK || status == BCCSPLAT_ERROR_IO) << at;
      failed += status == BCCSPLAT_ERROR_IO;
    }
    EXPECT_GT(failed, 10);
  }
}

TEST(Unreadable, SalvagesWhatIsDamagedAndAsksAgainForTheRest) {
  BadFile bad;
  bool holes = false;
  {
    const Volume volume = bad.open(1);
    bad.fail();
    EXPECT_EQ(bad.cut(volume, 4.4), BCCSPLAT_ERROR_IO);
    bad.file.failing.clear();
    EXPECT_OK(bad.cut(volume, 4.4, &holes)); // nothing was taken for lost meanwhile
    EXPECT_FALSE(holes);
  }
  bad.fail();
  {
    const Volume volume = bad.open(2);
    EXPECT_OK(bad.cut(volume, 4.4, &holes));
    EXPECT_TRUE(holes);
  }
  bad.file.failing.clear();
  bad.damage();
  {
    const Volume volume = bad.open(1);
    EXPECT_OK(bad.cut(volume, 4.4, &holes));
    EXPECT_TRUE(holes);
  }
  const Volume volume = bad.open(0);
  EXPECT_NE(bad.cut(volume, 4.4), BCCSPLAT_OK);
}

// A stream whose end has moved since it was opened.
struct Shortened {
  FarFile& file;
  uint64_t end;

  static int64_t read_at(void* user, uint64_t offset, void* to, uint64_t size) {
    const auto& s = *static_cast<Shortened*>(user);
    const uint64_t there = offset < s.end ? std::min(size, s.end - offset) : 0;
    return there == 0 ? 0 : FarFile::read_at(&s.file, offset, to, there);
  }
};

// Cut before it is opened a file has no tables any more; cut later it has lost what is gone, and its host
// hears that as of other damage.
TEST(Unreadable, BytesThatAreGoneAreDamage) {
  BadFile bad;
  for (const int32_t salvage : {0, 1, 2}) {
    Shortened s{bad.file, bad.file.bytes.size()};
    auto stream = bad.file.stream();
    stream.read_at = Shortened::read_at, stream.user = &s;
    auto o = sized<bccsplat_volume_options>();
    o.salvage = salvage;
    bccsplat_volume* v = nullptr;
    ASSERT_OK(bccsplat_volume_open_stream(bad.device.get(), &stream, &o, &v));
    const Volume volume(v);
    s.end = std::max_element(bad.chunks.begin(), bad.chunks.end())->first + 10;
    bool holes = false;
    EXPECT_EQ(bad.cut(volume, 4.4, &holes), salvage == 0 ? BCCSPLAT_ERROR_TRUNCATED : BCCSPLAT_OK);
    EXPECT_EQ(holes, salvage != 0);
    const bccsplat_verify_report report = verified(volume, BCCSPLAT_OK);
    EXPECT_GT(report.damages, 0u);
    EXPECT_EQ(report.unreadable, 0u);
    stream.size = s.end;
    bccsplat_volume* cut = nullptr;
    EXPECT_EQ(bccsplat_volume_open_stream(bad.device.get(), &stream, &o, &cut), BCCSPLAT_ERROR_TRUNCATED);
  }
}

// The number of corrections is the file's, whether they could be read or not.
TEST(Unreadable, CorrectionsAreCountedWithoutReading) {
  BadFile bad(3);
  auto whole = sized<bccsplat_channel_info>();
  ASSERT_OK(bccsplat_volume_get_channel_info(bad.open(0).get(), 0, &whole));
  ASSERT_GT(whole.corrections, 0u);
  bad.file.forget();
  const Volume volume = bad.open(0);
  const size_t opening = bad.file.reads.size();
  auto info = sized<bccsplat_channel_info>();
  ASSERT_OK(bccsplat_volume_get_channel_info(volume.get(), 0, &info));
  EXPECT_EQ(bad.file.reads.size(), opening);
  EXPECT_EQ(info.corrections, whole.corrections);
}

} // namespace
} // namespace host

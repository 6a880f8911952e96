// SPDX-License-Identifier: Apache-2.0
// The NIfTI reader on headers made byte by byte: byte orders, scaling, transforms and times, and damaged
// headers.
#include "readers/nifti/nifti_reader.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scratch.h"

namespace bcc4::test {
namespace {

// A NIfTI-1 header with the fields the reader looks at; i16 voxels 2 x 3 x 4 x `frames`.
class Nifti1 {
 public:
  explicit Nifti1(bool swapped = false, int16_t frames = 5) : swapped_(swapped), bytes_(352, '\0') {
    put<int32_t>(0, 348);
    for (const int16_t n :
         {int16_t{4}, int16_t{2}, int16_t{3}, int16_t{4}, frames, int16_t{1}, int16_t{1}, int16_t{1}})
      put<int16_t>(40 + 2 * next_dim_++, n);
    put<int16_t>(70, 4);
    put<int16_t>(72, 16);
    for (size_t i = 0; i < 8; ++i)
      put<float>(76 + 4 * i, std::array{1.0f, 2.0f, 3.0f, 4.0f, 2.5f, 0.f, 0.f, 0.f}[i]);
    put<float>(108, 352);
    bytes_[123] = 2 | 16; // mm, ms
    std::memcpy(bytes_.data() + 344, "n+1", 4);
  }
  template<class T> void put(size_t at, T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (swapped_) std::reverse(raw, raw + sizeof(T));
    std::copy(raw, raw + sizeof(T), bytes_.begin() + at);
  }
  [[nodiscard]] std::string file(size_t voxels = 120) const {
    std::vector<int16_t> v(voxels);
    std::iota(v.begin(), v.end(), int16_t{0});
    return bytes_ + bytes_of(v, swapped_);
  }
  std::string& bytes() { return bytes_; }

 private:
  bool swapped_;
  std::string bytes_;
  size_t next_dim_ = 0;
};

TEST(NiftiReader, ReadsBothByteOrdersPlainAndGzip) {
  Scratch s;
  for (const bool swapped : {false, true}) {
    const std::string file = Nifti1(swapped).file();
    for (const std::string& path : {s.file("a.nii", file), s.file("b.nii.gz", gzipped(file))}) {
      const auto reader = open_series(inputs({path}));
      const SeriesDescription& d = reader->description();
      ASSERT_EQ(d.dims, (std::array<uint64_t, 4>{2, 3, 4, 5}));
      EXPECT_EQ(d.times.unit, "ms");
      EXPECT_EQ(d.times.values, (std::vector<double>{0, 2.5, 5, 7.5, 10}));
      EXPECT_EQ(d.spatial_unit, "mm");
      EXPECT_EQ(d.affine, (std::array<double, 16>{2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 0, 0, 0, 1}));
      EXPECT_EQ(dense(*reader, 3)[23], 95);
    }
  }
}

TEST(NiftiReader, ScalesUnlessTheSlopeIsZero) {
  Scratch s;
  Nifti1 n;
  n.put<float>(112, 0);
  n.put<float>(116, 7);
  EXPECT_EQ(dense(*open_series(inputs({s.file("a.nii", n.file())})), 0)[3], 3);
  n.put<float>(112, 0.5f);
  const auto reader = open_series(inputs({s.file("a.nii", n.file())}));
  EXPECT_EQ(dense(*reader, 0)[3], 8.5);
  EXPECT_EQ(reader->description().channels[0].type, Type::f32);
}

TEST(NiftiReader, TakesTheSformThenTheQform) {
  Scratch s;
  Nifti1 n;
  n.put<int16_t>(252, 1); // a quarter turn about z: x -> y
  n.put<float>(264, std::sqrt(0.5f));
  n.put<float>(268, 10);
  const auto turned = open_series(inputs({s.file("q.nii", n.file())}))->description().affine;
  const std::array<double, 16> expected{0, -3, 0, 10, 2, 0, 0, 0, 0, 0, 4, 0, 0, 0, 0, 1};
  for (size_t i = 0; i < 16; ++i) EXPECT_NEAR(turned[i], expected[i], 1e-6) << i;
  n.put<int16_t>(254, 1);
  for (size_t i = 0; i < 12; ++i) n.put<float>(280 + 4 * i, i % 5 == 0 ? 9.0f : 0.0f);
  EXPECT_EQ(open_series(inputs({s.file("s.nii", n.file())}))->description().affine[5], 9);
}

bool notes(const SeriesDescription& d, const std::string& text) {
  return std::any_of(d.notes.begin(), d.notes.end(),
                     [&](const std::string& n) { return n.find(text) != std::string::npos; });
}

// Rows of an sform with these steps along the axes.
void put_sform(Nifti1& n, std::array<float, 3> steps, int16_t code = 1) {
  n.put<int16_t>(254, code);
  for (size_t i = 0; i < 12; ++i) n.put<float>(280 + 4 * i, i % 5 == 0 ? steps[i / 5] : 0.0f);
}

TEST(NiftiReader, AnSformOfZerosGivesWayToTheQform) {
  Scratch s;
  Nifti1 n;
  put_sform(n, {0, 0, 0});
  EXPECT_REFUSED(refusal(inputs({s.file("a.nii", n.file())})), Exit::bad_input,
                 "spans no volume: give --spacing");
  n.put<int16_t>(252, 1);
  n.put<float>(268, 7);
  for (const float flat : {0.0f, 2.0f}) {
    put_sform(n, {flat, flat, 0});
    const SeriesDescription d = open_series(inputs({s.file("a.nii", n.file())}))->description();
    EXPECT_EQ(d.affine, (std::array<double, 16>{2, 0, 0, 7, 0, 3, 0, 0, 0, 0, 4, 0, 0, 0, 0, 1}));
    EXPECT_EQ(d.affine_origin, "qform, code 1");
    EXPECT_TRUE(notes(d, "sform spans no volume"));
  }
}

TEST(NiftiReader, TellsFormsOfTwoHandednesses) {
  Scratch s;
  Nifti1 n;
  n.put<int16_t>(252, 1);
  put_sform(n, {-2, 3, 4});
  const SeriesDescription d = open_series(inputs({s.file("a.nii", n.file())}))->description();
  EXPECT_EQ(d.affine[0], -2);
  EXPECT_TRUE(notes(d, "left and right swapped"));
  put_sform(n, {2, 3, 4});
  EXPECT_FALSE(notes(open_series(inputs({s.file("b.nii", n.file())}))->description(), "swapped"));
}

TEST(NiftiReader, ScalesFloats) {
  Scratch s;
  Nifti1 n(false, 1);
  n.put<float>(112, 2);
  n.put<float>(116, 5);
  n.put<int16_t>(70, 16);
  const auto wide = [](double i) { return i * 100 / 23; };
  std::vector<float> floats;
  std::vector<double> doubles;
  for (int i = 0; i < 24; ++i) floats.push_back(static_cast<float>(wide(i))), doubles.push_back(wide(i));
  EXPECT_EQ(dense(*open_series(inputs({s.file("f.nii", n.bytes() + bytes_of(floats))})), 0)[23], 205);
  n.put<int16_t>(70, 64);
  EXPECT_EQ(dense(*open_series(inputs({s.file("d.nii", n.bytes() + bytes_of(doubles))})), 0)[23], 205);
}

// What export gives back as integers is told by the type of the source, not by that of the values read.
TEST(NiftiReader, IntegersOfAnyWidthAreSuch) {
  Scratch s;
  Nifti1 n(false, 1);
  const auto precision = [&](int16_t code, const std::string& voxels) {
    n.put<int16_t>(70, code);
    const auto reader = open_series(inputs({s.file("a.nii", n.bytes() + voxels)}));
    EXPECT_EQ(dense(*reader, 0)[7], 12101) << code;
    return reader->description().channels[0].precision;
  };
  EXPECT_EQ(precision(8, bytes_of(std::vector<int32_t>(24, 12101))), Type::i32);
  EXPECT_EQ(precision(768, bytes_of(std::vector<uint32_t>(24, 12101))), Type::u32);
  EXPECT_EQ(precision(1024, bytes_of(std::vector<int64_t>(24, 12101))), Type::i64);
}

TEST(NiftiReader, ReadsPairsAndNamesAnalyze) {
  Scratch s;
  Nifti1 n;
  const std::string voxels = n.file().substr(352);
  n.put<float>(108, 0);
  std::memcpy(n.bytes().data() + 344, "ni1", 4);
  s.file("p.hdr", n.bytes().substr(0, 348));
  EXPECT_REFUSED(refusal(inputs({s.path("p.hdr")})), Exit::bad_input, "p.img is missing");
  s.file("p.img", voxels);
  EXPECT_EQ(dense(*open_series(inputs({s.path("p.hdr")})), 3)[23], 95);
  EXPECT_REFUSED(refusal(inputs({s.path("p.img")})), Exit::bad_input, "p.hdr");
  s.file("q.hdr", n.bytes().substr(0, 348));
  s.file("q.img.gz", gzipped(voxels));
  EXPECT_EQ(dense(*open_series(inputs({s.path("q.hdr")})), 3)[23], 95);
  EXPECT_REFUSED(refusal(inputs({s.file("an.hdr", n.bytes().substr(0, 344) + std::string(4, '\0'))})),
                 Exit::bad_input, "an ANALYZE header");
}

TEST(NiftiReader, FilesOfASequenceAgreeInPlaceAndScaling) {
  Scratch s;
  Nifti1 n(false, 1);
  put_sform(n, {2, 2, 3});
  s.file("a_0.nii", n.file(24));
  s.file("a_1.nii", n.file(24));
  EXPECT_EQ(refusal(inputs({s.path("a_%d.nii")})).exit, Exit::ok);
  Nifti1 mirrored = n;
  put_sform(mirrored, {-2, 2, 3});
  s.file("a_1.nii", mirrored.file(24));
  EXPECT_REFUSED(refusal(inputs({s.path("a_%d.nii")})), Exit::bad_input, "a_1.nii: its spacing, directions");
  n.put<float>(112, 2);
  s.file("a_1.nii", n.file(24));
  EXPECT_REFUSED(refusal(inputs({s.path("a_%d.nii")})), Exit::bad_input, "convert the files to one scaling");
}

TEST(NiftiReader, KeepsItsText) {
  Scratch s;
  Nifti1 n;
  std::memcpy(n.bytes().data() + 148, "TE=30;phase=1", 13);
  std::memcpy(n.bytes().data() + 328, "bold", 4);
  const auto kept = [&] {
    return told(open_series(inputs({s.file("a.nii", n.file())}))->description(), "channel.bold");
  };
  EXPECT_EQ(kept(), "{\"description\":\"TE=30;phase=1\"}");
  std::memcpy(n.bytes().data() + 148, "bcc4\0", 5); // its own
  EXPECT_EQ(kept(), "");
}

TEST(NiftiReader, DoesNotGuessTimes) {
  Scratch s;
  Nifti1 n;
  n.put<float>(76 + 16, 0); // pixdim[4]
  const auto reader = open_series(inputs({s.file("a.nii", n.file())}));
  EXPECT_EQ(reader->description().times.values[4], 4);
  EXPECT_NE(reader->description().times.origin.find("none given"), std::string::npos);
  EXPECT_EQ(reader->description().times.unit, ""); // of what is counted
  EXPECT_EQ(open_series(inputs({s.file("b.nii", Nifti1(false, 1).file(24))}))->description().times.unit, "");
  ReaderOptions told = inputs({s.path("a.nii")});
  told.dt = 2;
  EXPECT_EQ(open_series(told)->description().times.unit, "ms");
  n.bytes()[123] = 32; // hertz
  EXPECT_REFUSED(refusal(inputs({s.file("a.nii", n.file())})), Exit::bad_input, "hertz");
}

TEST(NiftiReader, RefusesDamage) {
  Scratch s;
  const auto refused = [&](const std::string& text) { return refusal(inputs({s.file("a.nii", text)})); };
  EXPECT_REFUSED(refused(Nifti1().file(119)), Exit::bad_input, "are expected");
  EXPECT_REFUSED(refused(Nifti1(false, 0).file()), Exit::bad_input, "dim[4] is 0");
  EXPECT_REFUSED(refused(Nifti1(false, -1).file()), Exit::bad_input, "dim[4] is -1");
  Nifti1 quadruple;
  quadruple.put<int16_t>(70, 1536);
  EXPECT_REFUSED(refused(quadruple.file()), Exit::bad_input, "data type 1536");
  Nifti1 six;
  six.put<int16_t>(40, 6), six.put<int16_t>(52, 2);
  EXPECT_REFUSED(refused(six.file()), Exit::bad_input, "2 values per voxel (dim[6])");
  Nifti1 offset;
  offset.put<float>(108, -1);
  EXPECT_REFUSED(refused(offset.file()), Exit::bad_input, "vox_offset");
  EXPECT_REFUSED(refused(Nifti1().file().substr(0, 200)), Exit::bad_input,
                 "does not begin as a file of nifti");
}

// A NIfTI-2 header of u8 and 8 bytes of data.
std::string nifti2(std::array<int64_t, 5> dims, int64_t offset) {
  std::string bytes(544, '\0');
  const auto put = [&](size_t at, auto value) { std::memcpy(bytes.data() + at, &value, sizeof value); };
  put(0, int32_t{540});
  std::memcpy(bytes.data() + 4, "n+2\0\r\n\x1a\n", 8);
  put(12, int16_t{2}), put(14, int16_t{8});
  for (size_t i = 0; i < 8; ++i) put(16 + 8 * i, i < 5 ? dims[i] : int64_t{1}), put(104 + 8 * i, 1.0);
  put(168, offset);
  return bytes + std::string(8, '\1');
}

// Products that wrap around, sizes that no file holds, lengths and offsets below zero.
TEST(NiftiReader, RefusesWideDamage) {
  Scratch s;
  const auto refused = [&](const std::string& text) { return refusal(inputs({s.file("a.nii", text)})); };
  constexpr int64_t wide = int64_t{1} << 31;
  EXPECT_EQ(refused(nifti2({3, 2, 2, 2, 1}, 544)).exit, Exit::ok);
  EXPECT_REFUSED(refused(nifti2({3, wide, wide, 4, 1}, 544)), Exit::bad_input, "too many");
  EXPECT_REFUSED(refused(nifti2({4, 2 * wide, 2 * wide, 1, 1}, 544)), Exit::bad_input, "too many");
  EXPECT_REFUSED(refused(nifti2({3, 1000, 1000, 1000, 1}, 544)), Exit::bad_input, "are expected");
  EXPECT_REFUSED(refused(nifti2({3, 2, 2, -2, 1}, 544)), Exit::bad_input, "dim[3] is -2");
  EXPECT_REFUSED(refused(nifti2({3, 2, 2, 2, 1}, -400)), Exit::bad_input, "vox_offset");
  EXPECT_REFUSED(refused(nifti2({3, 2, 2, 2, 1}, int64_t{1} << 62)), Exit::bad_input, "vox_offset");
}

TEST(NiftiReader, SurvivesMutations) {
  Scratch s;
  const std::string good = Nifti1().file();
  size_t refused = 0;
  for (size_t i = 0; i < 352; ++i)
    for (const char c : {'\0', '\1', '\x7f', '\xff'}) {
      if ((i + static_cast<uint8_t>(c)) % 3 != 0) continue; // a third of them keeps the test short
      std::string bad = good;
      bad[i] = c;
      refused += refusal(inputs({s.file("m.nii", bad)})).exit != Exit::ok;
    }
  EXPECT_GT(refused, 20u);
}

} // namespace
} // namespace bcc4::test

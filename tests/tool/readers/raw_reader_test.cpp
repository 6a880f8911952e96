// SPDX-License-Identifier: Apache-2.0
// The reader of raw arrays: orders of axes, types, gzip, several arrays and frames, memory, sizes that do not
// fit, and the warnings about data that look wrongly declared.
#include "readers/raw/raw_reader.h"

#include <cmath>
#include <numeric>
#include <random>

#include "readers/decoders.h"
#include "scratch.h"

namespace bcc4::test {
namespace {

constexpr std::array<uint64_t, 4> kDims{3, 4, 5, 6};

// Returns a value that says where it is.
double value_at(uint64_t x, uint64_t y, uint64_t z, uint64_t t) {
  return static_cast<double>(x + 10 * y + 100 * z + 1000 * t);
}

// Returns all samples in the file order of `axes`, fastest first.
template<class T>
std::vector<T> file_values(const std::string& axes, const std::array<uint64_t, 4>& dims = kDims) {
  std::vector<T> out;
  std::array<uint64_t, 4> i{}; // along the file's axes
  std::array<size_t, 4> axis{0, 1, 2, 3};
  for (size_t a = 0; a < axes.size(); ++a) axis[a] = std::string("xyzt").find(axes[a]);
  const auto n = [&](size_t a) { return a < axes.size() ? dims[axis[a]] : 1; };
  for (i[3] = 0; i[3] < n(3); ++i[3])
    for (i[2] = 0; i[2] < n(2); ++i[2])
      for (i[1] = 0; i[1] < n(1); ++i[1])
        for (i[0] = 0; i[0] < n(0); ++i[0]) {
          std::array<uint64_t, 4> p{};
          for (size_t a = 0; a < axes.size(); ++a) p[axis[a]] = i[a];
          out.push_back(static_cast<T>(value_at(p[0], p[1], p[2], p[3])));
        }
  return out;
}

void expect_series(const ReaderOptions& options) {
  const auto reader = open_series(options);
  ASSERT_EQ(reader->description().dims, kDims);
  for (const uint64_t t : {0, 1, 2, 3, 4, 5, 2, 0}) { // back in time, too
    const auto values = dense(*reader, t);
    size_t i = 0;
    for (uint64_t z = 0; z < kDims[2]; ++z)
      for (uint64_t y = 0; y < kDims[1]; ++y)
        for (uint64_t x = 0; x < kDims[0]; ++x)
          ASSERT_EQ(values[i++], value_at(x, y, z, t)) << x << y << z << t;
  }
}

ReaderOptions raw(const std::string& path, Type type) {
  ReaderOptions o = inputs({path});
  o.dims = kDims;
  o.dtype = type;
  return o;
}

TEST(RawReader, ReadsEveryAxisOrder) {
  Scratch s;
  std::string order = "xyzt";
  std::sort(order.begin(), order.end());
  do {
    ReaderOptions o = raw(s.file("a.raw", bytes_of(file_values<uint16_t>(order))), Type::u16);
    o.axes = order;
    expect_series(o);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(RawReader, NeedsNoMoreMemoryThanItIsGiven) {
  Scratch s;
  for (const char* order : {"txyz", "xtyz", "xytz"}) {
    ReaderOptions o = raw(s.file("a.raw", bytes_of(file_values<uint16_t>(order))), Type::u16);
    o.axes = order;
    o.max_memory = 2 * 3 * 4 * 5 * 2 * 2; // two frames in half of it: three passes over the file
    expect_series(o);
    o.max_memory = 3 * 4 * 5 * 2 - 1;
    EXPECT_REFUSED(refusal(o), Exit::no_resources, "--max-mem");
  }
}

TEST(RawReader, ReadsTypesAndByteOrders) {
  Scratch s;
  const auto both = [&]<class T>(T, Type type) {
    for (const bool big : {false, true}) {
      ReaderOptions o = raw(s.file("a.raw", bytes_of(file_values<T>("xyzt"), big)), type);
      o.big_endian = big;
      expect_series(o);
    }
  };
  both(uint16_t{}, Type::u16);
  both(int16_t{}, Type::i16);
  both(int32_t{}, Type::i32);
  both(uint32_t{}, Type::u32);
  both(int64_t{}, Type::i64);
  both(float{}, Type::f32);
  both(double{}, Type::f64);
}

TEST(RawReader, ReadsGzipSkipsAndFilesPerFrame) {
  Scratch s;
  const std::string bytes = bytes_of(file_values<float>("xyzt")), head = "header!";
  ReaderOptions o = raw(s.file("a.raw", head + bytes), Type::f32);
  o.skip = head.size();
  expect_series(o);
  o.inputs = {s.file("a.raw.gz", gzipped(head + bytes))};
  expect_series(o);
  o.inputs = {s.file("members.gz", gzipped(head + bytes.substr(0, 100)) + gzipped(bytes.substr(100)))};
  expect_series(o);
  const size_t frame = bytes.size() / kDims[3];
  for (uint64_t t = 0; t < kDims[3]; ++t) {
    s.file(concat("f.", t, ".raw"), bytes.substr(t * frame, frame));
    s.file(concat("g.", t, ".gz"), gzipped(bytes.substr(t * frame, frame)));
  }
  o.skip.reset();
  o.dims = {kDims[0], kDims[1], kDims[2], 0};
  o.inputs = {s.path("f.%d.raw")};
  expect_series(o);
  o.inputs = {s.path("g.*.gz")};
  expect_series(o);
}

// Expects of a file of several arrays that every value of array c of frame t says where it is.
void expect_arrays(const ReaderOptions& o, const std::vector<uint64_t>& arrays, uint64_t frames) {
  const auto reader = open_series(o);
  const SeriesDescription& d = reader->description();
  ASSERT_EQ(d.channels.size(), arrays.size());
  ASSERT_EQ(d.dims, (std::array<uint64_t, 4>{4, 3, 2, frames}));
  for (uint64_t t = 0; t < frames; ++t)
    for (size_t c = 0; c < arrays.size(); ++c) {
      EXPECT_EQ(d.channels[c].name, concat("c", arrays[c]));
      for (size_t i = 0; i < 24; ++i)
        ASSERT_EQ(dense(*reader, t, c)[i], static_cast<double>(i + 100 * arrays[c] + 1000 * t));
    }
}

TEST(RawReader, ReadsSeveralArrays) {
  Scratch s;
  const auto bytes = [](const std::array<uint64_t, 3>& sizes, auto value) { // fastest first
    std::vector<float> v;
    for (uint64_t k = 0; k < sizes[2]; ++k)
      for (uint64_t j = 0; j < sizes[1]; ++j)
        for (uint64_t i = 0; i < sizes[0]; ++i) v.push_back(static_cast<float>(value(i, j, k)));
    return bytes_of(v);
  };
  ReaderOptions o = inputs(
      {s.file("a.raw", bytes({24, 3, 5}, [](auto i, auto c, auto t) { return i + 100 * c + 1000 * t; }))});
  o.dims = {4, 3, 2, 5}, o.dtype = Type::f32, o.count = 3;
  expect_arrays(o, {0, 1, 2}, 5);
  o.channels = {"c2", "0"};
  expect_arrays(o, {2, 0}, 5);
  o.channels.clear();
  // Interleaved, and the arrays as the slowest axis.
  o.axes = "cxyzt";
  o.inputs = {
      s.file("b.raw", bytes({3, 24, 5}, [](auto c, auto i, auto t) { return i + 100 * c + 1000 * t; }))};
  expect_arrays(o, {0, 1, 2}, 5);
  o.axes = "xyztc";
  o.inputs = {
      s.file("c.raw", bytes({24, 5, 3}, [](auto i, auto t, auto c) { return i + 100 * c + 1000 * t; }))};
  expect_arrays(o, {0, 1, 2}, 5);
  // A file per frame.
  o.axes.reset();
  o.dims = {4, 3, 2, 0};
  for (uint64_t t = 0; t < 2; ++t)
    s.file(concat("f.", t, ".raw"),
           bytes({24, 3, 1}, [t](auto i, auto c, auto) { return i + 100 * c + 1000 * t; }));
  o.inputs = {s.path("f.%d.raw")};
  expect_arrays(o, {0, 1, 2}, 2);
  o.count = 4;
  EXPECT_REFUSED(refusal(o), Exit::bad_input, "4 x 3 x 2 x 4 x 4 bytes (f32) = 384");
  o.count.reset();
  o.axes = "cxyz";
  EXPECT_REFUSED(refusal(o), Exit::usage, "--count");
  ReaderOptions nrrd =
      inputs({s.file("a.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n\n" +
                                   std::string(24, 'x'))});
  nrrd.count = 2;
  EXPECT_REFUSED(refusal(nrrd), Exit::usage, "--count describes raw files");
  nrrd.count.reset();
  nrrd.origin = {1, -2, 3.5}, nrrd.spacing = {2, 2, 4};
  EXPECT_EQ(open_series(nrrd)->description().affine,
            (std::array<double, 16>{2, 0, 0, 1, 0, 2, 0, -2, 0, 0, 4, 3.5, 0, 0, 0, 1}));
}

TEST(RawReader, SelectsFramesOfOneFile) {
  Scratch s;
  ReaderOptions o = raw(s.file("a.raw", bytes_of(file_values<float>("xyzt"))), Type::f32);
  o.frames = parse_frame_selection("1-5x2");
  const auto reader = open_series(o);
  EXPECT_EQ(reader->description().dims[3], 3u);
  EXPECT_EQ(reader->description().times.values, (std::vector<double>{0, 2, 4}));
  EXPECT_EQ(dense(*reader, 1)[0], value_at(0, 0, 0, 3));
  o.frames = parse_frame_selection("4-6");
  EXPECT_REFUSED(refusal(o), Exit::usage, "frames 0 to 5");
}

TEST(RawReader, ShowsTheArithmeticOfAWrongSize) {
  Scratch s;
  const std::string path = s.file("a.raw", std::string(3 * 4 * 5 * 6 * 2 - 1, 'x'));
  EXPECT_REFUSED(refusal(raw(path, Type::u16)), Exit::bad_input,
                 "719 bytes, but 3 x 4 x 5 x 6 frames x 2 bytes (u16) = 720");
  s.file("a.raw", std::string(3 * 4 * 5 * 7 * 2, 'x'));
  EXPECT_REFUSED(refusal(raw(path, Type::u16)), Exit::bad_input, "would fit 7 frames: --dims 3,4,5,7");
  s.file("a.raw", "");
  EXPECT_REFUSED(refusal(raw(path, Type::u16)), Exit::bad_input, "0 bytes");
}

TEST(RawReader, RefusesMissingAndOverflowingThings) {
  Scratch s;
  const std::string path = s.file("a.raw", "12345678");
  EXPECT_REFUSED(refusal(inputs({path})), Exit::usage, "--dims");
  EXPECT_REFUSED(refusal(inputs({s.path("none.raw")})), Exit::bad_input, "no such file");
  EXPECT_REFUSED(refusal(inputs({s.path(".")})), Exit::bad_input, "not a regular file");
  ReaderOptions huge = raw(path, Type::f64);
  huge.dims = {INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX};
  EXPECT_REFUSED(refusal(huge), Exit::bad_input, "too many");
  ReaderOptions o = raw(path, Type::u8);
  o.axes = "xxyz";
  EXPECT_REFUSED(refusal(o), Exit::usage, "--axes");
  o.axes = "xyz";
  EXPECT_REFUSED(refusal(o), Exit::usage, "has no t");
  o.axes = "xyt";
  EXPECT_REFUSED(refusal(o), Exit::usage, "z is missing");
}

TEST(RawReader, StopsAtDamagedAndExplodingGzip) {
  Scratch s;
  const std::string good = gzipped(bytes_of(file_values<float>("xyzt")));
  EXPECT_REFUSED(refusal(raw(s.file("cut.gz", good.substr(0, good.size() / 2)), Type::f32)), Exit::bad_input,
                 "end too early");
  std::string bad = good;
  bad[good.size() - 6] = static_cast<char>(bad[good.size() - 6] ^ 1); // in the check sum
  EXPECT_REFUSED(refusal(raw(s.file("bad.gz", bad), Type::f32)), Exit::bad_input, "damaged compressed data");
  EXPECT_REFUSED(refusal(raw(s.file("short.gz", gzipped("few")), Type::f32)), Exit::bad_input,
                 "1440 are expected");
  // The file holds 64 MiB of zeros in 64 KiB: more than declared is not unpacked, and no more can be declared
  // than deflate can make.
  const std::string bomb = s.file("bomb.gz", gzipped(std::string(64 << 20, '\0')));
  ReaderOptions o = raw(bomb, Type::f32);
  EXPECT_REFUSED(refusal(o), Exit::bad_input, "more than the 1440 bytes");
  o.dims = {100000, 100000, 100, 1};
  EXPECT_REFUSED(refusal(o), Exit::bad_input, "cannot hold more than");
}

TEST(RawReader, WarnsOfWrongByteOrderAndSwappedAxes) {
  Scratch s;
  constexpr std::array<uint64_t, 4> dims{20, 33, 48, 1};
  std::vector<uint16_t> smooth;
  for (uint64_t z = 0; z < dims[2]; ++z)
    for (uint64_t y = 0; y < dims[1]; ++y)
      for (uint64_t x = 0; x < dims[0]; ++x)
        smooth.push_back(static_cast<uint16_t>(2000 + 900 * std::sin(0.2 * static_cast<double>(x)) +
                                               700 * std::cos(0.15 * static_cast<double>(y + z))));
  ReaderOptions o = raw(s.file("a.raw", bytes_of(smooth)), Type::u16);
  o.dims = dims;
  EXPECT_TRUE(open_series(o)->description().warnings.empty()) << open_series(o)->description().warnings[0];
  o.big_endian = true;
  ASSERT_EQ(open_series(o)->description().warnings.size(), 1u);
  EXPECT_NE(open_series(o)->description().warnings[0].find("--endian"), std::string::npos);
  o.big_endian = false;
  o.dims = {48, 33, 20, 1};
  ASSERT_EQ(open_series(o)->description().warnings.size(), 1u);
  EXPECT_NE(open_series(o)->description().warnings[0].find("20,33,48"), std::string::npos);
}

std::vector<std::string> warnings_of(Scratch& s, const std::string& bytes, Type type, bool big_endian) {
  ReaderOptions o = raw(s.file("w.raw", bytes), type);
  o.dims = {24, 24, 24, 1};
  o.big_endian = big_endian;
  return open_series(o)->description().warnings;
}

template<class T, class F> std::string cube(F&& f) {
  std::vector<T> values;
  for (int z = 0; z < 24; ++z)
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 24; ++x) values.push_back(static_cast<T>(f(x, y, z)));
  return bytes_of(values);
}

TEST(RawReader, WarnsOfAWrongByteOrderHoweverRoughTheDataAre) {
  Scratch s;
  std::minstd_rand random(1);
  const auto noisy = [&](int x, int y, int z) {
    return 3000 + 1500 * std::sin(0.3 * x) * std::cos(0.2 * (y + z)) + static_cast<double>(random() % 1400);
  };
  const auto few = [&](int x, int y, int z) { return (x * x + 3 * y + z) % 256; }; // fill one byte of two
  const auto checked = [&](const std::string& bytes, Type type) {
    const auto right = warnings_of(s, bytes, type, false), wrong = warnings_of(s, bytes, type, true);
    EXPECT_TRUE(right.empty()) << type_name(type) << ": " << right[0];
    ASSERT_EQ(wrong.size(), 1u) << type_name(type);
    EXPECT_NE(wrong[0].find("--endian"), std::string::npos) << wrong[0];
  };
  checked(cube<uint16_t>(noisy), Type::u16);
  checked(cube<int16_t>(noisy), Type::i16);
  checked(cube<int32_t>(noisy), Type::i32);
  checked(cube<float>(noisy), Type::f32);
  checked(cube<uint16_t>(few), Type::u16);
  checked(cube<int32_t>(few), Type::i32);
  std::minstd_rand noise(2);
  EXPECT_TRUE(warnings_of(s, cube<uint16_t>([&](int, int, int) { return noise() % 65536; }), Type::u16, true)
                  .empty());
}

TEST(RawReader, WarnsOfNoByteOrderOfLabels) {
  Scratch s;
  // Smooth with the bytes reversed, by the numbers that the regions happen to have.
  const auto regions = [](int x, int y, int z) {
    return (x / 6 + 4 * (y / 8) + 12 * (z / 12)) * 256 + x / 6;
  };
  EXPECT_TRUE(warnings_of(s, cube<uint16_t>(regions), Type::u16, false).empty());
  EXPECT_TRUE(warnings_of(s, cube<uint16_t>(regions), Type::u16, true).empty());
  EXPECT_TRUE(warnings_of(s, cube<float>([](int, int, int) { return NAN; }), Type::f32, false).empty());
}

TEST(RawReader, LooksAtTheFirstOfSeveralArrays) {
  Scratch s;
  const std::string smooth = cube<uint16_t>([](int x, int y, int z) { return 900 + 40 * x + 7 * y * z; });
  ReaderOptions o = raw(s.file("e.raw", smooth + smooth), Type::u16);
  o.dims = {24, 24, 24, 1}, o.count = 2;
  EXPECT_TRUE(open_series(o)->description().warnings.empty());
  o.big_endian = true;
  EXPECT_EQ(open_series(o)->description().warnings.size(), 1u);
}

TEST(RawReader, LooksAtMoreThanAnEmptyFirstFrame) {
  Scratch s;
  const std::string smooth = cube<uint16_t>([](int x, int y, int z) { return 900 + 40 * x + 7 * y * z; });
  ReaderOptions o = raw(s.file("e.raw", std::string(smooth.size(), '\0') + smooth), Type::u16);
  o.dims = {24, 24, 24, 2};
  o.big_endian = true;
  EXPECT_EQ(open_series(o)->description().warnings.size(), 1u);
}

TEST(RawReader, WarnsOfAWrongSign) {
  Scratch s;
  const auto ct = [](int x, int y, int z) { return -1024 + 90 * x + 20 * (y + z); };
  const auto warned = [&](const std::string& bytes, Type type) {
    const auto w = warnings_of(s, bytes, type, false);
    return w.size() == 1 && w[0].find("--dtype") != std::string::npos;
  };
  EXPECT_TRUE(warnings_of(s, cube<int16_t>(ct), Type::i16, false).empty());
  EXPECT_TRUE(warned(cube<int16_t>(ct), Type::u16));
  EXPECT_TRUE(warned(cube<int32_t>(ct), Type::u32));
  const auto large = [](int x, int y, int z) { return 31000 + 100 * x + 20 * (y + z); };
  EXPECT_TRUE(warnings_of(s, cube<uint16_t>(large), Type::u16, false).empty());
  EXPECT_TRUE(warned(cube<uint16_t>(large), Type::i16));
  // A mask has both ends and means them.
  EXPECT_FALSE(warned(cube<uint16_t>([](int x, int y, int) { return x > y ? 65535 : 0; }), Type::u16));
}

TEST(Decoders, ReadNumbersAsText) {
  Scratch s;
  const std::string path = s.file("a.txt", "1 2,3\n\t-4.5e1\r\n+6 ");
  auto stream = open_ascii(std::make_unique<InputFile>(path), 0, Type::f32);
  std::vector<float> values(8, 0);
  EXPECT_EQ(stream->read(std::as_writable_bytes(std::span(values))), 5 * sizeof(float));
  EXPECT_EQ(values[3], -45.0f);
  EXPECT_EQ(values[4], 6.0f);
  stream = open_ascii(std::make_unique<InputFile>(s.file("b.txt", "1 256")), 0, Type::u8);
  EXPECT_REFUSED(refusal([&] { (void)stream->read(std::as_writable_bytes(std::span(values))); }),
                 Exit::bad_input, "256");
}

} // namespace
} // namespace bcc4::test

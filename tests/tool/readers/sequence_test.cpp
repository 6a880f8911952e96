// SPDX-License-Identifier: Apache-2.0
// Finding the files of a series: numbers, gaps, selections, lists and patterns; and the frames and times
// planned from them.
#include "readers/sequence.h"

#include "readers/frame_plan.h"
#include "scratch.h"

namespace bcc4::test {
namespace {

std::vector<int64_t> numbers(const Sequence& s) {
  std::vector<int64_t> out;
  for (const SequenceFile& f : s.files) out.push_back(f.number);
  return out;
}

using Numbers = std::vector<int64_t>;

TEST(Sequence, SortsByNumberThroughAPaddingChange) {
  Scratch s;
  for (const char* n : {"smoke.998.vdb", "smoke.999.vdb", "smoke.1000.vdb", "smoke.1001.vdb", "smoke.97.vdb",
                        "other.999.vdb"})
    s.file(n, "x");
  EXPECT_EQ(numbers(find_sequence({s.path("smoke.%03d.vdb")}, {})), (Numbers{998, 999, 1000, 1001}));
  EXPECT_EQ(numbers(find_sequence({s.path("smoke.###.vdb")}, {})), (Numbers{998, 999, 1000, 1001}));
  EXPECT_EQ(numbers(find_sequence({s.path("smoke.%d.vdb")}, {})), (Numbers{97, 998, 999, 1000, 1001}));
  EXPECT_EQ(numbers(find_sequence({s.path("smoke.*.vdb")}, {})), (Numbers{97, 998, 999, 1000, 1001}));
}

TEST(Sequence, TakesTheDigitsThatDiffer) {
  Scratch s;
  std::vector<std::string> files;
  for (const char* n : {"run01_t010_f32_zlib2.vti", "run01_t002_f32_zlib2.vti", "run01_t001_f32_zlib2.vti"})
    files.push_back(s.file(n, "x"));
  const Sequence found = find_sequence(files, {});
  EXPECT_TRUE(found.numbered);
  EXPECT_EQ(numbers(found), (Numbers{1, 2, 10}));
  EXPECT_NE(found.files[1].path.find("t002"), std::string::npos);
}

TEST(Sequence, KeepsTheGivenOrderOfNamesWithoutNumbers) {
  Scratch s;
  const std::vector<std::string> files{s.file("zero.raw", "x"), s.file("alpha.raw", "x")};
  const Sequence found = find_sequence(files, {});
  EXPECT_FALSE(found.numbered);
  EXPECT_EQ(found.files[0].path, files[0]);
  EXPECT_REFUSED(refusal([&] { (void)find_sequence({s.path("*.raw")}, {}); }), Exit::bad_input,
                 "list the files in order");
}

TEST(Sequence, NamesWhatIsMissing) {
  Scratch s;
  for (const char* n : {"a.1001.raw", "a.1002.raw", "a.1005.raw", "a.1007.raw"}) s.file(n, "x");
  const Sequence found = find_sequence({s.path("a.####.raw")}, {});
  EXPECT_EQ(found.missing, (Numbers{1003, 1004, 1006}));
  EXPECT_EQ(range_text(found.missing, 1), "1003-1004 and 1006");
  EXPECT_REFUSED(refusal([&] { (void)plan_files(found, {}); }), Exit::bad_input, "1003-1004 and 1006");
}

TEST(Sequence, CountsInTheStrideOfTheNumbers) {
  Scratch s;
  for (const char* n : {"a.0.raw", "a.10.raw", "a.30.raw", "a.40.raw"}) s.file(n, "x");
  const Sequence found = find_sequence({s.path("a.%d.raw")}, {});
  EXPECT_EQ(found.natural_stride, 10);
  EXPECT_EQ(found.missing, (Numbers{20}));
}

TEST(Sequence, SelectsByNumber) {
  Scratch s;
  for (int i = 1001; i <= 1010; ++i) s.file(concat("a.", i, ".raw"), "x");
  EXPECT_EQ(numbers(find_sequence({s.path("a.%d.raw")}, parse_frame_selection("1003-1008x2"))),
            (Numbers{1003, 1005, 1007}));
  EXPECT_EQ(numbers(find_sequence({s.path("a.%d.raw")}, parse_frame_selection("1009-"))),
            (Numbers{1009, 1010}));
  EXPECT_EQ(find_sequence({s.path("a.%d.raw")}, parse_frame_selection("1009-1012")).missing,
            (Numbers{1011, 1012}));
  EXPECT_REFUSED(refusal([&] { (void)find_sequence({s.path("a.%d.raw")}, parse_frame_selection("1-5")); }),
                 Exit::usage, "none");
}

TEST(Sequence, RefusesOneNumberTwiceAndNothing) {
  Scratch s;
  s.file("a.1.raw", "x");
  s.file("a.01.raw", "x");
  EXPECT_REFUSED(refusal([&] { (void)find_sequence({s.path("a.%d.raw")}, {}); }), Exit::bad_input,
                 "frame 1 stands in two files");
  EXPECT_REFUSED(refusal([&] { (void)find_sequence({s.path("b.%d.raw")}, {}); }), Exit::bad_input,
                 "no file has such a name");
  EXPECT_REFUSED(refusal([&] { (void)find_sequence({s.path("a.%03d.raw")}, {}); }), Exit::bad_input,
                 "try %d");
}

TEST(Sequence, ReadsListsRelativeToTheList) {
  Scratch s;
  s.file("d/f2.raw", "x");
  s.file("d/f1.raw", "x");
  const std::string list = s.file("d/list.txt", "# frames\r\nf2.raw\r\n\r\nf1.raw\r\n");
  const Sequence found = find_sequence({"@" + list}, {});
  EXPECT_EQ(numbers(found), (Numbers{1, 2}));
  EXPECT_TRUE(std::filesystem::equivalent(found.files[0].path, s.path("d/f1.raw")));
}

TEST(Sequence, RefusesSelectionsThatAreNone) {
  for (const char* text : {"", "-", "5-2", "a-b", "1-5x0", "1-5x", "1--5", "1.5-2"})
    EXPECT_REFUSED(refusal([&] { (void)parse_frame_selection(text); }), Exit::usage, "--frames");
}

TEST(Sequence, PatternsNameOutputs) {
  EXPECT_EQ(apply_frame_pattern("d/smoke.%04d.vdb", 7), "d/smoke.0007.vdb");
  EXPECT_EQ(apply_frame_pattern("smoke.###.png", 12345), "smoke.12345.png");
  EXPECT_EQ(apply_frame_pattern("plain.png", 7), "plain.png");
  EXPECT_FALSE(has_frame_pattern("a%b/plain.png"));
}

// Returns a series of one voxel whose value is its file number.
std::unique_ptr<FrameReader> numbered_series(Scratch& s, const std::vector<int>& files, GapPolicy gaps,
                                             std::optional<double> dt = {}) {
  for (const int n : files) s.file(concat("v.", n, ".raw"), std::string(1, static_cast<char>(n)));
  ReaderOptions o = inputs({s.path("v.%d.raw")});
  o.dims = {1, 1, 1, 0};
  o.dtype = Type::u8;
  o.gaps = gaps;
  o.dt = dt;
  return open_series(o);
}

struct Played {
  std::vector<double> values, times;
};
Played play(FrameReader& reader) {
  Played p;
  p.times = reader.description().times.values;
  for (uint64_t f = 0; f < reader.description().dims[3]; ++f) p.values.push_back(dense(reader, f)[0]);
  return p;
}

TEST(Gaps, HoldSkipAndInterpolate) {
  Scratch s;
  using V = std::vector<double>;
  const Played hold = play(*numbered_series(s, {1, 2, 5, 6}, GapPolicy::hold));
  EXPECT_EQ(hold.values, (V{1, 2, 2, 2, 5, 6}));
  EXPECT_EQ(hold.times, (V{0, 1, 2, 3, 4, 5}));
  const Played skip = play(*numbered_series(s, {1, 2, 5, 6}, GapPolicy::skip, 0.5));
  EXPECT_EQ(skip.values, (V{1, 2, 5, 6}));
  EXPECT_EQ(skip.times, (V{0, 0.5, 2, 2.5}));
  const Played between = play(*numbered_series(s, {1, 2, 5, 6}, GapPolicy::interpolate));
  EXPECT_EQ(between.values, (V{1, 2, 3, 4, 5, 6}));
}

TEST(Times, ComeFromTheUserAndRise) {
  Scratch s;
  for (int n = 0; n < 3; ++n) s.file(concat("v.", n, ".raw"), "x");
  ReaderOptions o = inputs({s.path("v.%d.raw")});
  o.dims = {1, 1, 1, 0};
  o.dtype = Type::u8;
  o.times = {{0, 0.25, 7}};
  EXPECT_EQ(open_series(o)->description().times.values, (std::vector<double>{0, 0.25, 7}));
  o.times = {{0, 1}};
  EXPECT_REFUSED(refusal(o), Exit::usage, "2 times for 3 frames");
  o.times = {{0, 2, 2}};
  EXPECT_REFUSED(refusal(o), Exit::bad_input, "times must rise");
}

} // namespace
} // namespace bcc4::test

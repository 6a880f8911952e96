// SPDX-License-Identifier: Apache-2.0
// The order of files by their names: dates and other tuples, decimals, counters; and the times that follow.
#include "readers/name_numbers.h"

#include "readers/sequence.h"
#include "scratch.h"

namespace bcc4::test {
namespace {

using Strings = std::vector<std::string>;

struct Ordered {
  NameOrder order;
  Strings names;
  std::vector<int64_t> numbers;
  std::vector<double> decimals;
};

Ordered ordered(const Strings& names) {
  std::vector<SequenceFile> files;
  for (const std::string& name : names) files.push_back({"d/" + name});
  Ordered o{order_by_names(files), {}, {}, {}};
  for (const SequenceFile& f : files) {
    o.names.push_back(f.path.substr(2));
    o.numbers.push_back(f.number);
    o.decimals.push_back(f.decimal);
  }
  return o;
}

Strings reversed(Strings names) {
  std::reverse(names.begin(), names.end());
  return names;
}

TEST(NameNumbers, DatesAreTuples) {
  const Strings months{"t_2023-11.raw", "t_2023-12.raw", "t_2024-01.raw", "t_2024-02.raw"};
  const Strings hours{"20230131T18.nc", "20230131T21.nc", "20230201T00.nc"};
  const Strings days{"a.2023.09.30.vdb", "a.2023.10.01.vdb", "a.2024.01.01.vdb"};
  for (const Strings& names : {months, hours, days})
    for (const Strings& given : {names, reversed(names)}) {
      const Ordered o = ordered(given);
      EXPECT_EQ(o.order, NameOrder::tuple) << names[0];
      EXPECT_EQ(o.names, names);
      EXPECT_EQ(o.numbers[2], 2);
    }
}

TEST(NameNumbers, DecimalsAndExponentsAreNumbers) {
  const Strings halves{"dec_0.5.raw", "dec_1.0.raw",  "dec_1.5.raw",
                       "dec_2.0.raw", "dec_10.0.raw", "dec_10.5.raw"};
  const Strings quarters{"t0.1.raw", "t0.2.raw", "t0.25.raw", "t0.5.raw", "t1.raw"};
  const Strings inverse{"q1.9.raw", "q2.8.raw"};
  const Strings small{"e_1e-03.raw", "e_5e-03.raw", "e_1e-02.raw", "e_2.5e+01.raw"};
  for (const Strings& names : {halves, quarters, inverse, small}) {
    Strings sorted = names;
    std::sort(sorted.begin(), sorted.end()); // as a shell does
    for (const Strings& given : {names, reversed(names), sorted}) {
      const Ordered o = ordered(given);
      EXPECT_EQ(o.order, NameOrder::decimals) << names[0];
      EXPECT_EQ(o.names, names);
    }
  }
  EXPECT_EQ(ordered(halves).decimals, (std::vector<double>{0.5, 1, 1.5, 2, 10, 10.5}));
  EXPECT_EQ(ordered(small).decimals, (std::vector<double>{0.001, 0.005, 0.01, 25}));
}

TEST(NameNumbers, CountersStayCounters) {
  const Ordered padded = ordered({"sim2.0003.vdb", "sim2.0001.vdb", "sim2.0002.vdb"});
  EXPECT_EQ(padded.order, NameOrder::counter);
  EXPECT_EQ(padded.numbers, (std::vector<int64_t>{3, 1, 2})); // find_sequence sorts them
  // Versions, not decimals.
  EXPECT_EQ(ordered({"v1.8.raw", "v1.9.raw", "v1.10.raw"}).numbers, (std::vector<int64_t>{8, 9, 10}));
  EXPECT_EQ(ordered({"v1.9.raw", "v2.2.raw", "v2.11.raw"}).order, NameOrder::tuple);
  EXPECT_EQ(ordered({"s1e01.raw", "s1e02.raw"}).numbers, (std::vector<int64_t>{1, 2}));
  // A second number that goes with the counter.
  EXPECT_EQ(ordered({"a_1_f007.raw", "a_2_f008.raw", "a_3_f009.raw"}).numbers,
            (std::vector<int64_t>{7, 8, 9}));
  EXPECT_EQ(ordered({"a_10_f1.raw", "a_9_f2.raw"}).names, (Strings{"a_10_f1.raw", "a_9_f2.raw"}));
  EXPECT_EQ(ordered({"a1.raw", "b2.raw"}).order, NameOrder::given);
  EXPECT_REFUSED(refusal([] {
                   (void)ordered({"a1e-1.raw", "a10e-2.raw", "a5e-1.raw"});
                 }),
                 Exit::bad_input, "stands in two files");
}

// Files of one byte.
ReaderOptions bytes(const Scratch& s, const Strings& names) {
  ReaderOptions o;
  for (const std::string& name : names) o.inputs.push_back(s.file(name, "x"));
  o.dims = {1, 1, 1, 0};
  o.dtype = Type::u8;
  return o;
}

TEST(NameNumbers, GiveTimesWhereTheyAreDecimalsOrFurtherApart) {
  Scratch s;
  using V = std::vector<double>;
  const auto times = [](const ReaderOptions& o) { return open_series(o)->description().times.values; };
  EXPECT_EQ(times(bytes(s, {"d_0.5.raw", "d_1.0.raw", "d_10.5.raw"})), (V{0.5, 1, 10.5}));
  EXPECT_EQ(times(bytes(s, {"m_2023-12.raw", "m_2024-01.raw", "m_2024-02.raw"})), (V{0, 1, 2}));
  ReaderOptions odd = bytes(s, {"f_1.raw", "f_3.raw", "f_5.raw"});
  EXPECT_EQ(times(odd), (V{1, 3, 5}));
  // The same with the files between them.
  ReaderOptions all = bytes(s, {"f_1.raw", "f_2.raw", "f_3.raw", "f_4.raw", "f_5.raw"});
  EXPECT_EQ(times(all), (V{0, 1, 2, 3, 4}));
  all.frames = odd.frames = parse_frame_selection("1-5x2");
  EXPECT_EQ(times(all), (V{1, 3, 5}));
  EXPECT_EQ(times(odd), (V{1, 3, 5}));
  odd.dt = 0.5;
  EXPECT_EQ(times(odd), (V{0, 0.5, 1}));
}

} // namespace
} // namespace bcc4::test

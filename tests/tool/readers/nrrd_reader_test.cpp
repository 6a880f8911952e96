// SPDX-License-Identifier: Apache-2.0
// The NRRD reader on headers written here: where the data are, which axis is time, times and components, and
// malformed headers.
#include "readers/nrrd/nrrd_reader.h"

#include <cmath>
#include <numeric>

#include "readers/nrrd/nrrd_header.h"
#include "scratch.h"

namespace bcc4::test {
namespace {

// Returns 2 x 3 x 4 x 5 values of u16, each its own index in x, y, z, t order.
std::string payload(bool big = false) {
  std::vector<uint16_t> v(2 * 3 * 4 * 5);
  std::iota(v.begin(), v.end(), uint16_t{0});
  return bytes_of(v, big);
}

std::string header(const std::string& encoding = "raw", const std::string& more = "") {
  return "NRRD0004\n# a comment\ntype: ushort\ndimension: 4\nsizes: 2 3 4 5\nkinds: space space space "
         "time\nendian: little\nencoding: " +
         encoding + "\n" + more;
}

void expect_counting(FrameReader& reader) {
  ASSERT_EQ(reader.description().dims, (std::array<uint64_t, 4>{2, 3, 4, 5}));
  for (uint64_t t = 0; t < 5; ++t) {
    const auto v = dense(reader, t);
    for (size_t i = 0; i < v.size(); ++i) ASSERT_EQ(v[i], static_cast<double>(24 * t + i));
  }
}

TEST(NrrdReader, ReadsAttachedData) {
  Scratch s;
  expect_counting(*open_series(inputs({s.file("a.nrrd", header() + "\n" + payload())})));
  expect_counting(*open_series(inputs({s.file("g.nrrd", header("gzip") + "\n" + gzipped(payload()))})));
  std::string text;
  for (int i = 0; i < 120; ++i) text += concat(i, i % 7 ? " " : "\n");
  expect_counting(*open_series(inputs({s.file("t.nrrd", header("ascii") + "\n" + text)})));
  std::string big = header();
  big.replace(big.find("little"), 6, "big");
  expect_counting(*open_series(inputs({s.file("b.nrrd", big + "\n" + payload(true))})));
}

TEST(NrrdReader, FiveAxesWithoutAWordOfThemAreNamedWithComponents) {
  Scratch s;
  const std::string path = s.file("a.nrrd", "NRRD0004\ntype: ushort\ndimension: 5\nsizes: 2 1 3 4 5\nendian: "
                                            "little\nencoding: raw\n\n" +
                                                payload());
  EXPECT_REFUSED(refusal(inputs({path})), Exit::bad_input, "--axes cxyzt");
  ReaderOptions told = inputs({path});
  told.axes = "cxyzt";
  const auto reader = open_series(told);
  ASSERT_EQ(reader->description().dims, (std::array<uint64_t, 4>{1, 3, 4, 5}));
  ASSERT_EQ(reader->description().channels.size(), 2u);
  for (size_t c = 0; c < 2; ++c)
    for (size_t i = 0; i < 12; ++i)
      ASSERT_EQ(dense(*reader, 3, c)[i], static_cast<double>(72 + 2 * i + c)) << i;
  for (const std::string axes : {"xyzt", "ccxyz", "cxyza"}) {
    told.axes = axes;
    EXPECT_REFUSED(refusal(told), Exit::usage, "--axes " + axes.substr(axes[0] == 'c' ? 1 : 0));
  }
}

TEST(NrrdReader, ReadsCarriageReturns) {
  Scratch s;
  std::string crlf;
  for (const char c : header() + "\n") crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  expect_counting(*open_series(inputs({s.file("a.nrrd", crlf + payload())})));
}

TEST(NrrdReader, ReadsDetachedData) {
  Scratch s;
  const std::string all = payload();
  s.file("d/a.raw", "two\nlines\n" + all);
  expect_counting(
      *open_series(inputs({s.file("a.nhdr", header("raw", "line skip: 2\ndata file: d/a.raw\n"))})));
  s.file("tail.raw", "whatever stands before" + all);
  expect_counting(
      *open_series(inputs({s.file("b.nhdr", header("raw", "byte skip: -1\ndatafile: tail.raw\n"))})));
  for (size_t t = 0; t < 5; ++t) s.file(concat("f.", t + 1, ".gz"), gzipped(all.substr(t * 48, 48)));
  expect_counting(*open_series(inputs({s.file("c.nhdr", header("gzip", "data file: f.%d.gz 1 5 1\n"))})));
  expect_counting(*open_series(inputs(
      {s.file("e.nhdr", header("gzip", "data file: LIST\nf.1.gz\nf.2.gz\nf.3.gz\nf.4.gz\nf.5.gz\n"))})));
  s.file("skipped.gz", gzipped("abc" + all));
  expect_counting(
      *open_series(inputs({s.file("h.nhdr", header("gzip", "byte skip: 3\ndata file: skipped.gz\n"))})));
}

TEST(NrrdReader, RefusesDataOutsideItsFolder) {
  Scratch s;
  s.file("secret.raw", payload());
  for (const std::string name : {"../secret.raw", "/etc/passwd", "a/../../secret.raw"})
    EXPECT_REFUSED(refusal(inputs({s.file("sub/a.nhdr", header("raw", "data file: " + name + "\n"))})),
                   Exit::bad_input, "own folder");
  EXPECT_REFUSED(refusal(inputs({s.file("sub/b.nhdr", header("raw", "data file: LIST\n../secret.raw\n"))})),
                 Exit::bad_input, "own folder");
  EXPECT_REFUSED(refusal(inputs({s.file("sub/c.nhdr", header("raw", "data file: ../s%d.raw 1 5 1\n"))})),
                 Exit::bad_input, "own folder");
}

// A header of a few lines must not name more files than memory has room for.
TEST(NrrdReader, RefusesMoreDataFilesThanAnyoneHas) {
  Scratch s;
  EXPECT_REFUSED(
      refusal(inputs({s.file("e.nhdr", header("raw", "data file: i%d 1 9 1\ndata file: j%d 1 9 1\n"))})),
      Exit::bad_input, "twice");
  EXPECT_REFUSED(refusal(inputs({s.file("f.nhdr", header("raw", "data file: i%d 0 1000000 1\n"))})),
                 Exit::bad_input, "a million");
}

// The same series with the list axis first and last, as Slicer wrote them at different times.
TEST(NrrdReader, FindsTheListAxisByKindWhereverItStands) {
  Scratch s;
  const std::string last =
      "NRRD0005\ntype: unsigned short\ndimension: 4\nspace: left-posterior-superior\nsizes: 2 3 4 5\n"
      "space directions: (1,0,0) (0,2,0) (0,0,3) none\nkinds: domain domain domain list\nendian: little\n"
      "encoding: raw\nspace origin: (10,20,30)\naxis 3 index type:=numeric\naxis 3 index values:=0 0.5 1 2 "
      "4\n\n";
  const std::string first =
      "NRRD0005\ntype: unsigned short\ndimension: 4\nspace: left-posterior-superior\nsizes: 5 2 3 4\n"
      "space directions: none (1,0,0) (0,2,0) (0,0,3)\nkinds: list domain domain domain\nendian: little\n"
      "encoding: raw\nspace origin: (10,20,30)\naxis 0 index type:=numeric\naxis 0 index values:=0 0.5 1 2 "
      "4\n\n";
  std::vector<uint16_t> interleaved;
  for (uint16_t i = 0; i < 24; ++i)
    for (uint16_t t = 0; t < 5; ++t) interleaved.push_back(static_cast<uint16_t>(24 * t + i));
  for (const std::string& path :
       {s.file("last.seq.nrrd", last + payload()), s.file("first.seq.nrrd", first + bytes_of(interleaved))}) {
    const auto reader = open_series(inputs({path}));
    expect_counting(*reader);
    const SeriesDescription& d = reader->description();
    EXPECT_EQ(d.times.values, (std::vector<double>{0, 0.5, 1, 2, 4}));
    EXPECT_EQ(d.affine, (std::array<double, 16>{1, 0, 0, 10, 0, 2, 0, 20, 0, 0, 3, 30, 0, 0, 0, 1}));
  }
}

TEST(NrrdReader, NeverTakesTimeByItsPlace) {
  Scratch s;
  const std::string plain =
      "NRRD0004\ntype: ushort\ndimension: 4\nsizes: 2 3 4 5\nendian: little\nencoding: raw\n";
  const std::string path = s.file("a.nrrd", plain + "\n" + payload());
  EXPECT_REFUSED(refusal(inputs({path})), Exit::bad_input, "--axes xyzt");
  ReaderOptions told = inputs({path});
  told.axes = "xyzt";
  expect_counting(*open_series(told));
  s.file("a.nrrd", plain + "labels: \"x\" \"y\" \"z\" \"time\"\n\n" + payload());
  expect_counting(*open_series(inputs({path})));
  s.file("a.nrrd", plain + "kinds: domain domain domain list\nmodality:=DWMRI\n\n" + payload());
  EXPECT_REFUSED(refusal(inputs({path})), Exit::bad_input, "gradients");
}

// A plane in space, aslant: what is across it has the length of a unit.
TEST(NrrdReader, PlanesHaveAnAxisAcrossThem) {
  Scratch s;
  const auto series = open_series(inputs({s.file(
      "a.nrrd",
      "NRRD0005\ntype: ushort\ndimension: 3\nsizes: 6 4 5\nspace dimension: 3\nspace directions: (2,1,0) "
      "(0,1,3) none\nkinds: domain domain time\nendian: little\nencoding: raw\n\n" +
          payload())}));
  const std::array<double, 16> m = series->description().affine;
  const double length = std::sqrt(9.0 + 36 + 4); // of (2, 1, 0) x (0, 1, 3) = (3, -6, 2)
  const double want[3][3] = {{2, 0, 3 / length}, {1, 1, -6 / length}, {0, 3, 2 / length}};
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(m[4 * r + c], want[r][c], 1e-12) << r << c;
}

TEST(NrrdReader, TellsWhatTimeWasKnownBy) {
  Scratch s;
  const std::string plain =
      "NRRD0005\ntype: ushort\ndimension: 4\nsizes: 2 3 4 5\nendian: little\nencoding: raw\n";
  const auto axes = [&](const std::string& fields) {
    return open_series(inputs({s.file("a.nrrd", plain + fields + "\n" + payload())}))->description().axes;
  };
  const auto ends_with = [](const std::string& text, const char* end) { return text.ends_with(end); };
  EXPECT_PRED2(ends_with, axes("kinds: domain domain domain list\n"), "time by its kind, list");
  EXPECT_PRED2(ends_with, axes("kinds: domain domain domain domain\nlabels: \"x\" \"y\" \"z\" \"time\"\n"),
               "time by its label");
  EXPECT_PRED2(ends_with,
               axes("space dimension: 4\nspace directions: (1,0,0,0) (0,1,0,0) (0,0,1,0) (0,0,0,2)\n"),
               "time by its direction");
}

TEST(NrrdReader, BelievesKindsBeforeLabelsAndListsBesideTimeAreValues) {
  Scratch s;
  const std::string start = "NRRD0004\ntype: ushort\nendian: little\nencoding: raw\n";
  const auto list = open_series(inputs(
      {s.file("a.nrrd", start + "dimension: 5\nsizes: 2 3 2 2 5\nkinds: domain domain list domain time\n\n" +
                            payload())}));
  ASSERT_EQ(list->description().dims, (std::array<uint64_t, 4>{2, 3, 2, 5}));
  ASSERT_EQ(list->description().channels.size(), 2u);
  EXPECT_EQ(dense(*list, 3, 1)[0], 3 * 24 + 6);
  const auto space = open_series(inputs(
      {s.file("a.nrrd",
              start + "dimension: 3\nsizes: 4 5 6\nkinds: space space space\nlabels: \"r\" \"s\" \"t\"\n\n" +
                  payload())}));
  EXPECT_EQ(space->description().dims, (std::array<uint64_t, 4>{4, 5, 6, 1}));
}

TEST(NrrdReader, ReadsTimesFromTheSpacing) {
  Scratch s;
  const auto reader = open_series(inputs({s.file(
      "a.nrrd",
      header("raw", "spacings: 1 1 2.5 0.04\naxis mins: nan nan nan 3\nunits: \"mm\" \"mm\" \"mm\" \"s\"\n") +
          "\n" + payload())}));
  const SeriesDescription& d = reader->description();
  EXPECT_EQ(d.times.unit, "s");
  EXPECT_DOUBLE_EQ(d.times.values[4], 3.16);
  EXPECT_EQ(d.spatial_unit, "mm");
  EXPECT_EQ(d.affine[10], 2.5);
  EXPECT_NE(d.times.origin.find("0.04"), std::string::npos);
}

TEST(NrrdReader, NamesTheChannelByItsContent) {
  Scratch s;
  const auto channel = [&](const std::string& fields) {
    return open_series(inputs({s.file("a.nrrd", header("raw", fields) + "\n" + payload())}))
        ->description()
        .channels[0];
  };
  EXPECT_EQ(channel("content: wind speed\nsample units: m/s\n").name, "wind speed");
  for (const char* unit : {"m/s", "\"m/s\"", "  m/s "})
    EXPECT_EQ(channel(concat("sample units: ", unit, "\n")).unit, "m/s");
  EXPECT_EQ(channel("content: T in \xb0\x43\n").name, "T in \xc2\xb0\x43"); // Latin-1
  EXPECT_EQ(channel("content:\n").name, "value");
  EXPECT_EQ(channel("content: " + std::string(65, 'x') + "\n").name, "value"); // a description
  // What differs from file to file is not the name of what they hold.
  const std::string one = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 1\nencoding: raw\ncontent: ";
  for (const char* second : {"smoke", "smoke 2"}) {
    const auto series = open_series(
        inputs({s.file("f.1.nrrd", one + "smoke\n\nab"), s.file("f.2.nrrd", concat(one, second, "\n\nab"))}));
    EXPECT_EQ(series->description().channels[0].name, second == std::string("smoke") ? "smoke" : "value");
  }
}

TEST(NrrdReader, TakesTheTimesOfFilesThatRise) {
  Scratch s;
  const auto series = [&](const std::vector<std::string>& keys) {
    ReaderOptions o;
    for (size_t i = 0; i < keys.size(); ++i)
      o.inputs.push_back(
          s.file(concat("f.", i, ".nrrd"),
                 "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 1\nencoding: raw\n" + keys[i] + "\n\nab"));
    return open_series(o)->description();
  };
  const SeriesDescription good = series({"time:=-1.5\ntime unit:=s", "time:= 2", "time:=1e3"});
  EXPECT_EQ(good.times.values, (std::vector<double>{-1.5, 2, 1000}));
  EXPECT_EQ(good.times.unit, "s");
  EXPECT_EQ(good.times.origin, "\"time\" of each file");
  EXPECT_EQ(series({"time:=7"}).times.values, std::vector<double>{7});
  EXPECT_TRUE(good.notes.back().find("\"time\"") == std::string::npos);
  for (const auto& keys : {std::vector<std::string>{"time:=1", "a:=b", "time:=2"},
                           {"time:=1", "time:=1"},
                           {"time:=1\ntime unit:=h", "time:=2\ntime unit:=s"},
                           {"time:=12:30", "time:=12"},
                           {"time:=nan", "time:=1"}}) {
    const SeriesDescription d = series(keys);
    EXPECT_EQ(d.times.values.back(), static_cast<double>(keys.size() - 1));
    EXPECT_EQ(d.times.unit, "");
    EXPECT_NE(d.notes.back().find("not taken"), std::string::npos);
  }
}

TEST(NrrdReader, SplitsComponentsIntoChannels) {
  Scratch s;
  const std::string path = s.file("a.nrrd", "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 2 1 2\nkinds: "
                                            "RGB-color domain domain domain\nencoding: raw\n\n" +
                                                std::string("\0\1\2\3\4\5\6\7\10\11\12\13", 12));
  const auto reader = open_series(inputs({path}));
  ASSERT_EQ(reader->description().channels.size(), 3u);
  EXPECT_EQ(dense(*reader, 0, 1), (std::vector<double>{1, 4, 7, 10}));
  ReaderOptions o = inputs({path});
  o.channels = {"c2"};
  EXPECT_EQ(dense(*open_series(o), 0), (std::vector<double>{2, 5, 8, 11}));
  o.channels = {"c3"};
  EXPECT_REFUSED(refusal(o), Exit::usage, "c0 to c2");
}

TEST(NrrdReader, RefusesMalformedHeaders) {
  Scratch s;
  const auto refused = [&](const std::string& text) { return refusal(inputs({s.file("a.nrrd", text)})); };
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string h = header();
    h.replace(h.find(from), from.size(), to);
    return refused(h + "\n" + payload());
  };
  EXPECT_REFUSED(refused(header() + "\n" + payload().substr(1)), Exit::bad_input, "are expected");
  EXPECT_REFUSED(refused(header() + "\n" + payload() + "x"), Exit::bad_input, "are expected");
  EXPECT_REFUSED(refused(header()), Exit::bad_input, "does not end with an empty line");
  EXPECT_REFUSED(with("2 3 4 5", "2 3 4 0"), Exit::bad_input, "no samples");
  EXPECT_REFUSED(with("2 3 4 5", "2 3 4"), Exit::bad_input, "3 entries for 4 axes");
  EXPECT_REFUSED(with("2 3 4 5", "2 3 4 -5"), Exit::bad_input, "no number");
  EXPECT_REFUSED(with("2 3 4 5", "2 3 4 18446744073709551615"), Exit::bad_input, "too many");
  EXPECT_REFUSED(with("2 3 4 5", "65536 65536 65536 65536"), Exit::bad_input, "too many");
  EXPECT_REFUSED(with("ushort", "block"), Exit::bad_input, "block");
  EXPECT_REFUSED(with("dimension: 4", "dimension: 99"), Exit::bad_input, "99 axes");
  EXPECT_REFUSED(with("endian: little\n", ""), Exit::bad_input, "no endian");
  EXPECT_REFUSED(with("encoding: raw", "encoding: bzip2"), Exit::bad_input, "bzip2");
  EXPECT_REFUSED(with("kinds: space space space time", "kinds: time time space space"), Exit::bad_input,
                 "several axes");
  EXPECT_REFUSED(with("# a comment", "no colon here"), Exit::bad_input, "line 2");
  EXPECT_REFUSED(with("# a comment", "spacings: 1 1 1 1"), Exit::bad_input, "must come first");
  EXPECT_REFUSED(refused("NRRD0009\n"), Exit::bad_input, "NRRD0001 to NRRD0005");
  EXPECT_REFUSED(with("endian: little\n", "endian: little\nspacings: 0 1 1 1\n"), Exit::bad_input,
                 "no volume");
}

TEST(NrrdReader, RefusesOptionsThatAreNotItsOwn) {
  Scratch s;
  ReaderOptions o = inputs({s.file("a.nrrd", header() + "\n" + payload())});
  o.grids = {"density"};
  EXPECT_REFUSED(refusal(o), Exit::usage, "--grid");
  o = inputs(o.inputs);
  o.dtype = Type::u8;
  EXPECT_REFUSED(refusal(o), Exit::usage, "--dtype");
}

// Every byte of a header is replaced by many others: the file is refused or read, never worse.
TEST(NrrdReader, SurvivesMutations) {
  Scratch s;
  const std::string good =
      header("raw", "spacings: 1 1 1 1\nspace: lps\nspace directions: (1,0,0) (0,1,0) (0,0,1) none\n") +
      "\n" + payload();
  size_t refused = 0;
  for (size_t i = 0; i < good.size() - payload().size(); ++i)
    for (const char c : {'\0', '\n', ':', '-', '9', '(', '%', '\xff'}) {
      if ((i + static_cast<uint8_t>(c)) % 3 != 0) continue; // a third of them keeps the test short
      std::string bad = good;
      bad[i] = c;
      refused += refusal(inputs({s.file("m.nrrd", bad)})).exit != Exit::ok;
    }
  EXPECT_GT(refused, 100u);
}

} // namespace
} // namespace bcc4::test

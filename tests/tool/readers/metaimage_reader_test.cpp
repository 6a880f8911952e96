// SPDX-License-Identifier: Apache-2.0
// The MetaImage reader on files made here: every way of storing the data, the grid's place, files of a
// series, and what is refused.
#include "readers/metaimage/metaimage_reader.h"

#include <algorithm>
#include <numeric>

#include "scratch.h"

namespace bcc4::test {
namespace {

const std::string mha_header =
    "ObjectType = Image\nNDims = 4\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
    "CompressedData = False\nDimSize = 2 3 4 5\nElementType = MET_SHORT\n";

std::vector<int16_t> ramp(size_t count = 120) {
  std::vector<int16_t> v(count);
  std::iota(v.begin(), v.end(), int16_t{0});
  return v;
}

std::string deflated(const std::string& data) {
  uLongf size = compressBound(static_cast<uLong>(data.size()));
  std::string out(size, '\0');
  compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(data.data()),
           static_cast<uLong>(data.size()));
  out.resize(size);
  return out;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(MetaImageReader, ReadsAttachedDetachedCompressedAndTextAlike) {
  Scratch s;
  const std::string raw = bytes_of(ramp());
  std::string text;
  for (const int16_t v : ramp()) text += std::to_string(v) + " ";
  s.file("d.raw", raw);
  s.file("d.zraw", deflated(raw));
  const std::string zip = replaced(mha_header, "CompressedData = False", "CompressedData = True");
  const std::vector<std::string> files{
      s.file("a.mha", mha_header + "ElementDataFile = LOCAL\n" + raw),
      s.file("b.mhd", mha_header + "ElementDataFile = d.raw\n"),
      s.file("c.mhd", zip + "ElementDataFile = d.zraw\n"),
      s.file("d.mha", zip + "ElementDataFile = LOCAL\n" + deflated(raw)),
      s.file("e.mha", replaced(mha_header, "ByteOrderMSB = False", "ByteOrderMSB = True") +
                          "ElementDataFile = LOCAL\n" + bytes_of(ramp(), true)),
      s.file("f.mha", replaced(mha_header, "BinaryData = True", "BinaryData = False") +
                          "ElementDataFile = LOCAL\n" + text)};
  for (const std::string& file : files) {
    const auto reader = open_series(inputs({file}));
    ASSERT_EQ(reader->description().dims, (std::array<uint64_t, 4>{2, 3, 4, 5})) << file;
    EXPECT_EQ(reader->description().format, "MetaImage");
    for (const uint64_t frame : {3, 0, 4}) {
      const std::vector<double> values = dense(*reader, frame);
      for (size_t i = 0; i < 24; ++i)
        ASSERT_EQ(values[i], static_cast<double>(frame * 24 + i)) << file << " " << frame;
    }
  }
}

std::ptrdiff_t orientation_notes(const SeriesDescription& d) {
  return std::count_if(d.notes.begin(), d.notes.end(), [](const std::string& note) {
    return note.find("is not that of the axes") != std::string::npos;
  });
}

TEST(MetaImageReader, PlacesTheGridInTheWorldAndTime) {
  Scratch s;
  const std::string file = s.file("a.mha", mha_header +
                                               "ElementSpacing = 2 3 4 0.5\nOffset = 10 20 30 7\n"
                                               "TransformMatrix = 0 1 0 0  -1 0 0 0  0 0 1 0  0 0 0 1\n"
                                               "AnatomicalOrientation = RAI\nElementDataFile = LOCAL\n" +
                                               bytes_of(ramp()));
  const auto reader = open_series(inputs({file}));
  const SeriesDescription& d = reader->description();
  // Axis 0 points along +y, axis 1 along -x.
  EXPECT_EQ(d.affine, (std::array<double, 16>{0, -3, 0, 10, 2, 0, 0, 20, 0, 0, 4, 30, 0, 0, 0, 1}));
  EXPECT_EQ(d.times.values, (std::vector<double>{7, 7.5, 8, 8.5, 9}));
  EXPECT_EQ(d.attributes,
            (std::vector<std::pair<std::string, std::string>>{{"anatomical_orientation", "RAI"}}));
  EXPECT_EQ(orientation_notes(d), 1); // it would be ALI
}

TEST(MetaImageReader, AnOrientationThatFitsTheAxesMakesTheWorldLps) {
  Scratch s;
  const auto described = [&](const std::string& fields) {
    return open_series(inputs({s.file("a.mha",
                                      mha_header + fields + "ElementDataFile = LOCAL\n" + bytes_of(ramp()))}))
        ->description();
  };
  const std::string turned = "TransformMatrix = 0 1 0 0  -1 0 0 0  0 0 1 0  0 0 0 1\n";
  for (const std::string& fields :
       {std::string("AnatomicalOrientation = RAI?\n"), turned + "AnatomicalOrientation = ALI\n"}) {
    const SeriesDescription d = described(fields);
    ASSERT_EQ(d.attributes.size(), 2u) << fields;
    EXPECT_EQ(d.attributes[1].first, "space");
    EXPECT_EQ(d.attributes[1].second, "left-posterior-superior");
    EXPECT_EQ(orientation_notes(d), 0) << fields;
  }
  EXPECT_TRUE(described("AnatomicalOrientation = ???\n").attributes.empty());
  for (const std::string orientation : {"LPS", "RA", "xyz"}) {
    const SeriesDescription d = described("AnatomicalOrientation = " + orientation + "\n");
    EXPECT_EQ(d.attributes.size(), 1u) << orientation;
    EXPECT_EQ(orientation_notes(d), 1) << orientation;
  }
}

TEST(MetaImageReader, TakesFilesOneByOneByListAndByNumber) {
  Scratch s;
  for (int i = 0; i < 5; ++i) {
    std::vector<int16_t> part = ramp();
    part = {part.begin() + 24 * i, part.begin() + 24 * (i + 1)};
    s.file("slice" + std::to_string(i + 1) + ".raw", bytes_of(part));
    s.file("step" + std::to_string(i) + ".mha",
           replaced(replaced(mha_header, "NDims = 4", "NDims = 3"), "2 3 4 5", "2 3 4") +
               "ElementDataFile = LOCAL\n" + bytes_of(part));
  }
  const std::string list =
      s.file("list.mhd", mha_header + "ElementDataFile = LIST\nslice1.raw\nslice2.raw\nslice3.raw\n"
                                      "slice4.raw\nslice5.raw\n");
  const std::string numbered = s.file("numbered.mhd", mha_header + "ElementDataFile = slice%d.raw 1 5 1\n");
  for (const std::string& input : {list, numbered, s.path("step#.mha")}) {
    const auto reader = open_series(inputs({input}));
    ASSERT_EQ(reader->description().dims[3], 5u) << input;
    for (uint64_t f = 0; f < 5; ++f)
      EXPECT_EQ(dense(*reader, f)[5], static_cast<double>(24 * f + 5)) << input;
  }
}

TEST(MetaImageReader, GivesComponentsAsChannels) {
  Scratch s;
  const std::string file =
      s.file("a.mha", replaced(mha_header, "2 3 4 5", "2 3 4 1") +
                          "ElementNumberOfChannels = 5\nElementDataFile = LOCAL\n" + bytes_of(ramp()));
  const auto reader = open_series(inputs({file}));
  ASSERT_EQ(reader->description().channels.size(), 5u);
  for (size_t c = 0; c < 5; ++c)
    for (size_t i = 0; i < 24; ++i) ASSERT_EQ(dense(*reader, 0, c)[i], static_cast<double>(5 * i + c));
  ReaderOptions one = inputs({file});
  one.channels = {"c3"};
  EXPECT_EQ(dense(*open_series(one), 0)[2], 13);
}

// A file of floats 0, 1, 2 ... with these fields.
std::string floats(const std::string& fields, size_t count = 24) {
  std::vector<float> v(count);
  std::iota(v.begin(), v.end(), 0.0f);
  return "ObjectType = Image\n" + fields + "ElementType = MET_FLOAT\nElementDataFile = LOCAL\n" + bytes_of(v);
}

TEST(MetaImageReader, ScalesFloats) {
  Scratch s;
  const auto reader = open_series(
      inputs({s.file("a.mha", floats("NDims = 3\nDimSize = 2 3 4\nElementToIntensityFunctionSlope = 2\n"
                                     "ElementToIntensityFunctionOffset = 5\n"))}));
  EXPECT_EQ(dense(*reader, 0)[23], 51);
  EXPECT_EQ(reader->description().channels[0].type, Type::f32);
}

TEST(MetaImageReader, FilesOfASequenceAgreeInPlaceAndScaling) {
  Scratch s;
  const std::string same = "NDims = 3\nDimSize = 2 3 4\nElementSpacing = 2 2 3\nOffset = 0 0 0\n";
  s.file("m_0.mha", floats(same));
  s.file("m_1.mha", floats(same));
  EXPECT_EQ(refusal(inputs({s.path("m_%d.mha")})).exit, Exit::ok);
  s.file("m_1.mha", floats(replaced(same, "2 2 3", "2 2 5")));
  EXPECT_REFUSED(refusal(inputs({s.path("m_%d.mha")})), Exit::bad_input, "m_1.mha: its spacing, directions");
  s.file("m_1.mha", floats(replaced(same, "Offset = 0", "Offset = 40")));
  EXPECT_REFUSED(refusal(inputs({s.path("m_%d.mha")})), Exit::bad_input, "20 voxels elsewhere");
  s.file("m_1.mha", floats(same + "ElementToIntensityFunctionSlope = 2\n"));
  EXPECT_REFUSED(refusal(inputs({s.path("m_%d.mha")})), Exit::bad_input, "convert the files to one scaling");
}

TEST(MetaImageReader, TakesTheTimestampsOfFrames) {
  Scratch s;
  const std::string stamps = "Seq_Frame0000_Timestamp = 1.5\nSeq_Frame0001_Timestamp = 1.75\n"
                             "Seq_Frame0002_Timestamp = 2.5\n";
  for (const std::string sizes : {"NDims = 4\nDimSize = 2 3 4 3\n", "NDims = 3\nDimSize = 6 4 3\n"}) {
    const auto reader = open_series(inputs({s.file("a.mha", floats(sizes + stamps, 72))}));
    EXPECT_EQ(reader->description().dims[3], 3u) << sizes;
    EXPECT_EQ(reader->description().times.values, (std::vector<double>{1.5, 1.75, 2.5}));
    EXPECT_EQ(reader->description().times.unit, "s");
    EXPECT_EQ(dense(*reader, 2)[1], 49);
  }
  // Of a file for each frame it is the first one; what does not rise is not taken.
  const std::string one = "NDims = 3\nDimSize = 2 3 4\n";
  s.file("m_0.mha", floats(one + "Seq_Frame0000_Timestamp = 4\n"));
  s.file("m_1.mha", floats(one + "Seq_Frame0000_Timestamp = 4.5\n"));
  EXPECT_EQ(open_series(inputs({s.path("m_%d.mha")}))->description().times.values,
            (std::vector<double>{4, 4.5}));
  s.file("m_1.mha", floats(one + "Seq_Frame0000_Timestamp = 3\n"));
  EXPECT_EQ(open_series(inputs({s.path("m_%d.mha")}))->description().times.values,
            (std::vector<double>{0, 1}));
}

TEST(MetaImageReader, RefusesWhatItCannotTrust) {
  Scratch s;
  const std::string raw = bytes_of(ramp());
  const std::string tail = "ElementDataFile = LOCAL\n" + raw;
  const auto refused = [&](const std::string& content) {
    return refusal(inputs({s.file("x.mha", content)}));
  };
  EXPECT_REFUSED(refused(mha_header + "ElementDataFile = ../secret.raw\n"), Exit::bad_input, "own folder");
  EXPECT_REFUSED(refused(mha_header + "ElementDataFile = /etc/passwd\n"), Exit::bad_input, "own folder");
  EXPECT_REFUSED(refused(mha_header + "ElementDataFile = LOCAL\n" + raw.substr(2)), Exit::bad_input, "x.mha");
  EXPECT_REFUSED(refused(mha_header), Exit::bad_input, "ElementDataFile");
  EXPECT_REFUSED(refused(replaced(mha_header, "MET_SHORT", "MET_SHORT_ARRAY") + tail), Exit::bad_input,
                 "MET_SHORT_ARRAY");
  EXPECT_REFUSED(refused(replaced(mha_header, "2 3 4 5", "2 3 4") + tail), Exit::bad_input, "NDims");
  EXPECT_REFUSED(refused(replaced(mha_header, "2 3 4 5", "0 3 4 5") + tail), Exit::bad_input, "no samples");
  EXPECT_REFUSED(refused(replaced(mha_header, "2 3 4 5", "2147483647 2147483647 4 5") + tail),
                 Exit::bad_input, "too many");
  EXPECT_REFUSED(refused(replaced(mha_header, "NDims = 4", "NDims = 77") + tail), Exit::bad_input,
                 "NDims 77");
  EXPECT_REFUSED(refused("NDims = 3\nElementSpacing = 1 1 1\n" + mha_header + tail), Exit::bad_input,
                 "a second \"NDims\"");
  EXPECT_REFUSED(refused(mha_header + "DimSize = 1 1 1 1\n" + tail), Exit::bad_input, "a second \"DimSize\"");
  EXPECT_REFUSED(refused(replaced(mha_header, "Image\n", "Tube\n") + tail), Exit::bad_input, "Tube");
  EXPECT_REFUSED(refused(mha_header + "ElementSpacing = 1 0 1 1\n" + tail), Exit::bad_input, "--spacing");
  EXPECT_REFUSED(refused(mha_header + "ElementSpacing = 1 nan 1 1\n" + tail), Exit::bad_input, "line 8");
  EXPECT_REFUSED(
      refused(mha_header + "ElementDataFile = s%d.raw -9223372036854775808 9223372036854775807 1\n"),
      Exit::bad_input, "first, last, step");
  EXPECT_REFUSED(refused(replaced(mha_header, "CompressedData = False", "CompressedData = True") + tail),
                 Exit::bad_input, "x.mha");
}

} // namespace
} // namespace bcc4::test

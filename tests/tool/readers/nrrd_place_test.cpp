// SPDX-License-Identifier: Apache-2.0
// Where the NRRD reader has samples: cells and nodes, ends of axes, left-handed spaces, files of a sequence.
#include "readers/nrrd/nrrd_place.h"

#include "scratch.h"

namespace bcc4::test {
namespace {

using Matrix = std::array<double, 16>;

// A file of 2 x 3 x 4 bytes with these fields.
std::string nrrd(const std::string& fields) {
  return "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n" + fields + "\n" +
         std::string(24, '\1');
}

SeriesDescription described(const Scratch& s, const std::string& fields) {
  return open_series(inputs({s.file("a.nrrd", nrrd(fields))}))->description();
}

std::array<double, 3> origin_of(const SeriesDescription& d) {
  return {d.affine[3], d.affine[7], d.affine[11]};
}

TEST(NrrdPlace, TheFirstCellLiesHalfAStepInwards) {
  Scratch s;
  const std::string ends = "spacings: 2 3 4\naxis mins: -22 0 10\n";
  EXPECT_EQ(origin_of(described(s, ends + "centerings: cell cell cell\n")),
            (std::array<double, 3>{-21, 1.5, 12}));
  EXPECT_EQ(origin_of(described(s, ends + "centers: node cell ???\n")),
            (std::array<double, 3>{-22, 1.5, 12}));
  EXPECT_EQ(origin_of(described(s, ends)), (std::array<double, 3>{-21, 1.5, 12})) << "cells unless told";
  EXPECT_EQ(origin_of(described(s, "spacings: 2 3 4\n")), (std::array<double, 3>{0, 0, 0}));
  EXPECT_REFUSED(refusal(inputs({s.file("b.nrrd", nrrd("centerings: cell side node\n"))})), Exit::bad_input,
                 "\"side\" is neither cell nor node");
}

TEST(NrrdPlace, EndsOfAnAxisGiveItsStep) {
  Scratch s;
  const SeriesDescription cells = described(s, "axis mins: 0 0 0\naxis maxs: 4 9 16\n");
  EXPECT_EQ(cells.affine, (Matrix{2, 0, 0, 1, 0, 3, 0, 1.5, 0, 0, 4, 2, 0, 0, 0, 1}));
  const SeriesDescription nodes =
      described(s, "axis mins: 0 0 0\naxis maxs: 4 9 -9\ncenterings: node node node\n");
  EXPECT_EQ(nodes.affine, (Matrix{4, 0, 0, 0, 0, 4.5, 0, 0, 0, 0, -3, 0, 0, 0, 0, 1}));
  // Spacing and ends together tell what samples are.
  const SeriesDescription told = described(s, "axis mins: 0 0 0\naxis maxs: 2 6 16\nspacings: 2 3 4\n");
  EXPECT_EQ(origin_of(told), (std::array<double, 3>{0, 0, 2}));
  EXPECT_EQ(origin_of(described(s, "axis maxs: 4 9 16\nspacings: 2 3 4\n")),
            (std::array<double, 3>{1, 1.5, 2}));
}

TEST(NrrdPlace, LeftHandedSpacesAreTurnedRound) {
  Scratch s;
  const std::string place = "space directions: (-1,0,0) (0,1,0) (0,0,1)\nspace origin: (39,5,6)\n";
  const SeriesDescription las = described(s, "space: LAS\n" + place);
  EXPECT_EQ(las.affine, (Matrix{1, 0, 0, -39, 0, 1, 0, 5, 0, 0, 1, 6, 0, 0, 0, 1}));
  EXPECT_EQ(las.attributes,
            (std::vector<std::pair<std::string, std::string>>{{"space", "right-anterior-superior"}}));
  ASSERT_FALSE(las.notes.empty());
  EXPECT_NE(las.notes[0].find("axis x is turned round"), std::string::npos);
  const SeriesDescription left = described(s, "space: 3D-left-handed\n" + place);
  EXPECT_EQ(left.affine, (Matrix{-1, 0, 0, 39, 0, 1, 0, 5, 0, 0, -1, -6, 0, 0, 0, 1}));
  EXPECT_EQ(left.attributes[0].second, "3d-right-handed");
  const SeriesDescription lps = described(s, "space: LPS\n" + place);
  EXPECT_EQ(lps.affine[0], -1);
  EXPECT_TRUE(lps.notes.empty());
}

TEST(NrrdPlace, FilesOfASequenceLieInOnePlace) {
  Scratch s;
  const auto fields = [](const char* x, const char* origin) {
    return concat("space: LPS\nspace directions: (", x, ",0,0) (0,2,0) (0,0,3)\nspace origin: (", origin,
                  ")\n");
  };
  s.file("q_0.nrrd", nrrd(fields("2", "0,0,0")));
  s.file("q_1.nrrd", nrrd(fields("2.0000001", "0,0,0")));
  EXPECT_EQ(refusal(inputs({s.path("q_%d.nrrd")})).exit, Exit::ok);
  s.file("q_1.nrrd", nrrd(fields("-2", "0,0,0")));
  EXPECT_REFUSED(refusal(inputs({s.path("q_%d.nrrd")})), Exit::bad_input,
                 "q_1.nrrd: its spacing, directions");
  s.file("q_1.nrrd", nrrd(fields("2", "0,0,7")));
  EXPECT_REFUSED(refusal(inputs({s.path("q_%d.nrrd")})), Exit::bad_input, "voxels elsewhere");
  ReaderOptions o = inputs({s.path("q_%d.nrrd")});
  o.origin = {{0, 0, 0}};
  EXPECT_EQ(refusal(o).exit, Exit::ok);
  o = inputs({s.path("q_%d.nrrd")});
  o.spacing = {{2, 2, 3}};
  EXPECT_EQ(refusal(o).exit, Exit::ok);
}

} // namespace
} // namespace bcc4::test

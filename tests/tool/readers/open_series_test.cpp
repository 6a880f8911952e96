// SPDX-License-Identifier: Apache-2.0
#include "readers/open_series.h"

#include <cstdlib>
#include <filesystem>

#include "openings.h"

namespace bcc4::test {
namespace {

// The first file is opened once more than the others, to be recognised.
TEST(OpenSeries, ReadsTheFirstHeaderOnce) {
  const std::string voxels(24, '\1');
  std::string nifti(352, '\0');
  const auto put = [&](size_t at, auto value) { std::memcpy(nifti.data() + at, &value, sizeof value); };
  put(0, int32_t{348});
  for (size_t a = 0; a < 8; ++a) put(40 + 2 * a, std::array<int16_t, 8>{3, 2, 3, 4, 1, 1, 1, 1}[a]);
  put(70, int16_t{2});
  put(108, 352.0f);
  std::memcpy(nifti.data() + 344, "n+1", 4);
  std::string numbers;
  for (int i = 0; i < 24; ++i) numbers += "1 ";

  const std::pair<const char*, std::string> formats[] = {
      {"raw", voxels},
      {"nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n\n" + voxels},
      {"mha", "NDims = 3\nDimSize = 2 3 4\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + voxels},
      {"nii", nifti + voxels},
      {"nii.gz", gzipped(nifti + voxels)},
      {"vti", "<VTKFile type=\"ImageData\"><ImageData><Piece Extent=\"0 1 0 2 0 3\"><PointData>"
              "<DataArray type=\"UInt8\" Name=\"d\" format=\"ascii\">" +
                  numbers + "</DataArray></PointData></Piece></ImageData></VTKFile>"}};
  for (const auto& [extension, content] : formats) {
    SCOPED_TRACE(extension);
    Scratch s;
    const std::string first = concat("f.1.", extension), second = concat("f.2.", extension);
    s.file(first, content);
    s.file(second, content);
    ReaderOptions o = inputs({s.path(concat("f.%d.", extension))});
    if (std::string_view(extension) == "raw") {
      o.dims = {2, 3, 4, 0};
      o.dtype = Type::u8;
    }
    expect_opened_once(s, o, first, second, 1);
  }
}

// Formats without a gzip of their own: what is said has the names of the packed files, and nothing stays
// behind.
TEST(OpenSeries, UnpacksWhatIsPackedWithGzip) {
  Scratch s;
#ifndef _WIN32
  ::setenv("TMPDIR", s.path("").c_str(), 1); // other tests unpack at the same time
#endif
  const std::string nrrd =
      "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n\n" + std::string(24, 'x');
  const auto temporary = [] {
    size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::temp_directory_path()))
      count += entry.path().filename().string().starts_with("bcc4-") ? 1 : 0;
    return count;
  };
  const size_t before = temporary();
  for (const char* const name : {"a.nrrd.gz", "b.nrrd"}) {
    const std::string path = s.file(name, gzipped(nrrd));
    const auto reader = open_series(inputs({path}));
    EXPECT_EQ(reader->description().dims, (std::array<uint64_t, 4>{2, 3, 4, 1}));
    EXPECT_EQ(reader->description().files.at(0).path, path);
    EXPECT_EQ(reader->description().files.at(0).bytes, std::filesystem::file_size(path));
    EXPECT_EQ(reader->frame_name(0), path);
    EXPECT_EQ(static_cast<char>(*reader->read(0, 0).boxes.at(0).data), 'x');
  }
  EXPECT_EQ(temporary(), before);
  const auto packed = [&](const char* name, const std::string& content) {
    return refusal(inputs({s.file(name, gzipped(content))}));
  };
  EXPECT_REFUSED(packed("a.mha.gz", "NDims = 3\nDimSize = 2 3 4\n"), Exit::bad_input, s.path("a.mha.gz"));
  EXPECT_REFUSED(packed("a.vti.gz", "<VTKFile type=\"ImageData\">"), Exit::bad_input, s.path("a.vti.gz"));
  EXPECT_REFUSED(packed("a.nhdr.gz", nrrd), Exit::bad_input, "names other files");
  EXPECT_EQ(temporary(), before);
  ReaderOptions o = inputs({s.file("a.raw", gzipped(nrrd.substr(1)))});
  o.dims = {10, 10, 10, 1}, o.dtype = Type::u8;
  EXPECT_REFUSED(refusal(o), Exit::bad_input, "packed with gzip: name it .gz");
}

TEST(OpenSeries, NamesWhatAFileIsNot) {
  Scratch s;
  EXPECT_REFUSED(refusal(inputs({s.file("a.nrrd", "nothing")})), Exit::bad_input, "damaged or misnamed");
  EXPECT_REFUSED(refusal(inputs({s.file("a.dat", "NanoVDB0")})), Exit::bad_input, "nanovdb_convert");
  EXPECT_REFUSED(refusal(inputs({s.file("b.dat", "BCC4....")})), Exit::bad_input, "a .bcc4 file already");
  EXPECT_REFUSED(refusal(inputs({s.file("c.dat", "nothing")})), Exit::usage, "none of the known formats");
  EXPECT_REFUSED(refusal(inputs({})), Exit::usage, "no input");
}

TEST(OpenSeries, ListsEveryReader) {
  std::vector<std::string> names;
  for (const ReaderInfo& reader : reader_list()) names.emplace_back(reader.name);
  EXPECT_EQ(names, (std::vector<std::string>{"raw", "nrrd", "vti", "nifti", "metaimage", "netcdf", "tiff",
                                             "openvdb"}));
}

} // namespace
} // namespace bcc4::test

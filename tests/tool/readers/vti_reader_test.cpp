// SPDX-License-Identifier: Apache-2.0
// The reader of VTK ImageData on files written here: every encoding, cells, collections and their times,
// choices of arrays, and damaged files.
#include "readers/vti/vti_reader.h"

#include <numeric>

#include "readers/vti/base64.h"
#include "readers/vti/vti_file.h"
#include "scratch.h"

namespace bcc4::test {
namespace {

std::string base64(const std::string& bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::string u32(std::vector<uint32_t> values, bool swapped = false) { return bytes_of(values, swapped); }

// Returns 2 x 3 x 4 floats, each its own index.
std::vector<float> counting() {
  std::vector<float> v(24);
  std::iota(v.begin(), v.end(), 0.0f);
  return v;
}

// Returns zlib blocks of `block` bytes as VTK lays them out.
std::string blocks(const std::string& data, size_t block, std::string& sizes) {
  std::string out;
  std::vector<uint32_t> head{static_cast<uint32_t>((data.size() + block - 1) / block),
                             static_cast<uint32_t>(block), static_cast<uint32_t>(data.size() % block)};
  for (size_t at = 0; at < data.size(); at += block) {
    const std::string part = data.substr(at, block);
    uLongf size = compressBound(static_cast<uLong>(part.size()));
    std::string packed(size, '\0');
    compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(part.data()),
             static_cast<uLong>(part.size()));
    packed.resize(size);
    head.push_back(static_cast<uint32_t>(size));
    out += packed;
  }
  sizes = u32(head);
  return out;
}

std::string vti(const std::string& array, const std::string& root = "", const std::string& after = "") {
  return "<?xml version=\"1.0\"?>\n<!-- made by hand -->\n<VTKFile type=\"ImageData\" version=\"0.1\" " +
         root +
         ">\n<ImageData WholeExtent=\"0 1 0 2 0 3\" Origin=\"1 2 3\" Spacing=\"0.5 1 2\">\n<Piece Extent=\"0 "
         "1 0 2 0 3\">\n"
         "<PointData Scalars=\"d\">" +
         array + "</PointData>\n<CellData></CellData>\n</Piece>\n</ImageData>\n" + after + "</VTKFile>\n";
}

void expect_counting_file(const std::string& path) {
  const auto reader = open_series(inputs({path}));
  ASSERT_EQ(reader->description().dims, (std::array<uint64_t, 4>{2, 3, 4, 1}));
  const auto v = dense(*reader, 0);
  for (size_t i = 0; i < v.size(); ++i) ASSERT_EQ(v[i], static_cast<double>(i));
  EXPECT_EQ(reader->description().affine,
            (std::array<double, 16>{0.5, 0, 0, 1, 0, 1, 0, 2, 0, 0, 2, 3, 0, 0, 0, 1}));
}

TEST(VtiReader, ReadsEveryKindOfData) {
  Scratch s;
  std::string text;
  for (const float v : counting()) text += concat(v, " ");
  expect_counting_file(s.file("ascii.vti", vti("<DataArray type=\"Float32\" Name=\"d\" format=\"ascii\">\n" +
                                               text + "</DataArray>")));

  const std::string data = bytes_of(counting());
  const std::string plain = u32({96}) + data;
  expect_counting_file(
      s.file("binary.vti", vti("<DataArray type=\"Float32\" Name=\"d\" format=\"binary\">\n " +
                               base64(plain) + "\n</DataArray>")));
  const std::string wide = bytes_of(std::vector<uint64_t>{96}) + data;
  expect_counting_file(s.file("wide.vti", vti("<DataArray type=\"Float32\" Name=\"d\" format=\"binary\">" +
                                                  base64(wide) + "</DataArray>",
                                              "byte_order=\"LittleEndian\" header_type=\"UInt64\"")));
  const std::string big = u32({96}, true) + bytes_of(counting(), true);
  const std::string reference = "<DataArray type=\"Float32\" Name=\"d\" format=\"appended\" offset=\"0\"/>";
  expect_counting_file(
      s.file("big.vti", vti(reference, "byte_order=\"BigEndian\"",
                            "<AppendedData encoding=\"raw\">\n _" + big + "\n</AppendedData>")));
  expect_counting_file(s.file(
      "appended64.vti",
      vti(reference, "", "<AppendedData encoding=\"base64\">\n_" + base64(plain) + "\n</AppendedData>")));

  std::string sizes;
  const std::string packed = blocks(data, 40, sizes);
  const std::string zlib = "compressor=\"vtkZLibDataCompressor\"";
  expect_counting_file(
      s.file("zlib.vti",
             vti(reference, zlib, "<AppendedData encoding=\"raw\">_" + sizes + packed + "</AppendedData>")));
  expect_counting_file(s.file("zlib64.vti", vti("<DataArray type=\"Float32\" Name=\"d\" format=\"binary\">" +
                                                    base64(sizes) + base64(packed) + "</DataArray>",
                                                zlib)));
}

TEST(VtiReader, PlacesCellsAtTheirCentres) {
  Scratch s;
  std::string file = vti("", "");
  file.replace(
      file.find("<CellData></CellData>"), 21,
      "<CellData><DataArray type=\"UInt8\" Name=\"c\" format=\"ascii\">0 1 2 3 4 5</DataArray></CellData>");
  const auto reader = open_series(inputs({s.file("cells.vti", file)}));
  EXPECT_EQ(reader->description().dims, (std::array<uint64_t, 4>{1, 2, 3, 1}));
  EXPECT_EQ(reader->description().affine[3], 1.25);
  EXPECT_EQ(reader->description().affine[11], 4);
}

TEST(VtiReader, ReadsSeriesWithTheirTimes) {
  Scratch s;
  const auto frame = [](double time, int value) {
    std::string text;
    for (int i = 0; i < 24; ++i) text += concat(value, " ");
    std::string file = vti("<DataArray type=\"Int16\" Name=\"d\" format=\"ascii\">" + text + "</DataArray>");
    return file.insert(file.find("<Piece"),
                       concat("<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" "
                              "NumberOfTuples=\"1\" format=\"ascii\">",
                              time, "</DataArray></FieldData>"));
  };
  s.file("f_8.vti", frame(0.5, 8));
  s.file("f_9.vti", frame(0.75, 9));
  s.file("f_10.vti", frame(1.5, 10));
  const auto reader = open_series(inputs({s.path("f_%d.vti")}));
  EXPECT_EQ(reader->description().times.values, (std::vector<double>{0.5, 0.75, 1.5}));
  EXPECT_EQ(dense(*reader, 2)[0], 10);

  s.file("all.pvd",
         "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"3\" part=\"0\" file=\"f_10.vti\"/>"
         "<DataSet timestep=\"1\" file=\"f_8.vti\"/></Collection></VTKFile>");
  const auto collection = open_series(inputs({s.path("all.pvd")}));
  EXPECT_EQ(collection->description().times.values, (std::vector<double>{1, 3}));
  EXPECT_EQ(dense(*collection, 0)[0], 8);
  EXPECT_EQ(open_series(inputs({s.path("*.pvd")}))->description().dims[3], 2u); // a pattern finds it, too
  EXPECT_REFUSED(refusal(inputs({s.path("all.pvd"), s.path("all.pvd")})), Exit::usage, "stands alone");
  s.file("sub/out.pvd", "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"3\" "
                        "file=\"../f_8.vti\"/></Collection></VTKFile>");
  EXPECT_REFUSED(refusal(inputs({s.path("sub/out.pvd")})), Exit::bad_input, "own folder");
}

TEST(VtiReader, UnitsAndTimesAsOthersWriteThem) {
  Scratch s;
  std::string zeros;
  for (int i = 0; i < 24; ++i) zeros += "0 ";
  std::string file = vti("<DataArray type=\"UInt8\" Name=\"d\" format=\"ascii\"><InformationKey "
                         "name=\"UNITS_LABEL\" location=\"vtkDataArray\">m/s</InformationKey>" +
                         zeros + "</DataArray>");
  const auto with_field = [&](const std::string& array) {
    std::string text = file;
    return text.insert(text.find("<Piece"),
                       "<FieldData><DataArray type=\"Float64\" " + array + "</DataArray></FieldData>");
  };
  const auto times = [&](const std::string& array) {
    return open_series(inputs({s.file("t.vti", with_field(array))}))->description().times;
  };
  EXPECT_EQ(times("Name=\"TIME\" NumberOfTuples=\"1\" format=\"ascii\">2.5").values,
            (std::vector<double>{2.5})); // VisIt
  EXPECT_TRUE(times("Name=\"time\" NumberOfTuples=\"2\" format=\"ascii\">2.5 3").counted);
  EXPECT_EQ(open_series(inputs({s.path("t.vti")}))->description().channels[0].unit, "m/s");
}

TEST(VtiReader, CollectionsNameOneFileForEachTime) {
  Scratch s;
  std::string zeros;
  for (int i = 0; i < 24; ++i) zeros += "0 ";
  const std::string file =
      vti("<DataArray type=\"UInt8\" Name=\"d\" format=\"ascii\">" + zeros + "</DataArray>");
  for (const char* name : {"d/a 0.vti", "d/a 1.vti"}) s.file(name, file);
  const auto collection = [&](const std::string& sets) {
    return s.file("c.pvd", "<VTKFile type=\"Collection\"><Collection>" + sets + "</Collection></VTKFile>");
  };
  const auto set = [](const std::string& attributes, const std::string& name) {
    return "<DataSet " + attributes + " file=\"" + name + "\"/>";
  };
  ReaderOptions o = inputs({collection(set("timestep=\"0\" part=\"0\"", "d/a 0.vti") +
                                       set("timestep=\"0\" part=\"1\"", "d/a 1.vti"))});
  EXPECT_REFUSED(refusal(o), Exit::bad_input, "timestep 0 has several parts, ");
  o.dt = 1; // parts are no frames, whatever their times
  EXPECT_REFUSED(refusal(o), Exit::bad_input, "write one .vti for each time step");
  o = inputs({collection(set("timestep=\"0\"", "d/a 0.vti") + set("timestep=\"0\"", "d/a 1.vti"))});
  EXPECT_REFUSED(refusal(o), Exit::bad_input, "timestep 0 has two files");
  o.dt = 1;
  EXPECT_EQ(open_series(o)->description().times.values, (std::vector<double>{0, 1}));
  // A file that is named once more is one frame.
  o = inputs({collection(set("timestep=\"0\"", "d/a 0.vti") + set("timestep=\"0\"", "d/a 0.vti") +
                         set("timestep=\"1\"", "d/a 1.vti"))});
  EXPECT_EQ(open_series(o)->description().times.values, (std::vector<double>{0, 1}));
  o = inputs({collection(set("", "d/a 0.vti") + set("", "d/a 1.vti"))});
  EXPECT_REFUSED(refusal(o), Exit::bad_input, "no timestep: give --dt or --times");
  o.times = {{3, 5}};
  EXPECT_EQ(open_series(o)->description().times.values, (std::vector<double>{3, 5}));
  // Absolute paths below the collection's folder, and those of Windows.
  o = inputs({collection(set("timestep=\"0\"", s.path("d/a 0.vti")) + set("timestep=\"1\"", "d\\a 1.vti"))});
  EXPECT_EQ(refusal(o).exit, Exit::ok) << refusal(o).text;
  o = inputs({collection(set("timestep=\"0\"", "/elsewhere/a 0.vti"))});
  EXPECT_REFUSED(refusal(o), Exit::bad_input, "not below the collection's own folder: move");
  s.file("p.pvti", "<VTKFile type=\"PImageData\"><PImageData/></VTKFile>");
  EXPECT_REFUSED(refusal(inputs({s.path("p.pvti")})), Exit::bad_input, "save it as one .vti");
  s.file("f.vti.series", "{\"file-series-version\": \"1.0\"}");
  EXPECT_REFUSED(refusal(inputs({s.path("f.vti.series")})), Exit::bad_input, "give the files themselves");
}

TEST(VtiReader, RunsThatAreTakenUpAgainGoOnFromThere) {
  Scratch s;
  const auto file = [&](const std::string& name, int value) {
    std::string values;
    for (int i = 0; i < 24; ++i) values += std::to_string(value) + " ";
    s.file(name, vti("<DataArray type=\"UInt8\" Name=\"d\" format=\"ascii\">" + values + "</DataArray>"));
  };
  std::string sets;
  const auto write = [&](double time, int value) {
    const std::string name = std::to_string(value) + ".vti";
    file(name, value);
    sets += concat("<DataSet timestep=\"", time, "\" file=\"", name, "\"/>");
  };
  for (int i = 0; i < 5; ++i) write(i * 0.1, 10 + i); // the third at 0.30000000000000004
  write(0.2, 20), write(0.25, 21), write(0.35, 22);
  ReaderOptions o = inputs(
      {s.file("c.pvd", "<VTKFile type=\"Collection\"><Collection>" + sets + "</Collection></VTKFile>")});
  for (const bool with_step : {false, true}) {
    if (with_step) o.dt = 1;
    const auto reader = open_series(o);
    EXPECT_EQ(reader->description().times.values, with_step ? (std::vector<double>{0, 1, 2, 3, 4})
                                                            : (std::vector<double>{0, 0.1, 0.2, 0.25, 0.35}));
    std::vector<int> first;
    for (uint64_t f = 0; f < 5; ++f) first.push_back(static_cast<int>(*reader->read(f, 0).boxes[0].data));
    EXPECT_EQ(first, (std::vector<int>{10, 11, 20, 21, 22}));
    EXPECT_NE(
        reader->description().notes[0].find("without 3 that the run wrote before it was taken up again: "
                                            "12.vti, 13.vti and 14.vti"),
        std::string::npos);
  }
}

TEST(VtiReader, TimesOfACollectionThatAreCloseAreTwo) {
  Scratch s;
  std::string values;
  for (int i = 0; i < 24; ++i) values += "1 ";
  const auto times = [&](const std::vector<std::pair<double, int>>& named, const std::string& more = "") {
    std::string sets;
    for (const auto& [time, number] : named) {
      const std::string name = concat(number, ".vti");
      s.file(name, vti("<DataArray type=\"UInt8\" Name=\"d\" format=\"ascii\">" + values + "</DataArray>"));
      sets += concat("<DataSet timestep=\"", time, "\" file=\"", name, "\"/>");
    }
    sets += more;
    const ReaderOptions o = inputs(
        {s.file("c.pvd", "<VTKFile type=\"Collection\"><Collection>" + sets + "</Collection></VTKFile>")});
    return open_series(o)->description().times.values;
  };
  EXPECT_EQ(times({{1.7e9, 0}, {1.7e9 + 1, 1}, {1.7e9 + 2, 2}}),
            (std::vector<double>{1.7e9, 1.7e9 + 1, 1.7e9 + 2}));
  // A run that is taken up again and writes over its files.
  EXPECT_EQ(times({{0, 0}, {1, 1}, {2, 2}, {1, 1}, {1.5, 2}}), (std::vector<double>{0, 1, 1.5}));
  // One whose times meet none of before, for it goes on in other steps; its files count on.
  EXPECT_EQ(times({{0, 0}, {1, 1}, {2, 2}, {3, 3}, {1.5, 4}, {2.5, 5}}),
            (std::vector<double>{0, 1, 1.5, 2.5}));
  // A collection that is only not sorted.
  EXPECT_EQ(times({{0, 0}, {1, 1}, {10, 10}, {11, 11}, {2, 2}, {3, 3}}),
            (std::vector<double>{0, 1, 2, 3, 10, 11}));
  EXPECT_EQ(times({{2, 2}, {1, 1}, {0, 0}}), (std::vector<double>{0, 1, 2}));
  // Another series of the same times.
  EXPECT_THROW(times({{0, 0}, {1, 1}, {2, 2}}, "<DataSet timestep=\"0\" name=\"solid\" file=\"1.vti\"/>"),
               Error);
}

TEST(VtiReader, ChoosesArrays) {
  Scratch s;
  std::string a, b;
  for (int i = 0; i < 24; ++i) {
    a += "1 ";
    b += "2 3 ";
  }
  std::string file =
      vti("<DataArray type=\"UInt8\" Name=\"mass\" format=\"ascii\">" + a +
          "</DataArray><DataArray type=\"UInt8\" Name=\"flow\" NumberOfComponents=\"2\" format=\"ascii\">" +
          b + "</DataArray>");
  ReaderOptions o = inputs({s.file("a.vti", file)});
  EXPECT_REFUSED(refusal(o), Exit::usage, "no array \"d\""); // the active scalars are none of them
  o.channels = {"flow"};
  const auto reader = open_series(o);
  ASSERT_EQ(reader->description().channels.size(), 2u);
  EXPECT_EQ(dense(*reader, 0, 0)[5], 2);
  EXPECT_EQ(dense(*reader, 0, 1)[5], 3);
  o.channels = {"mas"};
  EXPECT_REFUSED(refusal(o), Exit::usage, "did you mean mass?");
}

TEST(VtiReader, RefusesDamage) {
  Scratch s;
  const auto refused = [&](const std::string& text) { return refusal(inputs({s.file("a.vti", text)})); };
  const std::string reference = "<DataArray type=\"Float32\" Name=\"d\" format=\"appended\" offset=\"0\"/>";
  const auto appended = [&](const std::string& data, const std::string& root = "") {
    return refused(vti(reference, root, "<AppendedData encoding=\"raw\">_" + data));
  };
  const std::string data = bytes_of(counting());
  EXPECT_REFUSED(appended(u32({96}) + data.substr(0, 50)), Exit::bad_input, "are expected");
  EXPECT_REFUSED(appended(u32({92}) + data), Exit::bad_input, "holds 92 bytes");
  const std::string zlib = "compressor=\"vtkZLibDataCompressor\"";
  std::string sizes;
  std::string packed = blocks(data, 40, sizes);
  EXPECT_REFUSED(appended(u32({4000000000u, 40, 16}) + data, zlib), Exit::bad_input, "declares");
  EXPECT_REFUSED(appended(sizes + packed.substr(0, 10), zlib), Exit::bad_input, "cut off");
  packed[5] = static_cast<char>(packed[5] ^ 0x55);
  EXPECT_REFUSED(appended(sizes + packed, zlib), Exit::bad_input, "damaged");
  EXPECT_REFUSED(appended(data, "compressor=\"vtkLZ4DataCompressor\""), Exit::bad_input,
                 "vtkLZ4DataCompressor");
  std::string huge = vti(reference, "", "<AppendedData encoding=\"raw\">_xx");
  for (size_t at = huge.find("0 1 0 2 0 3"); at != std::string::npos; at = huge.find("0 1 0 2 0 3"))
    huge.replace(at, 11, "0 99999 0 99999 0 99999");
  EXPECT_REFUSED(refused(huge), Exit::bad_input, "cannot fit");
  EXPECT_REFUSED(refused("<VTKFile type=\"PolyData\"></VTKFile>"), Exit::bad_input, "ImageData");
  EXPECT_REFUSED(refused("<VTKFile type=\"ImageData\">"), Exit::bad_input, "mismatch");
  std::string deep = "<VTKFile type=\"ImageData\">";
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  EXPECT_REFUSED(refused(deep), Exit::bad_input, "mismatch");
  for (int i = 0; i < 100000; ++i) deep += "</a>";
  EXPECT_REFUSED(refused(deep + "</VTKFile>"), Exit::bad_input, "no ImageData element");
  // Entities that name each other are not followed.
  std::string laughs = "<!DOCTYPE v [<!ENTITY a \"aaaaaaaaaa\">";
  for (char c = 'b'; c < 'j'; ++c)
    laughs += concat("<!ENTITY ", c, " \"&", char(c - 1), ";&", char(c - 1), ";\">");
  EXPECT_REFUSED(refused(laughs + "]><VTKFile type=\"&i;\"></VTKFile>"), Exit::bad_input, "ImageData");
}

TEST(VtiReader, SurvivesMutations) {
  Scratch s;
  const std::string good = vti("<DataArray type=\"Float32\" Name=\"d\" format=\"binary\">" +
                               base64(u32({96}) + bytes_of(counting())) + "</DataArray>");
  size_t refused = 0;
  for (size_t i = 0; i < good.size(); ++i)
    for (const char c : {'\0', '<', '"', '-', '9', '='}) {
      if ((i + static_cast<uint8_t>(c)) % 3 != 0) continue; // a third of them keeps the test short
      std::string bad = good;
      bad[i] = c;
      refused += refusal(inputs({s.file("m.vti", bad)})).exit != Exit::ok;
    }
  EXPECT_GT(refused, 100u);
}

TEST(Base64, RoundTrips) {
  for (size_t n = 0; n < 9; ++n) {
    std::string bytes;
    for (size_t i = 0; i < n; ++i) bytes += static_cast<char>(37 * i + 200);
    const std::string text = base64(bytes) + base64("next");
    std::string_view rest = text;
    const Bytes out = take_base64(rest, n, "test");
    EXPECT_TRUE(std::equal(out.begin(), out.end(), std::as_bytes(std::span(bytes)).begin(),
                           std::as_bytes(std::span(bytes)).end()));
    if (n % 3 != 0) {
      EXPECT_EQ(rest, base64("next"));
    }
  }
  std::string_view bad = "AB*D";
  EXPECT_REFUSED(refusal([&] { (void)take_base64(bad, 3, "test"); }), Exit::bad_input, "base64");
}

// 2 x 3 x 4 samples at uneven places along z; x is even, y falls.
std::string vtr(const std::string& z, const std::string& data, const char* kind = "PointData") {
  const bool cells = std::string(kind) == "CellData";
  return std::string("<VTKFile type=\"RectilinearGrid\" version=\"0.1\"><RectilinearGrid WholeExtent=\"") +
         (cells ? "0 2 0 3 0 4" : "0 1 0 2 0 3") + "\"><Piece Extent=\"" +
         (cells ? "0 2 0 3 0 4" : "0 1 0 2 0 3") + "\"><" + kind +
         "><DataArray type=\"Float32\" Name=\"d\" format=\"ascii\">" + data + "</DataArray></" + kind +
         "><Coordinates><DataArray type=\"Float32\" format=\"ascii\">" + (cells ? "3 5 7" : "3 5") +
         "</DataArray><DataArray type=\"Float64\" format=\"ascii\">" + (cells ? "9 8 6 0" : "9 8 6") +
         "</DataArray><DataArray type=\"Int32\" format=\"ascii\">" + z +
         "</DataArray></Coordinates></Piece></RectilinearGrid></VTKFile>";
}

TEST(VtiReader, TakesRectilinearGridsWithTheirCoordinates) {
  Scratch s;
  std::string data;
  for (int i = 0; i < 24; ++i) data += std::to_string(i) + " ";
  const auto reader = open_series(inputs({s.file("a.vtr", vtr("0 10 20 50", data))}));
  const SeriesDescription& d = reader->description();
  EXPECT_EQ(d.format, "VTK RectilinearGrid");
  EXPECT_EQ(d.dims, (std::array<uint64_t, 4>{2, 3, 4, 1}));
  EXPECT_TRUE(d.places[0].coordinates.empty());
  EXPECT_EQ(d.places[1].coordinates, (std::vector<double>{9, 8, 6}));
  EXPECT_EQ(d.places[2].coordinates, (std::vector<double>{0, 10, 20, 50}));
  EXPECT_EQ(d.affine, (Affine{2, 0, 0, 3, 0, -1.5, 0, 9, 0, 0, 50.0 / 3, 0, 0, 0, 0, 1}));
  EXPECT_EQ(dense(*reader, 0)[23], 23);
  const auto cells = open_series(inputs({s.file("c.vtr", vtr("0 10 20 50 100", data, "CellData"))}));
  EXPECT_EQ(cells->description().places[2].coordinates, (std::vector<double>{5, 15, 35, 75}));
  EXPECT_EQ(cells->description().places[1].coordinates, (std::vector<double>{8.5, 7, 3}));
  for (const char* z : {"0 10 10 50", "0 10 5 50"})
    EXPECT_THROW((void)open_series(inputs({s.file("b.vtr", vtr(z, data))})), Error) << z;
  // Files of a series must agree.
  const auto series = open_series(
      inputs({s.file("t0.vtr", vtr("0 10 20 50", data)), s.file("t1.vtr", vtr("0 10 21 50", data))}));
  EXPECT_THROW((void)series->read(1, 0), Error);
}

} // namespace
} // namespace bcc4::test

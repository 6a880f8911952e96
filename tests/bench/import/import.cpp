// SPDX-License-Identifier: Apache-2.0
// Writes a plume as raw, gzip and OpenVDB files and times reading their bytes, reading their frames, and
// importing them into nothing as the tool does. Where no readers are built there is only an error.
#include "tests/bench/import/import.h"

#include "base/error.h"

#ifdef BCCSPLAT_BENCH_READERS

#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <random>
#include <vector>

#include <zlib.h>

#if BCCSPLAT_WITH_OPENVDB
#include <openvdb/openvdb.h>
#endif

#include "readers/byte_stream.h"
#include "readers/error.h"
#include "readers/open_series.h"
#include "series/read_ahead.h"
#include "tests/bench/scale/scale_host.h"

namespace bccsplat::bench {
namespace {

namespace fs = std::filesystem;
using host::sized;

// A plume of n^3 samples: a third of the box, the rest is 0.
struct Plume {
  int n = 96, frames = 24;
  [[nodiscard]] float value(int x, int y, int z, int t) const {
    const double u = (x + .5) / n - .5, v = (y + .5) / n, w = (z + .5) / n - .5;
    const double bend = .12 * std::sin(5 * v - .2 * t), width = .1 + .22 * v;
    const double r = std::hypot(u - bend, w + bend) / width;
    if (r >= 1) return 0;
    const double folds = 1 + .5 * std::sin(23 * u + 3 * v - .3 * t) * std::cos(19 * w + 17 * v - .5 * t);
    return static_cast<float>((1 - r * r) * folds);
  }
  [[nodiscard]] std::vector<float> frame(int t) const {
    std::vector<float> values;
    values.reserve(static_cast<size_t>(n) * n * n);
    for (int z = 0; z < n; ++z)
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) values.push_back(value(x, y, z, t));
    return values;
  }
  [[nodiscard]] double mib() const { return 4.0 * n * n * n * frames / 0x1p20; }
};

// One file per frame in a folder, removed at the end.
struct Written {
  fs::path folder = fs::temp_directory_path() / ("bccsplat-import-" + std::to_string(std::random_device{}()));
  std::vector<std::string> files;
  Written() { fs::create_directories(folder); }
  ~Written() {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  Written(const Written&) = delete;
  Written& operator=(const Written&) = delete;
  const std::string& add(const char* ending) {
    return files.emplace_back((folder / (std::to_string(files.size()) + ending)).string());
  }
};

void write_raw(const Plume& plume, Written& out) {
  for (int t = 0; t < plume.frames; ++t) {
    const std::vector<float> values = plume.frame(t);
    std::ofstream(out.add(".raw"), std::ios::binary)
        .write(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  }
}

void write_gzip(const Plume& plume, Written& out) {
  for (int t = 0; t < plume.frames; ++t) {
    const std::vector<float> values = plume.frame(t);
    const gzFile file = gzopen(out.add(".raw.gz").c_str(), "wb");
    gzwrite(file, values.data(), static_cast<unsigned>(values.size() * sizeof(float)));
    if (gzclose(file) != Z_OK) fail(Code::io_error, out.files.back(), ": cannot be written");
  }
}

#if BCCSPLAT_WITH_OPENVDB
void write_vdb(const Plume& plume, Written& out) {
  openvdb::initialize();
  for (int t = 0; t < plume.frames; ++t) {
    // Made by name, in OpenVDB: create() has the code of the whole tree compiled here once more.
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(
        openvdb::GridBase::createGrid(openvdb::FloatGrid::gridType()));
    grid->setName("density");
    auto at = grid->getAccessor();
    for (int z = 0; z < plume.n; ++z)
      for (int y = 0; y < plume.n; ++y)
        for (int x = 0; x < plume.n; ++x)
          if (const float v = plume.value(x, y, z, t); v != 0) at.setValue({x, y, z}, v);
    openvdb::io::File(out.add(".vdb")).write({grid});
  }
}
#endif

bcc4::ReaderOptions reader_options(const Plume& plume, const Written& series, bool described) {
  bcc4::ReaderOptions o;
  o.inputs = series.files;
  if (described) return o;
  const uint64_t n = plume.n;
  o.dims = {n, n, n, 0};
  o.dtype = bcc4::Type::f32;
  return o;
}

void read_bytes(const Written& series) {
  std::vector<std::byte> chunk(1 << 20);
  for (const std::string& path : series.files) {
    bcc4::InputFile file(path);
    for (uint64_t at = 0; at < file.size();) at += file.read_some(at, chunk);
  }
}

void read_frames(const bcc4::ReaderOptions& options) {
  const auto reader = bcc4::open_series(options);
  for (uint64_t f = 0; f < reader->description().dims[3]; ++f) static_cast<void>(reader->read(f, 0));
}

int64_t write_nowhere(void*, uint64_t, const void*, uint64_t size) { return size; }

// As the tool does it: the next frame is read while the last one is fitted. Into nothing.
void import_series(const bcc4::ReaderOptions& options, int threads) {
  const auto device = make_api_device(threads);
  const auto reader = bcc4::open_series(options);
  const bcc4::SeriesDescription& d = reader->description();
  auto o = sized<bccsplat_writer_options>();
  for (size_t a = 0; a < 4; ++a) o.dims[a] = static_cast<uint32_t>(d.dims[a]);
  auto nowhere = sized<bccsplat_write_stream>();
  nowhere.write_at = write_nowhere;
  bccsplat_writer* w = nullptr;
  api(bccsplat_writer_create_stream(device.get(), &nowhere, &o, &w));
  const Handle<bccsplat_writer> writer(w);
  bcc4::ReadAhead frames(*reader);
  for (uint64_t f = 0; f < d.dims[3]; ++f) {
    const bcc4::Frame frame = frames.next();
    std::vector<bccsplat_box> boxes;
    for (const bcc4::Box& b : frame.boxes) {
      bccsplat_box& box = boxes.emplace_back(sized<bccsplat_box>());
      box.type = BCCSPLAT_TYPE_F32;
      box.data = b.data;
      for (size_t a = 0; a < 3; ++a) {
        box.begin[a] = b.begin[a];
        box.dims[a] = b.dims[a];
        box.stride_bytes[a] = b.stride_bytes[a];
      }
    }
    api(bccsplat_writer_add_frame(writer.get(), 0, static_cast<double>(f), boxes.data(), boxes.size()));
  }
  api(bccsplat_writer_finish(writer.get(), nullptr));
}

// CPU time of the calling thread: with enough cores nothing is done before it is.
double own_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Row measure(const char* name, const Plume& plume, const Written& series, bool described, int repeats) {
  const bcc4::ReaderOptions options = reader_options(plume, series, described);
  uint64_t bytes = 0;
  for (const std::string& path : series.files) bytes += fs::file_size(path);
  const double plain = median_cpu_seconds([&] { read_bytes(series); }, repeats);
  const auto [read, import] =
      paired_cpu_seconds([&] { read_frames(options); }, [&] { import_series(options, 1); }, repeats);
  const double before = own_seconds();
  const double two = cpu_seconds([&] { import_series(options, 2); }), own = own_seconds() - before;
  return {word("series", name),
          figure("MiB of values", plume.mib(), 1),
          figure("MiB on disk", static_cast<double>(bytes) / 0x1p20, 1),
          figure("bytes read, CPU ms", 1e3 * plain, 1),
          figure("frames read, CPU ms", 1e3 * read, 1),
          figure("imported, CPU ms", 1e3 * import, 1),
          figure("import / read", import / read, 2),
          figure("import, MiB/s a core", plume.mib() / import, 0),
          figure("2 threads: CPU / that of the calling one", two / own, 2)};
}

} // namespace

int run_import_suite(std::span<const std::string> args, const Report& report) {
  if (!args.empty()) fail(Code::invalid_argument, "import: unknown option ", args[0]);
  const Plume plume = report.quick ? Plume{40, 6} : Plume{};
  const int repeats = report.quick ? 1 : 5;
  std::vector<Row> rows;
  try {
    Written raw, packed;
    write_raw(plume, raw);
    rows.push_back(measure("raw", plume, raw, false, repeats));
    write_gzip(plume, packed);
    rows.push_back(measure("raw, gzip", plume, packed, false, repeats));
#if BCCSPLAT_WITH_OPENVDB
    Written vdb;
    write_vdb(plume, vdb);
    rows.push_back(measure("OpenVDB", plume, vdb, true, repeats));
#endif
  } catch (const bcc4::Error& e) {
    fail(Code::internal, e.what());
  }
  report.table("A series of plumes, f32, one file per frame: import beside reading", rows);
  return 0;
}

} // namespace bccsplat::bench

#else

namespace bccsplat::bench {

int run_import_suite(std::span<const std::string>, const Report&) {
  fail(Code::unsupported, "import: this build has no readers");
}

} // namespace bccsplat::bench

#endif

// SPDX-License-Identifier: Apache-2.0
// Times import, slices and pictures of puffs as points, frames, pixels or threads grow, the first picture of
// a large file with the page cache warm and empty, and projects the costs per unit to 1024^3 x 1000.
#include "tests/bench/scale/scale.h"

#include <chrono>
#include <filesystem>
#include <random>

#include "base/error.h"
#include "base/text.h"
#include "tests/bench/scale/scale_blocks.h"
#include "tests/bench/scale/scale_host.h"

namespace bccsplat::bench {
namespace {

namespace fs = std::filesystem;

double wall_seconds(const std::function<void()>& body) {
  const auto begin = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double mib(uint64_t bytes) { return static_cast<double>(bytes) / 0x1p20; }

// A folder for the files of the suite, removed at the end.
struct Scratch {
  fs::path folder = fs::temp_directory_path() / ("bccsplat-scale-" + std::to_string(std::random_device{}()));
  Scratch() { fs::create_directories(folder); }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] std::string file(const char* name) const { return (folder / name).string(); }
};

// Opening a file on a fresh device, to the first picture.
struct FirstPicture {
  double open_ms = 0, picture_ms = 0; // wall
  uint64_t open_bytes = 0, bytes = 0; // read
  uint64_t peak = 0;                  // bytes held at most
};

FirstPicture first_picture(const std::string& path, double frame, int threads) {
  FirstPicture first;
  const auto device = make_api_device(threads);
  Handle<bccsplat_volume> volume;
  first.open_ms = 1e3 * wall_seconds([&] { volume = open_puffs(device.get(), path); });
  first.open_bytes = info_of(volume.get()).bytes_read;
  first.picture_ms =
      1e3 * wall_seconds([&] { draw_puffs(device.get(), slice_puffs(volume.get(), frame).get(), 512); });
  first.bytes = info_of(volume.get()).bytes_read;
  first.peak = peak_of(device.get());
  return first;
}

// Costs per unit, for the projection.
struct UnitCosts {
  double import_ns = 0;             // CPU, per source sample
  double slice_ns = 0, draw_ns = 0; // CPU, per point of the slice
  double bytes = 0;                 // of the file, per source sample
  double points = 0;                // of a slice, per sample of a frame
};

UnitCosts by_points(const Report& report, const Scratch& scratch) {
  UnitCosts costs;
  std::vector<Row> rows;
  Series slice_line{.title = "slice", .points = {}, .line = true, .labels = {}},
      draw_line{.title = "frame, 512 x 512", .points = {}, .line = true, .labels = {}},
      import_line{.title = "import, 8 frames", .points = {}, .line = true, .labels = {}};
  for (const uint32_t n :
       report.quick ? std::vector<uint32_t>{32, 64} : std::vector<uint32_t>{64, 128, 256}) {
    const Puffs puffs{n, 8};
    const auto device = make_api_device(1);
    const std::string path = scratch.file("points.bcc4");
    bccsplat_writer_report written{};
    const double import = cpu_seconds([&] { written = write_puffs(device.get(), puffs, path); });
    const uint64_t peak = peak_of(device.get());
    const auto volume = open_puffs(device.get(), path);
    Handle<bccsplat_slice> slice;
    const double cut = median_cpu_seconds([&] { slice = slice_puffs(volume.get(), 3.4); }, 3);
    const auto points = static_cast<double>(info_of(slice.get()).points);
    const double draw = median_cpu_seconds([&] { draw_puffs(device.get(), slice.get(), 512); }, 3);
    costs = {1e9 * import / puffs.samples(), 1e9 * cut / points, 1e9 * draw / points,
             static_cast<double>(written.bytes_file) / puffs.samples(),
             points / (puffs.samples() / puffs.frames)};
    import_line.points.push_back({puffs.samples() / puffs.frames, 1e3 * import});
    slice_line.points.push_back({points, 1e3 * cut});
    draw_line.points.push_back({points, 1e3 * draw});
    rows.push_back({word("samples", concat(n, "^3 x ", puffs.frames)),
                    figure("sites kept", static_cast<double>(written.sites_kept), 0),
                    figure("import s", import, 3), figure("ns per sample", costs.import_ns, 2),
                    figure("peak MiB", mib(peak), 1), figure("file MiB", mib(written.bytes_file), 2),
                    figure("slice points", points, 0), figure("slice ms", 1e3 * cut, 2),
                    figure("ns per point", costs.slice_ns, 1), figure("frame ms", 1e3 * draw, 1),
                    figure("ns per point drawn", costs.draw_ns, 1)});
  }
  report.table("cost against points: one thread, CPU time", rows);
  report.plot("points", {.title = "Cost against size, one thread",
                         .x_label = "points (import: samples of a frame)",
                         .y_label = "CPU ms",
                         .log_x = true,
                         .log_y = true,
                         .series = {import_line, slice_line, draw_line}});
  return costs;
}

void by_frames(const Report& report, const Scratch& scratch) {
  std::vector<Row> rows;
  for (const uint32_t frames :
       report.quick ? std::vector<uint32_t>{16, 64} : std::vector<uint32_t>{50, 100, 200, 400}) {
    const Puffs puffs{report.quick ? 32u : 64u, frames};
    const auto device = make_api_device(1);
    const std::string path = scratch.file("frames.bcc4");
    bccsplat_writer_report written{};
    const double import = cpu_seconds([&] { written = write_puffs(device.get(), puffs, path); });
    const FirstPicture first = first_picture(path, 0.5 * frames, 1);
    rows.push_back({word("samples", concat(puffs.n, "^3 x ", frames)), figure("import s", import, 3),
                    figure("peak KiB", static_cast<double>(peak_of(device.get())) / 1024, 0),
                    figure("file MiB", mib(written.bytes_file), 2),
                    figure("index KiB", static_cast<double>(written.bytes_index) / 1024, 1),
                    figure("open ms", first.open_ms, 2),
                    figure("opened KiB", static_cast<double>(first.open_bytes) / 1024, 1),
                    figure("first picture ms", first.picture_ms, 1),
                    figure("read KiB", static_cast<double>(first.bytes) / 1024, 1)});
  }
  report.table("cost against frames: one thread; opening and the first picture (512 x 512) in wall time",
               rows);
}

void by_pixels(const Report& report, const Scratch& scratch) {
  const auto device = make_api_device(1);
  const std::string path = scratch.file("pixels.bcc4");
  (void)write_puffs(device.get(), {report.quick ? 48u : 128u, 4}, path);
  const auto volume = open_puffs(device.get(), path);
  const auto slice = slice_puffs(volume.get(), 1.4);
  std::vector<Row> rows;
  for (const uint32_t size :
       report.quick ? std::vector<uint32_t>{64, 256} : std::vector<uint32_t>{64, 128, 256, 512, 1024, 2048}) {
    bccsplat_render_stats stats{};
    const double draw = median_cpu_seconds([&] { stats = draw_puffs(device.get(), slice.get(), size); }, 3);
    rows.push_back({word("pixels", concat(size, " x ", size)), figure("frame ms", 1e3 * draw, 1),
                    figure("ns per pixel", 1e9 * draw / (1.0 * size * size), 0),
                    figure("points drawn", static_cast<double>(stats.points_after_cull), 0)});
  }
  report.table("cost against pixels: one thread, CPU time", rows);
}

void by_threads(const Report& report, const Scratch& scratch) {
  std::vector<Row> rows;
  std::array<double, 3> one{};
  for (const int threads : {1, 2, 4}) {
    const auto device = make_api_device(threads);
    const std::string path = scratch.file("threads.bcc4");
    const Puffs puffs{report.quick ? 48u : 128u, 8};
    std::array<double, 3> t{1e30, 1e30, 1e30};
    for (int i = 0; i < 3; ++i) {
      t[0] = std::min(t[0], wall_seconds([&] { (void)write_puffs(device.get(), puffs, path); }));
      const auto volume = open_puffs(device.get(), path);
      Handle<bccsplat_slice> slice;
      t[1] = std::min(t[1], wall_seconds([&] { slice = slice_puffs(volume.get(), 3.4); }));
      t[2] = std::min(t[2], wall_seconds([&] { draw_puffs(device.get(), slice.get(), 512); }));
    }
    if (threads == 1) one = t;
    rows.push_back({figure("threads", threads, 0), figure("import ms", 1e3 * t[0], 1),
                    figure("x", one[0] / t[0], 2), figure("cold slice ms", 1e3 * t[1], 1),
                    figure("x", one[1] / t[1], 2), figure("frame ms", 1e3 * t[2], 1),
                    figure("x", one[2] / t[2], 2)});
  }
  report.table("cost against threads: wall time, best of three; means little on a busy machine", rows);
}

void large(const Report& report, const std::string& folder) {
  const Puffs puffs{report.quick ? 32u : 256u, 256};
  const std::string path = (fs::path(folder) / "large.bcc4").string(),
                    samples = concat(puffs.n, "^3 x ", puffs.frames, " u8");
  bccsplat_writer_report written{};
  uint64_t peak = 0;
  const double cpu = cpu_seconds([&] {
    const auto device = make_api_device(0);
    written = write_puffs(device.get(), puffs, path);
    peak = peak_of(device.get());
  });
  report.table(
      "a long series, streamed frame by frame",
      {{word("samples", samples), figure("source GiB", static_cast<double>(written.bytes_source) / 0x1p30, 2),
        figure("sites kept M", static_cast<double>(written.sites_kept) / 1e6, 1),
        figure("import CPU s", cpu, 1), figure("peak MiB", mib(peak), 1),
        figure("file MiB", mib(written.bytes_file), 1)}});
  std::vector<Row> rows;
  for (const bool cold : {true, false})
    for (const double share : {0.0, 0.48, 0.999}) {
      const double frame = share * (puffs.frames - 1);
      if (cold) forget_pages(path);
      const FirstPicture first = first_picture(path, frame, 0);
      rows.push_back({word("page cache", cold ? "empty" : "warm"), figure("frame", frame, 2),
                      figure("open ms", first.open_ms, 2),
                      figure("opened KiB", static_cast<double>(first.open_bytes) / 1024, 1),
                      figure("first picture ms", first.picture_ms, 1),
                      figure("read MiB", mib(first.bytes), 2),
                      figure("of the file %", 100 * mib(first.bytes) / mib(written.bytes_file), 2),
                      figure("peak MiB", mib(first.peak), 1)});
    }
  report.table("its first picture (512 x 512) on a fresh device, all threads, wall time", rows);
  fs::remove(path);
}

void projection(const Report& report, const UnitCosts& c) {
  const double frame = 1024.0 * 1024 * 1024, series = frame * 1000;
  report.table(
      "1024^3 x 1000 u8, projected from the costs per unit of the largest series above",
      {{figure("source GiB", series / 0x1p30, 0), figure("import CPU h", series * c.import_ns / 3.6e12, 2),
        figure("file GiB", series * c.bytes / 0x1p30, 1),
        figure("points of a slice M", frame * c.points / 1e6, 0),
        figure("slice CPU s", frame * c.points * c.slice_ns / 1e9, 2),
        figure("frame CPU s", frame * c.points * c.draw_ns / 1e9, 2)}});
}

} // namespace

int run_scale_suite(std::span<const std::string> args, const Report& report) {
  std::string folder;
  if (args.size() == 3 && args[0] == "--blocks") {
    write_block_series(report, parse_block_series(args[1]), args[2]);
    return 0;
  }
  for (size_t i = 0; i < args.size(); ++i) {
    if (args[i] != "--large" || i + 1 == args.size())
      fail(Code::invalid_argument, "scale: unknown option ", args[i]);
    folder = args[++i];
  }
  const Scratch scratch;
  const UnitCosts costs = by_points(report, scratch);
  by_frames(report, scratch);
  by_pixels(report, scratch);
  by_threads(report, scratch);
  if (!folder.empty()) large(report, folder);
  projection(report, costs);
  return 0;
}

} // namespace bccsplat::bench

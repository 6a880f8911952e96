// SPDX-License-Identifier: Apache-2.0
// Fits each set on CC and on D4* and compares relevant points, bytes as runs and through zlib, and the time
// of pictures drawn in turn, with the paper's kernel and the default one.
#include "tests/bench/paper/paper.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "base/error.h"
#include "field/coefficients/coefficients.h"
#include "formats/bcc4/coding/deflate.h"
#include "points/runs.h"
#include "scene/picture.h"
#include "slice/time_slice.h"

namespace bccsplat::bench {
namespace {

constexpr uint64_t cache = 8ull << 30;
constexpr double threshold = 0.05; // of the largest sample: nearer to 0 is air

struct OneThread {
  Tasks tasks{1};
  MemoryBudget memory;
  Progress progress;
  [[nodiscard]] Context get() { return {tasks, memory, progress}; }
};

// A set on one lattice.
struct Sampled {
  FitReport report;
  std::vector<BrickLayer> layers;
  size_t value_bytes = 1;

  [[nodiscard]] const FitChannelReport& channel() const { return report.channels[0]; }
};

Sampled sample(const FitSource& source, LatticeKind kind, float largest) {
  FitOptions options;
  options.lattice = kind;
  options.channels[0].threshold = static_cast<float>(threshold) * largest;
  Sampled s;
  s.report = fit_source(source, options, 0, &s.layers);
  s.value_bytes = source_bytes(source.type);
  return s;
}

// Kept values and the runs of the kept sites, brick by brick.
uint64_t rle_bytes(const Sampled& s) {
  uint64_t bytes = 0;
  for (const BrickLayer& layer : s.layers)
    for (size_t slot = 0; slot < layer.brick_slots(); ++slot) {
      const Brick* brick = layer.brick(slot);
      if (!brick) continue;
      const Int3 at = layer.slot_position(slot);
      Int3 size;
      for (size_t a = 0; a < 3; ++a) size[a] = std::min(brick_edge, layer.dims()[a] - at[a] * brick_edge);
      ByteWriter runs;
      RunEncoder encoder(runs);
      for (int z = 0; z < size[2]; ++z)
        for (int y = 0; y < size[1]; ++y) encoder.row(brick->kept[z * brick_edge + y], size[0]);
      encoder.finish();
      bytes += runs.size() + brick->count() * s.value_bytes;
    }
  return bytes;
}

// All sites, air included, as the stored type in the order x, y, z, layer: what zlib makes of the lattice
// alone.
uint64_t zlib_bytes(const Sampled& s) {
  std::vector<std::byte> bytes;
  const auto put = [&](auto value) {
    const auto* p = reinterpret_cast<const std::byte*>(&value);
    bytes.insert(bytes.end(), p, p + sizeof value);
  };
  for (const BrickLayer& layer : s.layers)
    for (const float v : layer_to_dense(layer)) {
      if (s.value_bytes == 1)
        put(static_cast<uint8_t>(std::lround(v)));
      else if (s.value_bytes == 2)
        put(static_cast<uint16_t>(std::lround(v)));
      else
        put(v);
    }
  return deflate_bytes(bytes, 6, DeflateKind::text).size();
}

double percent(double part, double whole) { return whole > 0 ? 100 * part / whole : 0; }

struct Frames {
  double cc = 0, bcc = 0;               // ms
  double cc_points = 0, bcc_points = 0; // of the slices, in the mean
};

// Pictures of both lattices in turn, orthographic, one thread. Kept points: those that are not air.
Frames draw(const Sampled& cc, const Sampled& bcc, float largest, const char* kernel, bool quick) {
  OneThread context;
  const int size = quick ? 96 : 400;
  const auto prune = static_cast<float>(threshold) * largest / 2;
  struct Side {
    MemorySamples samples;
    Coefficients coefficients;
    Slice slice;
    std::optional<KeptPoints> points;
    Scene scene;
    Side(const Sampled& s, const char* name, float limit)
        : samples(s.report.lattice, {0.0f}, {s.layers}),
          coefficients(samples, 0, make_kernel(name), limit, cache) {}
  };
  const auto a = std::make_unique<Side>(cc, kernel, prune), b = std::make_unique<Side>(bcc, kernel, prune);
  const double last = cc.report.lattice.last_frame();
  Frames frames;
  const int instants = last > 0 && !quick ? 3 : 1;
  for (int i = 0; i < instants; ++i) {
    const double t = std::min(std::floor(last * (i + 0.5) / instants) + 0.37, last);
    for (Side* side : {a.get(), b.get()}) {
      side->slice = time_slice(side->coefficients, t, {0, 0}, {}, context.get());
      side->points.emplace(make_points(side->slice, context.get()));
      Scene& scene = side->scene;
      scene.slice = &side->slice, scene.points = &*side->points;
      scene.camera = fit_camera(a->slice, false, 20, 30, size, size);
      const double top = largest;
      scene.function.colors = {{0, {0.2, 0.4, 0.9}}, {top, {0.9, 0.5, 0.2}}};
      scene.function.opacities = {{2 * threshold * top, 0}, {top, 0.3}};
    }
    frames.cc_points += static_cast<double>(a->slice.points()) / instants;
    frames.bcc_points += static_cast<double>(b->slice.points()) / instants;
    ImageStorage image(size, size);
    const auto picture = [&](const Side& side) {
      return [&] { (void)render(side.scene, RenderOptions{}, context.get(), image.image); };
    };
    const auto [first, second] = paired_cpu_seconds(picture(*a), picture(*b), quick ? 1 : 3);
    frames.cc += 1e3 * first / instants, frames.bcc += 1e3 * second / instants;
  }
  return frames;
}

struct Tables {
  std::vector<Row> points, stored, drawn;
};

void add(Tables& tables, const FitSource& source, bool quick) {
  float largest = 0;
  for (uint32_t t = 0; t < source.dims[3]; ++t)
    for (const float v : source.frame(t)) largest = std::max(largest, std::fabs(v));
  const Sampled cc = sample(source, LatticeKind::cc, largest),
                bcc = sample(source, LatticeKind::d4star, largest);
  const auto count = [](uint64_t n) { return static_cast<double>(n); };
  const double dense = count(cc.channel().sites_total);
  const std::string size = concat(source.dims[0], "x", source.dims[1], "x", source.dims[2],
                                  source.dims[3] > 1 ? concat("x", source.dims[3]) : std::string());
  tables.points.push_back(
      {word("set", source.name), word("size", size), figure("CC samples", dense, 0),
       figure("CC relevant", count(cc.channel().cc_relevant), 0),
       figure("CC kept", count(cc.channel().sites_kept), 0),
       figure("BCC sites", count(bcc.channel().sites_total), 0),
       figure("BCC kept", count(bcc.channel().sites_kept), 0),
       figure("BCC / CC kept %", percent(count(bcc.channel().sites_kept), count(cc.channel().sites_kept)), 1),
       figure("BCC kept / CC relevant %",
              percent(count(bcc.channel().sites_kept), count(cc.channel().cc_relevant)), 1)});
  const double cc_rle = count(rle_bytes(cc)), bcc_rle = count(rle_bytes(bcc));
  const double cc_zlib = count(zlib_bytes(cc)), bcc_zlib = count(zlib_bytes(bcc));
  const double raw = dense * static_cast<double>(cc.value_bytes);
  tables.stored.push_back(
      {word("set", source.name), figure("raw CC KB", raw / 1e3, 0), figure("RLE CC KB", cc_rle / 1e3, 0),
       figure("RLE BCC KB", bcc_rle / 1e3, 0), figure("RLE BCC / raw CC %", percent(bcc_rle, raw), 1),
       figure("RLE BCC / RLE CC %", percent(bcc_rle, cc_rle), 1),
       figure("bytes per point CC", cc_rle / std::max(1.0, count(cc.channel().sites_kept)), 2),
       figure("BCC", bcc_rle / std::max(1.0, count(bcc.channel().sites_kept)), 2),
       figure("zlib CC KB", cc_zlib / 1e3, 0), figure("zlib BCC KB", bcc_zlib / 1e3, 0),
       figure("BCC / CC %", percent(bcc_zlib, cc_zlib), 1)});
  for (const char* kernel : {"paper", "default"}) {
    const Frames f = draw(cc, bcc, largest, kernel, quick);
    tables.drawn.push_back({word("set", source.name), word("kernel", kernel),
                            figure("points CC", f.cc_points, 0), figure("points BCC", f.bcc_points, 0),
                            figure("points %", percent(f.bcc_points, f.cc_points), 1),
                            figure("frame CC ms", f.cc, 1), figure("frame BCC ms", f.bcc, 1),
                            figure("frame %", percent(f.bcc, f.cc), 1)});
  }
}

void print(const Report& report, const std::string& which, const Tables& tables) {
  report.table("Points, " + which + " (air: within 5 % of the largest sample)", tables.points);
  report.table("Bytes, " + which + " (RLE: values and runs of the kept points; zlib: all sites)",
               tables.stored);
  report.table("Pictures, " + which + " (CPU time, one thread; points of the slice)", tables.drawn);
}

} // namespace

int run_paper_suite(std::span<const std::string> args, const Report& report) {
  std::string folder, only;
  for (size_t i = 0; i < args.size(); i += 2) {
    if (i + 1 == args.size() || (args[i] != "--data" && args[i] != "--set"))
      fail(Code::invalid_argument, "paper: the options are --data DIR and --set NAME");
    (args[i] == "--data" ? folder : only) = args[i + 1];
  }
  if (!folder.empty() && !std::filesystem::is_directory(folder))
    fail(Code::not_found, "paper: no folder ", folder);
  Tables volumes, series;
  std::string absent;
  for (const PaperSet& set : paper_sets()) {
    if (report.quick && set.name != std::string_view("fuel")) continue;
    if (!only.empty() && set.name != only) continue;
    const auto source = folder.empty() ? std::nullopt : load_paper_set(set, folder);
    if (source)
      add(set.series ? series : volumes, *source, report.quick);
    else
      absent += concat(absent.empty() ? "" : ", ", set.name);
  }
  if (only.empty() || only == "smoke") {
    const uint32_t n = report.quick ? 24 : 64, frames = report.quick ? 6 : 32;
    const FitSource smoke =
        source_of<uint8_t>(smoke_like({n, n, n, frames}), SourceType::u8, 255, "generated smoke");
    add(series, smoke, report.quick);
    FitSource still = smoke;
    still.dims[3] = 1, still.bytes.resize(still.frame_bytes());
    add(volumes, still, report.quick);
  }
  print(report, "3D", volumes);
  print(report, "4D", series);
  if (!absent.empty() && !report.json)
    report.out << "\nLeft out, for want of their files: " << absent << "\n";
  return 0;
}

} // namespace bccsplat::bench

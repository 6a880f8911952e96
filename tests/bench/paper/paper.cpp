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
#include "tests/bench/kernels/kernels_chain.h"

namespace bccsplat::bench {
namespace {

constexpr uint64_t cache = 8ull << 30;
constexpr double threshold = 0.05; // of the largest sample: nearer to 0 is air
constexpr size_t small_volume = 4 << 20;

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

// What one lattice's pictures take, in the mean over the instants.
struct Costs {
  // CPU time: of the slice, of its points as the splatter reads them, of frames, and of frames without what
  // bricks leave out.
  double slice_ms = 0, points_ms = 0, frame_ms = 0, unskipped_ms = 0;
  double points = 0, runs = 0, bricks = 0; // of the slice: its points, bytes of run lengths, bytes
};
struct Frames {
  Costs cc, bcc;
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
      Costs& costs = side == a.get() ? frames.cc : frames.bcc;
      (void)time_slice(side->coefficients, t, {0, 0}, {},
                       context.get()); // coefficients are there from here on
      const int repeats = quick ? 1 : 3;
      costs.slice_ms += 1e3 / instants *
                        median_cpu_seconds(
                            [&] {
                              side->slice = time_slice(side->coefficients, t, {0, 0}, {}, context.get());
                            },
                            repeats);
      costs.points_ms +=
          1e3 / instants *
          median_cpu_seconds([&] { side->points.emplace(make_points(side->slice, context.get())); }, repeats);
      costs.points += static_cast<double>(side->slice.points()) / instants;
      costs.runs += static_cast<double>(slice_runs(side->slice)) / instants;
      const SplatPoints& made = side->points->of(side->slice, context.get());
      costs.bricks += static_cast<double>(made.position.size() * sizeof made.position[0] +
                                          made.coefficient.size() * sizeof made.coefficient[0]) /
                      instants;
      Scene& scene = side->scene;
      scene.slice = &side->slice, scene.points = &*side->points;
      scene.camera = fit_camera(a->slice, false, 20, 30, size, size);
      const double top = largest;
      scene.function.colors = {{0, {0.2, 0.4, 0.9}}, {top, {0.9, 0.5, 0.2}}};
      scene.function.opacities = {{2 * threshold * top, 0}, {top, 0.3}};
    }
    ImageStorage image(size, size);
    RenderOptions whole;
    whole.disable_skips = skip_transfer_function | skip_cells | skip_occlusion;
    const auto picture = [&](const Side& side, const RenderOptions& o) {
      return [&] { (void)render(side.scene, o, context.get(), image.image); };
    };
    const RenderOptions usual;
    const int repeats = quick ? 1 : 3;
    const auto [first, second] = paired_cpu_seconds(picture(*a, usual), picture(*b, usual), repeats);
    frames.cc.frame_ms += 1e3 * first / instants, frames.bcc.frame_ms += 1e3 * second / instants;
    const auto [cc_all, bcc_all] = paired_cpu_seconds(picture(*a, whole), picture(*b, whole), repeats);
    frames.cc.unskipped_ms += 1e3 * cc_all / instants, frames.bcc.unskipped_ms += 1e3 * bcc_all / instants;
  }
  return frames;
}

struct Tables {
  std::vector<Row> points, stored, drawn, slices;
};

// Bytes per point of a slice as run lengths: its values as wide as the source's, and the runs.
double run_bytes(const Costs& c, size_t value_bytes) {
  return c.points > 0 ? static_cast<double>(value_bytes) + c.runs / c.points : 0;
}
double brick_bytes(const Costs& c) { return c.points > 0 ? c.bricks / c.points : 0; }

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
    const auto all = [](const Costs& c) { return c.slice_ms + c.points_ms + c.frame_ms; };
    const double cc_all = all(f.cc), bcc_all = all(f.bcc);
    tables.drawn.push_back(
        {word("set", source.name), word("kernel", kernel), figure("points CC", f.cc.points, 0),
         figure("points BCC", f.bcc.points, 0), figure("points %", percent(f.bcc.points, f.cc.points), 1),
         figure("slice CC ms", f.cc.slice_ms + f.cc.points_ms, 1),
         figure("BCC ms", f.bcc.slice_ms + f.bcc.points_ms, 1), figure("of it points", f.bcc.points_ms, 1),
         figure("frame CC ms", f.cc.frame_ms, 1), figure("frame BCC ms", f.bcc.frame_ms, 1),
         figure("frame %", percent(f.bcc.frame_ms, f.cc.frame_ms), 1),
         figure("slice and frame %", percent(bcc_all, cc_all), 1)});
    tables.slices.push_back(
        {word("set", source.name), word("kernel", kernel),
         figure("RLE CC KB", f.cc.points * run_bytes(f.cc, cc.value_bytes) / 1e3, 0),
         figure("RLE BCC KB", f.bcc.points * run_bytes(f.bcc, cc.value_bytes) / 1e3, 0),
         figure("RLE %",
                percent(f.bcc.points * run_bytes(f.bcc, cc.value_bytes),
                        f.cc.points * run_bytes(f.cc, cc.value_bytes)),
                1),
         figure("runs, bytes per point CC", f.cc.points > 0 ? f.cc.runs / f.cc.points : 0, 2),
         figure("BCC", f.bcc.points > 0 ? f.bcc.runs / f.bcc.points : 0, 2),
         figure("RLE, bytes per point BCC", run_bytes(f.bcc, cc.value_bytes), 2),
         figure("splatted bricks", brick_bytes(f.bcc), 2), figure("frame BCC ms", f.bcc.frame_ms, 1),
         figure("without what bricks leave out", f.bcc.unskipped_ms, 1)});
  }
}

void print(const Report& report, const std::string& which, const Tables& tables) {
  report.table("Points, " + which + " (air: within 5 % of the largest sample)", tables.points);
  report.table("Bytes, " + which + " (RLE: values and runs of the kept points; zlib: all sites)",
               tables.stored);
  report.table("Pictures, " + which +
                   " (CPU time, one thread; points of the slice, which is made of coefficients "
                   "that are there)",
               tables.drawn);
  report.table("Slices, " + which + " (RLE: a value of the source's type for each point, and runs)",
               tables.slices);
}

} // namespace

int run_paper_suite(std::span<const std::string> args, const Report& report) {
  std::string folder, only, part, lattice;
  for (size_t i = 0; i < args.size(); ++i) {
    const bool last = i + 1 == args.size();
    if (args[i] == "--slicing" && !last && (args[i + 1] == "cc" || args[i + 1] == "d4star"))
      part = args[i], lattice = args[++i];
    else if (args[i] == "--slicing" || args[i] == "--phantom" || args[i] == "--band" ||
             args[i] == "--shift" || args[i] == "--pipeline")
      part = args[i];
    else if (!last && (args[i] == "--data" || args[i] == "--set"))
      (args[i] == "--data" ? folder : only) = args[i + 1], ++i;
    else
      fail(Code::invalid_argument,
           "paper: the options are --data DIR, --set NAME, --slicing [d4star|cc], --phantom, "
           "--band, --shift and --pipeline, not ",
           args[i]);
  }
  if (!folder.empty() && !std::filesystem::is_directory(folder))
    fail(Code::not_found, "paper: no folder ", folder);
  const auto wanted = [&](const char* name) { return part == name || (part.empty() && only.empty()); };
  const bool sets = part.empty(), band = wanted("--band"), shift = wanted("--shift");
  Tables volumes, series;
  std::vector<FitSource> of_energy, of_shift;
  std::string absent;
  for (const PaperSet& set : paper_sets()) {
    if (report.quick && set.name != std::string_view("fuel")) continue;
    if (!only.empty() && set.name != only) continue;
    if (!sets && !(band && set.series) && !(shift && !set.series)) continue;
    const auto source = folder.empty() ? std::nullopt : load_paper_set(set, folder);
    if (source && band && set.series) of_energy.push_back(*source);
    if (source && shift && !set.series && source->frame_samples() <= small_volume)
      of_shift.push_back(*source);
    if (source && sets)
      add(set.series ? series : volumes, *source, report.quick);
    else if (!source)
      absent += concat(absent.empty() ? "" : ", ", set.name);
  }
  if (only.empty() || only == "smoke") {
    const uint32_t n = report.quick ? 24 : 64, frames = report.quick ? 6 : 32;
    const FitSource smoke =
        source_of<uint8_t>(smoke_like({n, n, n, frames}), SourceType::u8, 255, "generated smoke");
    if (sets) add(series, smoke, report.quick);
    if (band) of_energy.push_back(smoke);
    FitSource still = smoke;
    still.dims[3] = 1, still.bytes.resize(still.frame_bytes());
    if (sets) add(volumes, still, report.quick);
    if (shift) of_shift.push_back(still);
  }
  if (sets) print(report, "3D", volumes), print(report, "4D", series);
  if (wanted("--slicing")) report_slicing(report, lattice);
  if (wanted("--phantom")) report_phantom(report);
  if (band) report_band(report), report_energy(report, of_energy);
  if (shift) report_shift(report, of_shift);
  if (wanted("--pipeline")) run_paper_kernel(report);
  if (!absent.empty() && !report.json)
    report.out << "\nLeft out, for want of their files: " << absent << "\n";
  return 0;
}

} // namespace bccsplat::bench

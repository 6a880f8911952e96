// SPDX-License-Identifier: Apache-2.0
// Times slices of all kinds, merging against copying memory, and counts the bricks that a slice asks for as
// volumes grow; slice_paper.cpp has the paper's methods.
#include "tests/bench/slice/slice.h"

#include <cmath>
#include <cstring>

#include "base/error.h"
#include "field/evaluate.h"
#include "scene/picture.h"
#include "slice/time_slice.h"
#include "splat/points/points.h"
#include "tests/bench/slice/slice_parts.h"
#include "tests/bench/storage/storage_series.h"

namespace bccsplat::bench {
namespace {

using test::sample_field;
using test::TestContext;

// A source that counts the bricks that are asked of it.
class Counting final : public SampleSource {
 public:
  explicit Counting(const SampleSource& source) : source_(source) {}
  const Lattice4& lattice() const override { return source_.lattice(); }
  int channels() const override { return source_.channels(); }
  float air(int channel) const override { return source_.air(channel); }
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox& region,
                        const Context& context) const override {
    const BrickLayer whole = source_.read_layer(channel, layer, region, context);
    BrickLayer part(whole.lattice(), whole.coset());
    for (size_t s = 0; s < whole.brick_slots(); ++s)
      if (whole.brick(s) && region.contains(whole.slot_position(s))) {
        part.set(s, whole.share(s));
        points += whole.brick(s)->count(), ++bricks;
      }
    return part;
  }
  mutable int64_t points = 0, bricks = 0;

 private:
  const SampleSource& source_;
};

// Copies memory: n bytes of traffic, half read and half written.
class Copy {
 public:
  explicit Copy(uint64_t bytes) : from_(std::max<size_t>(bytes / 2, 64), 1), to_(from_.size(), 2) {}
  void operator()() {
    std::memcpy(to_.data(), from_.data(), from_.size());
    from_[from_.size() / 2] = to_[from_.size() / 3]; // so that no copy is left out
  }

 private:
  std::vector<char> from_, to_;
};

struct Case {
  std::string name;
  Hyperplane h;
  HypersliceOptions options;
};

std::vector<Case> cases(const std::array<uint32_t, 4>& dims) {
  std::vector<Case> all;
  for (const NamedPlane& p : planes_through_centre(dims)) all.push_back({p.name, p.h, {}});
  const auto add = [&](const std::string& name, size_t plane, auto change) {
    Case c{name, all[plane].h, {}};
    change(c.options);
    all.push_back(c);
  };
  const size_t last = all.size() - 1;
  add("x resampled", 1, [](auto& o) { o.method = SliceMethod::resampled; });
  add(all[last].name + ", CC target", last, [](auto& o) { o.target = LatticeKind::cc; });
  for (const size_t plane : {size_t{0}, size_t{1}, last}) {
    add(all[plane].name + ", slab 4, mean", plane, [](auto& o) { o.thickness = {4, ThicknessKind::mean}; });
    add(all[plane].name + ", slab 4, max", plane, [](auto& o) { o.thickness = {4, ThicknessKind::maximum}; });
  }
  return all;
}

// Time and error of every kind of slice of a series without air.
void report_kinds(const Report& report) {
  TestContext context(1);
  const uint32_t n = report.quick ? 24 : 40;
  const std::array<uint32_t, 4> dims{n, n, n, n};
  const test::PlaneWaves waves(12, 0.5, 3);
  std::vector<Row> rows;
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
    const auto lattice = Lattice4::fit(kind, dims);
    const MemorySamples samples = sample_field(lattice, waves);
    const Coefficients coefficients(samples, 0, make_kernel("default"), 0, large_cache);
    const auto points = test::random_points(lattice, 4000, 7, 8);
    std::vector<float> v(points.size());
    evaluate4(coefficients, points, v, {}, context.get());
    const double volume_snr = snr(v, points, waves);
    for (const Case& c : cases(dims)) {
      Slice slice;
      const auto make = [&] { slice = hyperslice(coefficients, c.h, c.options, {}, context.get()); };
      make();
      const double seconds = median_cpu_seconds(make, report.quick ? 1 : 3);
      const bool field = c.options.thickness.length == 0;
      const auto count = static_cast<double>(slice.points());
      rows.push_back(
          {word("volume", kind == LatticeKind::cc ? "CC" : "D4*"), word("slice", c.name),
           figure("points", count, 0), figure("ms", 1000 * seconds, 2),
           figure("Mpoints/s", count / seconds / 1e6, 2),
           word("SNR dB", field ? number(slice_snr(slice, dims, waves, 8, context.get()), 1) : "-"),
           figure("volume's SNR", volume_snr, 1)});
    }
  }
  report.table(concat("Slices of ", n,
                      "^4 plane waves at rho .5, kernel default, nothing cached but the layers of "
                      "time slices; one thread, CPU time"),
               rows);
}

// Time slices of coefficients that are there already, against copying the memory they touch.
void report_merge(const Report& report) {
  TestContext context(1);
  std::vector<Row> rows;
  for (const uint32_t n : report.quick ? std::vector<uint32_t>{32} : std::vector<uint32_t>{64, 128}) {
    const std::array<uint32_t, 4> dims{n, n, n, 12};
    const Balls balls{dims, n / 10.0};
    const auto lattice = Lattice4::fit(LatticeKind::d4star, dims);
    const MemorySamples samples = sample_field(lattice, balls);
    for (const char* name : {"fast", "default", "fine"}) {
      const Coefficients coefficients(samples, 0, make_kernel(name), 1e-4f, large_cache);
      for (const double width : {0.0, 3.0}) {
        const double frame = 5.3;
        const std::array<double, 2> interval{-width / 2, width / 2};
        Slice slice = time_slice(coefficients, frame, interval, {}, context.get());
        const auto weights =
            width > 0 ? mean_weights(lattice, coefficients.kernel(), frame - width / 2, frame + width / 2)
                      : instant_weights(lattice, coefficients.kernel(), frame);
        uint64_t bytes = slice.bytes();
        for (const LayerWeight& w : weights) bytes += coefficients.layer(w.layer, context.get())->bytes();
        Copy copying(bytes);
        const auto [seconds, copy] =
            paired_cpu_seconds([&] { slice = time_slice(coefficients, frame, interval, {}, context.get()); },
                               [&] { copying(); }, report.quick ? 3 : 15);
        rows.push_back({word("series", concat(n, "^3")), word("kernel", name),
                        figure("slab, frames", width, 0),
                        figure("layers", static_cast<double>(weights.size()), 0),
                        figure("points", static_cast<double>(slice.points()), 0),
                        figure("MB touched", static_cast<double>(bytes) / 1e6, 1),
                        figure("ms", 1000 * seconds, 3), figure("copy ms", 1000 * copy, 3),
                        figure("of the copy's bandwidth %", 100 * copy / seconds, 0)});
      }
    }
  }
  report.table("Time slices, coefficients cached, against a memory copy of the bytes they touch", rows);
}

// Slices of volumes that grow as n^4.
void report_cost(const Report& report) {
  TestContext context(1);
  std::vector<Row> rows;
  std::vector<Series> lines;
  const std::vector<uint32_t> sizes =
      report.quick ? std::vector<uint32_t>{24, 36} : std::vector<uint32_t>{24, 36, 52, 72};
  const struct {
    const char* name;
    double radius; // of the balls, as a part of n; 0: plane waves everywhere
  } fields[] = {{"full", 0}, {"sparse", 0.05}};
  for (const auto& field : fields) {
    std::array<Series, 3> series;
    for (const uint32_t n : sizes) {
      const std::array<uint32_t, 4> dims{n, n, n, n};
      const auto lattice = Lattice4::fit(LatticeKind::d4star, dims);
      const Balls balls{dims, field.radius * n};
      const test::PlaneWaves waves(2, 0.5, 3);
      const MemorySamples samples =
          field.radius > 0 ? sample_field(lattice, balls) : sample_field(lattice, waves);
      int64_t all = 0;
      for (int32_t m = 0; m < lattice.layers(); ++m)
        all += samples.read_layer(0, m, {}, context.get()).kept_sites();
      for (size_t plane = 1; plane < 4; ++plane) {
        const NamedPlane p = planes_through_centre(dims)[plane];
        const Counting source(samples);
        const Coefficients coefficients(source, 0, make_kernel("default"), 1e-4f, large_cache);
        Slice slice;
        const double seconds =
            cpu_seconds([&] { slice = hyperslice(coefficients, p.h, {}, {}, context.get()); });
        const auto touched = static_cast<double>(source.points);
        Series& line = series[plane - 1];
        line.title = concat(field.name, ", ", p.name);
        line.points.push_back({static_cast<double>(std::max<int64_t>(source.bricks, 1)), 1000 * seconds});
        rows.push_back(
            {word("field", field.name), word("slice", p.name), word("volume", concat(n, "^4")),
             figure("points of the volume", static_cast<double>(all), 0),
             figure("in bricks touched", touched, 0),
             figure("touched %", 100 * touched / static_cast<double>(std::max<int64_t>(all, 1)), 1),
             figure("bricks", static_cast<double>(source.bricks), 0), figure("ms", 1000 * seconds, 1),
             figure("us per brick", 1e6 * seconds / static_cast<double>(std::max<int64_t>(source.bricks, 1)),
                    1),
             figure("slice's points", static_cast<double>(slice.points()), 0)});
      }
    }
    for (Series& line : series) lines.push_back(std::move(line));
  }
  report.table("Cost against points touched; kernel default", rows);
  report.plot("cost", {"Axis and oblique slices: time against the bricks (16^3 sites) that they touch",
                       "bricks that hold points and are touched", "CPU ms", true, true, std::move(lines)});
}

// Slices of a volume that grows where they are not.
void report_growth(const Report& report) {
  TestContext context(1);
  std::vector<Row> rows;
  std::vector<Series> lines(2);
  lines[0].title = "x = const", lines[1].title = "oblique";
  for (const uint32_t n :
       report.quick ? std::vector<uint32_t>{48, 96} : std::vector<uint32_t>{48, 96, 192, 384}) {
    const std::array<uint32_t, 4> dims{n, 24, 24, 24};
    const auto lattice = Lattice4::fit(LatticeKind::d4star, dims);
    const MemorySamples samples = sample_field(lattice, test::PlaneWaves(2, 0.5, 3));
    const std::array<Hyperplane, 2> planes{Hyperplane{1, 0, 0, 0, -24.2}, Hyperplane{1, 0.3, 0.2, 0.4, -32}};
    for (size_t i = 0; i < planes.size(); ++i) {
      const Counting source(samples);
      const Coefficients coefficients(source, 0, make_kernel("default"), 0, large_cache);
      Slice slice;
      const double seconds = median_cpu_seconds(
          [&] {
            source.points = source.bricks = 0;
            slice = hyperslice(coefficients, planes[i], {}, {}, context.get());
          },
          3);
      const auto all = static_cast<double>(lattice.sites());
      lines[i].points.push_back({all, 1000 * seconds});
      rows.push_back({word("slice", lines[i].title), word("volume", concat(n, " x 24^3")),
                      figure("points of the volume", all, 0),
                      figure("in bricks touched", static_cast<double>(source.points), 0),
                      figure("ms", 1000 * seconds, 2)});
    }
  }
  report.table("Cost against the size of the volume, the points touched being the same", rows);
  report.plot("growth", {"Slices of a volume that grows where they are not", "points of the volume", "CPU ms",
                         true, true, std::move(lines)});
}

// What slices read of a file.
void report_reading(const Report& report) {
  TestContext context(1);
  const uint32_t n = report.quick ? 32 : 64;
  const FitSeries series = smoke_like({n, n, n, report.quick ? 16u : 40u});
  Quantiser quantiser;
  quantiser.air = 0;
  const StoredSeries stored = store(series, {.quantiser = quantiser, .level = 1});
  std::vector<Row> rows;
  for (const NamedPlane& p : planes_through_centre(series.dims)) {
    const auto reader = Bcc4Reader::open(open_memory_source(stored.file));
    const Bcc4Samples samples(reader, context.memory);
    const Counting source(samples);
    const Coefficients coefficients(source, 0, make_kernel("default"), 0, large_cache);
    const uint64_t before = reader->bytes_read();
    Slice slice;
    const double seconds = cpu_seconds([&] { slice = hyperslice(coefficients, p.h, {}, {}, context.get()); });
    const auto bytes = static_cast<double>(reader->bytes_read() - before);
    rows.push_back({word("slice", p.name), figure("points", static_cast<double>(slice.points()), 0),
                    figure("bricks read", static_cast<double>(source.bricks), 0),
                    figure("KB read", bytes / 1e3, 0),
                    figure("of the file %", 100 * bytes / static_cast<double>(stored.file.size()), 1),
                    figure("ms, decoding included", 1000 * seconds, 1)});
  }
  report.table(concat("First slice from a file of smoke, ", n, "^3 x ", series.dims[3]), rows);
}

// What the list of a time slice costs beside the picture made of it.
void report_list(const Report& report) {
  TestContext context(1);
  const uint32_t n = report.quick ? 32 : 96;
  const std::array<uint32_t, 4> dims{n, n, n, 12};
  const Balls balls{dims, n / 8.0};
  const MemorySamples samples = sample_field(Lattice4::fit(LatticeKind::d4star, dims), balls);
  const Coefficients coefficients(samples, 0, make_kernel("default"), 1e-4f, large_cache);
  Slice slice = time_slice(coefficients, 5.3, {0, 0}, {}, context.get());
  SplatPoints points;
  const int repeats = report.quick ? 1 : 7;
  const double merge = median_cpu_seconds(
      [&] {
        slice = time_slice(coefficients, 5.3, {0, 0}, {}, context.get());
      },
      repeats);
  const double make = median_cpu_seconds([&] { points = make_points(slice, context.get()); }, repeats);
  std::vector<Row> rows;
  for (const int pixels : {256, 512}) {
    Scene scene;
    const KeptPoints kept(make_points(slice, context.get()));
    scene.slice = &slice, scene.points = &kept;
    scene.function.colors = {{0.1, {0.2, 0.3, 0.9}}, {0.9, {0.9, 0.4, 0.1}}};
    scene.function.opacities = {{0.1, 0}, {0.9, 0.3}};
    scene.camera = fit_camera(slice, false, 20, 30, pixels, pixels);
    const double draw = median_cpu_seconds(
        [&] {
          ImageStorage image(pixels, pixels);
          (void)render(scene, {}, context.get(), image.image);
        },
        report.quick ? 1 : 3);
    rows.push_back({figure("pixels", pixels, 0), figure("points", static_cast<double>(slice.points()), 0),
                    figure("slice ms", 1000 * merge, 2), figure("points for the splatter ms", 1000 * make, 2),
                    figure("picture ms", 1000 * draw, 1),
                    figure("slice, % of all", 100 * merge / (merge + make + draw), 1)});
  }
  report.table("A new time slice and its picture", rows);
}

} // namespace

int run_slice_suite(std::span<const std::string> args, const Report& report) {
  if (args.size() == 2 && args[0] == "--volumes") {
    const size_t comma = args[1].find(',');
    if (comma == std::string::npos) fail(Code::invalid_argument, "--volumes takes D4.bcc4,CC.bcc4");
    report_relevant_points(report, args[1].substr(0, comma), args[1].substr(comma + 1));
    return 0;
  }
  if (!args.empty()) fail(Code::invalid_argument, "slice: no option ", args[0]);
  report_merge(report);
  report_kinds(report);
  report_cost(report);
  report_growth(report);
  report_reading(report);
  report_list(report);
  report_paper_methods(report);
  report_relevant_points(report);
  return 0;
}

} // namespace bccsplat::bench

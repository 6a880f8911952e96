#include "tests/bench/storage/storage_moments.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "field/coefficients/coefficients.h"
#include "formats/bcc4/bcc4.h"
#include "slice/time_slice.h"
#include "store/volume_writer.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::TestContext;

constexpr uint32_t frames = 16;
constexpr uint64_t cache_bytes = uint64_t{1} << 30; // a volume's default

// A u8 frame: a sum of moving plane waves of 8 to 60 voxels; where `sparse`, only in a ball that moves and
// fills an eighth of the box.
std::vector<uint8_t> frame(uint32_t edge, uint32_t t, bool sparse) {
  struct Wave {
    double x, y, z, t, phase;
  };
  static const std::vector<Wave> waves = [] {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Wave> made;
    for (int i = 0; i < 12; ++i) {
      Wave w{unit(random), unit(random), unit(random), unit(random), 3 * unit(random)};
      const double length = std::sqrt(w.x * w.x + w.y * w.y + w.z * w.z + w.t * w.t);
      const double scale = 2 * std::numbers::pi / (8 + 52 * std::fabs(unit(random))) / length;
      w.x *= scale, w.y *= scale, w.z *= scale, w.t *= scale;
      made.push_back(w);
    }
    return made;
  }();
  const size_t n = edge;
  std::vector<float> sum(n * n * n);
  // Each wave is a product of turns along the axes: two multiplications a voxel.
  for (const Wave& w : waves)
    for (size_t z = 0; z < n; ++z)
      for (size_t y = 0; y < n; ++y) {
        const double start = w.y * static_cast<double>(y) + w.z * static_cast<double>(z) + w.t * t + w.phase;
        double re = std::cos(start), im = std::sin(start);
        const double c = std::cos(w.x), s = std::sin(w.x);
        float* row = sum.data() + (z * n + y) * n;
        for (size_t x = 0; x < n; ++x) {
          row[x] += static_cast<float>(re);
          const double next = re * c - im * s;
          im = re * s + im * c, re = next;
        }
      }
  std::vector<uint8_t> values(sum.size());
  const double radius = 0.31 * edge, middle = 0.5 * edge + 0.2 * t;
  for (size_t i = 0; i < values.size(); ++i) {
    const double dx = static_cast<double>(i % n) - middle, dy = static_cast<double>(i / n % n) - 0.5 * edge,
                 dz = static_cast<double>(i / n / n) - 0.5 * edge;
    const bool empty = sparse && dx * dx + dy * dy + dz * dz > radius * radius;
    values[i] = empty ? 0 : static_cast<uint8_t>(std::clamp(128.5f + 14 * sum[i], 1.0f, 255.0f));
  }
  return values;
}

struct Written {
  std::vector<std::byte> file;
  double seconds = 0;
};

Written write(uint32_t edge, bool sparse, bool coefficients, const Context& context) {
  Written out;
  WriterSettings settings;
  settings.dims = {edge, edge, edge, frames};
  settings.coefficients = coefficients;
  VolumeWriter writer(settings, create_memory_sink(out.file), context);
  for (uint32_t t = 0; t < frames; ++t) {
    const std::vector<uint8_t> values = frame(edge, t, sparse);
    FrameBox box;
    box.type = SourceType::u8;
    box.dims = {edge, edge, edge};
    box.data = values.data();
    out.seconds += cpu_seconds([&] { writer.add_frame(0, t, {&box, 1}); });
  }
  out.seconds += cpu_seconds([&] { (void)writer.finish(); });
  return out;
}

struct Moments {
  double seconds = 0, bytes = 0, layers = 0, mebibytes = 0;
};

// The mean of `count` moments, each from a volume that has been opened but not looked at.
Moments random_moments(const std::vector<std::byte>& file, int count) {
  Moments mean;
  std::mt19937 random(9);
  for (int i = 0; i < count; ++i) {
    TestContext context(1);
    const auto reader = Bcc4Reader::open(open_memory_source(file));
    const Bcc4Samples samples(reader, context.memory, cache_bytes / 4);
    const Coefficients field(samples, 0, make_kernel("default"), 0, cache_bytes - cache_bytes / 4);
    const uint64_t opened = reader->bytes_read();
    const double at = std::uniform_real_distribution<double>(3, frames - 4.0)(random);
    mean.seconds += cpu_seconds([&] { (void)time_slice(field, at, {0, 0}, {}, context.get()); }) / count;
    mean.bytes += static_cast<double>(reader->bytes_read() - opened) / count;
    const VolumeInfo& info = reader->info();
    uint64_t slabs = 0, per_slab = 0;
    for (int32_t s = 0; s < info.slabs(); ++s) {
      const auto chunks = reader->chunks(0, s).size();
      per_slab = std::max<uint64_t>(per_slab, chunks);
      slabs += chunks > 0;
    }
    // Chunks decode as a whole today.
    mean.layers += static_cast<double>(samples.chunks_decoded()) / static_cast<double>(per_slab) *
                   info.slab_layers / count;
    mean.mebibytes += static_cast<double>(context.memory.peak()) / (1 << 20) / count;
  }
  return mean;
}

struct Playback {
  double first = 0, seconds = 0; // the first moment, the mean of the others
  double decoded = 0, layers = 0;
  double mebibytes = 0;
};

// Half a frame on at a time, from a volume that stays open.
Playback play(const std::vector<std::byte>& file, int moments) {
  Playback out;
  TestContext context(1);
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  const Bcc4Samples samples(reader, context.memory, cache_bytes / 4);
  const Coefficients field(samples, 0, make_kernel("default"), 0, cache_bytes - cache_bytes / 4);
  for (int i = 0; i < moments; ++i) {
    const double at = 3 + 0.5 * i;
    const double s = cpu_seconds([&] { (void)time_slice(field, at, {0, 0}, {}, context.get()); });
    (i == 0 ? out.first : out.seconds) += i == 0 ? s : s / (moments - 1);
  }
  const VolumeInfo& info = reader->info();
  uint64_t per_slab = 0;
  for (int32_t s = 0; s < info.slabs(); ++s)
    per_slab = std::max<uint64_t>(per_slab, reader->chunks(0, s).size());
  out.decoded =
      static_cast<double>(samples.chunks_decoded()) / static_cast<double>(per_slab) * info.slab_layers;
  out.layers = info.slabs() * info.slab_layers;
  out.mebibytes = static_cast<double>(context.memory.peak()) / (1 << 20);
  return out;
}

// What somebody does who keeps all frames in memory: two of them, blended.
double raw_moment(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  std::vector<float> out(a.size());
  return median_cpu_seconds([&] {
    for (size_t i = 0; i < a.size(); ++i)
      out[i] = static_cast<float>(a[i]) + 0.37f * static_cast<float>(static_cast<int>(b[i]) - a[i]);
  });
}

} // namespace

void moment_tables(uint32_t edge, const Report& report) {
  std::vector<Row> rows, playing;
  const int count = report.quick ? 2 : 6;
  for (const bool sparse : {false, true}) {
    const double raw = raw_moment(frame(edge, 3, sparse), frame(edge, 4, sparse));
    for (const bool coefficients : {false, true}) {
      TestContext context;
      const Written w = write(edge, sparse, coefficients, context.get());
      const Moments m = random_moments(w.file, count);
      const double voxels = std::pow(edge, 3);
      const Field series =
          word("series", std::to_string(edge) + "^3 x 16 u8, " + (sparse ? "an eighth filled" : "dense"));
      const Field stores = word("stores", coefficients ? "coefficients" : "samples");
      const Playback p = play(w.file, report.quick ? 5 : 19);
      playing.push_back({series, stores, figure("first, CPU s", p.first, 3),
                         figure("each of the others, CPU s", p.seconds, 3),
                         figure("layers decoded in all", p.decoded, 1),
                         figure("layers of slabs", p.layers, 0), figure("MiB held", p.mebibytes, 0)});
      rows.push_back({series, stores, figure("MB", static_cast<double>(w.file.size()) / 1e6, 2),
                      figure("import, ns a voxel", w.seconds * 1e9 / voxels / frames, 1),
                      figure("layers decoded", m.layers, 1), figure("MB read", m.bytes / 1e6, 2),
                      figure("CPU s", m.seconds, 3), figure("MiB held", m.mebibytes, 0),
                      figure("raw frames in memory, blended: CPU s", raw, 4)});
    }
  }
  report.table("a random moment, one thread, cache of 1 GiB", rows);
  report.table("half a frame on at a time, one thread, cache of 1 GiB", playing);
}

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// Makes the tables of sizes, of levels of deflate, of parts of a file and of rate against distortion on D4*
// and CC.
#include "tests/bench/storage/storage.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include <zlib.h>

#include "base/error.h"
#include "field/coefficients/coefficients.h"
#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/read/samples.h"
#include "kernel/kernel.h"
#include "tests/bench/storage/storage_series.h"

namespace bccsplat::bench {
namespace {

constexpr LatticeKind d4star = LatticeKind::d4star, cc = LatticeKind::cc;

const char* name_of(LatticeKind kind) { return kind == d4star ? "D4*" : "CC"; }

double bits_per_cc_sample(const StoredSeries& s, const FitSeries& series) {
  return 8 * static_cast<double>(s.file.size()) / static_cast<double>(series.values.size());
}

// Integers of step `step`, air 0 in the middle of the codes or, for values that are never negative, at code
// 0.
Quantiser quantiser_of_step(double step, double largest, bool is_signed) {
  Quantiser q;
  const double codes = largest / step * (is_signed ? 2 : 1) + 4;
  q.type = codes < 256 ? ValueType::u8 : ValueType::u16;
  q.scale = step;
  q.offset = is_signed ? -step * std::ceil(codes / 2) : 0;
  return q;
}

// The file whose field has `decibels` against the source, or whose sites have where the kernel itself does
// not carry that far.
StoredSeries store_at(const FitSeries& series, StoreOptions o, double decibels, bool is_signed,
                      double largest, double peak, bool by_sites) {
  double step = peak * std::sqrt(12.0) * std::pow(10, -decibels / 20);
  StoredSeries s;
  for (int i = 0; i < 4; ++i) {
    o.quantiser = quantiser_of_step(step, largest, is_signed);
    s = store(series, o);
    const double got = by_sites ? s.site_psnr : s.field_psnr;
    if (std::fabs(got - decibels) < 0.05) break;
    step *= std::pow(10, (got - decibels) / 20);
  }
  return s;
}

Row rate_row(const std::string& name, const FitSeries& series, const StoredSeries& s, LatticeKind kind,
             const char* kernel, double decibels, bool by_sites) {
  return {word("series", name),
          word("lattice", name_of(kind)),
          word("kernel", kernel),
          word("asked at", concat(decibels, " dB of the ", by_sites ? "sites" : "CC samples")),
          figure("bits / CC sample", bits_per_cc_sample(s, series), 3),
          figure("bits / site",
                 8 * static_cast<double>(s.file.size()) / static_cast<double>(s.report.sites_kept), 3),
          figure("field PSNR dB", s.field_psnr, 2),
          figure("site PSNR dB", s.site_psnr, 2)};
}

void rate_tables(const Report& report) {
  const uint32_t n = report.quick ? 16 : 64;
  const FitSeries field = gaussian_field(n, 0.25, 0.9, 11);
  const auto [low, high] = std::minmax_element(field.values.begin(), field.values.end());
  const double peak = static_cast<double>(*high) - *low;
  std::vector<Row> rows;
  Plot plot{.title = "Rate against distortion, band-limited field",
            .x_label = "bits per CC sample",
            .y_label = "PSNR, dB: CC samples; sites where the kernel itself errs more",
            .series = {}};
  for (const LatticeKind kind : {d4star, cc}) {
    // The kernel that carries furthest for the lattice; its own error is the PSNR without quantisation.
    const char* kernel = kind == cc ? "radial20+b3" : "fine";
    StoreOptions o{.lattice = kind, .quantiser = {}, .kernel = kernel, .border = n / 8};
    const StoredSeries unquantised = store(field, o);
    rows.push_back(rate_row("band-limited f32", field, unquantised, kind, kernel, 999, true));
    Series line{.title = name_of(kind), .points = {}, .labels = {}};
    for (const double decibels :
         report.quick ? std::vector<double>{45} : std::vector<double>{35, 45, 60, 80}) {
      const bool by_sites = unquantised.field_psnr < decibels + 1;
      const StoredSeries s = store_at(field, o, decibels, true, 1.0, peak, by_sites);
      rows.push_back(rate_row("band-limited", field, s, kind, kernel, decibels, by_sites));
      line.points.push_back({bits_per_cc_sample(s, field), by_sites ? s.site_psnr : s.field_psnr});
    }
    plot.series.push_back(std::move(line));
  }
  report.table("rate: band-limited field, Gaussian spectrum", rows);
  report.plot("rate-distortion", plot);

  rows.clear();
  FitSeries smoke = smoke_like(report.quick ? std::array<uint32_t, 4>{48, 48, 48, 12}
                                            : std::array<uint32_t, 4>{128, 128, 128, 48});
  const float largest = *std::max_element(smoke.values.begin(), smoke.values.end());
  for (float& v : smoke.values) v = std::round(v / largest * 255); // as u8
  for (const LatticeKind kind : {d4star, cc})
    for (const double decibels : {45.0}) {
      StoreOptions o{.lattice = kind, .quantiser = {}, .kernel = kind == cc ? "radial20+b3" : "fine"};
      rows.push_back(rate_row("smoke-like u8", smoke, store_at(smoke, o, decibels, false, 255, 255, false),
                              kind, o.kernel.c_str(), decibels, false));
    }
  report.table("rate: smoke-like series", rows);
}

// Raw samples of the relevant extent through zlib, as many tools keep them.
std::vector<std::byte> zlib_of(std::span<const std::byte> bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<std::byte> out(size);
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                static_cast<uLong>(bytes.size()), 6) != Z_OK)
    fail(Code::internal, "zlib: no room");
  out.resize(size);
  return out;
}

// Decodes a whole file by time steps, one thread.
void read_all(const Bcc4Reader& reader, const Context& context) {
  for (int32_t slab = 0; slab < reader.info().slabs(); ++slab) {
    const auto data = reader.read_chunks(0, reader.chunks(0, slab), context);
    for (const auto& d : data)
      for (int m = 0; m < d->shape.layers; ++m) (void)reader.brick(0, *d, m);
  }
}

struct Case {
  std::string name;
  FitSeries series;
  Quantiser quantiser;
};

std::vector<Case> cases(const Report& report) {
  const bool quick = report.quick;
  std::vector<Case> all;
  const FitSeries smoke =
      smoke_like(quick ? std::array<uint32_t, 4>{64, 64, 64, 8} : std::array<uint32_t, 4>{128, 128, 128, 24});
  const FitSeries field = gaussian_field(quick ? 16 : 64, 0.25, 0.9, 11);
  all.push_back({"smoke-like u8", smoke, quantiser_of_step(1.3 / 250, 1.3, false)});
  all.push_back({"smoke-like u16", smoke, quantiser_of_step(1.3 / 40000, 1.3, false)});
  all.push_back({"smoke-like f32", smoke, {}});
  all.push_back({"dense u8", field, quantiser_of_step(2.0 / 240, 1, true)});
  all.push_back({"dense u16", field, quantiser_of_step(2.0 / 40000, 1, true)});
  all.push_back({"dense f32", field, {}});
  return all;
}

Row size_row(const Case& c) {
  const StoredSeries s = store(c.series, {.quantiser = c.quantiser, .level = 6});
  // The CC samples in the same precision.
  std::vector<std::byte> raw;
  for (const float v : c.series.values) {
    uint32_t bits = 0;
    if (c.quantiser.type == ValueType::f32)
      std::memcpy(&bits, &v, sizeof v);
    else
      bits = static_cast<uint32_t>(std::lround((v - c.quantiser.offset) / c.quantiser.scale));
    const auto bytes = std::as_bytes(std::span(&bits, 1)).first(value_bytes(c.quantiser.type));
    raw.insert(raw.end(), bytes.begin(), bytes.end());
  }
  const std::vector<std::byte> zipped = zlib_of(raw);
  Tasks tasks(1);
  MemoryBudget memory;
  Progress progress;
  const Context context{tasks, memory, progress};
  const auto reader = Bcc4Reader::open(open_memory_source(s.file));
  std::vector<std::byte> room(raw.size());
  const auto [decode, inflate] = paired_cpu_seconds(
      [&] { read_all(*reader, context); },
      [&] {
        uLongf size = static_cast<uLongf>(room.size());
        (void)uncompress(reinterpret_cast<Bytef*>(room.data()), &size,
                         reinterpret_cast<const Bytef*>(zipped.data()), static_cast<uLong>(zipped.size()));
      });
  const auto points = static_cast<double>(s.report.sites_kept);
  const double bytes = points * value_bytes(c.quantiser.type);
  return {
      word("series", c.name),
      figure("raw MB", static_cast<double>(raw.size()) / 1e6, 2),
      figure("raw+zlib MB", static_cast<double>(zipped.size()) / 1e6, 3),
      figure("bcc4 MB", static_cast<double>(s.file.size()) / 1e6, 3),
      figure("bcc4 / raw+zlib", static_cast<double>(s.file.size()) / static_cast<double>(zipped.size()), 3),
      figure("value bytes/point", static_cast<double>(s.report.bytes.values) / points, 3),
      figure("runs+index bytes/point",
             static_cast<double>(s.report.bytes.runs + s.report.bytes.index - preamble_bytes) / points, 4),
      figure("decode MB/s of samples", bytes / decode / 1e6, 0),
      figure("as f32 MB/s", points * 4 / decode / 1e6, 0),
      figure("unzip MB/s of raw", static_cast<double>(raw.size()) / inflate / 1e6, 0),
      figure("read time, bcc4 / raw+zlib", decode / inflate, 2)};
}

// Size, coding and decoding at every level of deflate the writer tells apart.
void level_rows(const Case& c, std::vector<Row>& rows) {
  Tasks tasks(1);
  MemoryBudget memory;
  Progress progress;
  const Context context{tasks, memory, progress};
  double usual = 0;
  for (const int level : {6, 0, 1, 3, 4, 5, 7, 8, 9}) {
    const StoredSeries s = store(c.series, {.quantiser = c.quantiser, .level = level});
    const auto size = static_cast<double>(s.file.size()), points = static_cast<double>(s.report.sites_kept);
    if (level == 6) usual = size;
    const auto reader = Bcc4Reader::open(open_memory_source(s.file));
    const double decode = median_cpu_seconds([&] { read_all(*reader, context); }, 3);
    rows.push_back({word("series", c.name), figure("level", level, 0),
                    figure("size, of level 6", size / usual, 3),
                    figure("coding ns/point", s.write_seconds / points * 1e9, 1),
                    figure("decoding ns/point", decode / points * 1e9, 1)});
  }
}

struct Cost {
  uint64_t opening = 0, bytes = 0, sites = 0;
};

// Kept sites of each column of bricks along x, by the index.
std::vector<uint64_t> column_points(const Bcc4Reader& reader, int32_t columns) {
  std::vector<uint64_t> points(static_cast<size_t>(columns));
  for (int32_t slab = 0; slab < reader.info().slabs(); ++slab)
    for (const Bcc4Chunk& c : reader.chunks(0, slab)) points[reader.brick_position(c.slot)[0]] += c.kept;
  return points;
}

// Bytes and time that parts of a file need, against all of it and against the stored bytes of the sites asked
// for.
void access_rows(const char* name, const FitSeries& series, const Quantiser& quantiser,
                 std::vector<Row>& rows) {
  const StoredSeries s = store(series, {.quantiser = quantiser, .level = 6});
  const Kernel kernel = make_kernel("default");
  Tasks tasks(1);
  Progress progress;
  // One part, or several like it, each read from a file just opened: means over them.
  const auto read_parts = [&](int32_t first_layer, int32_t last_layer, std::span<const BrickBox> regions) {
    Cost cost;
    for (const BrickBox& region : regions) {
      MemoryBudget memory;
      const Context context{tasks, memory, progress};
      const auto reader = Bcc4Reader::open(open_memory_source(s.file));
      const uint64_t opened = reader->bytes_read();
      const Bcc4Samples samples(reader, memory);
      for (int32_t m = first_layer; m <= last_layer; ++m) {
        const BrickLayer layer = samples.read_layer(0, m, region, context);
        cost.sites += layer.kept_sites();
      }
      cost.opening += opened;
      cost.bytes += reader->bytes_read() - opened;
    }
    return cost;
  };
  const Lattice4& lattice = s.fit.lattice;
  const int32_t middle = lattice.layers() / 2, last = lattice.layers() - 1;
  const BrickBox all{};
  const auto measure = [&](const char* what, int32_t first_layer, int32_t last_layer,
                           std::span<const BrickBox> regions) {
    const auto n = static_cast<double>(regions.size());
    Cost cost;
    const auto [part, whole] =
        paired_cpu_seconds([&] { cost = read_parts(first_layer, last_layer, regions); },
                           [&] { (void)read_parts(0, last, std::span(&all, 1)); });
    const double share = static_cast<double>(cost.sites) / n / static_cast<double>(s.report.sites_kept);
    const double data = static_cast<double>(s.report.bytes.values + s.report.bytes.runs);
    const double read = static_cast<double>(cost.bytes) / n;
    rows.push_back({word("series", name), word("part", what),
                    figure("layers", last_layer - first_layer + 1, 0),
                    figure("opening reads KB", static_cast<double>(cost.opening) / n / 1e3, 1),
                    figure("reads KB", read / 1e3, 1),
                    figure("of the file", read / static_cast<double>(s.file.size()), 3),
                    figure("of the points", share, 3),
                    figure("bytes read / bytes of the sites wanted", read / (share * data), 2),
                    figure("CPU, of a full decode", part / n / whole, 3)});
  };
  const int32_t reach = kernel.reach_layers();
  const auto column = [](int32_t x) { return BrickBox{{x, 0, 0}, {x + 1, INT32_MAX, INT32_MAX}}; };
  const int32_t columns = BrickLayer(lattice.space, 0).brick_dims()[0];
  std::vector<BrickBox> each;
  for (int32_t x = 0; x < columns; ++x) each.push_back(column(x));
  measure("time step, kernel's reach", std::max(0, middle - reach), std::min(last, middle + reach),
          std::span(&all, 1));
  measure(concat("x-slice, mean of all ", columns, " columns of bricks").c_str(), 0, last, each);
  const std::vector<uint64_t> points = column_points(*Bcc4Reader::open(open_memory_source(s.file)), columns);
  const auto densest = std::max_element(points.begin(), points.end()) - points.begin();
  measure("x-slice, densest column", 0, last, std::span(&each[densest], 1));
}

} // namespace

int run_storage_suite(std::span<const std::string> args, const Report& report) {
  std::vector<std::string> tables;
  for (const std::string& a : args) {
    if (a != "--sizes" && a != "--levels" && a != "--rate" && a != "--access")
      fail(Code::invalid_argument, "storage: unknown option ", a);
    tables.push_back(a);
  }
  const auto wanted = [&](const char* table) {
    return tables.empty() || std::find(tables.begin(), tables.end(), table) != tables.end();
  };
  if (wanted("--sizes")) {
    std::vector<Row> rows;
    for (const Case& c : cases(report)) rows.push_back(size_row(c));
    report.table("sizes and reading, one thread, level 6", rows);
  }
  if (wanted("--levels")) {
    std::vector<Row> rows;
    for (const Case& c : cases(report)) level_rows(c, rows);
    report.table("levels of deflate", rows);
  }
  if (wanted("--access")) {
    std::vector<Row> rows;
    access_rows("smoke-like u8",
                smoke_like(report.quick ? std::array<uint32_t, 4>{64, 64, 64, 32}
                                        : std::array<uint32_t, 4>{128, 128, 128, 96}),
                quantiser_of_step(1.3 / 250, 1.3, false), rows);
    if (!report.quick)
      access_rows("smoke-like u8, 256 wide", smoke_like({256, 128, 128, 32}),
                  quantiser_of_step(1.3 / 250, 1.3, false), rows);
    access_rows("dense u8", gaussian_field(report.quick ? 16 : 64, 0.25, 0.9, 11),
                quantiser_of_step(2.0 / 240, 1, true), rows);
    report.table("parts of a file", rows);
  }
  if (wanted("--rate")) rate_tables(report);
  return 0;
}

} // namespace bccsplat::bench

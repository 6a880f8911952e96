// SPDX-License-Identifier: Apache-2.0
// Small volumes for the tests of the container: any lattice, sparse and with holes, values from a formula.
#pragma once

#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/read/samples.h"
#include "formats/bcc4/write/writer.h"
#include "tests/unit/base/bench.h"

namespace bccsplat::test {

struct Sample {
  float value = 0; // relative to air
  bool kept = false, hole = false;
};
// Of channel c at the source position (x, y, z) and frame t.
using Formula = std::function<Sample(int c, double x, double y, double z, double t)>;

// A wavy ball that moves and leaves the box; a block inside is a hole.
inline Sample ball(int c, double x, double y, double z, double t) {
  const double dx = x - 11 - t, dy = y - 9 - 2 * c, dz = z - 10 + 0.5 * t;
  const double r2 = dx * dx + dy * dy + dz * dz;
  Sample s;
  s.kept = r2 < 64;
  if (s.kept) s.value = static_cast<float>((64 - r2) * (1 + 0.2 * std::sin(0.9 * x + 0.5 * y - t)));
  s.hole = s.kept && dx > 2 && dx < 4 && dy < 1;
  return s;
}
inline Sample ball_without_holes(int c, double x, double y, double z, double t) {
  Sample s = ball(c, x, y, z, t);
  s.hole = false;
  return s;
}
inline Sample dense(int c, double x, double y, double z, double t) {
  return {
      static_cast<float>(40 + 3 * c + 20 * std::sin(0.21 * x + 0.13 * y) + 10 * std::cos(0.17 * z - 0.2 * t)),
      true, false};
}

inline ChannelInfo channel(const std::string& name, ValueType type, float air = 0) {
  ChannelInfo c;
  c.name = name;
  c.type = type;
  c.air = air;
  c.scale = type == ValueType::u8 ? 0.5 : type == ValueType::u16 ? 1.0 / 256 : 1;
  c.offset = air;
  return c;
}

inline VolumeInfo volume(LatticeKind kind, const std::array<uint32_t, 4>& dims,
                         std::vector<ChannelInfo> channels) {
  VolumeInfo info;
  info.lattice = Lattice4::fit(kind, dims);
  info.channels = std::move(channels);
  return info;
}

// Layers of one channel.
inline std::vector<BrickLayer> make_layers(const VolumeInfo& info, int channel, const Formula& formula) {
  const Lattice4& l = info.lattice;
  std::vector<BrickLayer> layers;
  for (int32_t m = 0; m < l.layers(); ++m) {
    const int coset = l.coset(m);
    BrickLayer layer(l.space, coset);
    for (size_t s = 0; s < layer.brick_slots(); ++s) {
      const Int3 b = layer.slot_position(s);
      auto brick = std::make_shared<Brick>();
      bool any = false;
      for (int z = 0; z < 16; ++z)
        for (int y = 0; y < 16; ++y)
          for (int x = 0; x < 16; ++x) {
            const Int3 i{b[0] * 16 + x, b[1] * 16 + y, b[2] * 16 + z};
            if (i[0] >= layer.dims()[0] || i[1] >= layer.dims()[1] || i[2] >= layer.dims()[2]) continue;
            const Vec3 p = l.site_position(coset, i);
            const Sample v = formula(channel, p[0], p[1], p[2], l.is_static() ? 0 : l.layer_frame(m));
            if (!v.kept) continue;
            const size_t row = z * 16 + y;
            brick->value[row * 16 + x] = v.value;
            brick->kept[row] = static_cast<uint16_t>(brick->kept[row] | 1u << x);
            if (v.hole) {
              if (!brick->hole) brick->hole = std::make_unique<BrickMask>();
              (*brick->hole)[row] = static_cast<uint16_t>((*brick->hole)[row] | 1u << x);
            }
            any = true;
          }
      if (any) layer.set(s, std::move(brick));
    }
    layers.push_back(std::move(layer));
  }
  return layers;
}

using Layers = std::vector<std::vector<BrickLayer>>; // [channel][layer]

inline Layers make_volume(const VolumeInfo& info, const Formula& formula) {
  Layers all;
  for (size_t c = 0; c < info.channels.size(); ++c)
    all.push_back(make_layers(info, static_cast<int>(c), formula));
  return all;
}

inline Bcc4Report write_to(std::unique_ptr<ByteSink> sink, const VolumeInfo& info, const Layers& layers,
                           Bench& bench, const Bcc4WriterOptions& options = {}) {
  Bcc4Writer writer(std::move(sink), info, options);
  for (int32_t s = 0; s < info.slabs(); ++s)
    for (size_t c = 0; c < layers.size(); ++c) {
      const size_t first = s * info.slab_layers;
      const size_t count = std::min<size_t>(info.slab_layers, layers[c].size() - first);
      writer.write_slab(s, static_cast<int>(c), std::span(layers[c]).subspan(first, count), bench.context);
    }
  return writer.finish(bench.context);
}

inline std::vector<std::byte> write_file(const VolumeInfo& info, const Layers& layers, int threads = 1,
                                         const Bcc4WriterOptions& options = {}) {
  Bench bench(threads);
  std::vector<std::byte> bytes;
  write_to(create_memory_sink(bytes), info, layers, bench, options);
  return bytes;
}
inline std::vector<std::byte> write_file(const VolumeInfo& info, const Formula& formula, int threads = 1,
                                         const Bcc4WriterOptions& options = {}) {
  return write_file(info, make_volume(info, formula), threads, options);
}

// A series under way: what an unfinished file says of itself with its first slabs.
inline VolumeInfo first_slabs(VolumeInfo info, int32_t slabs) {
  info.lattice.last_layer = slabs * info.slab_layers - 1;
  info.lattice.dims[3] = static_cast<uint32_t>(info.lattice.layer_frame(info.lattice.last_layer)) + 1;
  return info;
}
// Left by its writer after four of its slabs, which it has shown one by one.
inline std::vector<std::byte> unfinished_file() {
  VolumeInfo info = volume(LatticeKind::d4star, {20, 11, 9, 30},
                           {channel("value", ValueType::u8), channel("other", ValueType::u16)});
  info.slab_layers = 4;
  const Layers layers = make_volume(info, ball_without_holes);
  std::vector<std::byte> bytes;
  Bench bench;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  for (int32_t s = 0; s < 4; ++s) {
    for (int c = 0; c < 2; ++c)
      writer.write_slab(s, c, std::span(layers[c]).subspan(4 * s, 4), bench.context);
    VolumeInfo shown = first_slabs(info, s + 1);
    shown.expected_frames = 30;
    if (shown.lattice.dims[3] > 1) writer.show(shown, bench.context);
  }
  return bytes;
}

// A series whose frames miss a coast, all the same one, and ice that comes and goes; the last one misses
// nothing.
inline std::vector<std::byte> masked_file() {
  VolumeInfo info = volume(LatticeKind::d4star, {20, 11, 9, 5},
                           {channel("value", ValueType::u8), channel("other", ValueType::u8)});
  std::vector<std::byte> bytes;
  Bench bench;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  const auto mask = [&](int c, uint32_t frame, uint64_t ice) {
    MaskRunWriter runs;
    for (uint64_t row = 0; row < 11 * 9; ++row) {
      runs.add(row * 20, row * 20 + 3 + row % 4);
      if (row >= 11 * 8) runs.add(row * 20 + 20 - ice, row * 20 + 20);
    }
    writer.write_mask(c, frame, runs.finish(), bench.context);
  };
  const Layers layers = make_volume(info, ball_without_holes);
  for (uint32_t frame = 0; frame < 4; ++frame) {
    mask(0, frame, 0);
    if (frame < 2) mask(1, frame, frame * 5);
  }
  for (int32_t slab = 0; slab < info.slabs(); ++slab)
    for (int c = 0; c < 2; ++c) {
      const auto first = layers[c].begin() + slab * info.slab_layers;
      const std::vector<BrickLayer> part(first, first + info.layers_of(slab));
      writer.write_slab(slab, c, part, bench.context);
    }
  writer.finish(bench.context);
  return bytes;
}

// What a level of a volume looks like as a volume of its own.
inline VolumeInfo volume_of_level(const VolumeInfo& info, int level) {
  VolumeInfo one = info;
  static_cast<StoredLattice&>(one) = info.level(level);
  one.levels.clear();
  return one;
}

// A series of two channels at two coarser levels.
inline VolumeInfo levels_info() {
  constexpr std::array<uint32_t, 4> dims{40, 26, 22, 7};
  VolumeInfo info =
      volume(LatticeKind::d4star, dims, {channel("value", ValueType::u8), channel("other", ValueType::u16)});
  info.channels[1].scale = 0.25;
  for (const int l : {1, 2}) {
    LevelInfo& level = info.levels.emplace_back();
    const double scale = 1 << l;
    level.lattice = Lattice4::fit(LatticeKind::d4star, dims, {scale, scale, scale, 1}, l == 2 ? 2 : 0,
                                  {l == 1 ? 2 : 0, 0, l == 2 ? 2 : 0});
    level.slab_layers = l == 1 ? 8 : 4;
    level.channels.resize(info.channels.size());
  }
  return info;
}

// Coarser levels of a slab come first.
inline void write_levels(Bcc4Writer& writer, const VolumeInfo& info, const Formula& formula, Bench& bench) {
  for (int level = info.level_count() - 1; level >= 0; --level) {
    const VolumeInfo one = volume_of_level(info, level);
    const Layers layers = make_volume(one, formula);
    for (int32_t s = 0; s < one.slabs(); ++s)
      for (int c = 0; c < static_cast<int>(layers.size()); ++c)
        writer.write_slab(s, {c, level}, std::span(layers[c]).subspan(s * one.slab_layers, one.layers_of(s)),
                          bench.context);
  }
}
inline std::vector<std::byte> levels_file(const Formula& formula = ball) {
  Bench bench;
  std::vector<std::byte> bytes;
  const VolumeInfo info = levels_info();
  Bcc4Writer writer(create_memory_sink(bytes), info);
  write_levels(writer, info, formula, bench);
  writer.finish(bench.context);
  return bytes;
}

// A file with corrections in three bricks of two frames and samples to set, and what was measured.
inline std::vector<std::byte> corrected_file(std::optional<float> base = {}) {
  VolumeInfo info = volume(LatticeKind::d4star, {70, 9, 68, 3}, {channel("value", ValueType::u8)});
  info.recommended_kernel = "radial20+b3";
  ResidualInfo& fix = info.channels[0].residuals;
  fix.step = fix.bound = 0.25, fix.local = true, fix.shape = CorrectionShape::smooth;
  fix.base = base;
  for (uint32_t kind = 1; kind <= 2; ++kind)
    info.errors.push_back({.kind = kind,
                           .frames = 3,
                           .samples = 70 * 9 * 68 * 3,
                           .rmse = 0.5 / kind,
                           .largest = 2.0 / kind,
                           .range = 100});
  std::vector<std::byte> bytes;
  Bench bench;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  const Layers layers = make_volume(info, ball);
  for (int32_t slab = 0; slab < info.slabs(); ++slab) {
    const auto first = layers[0].begin() + slab * info.slab_layers;
    const std::vector<BrickLayer> part(first, first + info.layers_of(slab));
    writer.write_slab(slab, 0, part, bench.context);
  }
  const auto voxel = [](uint64_t x, uint64_t y, uint64_t z) { return (z * 9 + y) * 70 + x; };
  FrameResiduals first, last;
  for (uint64_t x = 0; x < 70; x += 3) first.add.push_back({voxel(x, 4, 5), static_cast<int64_t>(x) - 30});
  first.add.push_back({voxel(69, 8, 67), 1000});
  last.add = {{voxel(0, 0, 0), 1}, {voxel(1, 0, 0), -1}}, last.set = {{voxel(33, 4, 20), 77}};
  writer.write_residuals(0, 0, first, bench.context);
  writer.write_residuals(0, 2, last, bench.context);
  writer.finish(bench.context);
  return bytes;
}

// Every sample of a level of a file.
inline Layers read_all(const std::shared_ptr<Bcc4Reader>& reader, Bench& bench, int level = 0) {
  const Bcc4Samples samples(reader, bench.memory, 256 << 20, RelativeTo::air, level);
  Layers all(reader->info().channels.size());
  for (size_t c = 0; c < all.size(); ++c)
    for (int32_t m = 0; m < samples.lattice().layers(); ++m)
      all[c].push_back(samples.read_layer(static_cast<int>(c), m, {}, bench.context));
  return all;
}
inline Layers read_all(std::span<const std::byte> file, int threads = 1) {
  Bench bench(threads);
  return read_all(Bcc4Reader::open(open_memory_source(file)), bench);
}

// Where two layers differ, or nothing. Values are compared as bits, after `expect` maps those of `a`.
inline float as_it_is(float value) { return value; }
inline std::optional<std::string> difference(const BrickLayer& a, const BrickLayer& b,
                                             const std::function<float(float)>& expect = as_it_is) {
  if (!(a.lattice() == b.lattice()) || a.coset() != b.coset()) return "other lattice";
  for (size_t s = 0; s < a.brick_slots(); ++s) {
    const Brick *p = a.brick(s), *q = b.brick(s);
    if (!p != !q) return concat("brick ", s, " is missing in one");
    if (!p) continue;
    if (p->kept != q->kept) return concat("other sites in brick ", s);
    if (!p->hole != !q->hole || (p->hole && *p->hole != *q->hole)) return concat("other holes in brick ", s);
    for (size_t i = 0; i < p->value.size(); ++i) {
      const float want = p->kept[i / 16] >> (i % 16) & 1 ? expect(p->value[i]) : 0;
      if (std::bit_cast<uint32_t>(want) != std::bit_cast<uint32_t>(q->value[i]))
        return concat("site ", i, " of brick ", s, ": ", want, " became ", q->value[i]);
    }
  }
  return std::nullopt;
}
inline std::optional<std::string> difference(const Layers& a, const Layers& b) {
  if (a.size() != b.size()) return "other channels";
  for (size_t c = 0; c < a.size(); ++c) {
    if (a[c].size() != b[c].size()) return "other layers";
    for (size_t m = 0; m < a[c].size(); ++m)
      if (auto d = difference(a[c][m], b[c][m])) return concat("channel ", c, " layer ", m, ": ", *d);
  }
  return std::nullopt;
}

} // namespace bccsplat::test

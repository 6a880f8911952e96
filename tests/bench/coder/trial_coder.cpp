// SPDX-License-Identifier: Apache-2.0
// Coder and decoder of trial files. The decoder has nothing but the bytes: it walks as the coder does, and
// asks its arithmetic decoder where the coder knows.
#include "tests/bench/coder/trial_coder.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "base/error.h"
#include "tests/bench/coder/holes.h"
#include "tests/bench/coder/symbols.h"
#include "tests/bench/coder/trial_plan.h"

namespace bccsplat::bench {
namespace {

size_t place_of(const Chain& c, const WalkRow& r) {
  return ((size_t(r.k) * c.size[2] + r.box.begin[2] + r.z) * c.size[1] + r.box.begin[1] + r.y) * c.size[0] +
         r.box.begin[0];
}

uint32_t expected_in(const std::vector<uint32_t>& sums, int width) {
  uint32_t all = 0;
  for (int x = 0; x < width; ++x) all += sums[x];
  return all;
}

struct Writing {
  const Chain& chain;
  const Slab& slab;
  SymbolCoder<BinaryEncoder>& symbols;
  bool row(const WalkRow& r, const std::vector<uint32_t>& sums) {
    const int32_t* const s = slab.steps.data() + place_of(chain, r);
    const bool any = std::any_of(s, s + r.box.size[0], [](int32_t v) { return v != 0; });
    return symbols.row(any, r, expected_in(sums, r.box.size[0]));
  }
  uint16_t site(const WalkRow& r, int x, const WalkSite& s) {
    const int v = slab.steps[place_of(chain, r) + x];
    symbols.code(v, r, s);
    return static_cast<uint16_t>(std::min(std::abs(v), most_context));
  }
};

struct Reading {
  const Chain& chain;
  const TrialHead& head;
  std::span<float> layers;
  SymbolCoder<BinaryDecoder>& symbols;
  bool row(const WalkRow& r, const std::vector<uint32_t>& sums) {
    return symbols.row(false, r, expected_in(sums, r.box.size[0]));
  }
  uint16_t site(const WalkRow& r, int x, const WalkSite& s) {
    const int v = symbols.code(0, r, s);
    layers[place_of(chain, r) + x] = restored(v, head.step, head.centres);
    return static_cast<uint16_t>(std::min(std::abs(v), most_context));
  }
};

std::vector<std::byte> code_chunk(const TrialHead& head, const Slab& slab, ChunkWalk& walk) {
  BinaryEncoder coder;
  SymbolCoder<BinaryEncoder> symbols(coder, slab.frames);
  Writing visit{head.chain, slab, symbols};
  walk.run(visit);
  return coder.finish();
}

void decode_chunk_into(const TrialHead& head, std::span<const std::byte> bytes, int frames, ChunkWalk& walk,
                       std::span<float> layers) {
  BinaryDecoder coder(bytes);
  SymbolCoder<BinaryDecoder> symbols(coder, frames);
  Reading visit{head.chain, head, layers, symbols};
  walk.run(visit);
}

void write_basis(const Slab& s, bool principal, ByteWriter& out) {
  out.write(static_cast<uint8_t>(principal));
  if (principal)
    for (const int16_t v : s.basis.rows) out.write(v);
}

TimeBasis read_basis(int frames, ByteReader& in) {
  TimeBasis basis = in.read<uint8_t>() ? TimeBasis{frames, {}} : cosine_basis(frames);
  if (basis.rows.empty())
    for (int i = 0; i < frames * frames; ++i) basis.rows.push_back(in.read<int16_t>());
  return basis;
}

// Frames of a slab: all of a short series, else about as many as a moment should read.
int usual_slab(int frames) {
  constexpr int most = 24, usual = 16;
  if (frames <= most) return frames;
  const int slabs = (frames + usual - 1) / usual;
  return (frames + slabs - 1) / slabs;
}

struct SlabBytes {
  std::vector<std::byte> bytes;
  uint64_t details = 0;
};

// The basis, how long each part is, coefficients of the chunks, details of the chunks.
SlabBytes slab_bytes(const TrialHead& head, const Slab& slab, bool principal, std::span<const float> source) {
  ByteWriter table, parts;
  SlabBytes out;
  write_basis(slab, principal, table);
  const auto add = [&](const std::vector<std::byte>& part) {
    table.write_varint(part.size());
    parts.write_bytes(part);
  };
  walk_slab(head.chain, head.edge, slab.frames, head.weights,
            [&](ChunkWalk& walk) { add(code_chunk(head, slab, walk)); });
  const std::vector<float> back = restored_slab(head, slab);
  for_positions(head, [&](const std::array<int, 3>& p) {
    const auto details = code_details(detail_box(head, slab.frames, p), head.rule, source, back);
    add(details);
    out.details += details.size();
  });
  out.bytes = table.release();
  const std::vector<std::byte> all = parts.release();
  out.bytes.insert(out.bytes.end(), all.begin(), all.end());
  return out;
}

void decode_slab(const TrialHead& head, ByteReader& in, int frames, std::span<float> samples) {
  const TimeBasis basis = read_basis(frames, in);
  std::vector<uint64_t> lengths;
  for (int c = 0; c < 2 * chunks_of(head) - 1; ++c) lengths.push_back(in.read_varint());
  size_t part = 0;
  walk_slab(head.chain, head.edge, frames, head.weights, [&](ChunkWalk& walk) {
    decode_chunk_into(head, in.take(lengths[part++]), frames, walk, samples);
  });
  restore_frames(head, basis, samples);
  for_positions(head, [&](const std::array<int, 3>& p) {
    apply_details(detail_box(head, frames, p), head.rule, in.take(lengths[part++]), samples);
  });
}

TrialHead head_of(const TrialSeries& series, const TrialSeries& filled, const TrialOptions& options) {
  TrialHead head;
  head.dims = series.dims;
  head.chain.size = {series.dims[0], series.dims[1], series.dims[2]};
  const auto& values = filled.values;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const auto count = [&](float v) { return std::count(values.begin(), values.end(), v); };
  head.low = *low, head.high = *high;
  head.mean = static_cast<float>(std::accumulate(values.begin(), values.end(), 0.0) /
                                 static_cast<double>(values.size()));
  head.rule = {values != series.values, count(0) > count(*low) ? 0 : *low, static_cast<float>(options.bound)};
  head.slab = options.slab > 0 ? options.slab : usual_slab(series.dims[3]);
  head.edge = options.edge;
  return head;
}

double wanted_error(const TrialHead& head, const TrialOptions& options) {
  constexpr double decibels = 20, of_constants = 1;
  const double range = head.high - head.low;
  if (options.bound > 0) return options.inside * options.bound;
  return range > 0 ? range / std::pow(10.0, options.psnr / decibels) : of_constants;
}

} // namespace

TrialFile trial_encode(const TrialSeries& series, const TrialOptions& options) {
  if (options.edge < edge_unit || options.edge % edge_unit != 0)
    fail(Code::invalid_argument, "chunks are multiples of ", edge_unit, " samples wide, not ", options.edge);
  const TrialSeries filled = without_holes(series);
  const TrialHead head = head_of(series, filled, options);
  const double error = wanted_error(head, options);
  const TrialPlan plan = plan_trial(series, filled, head, error * error, options.lambda);
  ByteWriter out;
  write_head(plan.head, out);
  TrialFile file;
  std::vector<std::vector<std::byte>> parts;
  for (const Slab& s : plan.slabs) {
    SlabBytes made = slab_bytes(plan.head, s, plan.principal, source_of(plan.head, s, series));
    out.write_varint(made.bytes.size());
    file.details += made.details;
    parts.push_back(std::move(made.bytes));
  }
  for (const auto& p : parts) out.write_bytes(p);
  file.bytes = out.release();
  file.chain = plan.words();
  return file;
}

TrialSeries trial_decode(std::span<const std::byte> bytes) {
  ByteReader in(bytes, "trial file");
  const TrialHead head = read_head(in);
  TrialSeries series{head.dims, std::vector<float>(head.frame() * head.dims[3])};
  std::vector<uint64_t> sizes(head.slabs());
  for (uint64_t& s : sizes) s = in.read_varint();
  for (int i = 0; i < head.slabs(); ++i) {
    ByteReader slab(in.take(sizes[i]), "slab of a trial file");
    const size_t first = i * head.slab * head.frame(), samples = head.frames_of(i) * head.frame();
    decode_slab(head, slab, head.frames_of(i), std::span(series.values).subspan(first, samples));
  }
  return series;
}

uint64_t trial_moment_bytes(std::span<const std::byte> bytes, int first, int last) {
  ByteReader in(bytes, "trial file");
  const TrialHead head = read_head(in);
  uint64_t needed = 0;
  for (int i = 0; i < head.slabs(); ++i) {
    const uint64_t size = in.read_varint();
    if (i * head.slab <= last && (i + 1) * head.slab > first) needed += size;
  }
  return needed + in.position();
}

} // namespace bccsplat::bench

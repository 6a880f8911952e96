// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/coder/trial_head.h"

#include <algorithm>

#include "base/error.h"

namespace bccsplat::bench {
namespace {

constexpr uint32_t trial_magic = 0x33434342;

int read_size(ByteReader& in, uint64_t most, const char* what) {
  const uint64_t v = in.read_varint();
  if (v < 1 || v > most) fail(Code::corrupt, "trial file: ", what, " of ", v, ", not 1 to ", most);
  return static_cast<int>(v);
}

void read_axes(ByteReader& in, TrialHead& h) {
  constexpr uint64_t most_along = 1 << 16, most_samples = uint64_t{1} << 28;
  uint64_t all = 1;
  for (int& d : h.dims) {
    d = read_size(in, most_along, "axis");
    all = std::min(all * static_cast<uint64_t>(d), most_samples + 1);
  }
  if (all > most_samples) fail(Code::corrupt, "trial file: more than ", most_samples, " samples");
  h.chain.size = {h.dims[0], h.dims[1], h.dims[2]};
  for (int& n : h.chain.halvings) n = in.read<uint8_t>();
  for (const int n : h.chain.halvings)
    if (n > most_levels) fail(Code::corrupt, "trial file: ", n, " halvings, at most ", most_levels);
  h.slab = read_size(in, most_along, "slab");
  h.edge = read_size(in, most_along, "chunk");
  if (h.edge % edge_unit != 0) fail(Code::corrupt, "trial file: chunks of ", h.edge, " samples do not halve");
}

void read_values(ByteReader& in, TrialHead& h) {
  for (float* v : {&h.mean, &h.low, &h.high, &h.step, &h.rule.air, &h.rule.bound}) *v = in.read<float>();
  if (!(h.low <= h.high)) fail(Code::corrupt, "trial file: values from ", h.low, " to ", h.high);
  h.rule.has_holes = in.read<uint8_t>() != 0;
}

} // namespace

DetailBox detail_box(const TrialHead& head, int frames, const std::array<int, 3>& position) {
  DetailBox box{{}, {}, head.chain.size, frames};
  for (int a = 0; a < 3; ++a) {
    box.begin[a] = position[a] * head.edge;
    box.size[a] = std::min(head.edge, head.chain.size[a] - box.begin[a]);
  }
  return box;
}

int chunks_of(const TrialHead& head) {
  const std::array<int, 3> n = chunk_counts(head.chain, head.edge);
  return 1 + n[0] * n[1] * n[2];
}

void write_head(const TrialHead& h, ByteWriter& out) {
  out.write(trial_magic);
  for (const int d : h.dims) out.write_varint(static_cast<uint64_t>(d));
  for (const int n : h.chain.halvings) out.write(static_cast<uint8_t>(n));
  out.write_varint(static_cast<uint64_t>(h.slab));
  out.write_varint(static_cast<uint64_t>(h.edge));
  for (const float v : {h.mean, h.low, h.high, h.step, h.rule.air, h.rule.bound}) out.write(v);
  out.write(static_cast<uint8_t>(h.rule.has_holes));
  for (int l = 0; l <= h.chain.levels(); ++l)
    for (const uint8_t w : h.weights[l]) out.write(w);
  for (const uint8_t c : h.centres) out.write(c);
}

TrialHead read_head(ByteReader& in) {
  TrialHead h;
  if (in.read<uint32_t>() != trial_magic) fail(Code::corrupt, "this is no trial file");
  read_axes(in, h);
  read_values(in, h);
  for (int l = 0; l <= h.chain.levels(); ++l)
    for (uint8_t& w : h.weights[l]) w = in.read<uint8_t>();
  for (uint8_t& c : h.centres) c = in.read<uint8_t>();
  return h;
}

void restore_frames(const TrialHead& head, const TimeBasis& basis, std::span<float> slab) {
  const size_t frame = head.chain.samples();
  for (int k = 0; k < basis.frames; ++k) synthesise(head.chain, slab.subspan(k * frame, frame));
  to_frames(basis, slab);
  for (float& v : slab) v = std::clamp(v + head.mean, head.low, head.high);
}

} // namespace bccsplat::bench

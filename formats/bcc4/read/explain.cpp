// SPDX-License-Identifier: Apache-2.0
// Puts the damage of a file into words: what is lost, and what is not.
#include <algorithm>
#include <cmath>

#include "formats/bcc4/read/explain.h"
#include "kernel/kernel.h"

namespace bccsplat {
namespace {

// Returns the file's own kernel, or the default one where this version does not know it.
Kernel kernel_of(const VolumeInfo& info) {
  try {
    return make_kernel(info.recommended_kernel);
  } catch (const Error&) {
    return make_kernel("");
  }
}

struct Frames {
  int64_t first, last; // closed
};

// The source frames that depend on the layers first .. last; of a periodic series two stretches where they go
// on across its end.
std::vector<Frames> frames_of(const Lattice4& l, int32_t first, int32_t last, int reach) {
  const int64_t end = int64_t{l.dims[3]} - 1;
  if (l.is_static()) return {{0, end}};
  // Frames are strictly within reach, as a layer at the end of the kernel has weight 0.
  const auto low = static_cast<int64_t>(std::floor(l.layer_frame(first - reach))) + 1;
  const auto high = static_cast<int64_t>(std::ceil(l.layer_frame(last + reach))) - 1;
  if (!l.periodic) return {{std::clamp<int64_t>(low, 0, end), std::clamp<int64_t>(high, 0, end)}};
  if (high - low >= end) return {{0, end}};
  const int64_t from = l.turned_frame(low), to = l.turned_frame(high);
  if (from <= to) return {{from, to}};
  return {{0, to}, {from, end}};
}

std::string frames_text(const Frames& f) {
  return f.first == f.last ? concat(f.first) : concat(f.first, " to ", f.last);
}

} // namespace

std::string describe_loss(const VolumeInfo& info, const Bcc4Damage& damage) {
  if (damage.channel < 0 || damage.last_layer < damage.first_layer) return {};
  const Lattice4& l = info.level(damage.level).lattice;
  std::string text = concat("; lost: channel ", info.channels[damage.channel].name);
  if (damage.level > 0) text += concat(", level ", damage.level);
  if (!damage.whole_layers) {
    text += ", samples";
    for (size_t a = 0; a < 3; ++a) {
      const double planes = brick_edge * (l.space.bcc ? 2.0 : 1.0), end = l.dims[a] - 1.0;
      const double begin = l.plane_position(a, planes * damage.brick[a]),
                   behind = l.plane_position(a, planes * (damage.brick[a] + 1) - 1);
      const double first = std::clamp(std::floor(begin), 0.0, end),
                   last = std::clamp(std::ceil(behind), 0.0, end);
      text += concat(" ", "xyz"[a], " ", first, " to ", last);
    }
  } else {
    text += ", any samples";
  }
  std::string frames;
  for (const Frames& f : frames_of(l, damage.first_layer, damage.last_layer, 1))
    frames += concat(frames.empty() ? "" : ", ", frames_text(f));
  return text + concat(" of frames ", frames);
}

std::string describe_survivors(const VolumeInfo& info, std::span<const Bcc4Damage> damage) {
  const int reach = kernel_of(info).reach_layers();
  std::vector<Frames> touched;
  bool coarser = false;
  for (const Bcc4Damage& d : damage)
    if (d.channel >= 0 && d.last_layer >= d.first_layer) {
      coarser = coarser || d.level > 0;
      if (d.level > 0) continue;
      for (const Frames& f : frames_of(info.lattice, d.first_layer, d.last_layer, reach))
        touched.push_back(f);
    }
  if (touched.empty()) return coarser ? "no sample of level 0 is lost" : "no sample is lost";
  std::sort(touched.begin(), touched.end(),
            [](const Frames& a, const Frames& b) { return a.first < b.first; });
  std::string whole;
  int64_t next = 0; // the first frame not yet accounted for
  const auto add = [&](int64_t end) {
    if (next < end) whole += concat(whole.empty() ? "" : ", ", frames_text({next, end - 1}));
  };
  for (const Frames& f : touched) {
    add(f.first);
    next = std::max(next, f.last + 1);
  }
  add(info.lattice.dims[3]);
  return whole.empty() ? "no frame is whole; the others of its samples can be exported as they are"
                       : concat("whole are frames ", whole, " of 0 to ", info.lattice.dims[3] - 1);
}

} // namespace bccsplat

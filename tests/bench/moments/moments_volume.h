// SPDX-License-Identifier: Apache-2.0
// What the suite `moments` is asked for, and a volume of it as a host opens it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <set>
#include <vector>

#include "base/machine.h"
#include "field/coefficients/coefficients.h"
#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/read/samples.h"
#include "slice/time_slice.h"
#include "tests/bench/moments/moments_series.h"
#include "tests/support/fields.h"
#include "volume/volume_cache.h"

namespace bccsplat::bench {

inline constexpr double mebibyte = 1 << 20;

struct MomentOptions {
  uint32_t edge = 256, frames = 16;
  int count = 6; // random moments
  std::vector<bool> sparse{false, true};
  int levels = 0;     // coarser ones, of series that are written without them first
  uint64_t cache = 0; // bytes; 0: a volume's default
  bool cuts = false;
  bool slices = false;   // only slices of files that the tool made
  bool pictures = false; // nothing but pictures of levels
  bool contents = false; // only pictures of levels, of all kinds of contents
};

// A level of a volume as a host opens it, on one thread.
struct Opened {
  test::TestContext context{1};
  std::shared_ptr<Bcc4Reader> reader;
  Kernel kernel = make_kernel("default");
  VolumeCache playing;
  uint64_t cache;
  VolumeCache share;
  Bcc4Samples samples;
  Coefficients field;
  uint64_t opening; // bytes read

  Opened(const WrittenSeries& written, const MomentOptions& o, int level = 0)
      : reader(Bcc4Reader::open(open_memory_source(written.file))), playing(playing_cache(*reader, kernel)),
        cache(o.cache > 0 ? o.cache : default_cache_bytes(playing, UINT64_MAX, machine_memory())),
        share(share_cache(cache, playing)),
        samples(reader, context.memory, share.chunks, RelativeTo::base, level),
        field(samples, 0, kernel, 0, share.coefficients), opening(reader->bytes_read()) {}

  Slice moment(double frame) { return time_slice(field, frame, {0, 0}, {}, context.get()); }
  [[nodiscard]] const StoredLattice& stored() const { return reader->info().level(samples.level()); }

  // Of a layer's chunks, where a slab has most of them.
  [[nodiscard]] double layers_decoded() const {
    const StoredLattice& info = stored();
    uint64_t most = 0;
    for (int32_t s = 0; s < info.slabs(); ++s)
      most = std::max<uint64_t>(most, reader->chunks({0, samples.level()}, s).size());
    return static_cast<double>(samples.chunk_layers_decoded()) / static_cast<double>(most);
  }
  // Beyond once each, of those in the file.
  [[nodiscard]] double layers_decoded_twice() const {
    const StoredLattice& info = stored();
    uint64_t all = 0;
    for (int32_t s = 0; s < info.slabs(); ++s)
      all += reader->chunks({0, samples.level()}, s).size() * info.layers_of(s);
    const uint64_t once = std::min(samples.chunk_layers_decoded(), all);
    return layers_decoded() *
           (1 - static_cast<double>(once) / static_cast<double>(samples.chunk_layers_decoded()));
  }
  // The layers of the file that a moment depends on.
  [[nodiscard]] std::set<int32_t> in_reach(double frame) const {
    const Lattice4& lattice = stored().lattice;
    std::set<int32_t> layers;
    for (const LayerWeight& w : instant_weights(lattice, field.kernel(), frame))
      layers.merge(field.reads(lattice.mirror_layer(w.layer)));
    return layers;
  }
  [[nodiscard]] double mebibytes() const { return static_cast<double>(context.memory.peak()) / mebibyte; }
};

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// The samples of a .bcc4 file as a SampleSource.
#pragma once

#include <bit>
#include <climits>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/memory.h"
#include "formats/bcc4/read/reader.h"
#include "points/sample_source.h"

namespace bccsplat {

class Attempts;       // base/would_block.h
class UnchangedSlabs; // unchanged_slabs.h
struct TileValues;    // tile_sums.h

// The samples of a level of a file as a SampleSource, relative to air or to the base of the field. Decoded
// chunks are cached, least recently used first out, as far as `budget` (which must outlive this) and
// `cache_bytes` allow: consecutive layers of a slab decode each chunk once, and so do those that are read
// together, whatever the cache. Layers that were handed over as samples are not held as well. Where many
// layers are asked for at once, as a moment does that nothing is known of, decoding stops behind the last
// one; what is left of such a chunk is held as it is stored.
class Bcc4Samples final : public SampleSource {
 public:
  Bcc4Samples(std::shared_ptr<const Bcc4Reader> reader, MemoryBudget& budget,
              uint64_t cache_bytes = 256 << 20, RelativeTo to = RelativeTo::air, int level = 0);
  ~Bcc4Samples() override;

  // Shares the chunks that are unchanged and that another one holds, of the file before it grew.
  void take_over(const Bcc4Samples& older, const UnchangedSlabs& unchanged);

  const Lattice4& lattice() const override;
  int channels() const override;
  float air(int channel) const override;
  float base(int channel) const override;
  // Nothing of a channel whose error is bounded may be rounded: its corrections fit only the values that they
  // were made of.
  double sample_step(int channel) const override;
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox& region,
                        const Context& context) const override;
  void read_layers(int channel, std::span<const int32_t> layers, const BrickBox& region,
                   const Context& context, const TakeLayer<BrickLayer>& take) const override;
  void read_samples(int channel, std::span<const int32_t> layers, const BrickBox& region,
                    const Context& context, const TakeLayer<SampleLayer>& take) const override;
  // Sums are made of linear tiles.
  bool adds_layers(int channel) const override;
  uint64_t bricks_at_most(int channel, std::span<const int32_t> layers,
                          const BrickBox& region) const override;
  std::vector<BrickLayer> add_layers(int channel, std::span<const LayerSum> sums, const BrickBox& region,
                                     const Context& context) const override;

  // Appends where the bytes are that reading a layer takes, unmerged; missing: without those of cached chunks
  // and of the index. It reads the index.
  void list_reads(int channel, int32_t layer, const BrickBox& region, bool missing,
                  std::vector<ByteRange>& out) const;
  [[nodiscard]] const Bcc4Reader& reader() const;
  [[nodiscard]] int level() const { return level_; }
  // The number of chunks decoded so far, whole or in part, and that of their layers, each chunk's counted.
  [[nodiscard]] uint64_t chunks_decoded() const;
  [[nodiscard]] uint64_t chunk_layers_decoded() const;

 private:
  class HeldChunk;
  struct Cache;
  // Layers of a slab, a bit each, and whether those behind them may be left for later.
  struct SlabLayers {
    uint32_t bits = 0;
    bool stops = false;
    [[nodiscard]] int end() const { return stops ? static_cast<int>(std::bit_width(bits)) : INT_MAX; }
  };
  // Calls body(brick, held) from any thread for the chunks, or the bricks of tiles, of a slab in `region`,
  // with these of its layers.
  using ChunkBody = std::function<void(const Int3& brick, const HeldChunk& held)>;
  void for_chunks(int channel, int32_t slab, const BrickBox& region, const SlabLayers& layers,
                  const Context& context, const ChunkBody& body) const;
  // Returns chunks of a slab, from the cache or decoded; null where their bytes are not there yet.
  [[nodiscard]] std::vector<std::shared_ptr<const HeldChunk>>
  fetch_chunks(const ChannelLevel& at, int32_t slab, std::span<const Bcc4Chunk> chunks,
               const SlabLayers& layers, const Context& context, Attempts& attempts) const;
  // Returns how many chunks are worked on at once.
  [[nodiscard]] size_t chunks_at_once() const;
  void for_bricks(uint32_t slot, const HeldChunk& held, const ChunkBody& body) const;
  [[nodiscard]] uint64_t bricks_of_chunk() const;
  // Decodes what chunks have left, those at these places; of tiles these layers.
  void finish_chunks(const ChannelLevel& at, std::span<const size_t> places,
                     std::span<std::shared_ptr<const HeldChunk>> held, uint32_t layers,
                     const Context& context) const;
  // Hands over layers, slab by slab; brick(held, layer of the slab) makes one of their bricks.
  template<class Layer, class MakeBrick>
  void read_slabs(int channel, std::span<const int32_t> layers, const BrickBox& region,
                  const Context& context, const TakeLayer<Layer>& take, const MakeBrick& brick) const;
  // Takes room for layers of one slab that are read together: the first one stands beside the budget, the
  // others within, as many as leave what decoding one of its chunks takes.
  [[nodiscard]] std::vector<Reservation> reserve_others(const ChannelLevel& at,
                                                        std::span<const int32_t> layers,
                                                        const BrickBox& region,
                                                        uint64_t bytes_of_brick) const;
  // linear_samples.cpp
  struct SlabTerms;
  [[nodiscard]] std::vector<SlabTerms> terms_of(std::span<const LayerSum> sums) const;
  void add_tiles(std::span<const SlabTerms> slabs, uint32_t slot, std::span<const LayerSum> sums,
                 const TileValues& values, const BrickBox& region, std::vector<float>& room,
                 std::span<BrickLayer> out) const;
  void read_linear(int channel, std::span<const int32_t> layers, const BrickBox& region,
                   const Context& context, const TakeLayer<BrickLayer>& take) const;
  void lose_neighbours(int channel, int32_t layer, const BrickBox& region, const Context& context,
                       BrickLayer& out) const;
  [[nodiscard]] std::string shown_kernel() const;
  // The slabs that it looks at for a layer, in a region that is wider than the layer's.
  [[nodiscard]] std::set<int32_t> slabs_beside(int32_t layer) const;

  [[nodiscard]] MemoryBudget& budget() const;

  std::shared_ptr<const Bcc4Reader> reader_;
  std::unique_ptr<Cache> cache_;
  RelativeTo to_;
  int level_;
};

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// The .bcc4 container: sparse samples of a 4D volume, written slab by slab and read chunk by chunk
// (formats/bcc4.md).
//
// A chunk is one 4D brick of one channel: the 16^3 bricks at one brick position in `slab_layers` consecutive
// layers.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <climits>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/byte_range.h"
#include "base/context.h"
#include "base/files.h"
#include "formats/bcc4/coding/chunk_entry.h"
#include "formats/bcc4/coding/mask_runs.h"
#include "formats/bcc4/coding/residuals.h"
#include "formats/bcc4/correction_table.h"
#include "formats/bcc4/info.h"
#include "points/brick.h"
#include "points/sample_source.h"

namespace bccsplat {

struct Bcc4Bytes {
  uint64_t file = 0;
  uint64_t runs = 0;   // which sites are kept, and holes
  uint64_t values = 0; // samples
  uint64_t index = 0;  // tables, metadata, roots and padding; file = runs + values + index + unused
  uint64_t unused = 0; // referenced by nothing
};

struct Bcc4Report {
  Bcc4Bytes bytes;
  uint64_t chunks = 0;
  uint64_t bytes_corrections = 0;                  // of the index
  uint64_t slabs_reused = 0;                       // taken from an earlier writer or file, not coded again
  uint64_t sites_total = 0;                        // all channels
  uint64_t sites_kept = 0, holes = 0, clamped = 0; // all channels
};

class Bcc4Journal; // journal.h
class Bcc4Reader;

struct Bcc4WriterOptions {
  int level = 6;            // of deflate, 1 (fast) .. 9 (small); 0: raw chunks, usable from a mapping
  uint64_t data_offset = 0; // where the first chunk may go at the earliest; what lies before stays unused
  // Records what has been written, for a writer that comes after a crash: slabs that an earlier one recorded
  // are not coded again. The sink must be the file of the earlier one (Partial::taken_over).
  std::shared_ptr<Bcc4Journal> journal{};
  uint32_t fingerprint = 0; // of what decides the samples but is not in the VolumeInfo
  // A finished file whose first slabs are those to be written: their chunks are copied.
  std::shared_ptr<const Bcc4Reader> earlier{};
  int32_t earlier_slabs = 0;
};

class Bcc4Writer {
 public:
  Bcc4Writer(std::unique_ptr<ByteSink> sink, const VolumeInfo& initial,
             const Bcc4WriterOptions& options = {});
  ~Bcc4Writer(); // without finish, nothing is left under the final name
  Bcc4Writer(const Bcc4Writer&) = delete;
  Bcc4Writer& operator=(const Bcc4Writer&) = delete;

  // Writes the layers of one slab of one channel at a level: slab_layers of them, fewer only at the end of
  // the series. Bricks hold values minus air; a hole counts as kept. The slabs of a channel at a level rise;
  // those of a periodic series may begin with any, and end with those before it. A slab that is left out is
  // air. Integer types round to nearest and clamp. Values must be finite (Code::nonfinite_value). rounded:
  // the sum of the squares by which values were rounded to those given; of tiles it is a part of the error
  // that their sites may have, which is kept (else Code::bound_not_met).
  void write_slab(int32_t slab, const ChannelLevel& at, std::span<const SampleLayer> layers,
                  const Context& context, double rounded = 0);
  void write_slab(int32_t slab, const ChannelLevel& at, std::span<const BrickLayer> layers,
                  const Context& context);

  // Of a file of tiles, whose samples are rounded as they are coded: what a reader gets of these layers of a
  // slab, as codes. Of the slab that was just written it is at hand once; any other is coded for it.
  [[nodiscard]] std::vector<SampleLayer> as_read(int32_t slab, const ChannelLevel& at,
                                                 std::span<const SampleLayer> layers, const Context& context,
                                                 double rounded = 0);

  // Writes a slab by copying its chunks, undecoded, from files of equal coding that have some of its bricks
  // each. Throws invalid_argument where two have the same.
  void copy_slab(int32_t slab, const ChannelLevel& at, std::span<const Bcc4Reader* const> from);
  void copy_slab(int32_t slab, const ChannelLevel& at, const Bcc4Reader& from) {
    const Bcc4Reader* const one = &from;
    copy_slab(slab, at, {&one, 1});
  }

  // Write the corrections of one frame, in any order of channels and frames; a frame that gets none has none.
  // Those to add go into bricks where the channel's are local (ResidualInfo).
  void write_residuals(int channel, uint32_t frame, const FrameResiduals& residuals, const Context& context);
  // Copies them from files that have those of some of its samples each; see FrameBlocks::copy_corrections.
  void copy_residuals(int channel, uint32_t frame, std::span<const Bcc4Reader* const> from,
                      const Context& context);
  // Write which samples of one frame are missing, as MaskRunWriter has it; empty: none.
  void write_mask(int channel, uint32_t frame, std::span<const std::byte> runs, const Context& context);
  void copy_mask(int channel, uint32_t frame, const Bcc4Reader& from);
  // The same of files that are blocks of space: a sample is missing where it is in one of them.
  void copy_mask(int channel, uint32_t frame, std::span<const Bcc4Reader* const> from,
                 const Context& context);
  // Returns how many slabs every channel has at every level; 0 where some have more than others.
  [[nodiscard]] int32_t common_slabs() const;
  // Lets readers see an unfinished series: puts index, metadata and a root of it behind what is written,
  // durable before the root, and goes on. info: what is said of the series, a whole one of dims[3] frames and
  // of the layers of common_slabs(), completed as for finish.
  void show(VolumeInfo info, const Context& context);
  // The caller completes dims[3], last_layer (of all levels), times and statistics before finish; what
  // decides how samples are coded may not change any more.
  [[nodiscard]] VolumeInfo& info();
  // Writes index, metadata and roots and commits the sink.
  Bcc4Report finish(const Context& context);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// A file that exceeds one of them is refused before anything is allocated: Code::limit_exceeded. A writer
// makes no file whose layers, metadata or directory exceed them.
struct Bcc4Limits {
  uint64_t metadata_bytes = 64 << 20; // decoded
  uint64_t directory_bytes = 256 << 20;
  uint64_t bricks_per_layer = 16 << 20; // a layer holds 16 bytes for each
  int32_t planes = 16 << 20; // along an axis of space, and layers: some tables have a number for each
  uint32_t channels = 1024;
  uint32_t cached_pages = 64; // decoded index pages kept, each up to 3 MiB
  // Damaged chunks, and all chunks that a damaged index page may have listed, read as holes instead of
  // failing.
  bool salvage = false;
  // What cannot be read counts as holes, too.
  bool salvage_unreadable = false;
};

class Attempts;       // would_block.h
class UnchangedSlabs; // unchanged_slabs.h
struct ChunkData;     // a decoded chunk, chunk.h
class OpenTile;       // open_tile.h
struct ChunkRest;     // what of one is still to be decoded
struct ChunkScratch;

// What the values of bricks are relative to.
enum class RelativeTo : uint8_t { air, base };

// A place in the file that failed a check.
struct Bcc4Damage {
  Code code = Code::corrupt;
  std::string message;
  uint64_t offset = 0;
  int channel = -1;                         // -1: the whole file
  int level = 0;                            // whose layers and bricks these are
  int32_t first_layer = 0, last_layer = -1; // layers that cannot be read; none when last < first
  bool whole_layers = false;                // else only `brick`
  Int3 brick{};
};

struct Bcc4VerifyResult {
  uint64_t chunks = 0;
  uint64_t chunks_damaged = 0;
  uint64_t bytes_checked = 0;
  std::vector<Bcc4Damage> damage;
  std::vector<Bcc4Damage> unreadable; // places that no check came to, for they could not be read
  std::string survivors;              // what is whole, in words; empty where all is
};

// An open file. It is immutable but for its page cache; all calls may run concurrently.
class Bcc4Reader {
 public:
  // Reads the roots, the directory of index pages and the metadata.
  [[nodiscard]] static std::shared_ptr<Bcc4Reader> open(std::unique_ptr<ByteSource> source,
                                                        const Bcc4Limits& limits = {});
  ~Bcc4Reader();

  [[nodiscard]] const VolumeInfo& info() const;
  [[nodiscard]] const Bcc4Bytes& bytes() const;
  [[nodiscard]] uint64_t chunk_count() const;
  // Returns the bytes read from the source so far.
  [[nodiscard]] uint64_t bytes_read() const;
  // Reads bytes that nobody wants yet: throws WouldBlock where they are not there.
  void try_read(const ByteRange& range) const;
  // Returns up to how many unwanted bytes between two wanted ones are read with them.
  [[nodiscard]] uint64_t merge_gap() const;
  // Returns whether it was opened to salvage what can be decoded.
  [[nodiscard]] bool salvages() const;
  // Returns whether it goes on without what failed so: damage, or, if the limits say so, unreadable bytes.
  [[nodiscard]] bool goes_without(const Error& failure) const;
  // Returns whether a root record is damaged, by an interrupted append or otherwise; verify_all tells.
  [[nodiscard]] bool root_damaged() const;

  // Shares the index pages that another reader has in its cache, of the file before it grew.
  void take_over(const Bcc4Reader& older) const;
  // The chunks of one slab in `region`, by rising slot. Reads the index pages of the slab that are not
  // cached.
  [[nodiscard]] std::vector<Bcc4Chunk> chunks(const ChannelLevel& at, int32_t slab,
                                              const BrickBox& region = {}) const;
  // Returns where in the file the index of a slab is.
  [[nodiscard]] std::vector<ByteRange> index_pages(const ChannelLevel& at, int32_t slab) const;
  // The position of a slot in bricks, as in a BrickLayer of coset 0.
  [[nodiscard]] Int3 brick_position(uint32_t slot, int level = 0) const;
  // The smallest and the largest kept sample of a chunk, relative to air.
  [[nodiscard]] Range sample_range(const ChannelLevel& at, const Bcc4Chunk& chunk) const;
  // What decoding a tile takes from the memory budget while it lasts.
  [[nodiscard]] uint64_t decoding_bytes(const ChannelLevel& at, const Bcc4Chunk& tile) const;
  // The bytes of the chunks of a level, of all channels.
  [[nodiscard]] uint64_t level_bytes(int level) const;

  // The bytes of a chunk as the file holds them, padding included; their checksum has been verified.
  [[nodiscard]] std::vector<std::byte> stored_bytes(const Bcc4Chunk& chunk) const;
  // Decodes chunks of one channel and level in parallel; neighbours in the file are read together.
  [[nodiscard]] std::vector<std::shared_ptr<const ChunkData>>
  read_chunks(const ChannelLevel& at, std::span<const Bcc4Chunk> chunks, const Context& context) const;
  // Does the same; those whose bytes are not there yet are null, and `attempts` knows. Of each chunk the
  // first `layers` are wanted: it may have a rest. Chunks that are salvaged are decoded whole. Of tiles there
  // is what their bricks are made of.
  [[nodiscard]] std::vector<std::shared_ptr<const ChunkData>>
  read_chunks(const ChannelLevel& at, std::span<const Bcc4Chunk> chunks, const Context& context,
              Attempts& attempts, int layers = INT_MAX) const;
  // Decodes the rest of a chunk, as chunk.h says.
  [[nodiscard]] ChunkData finish_chunk(const ChunkRest& rest,
                                       const std::optional<std::array<std::span<const std::byte>, 2>>& before,
                                       ChunkScratch& scratch) const;
  // Returns the corrections of a source frame that are in one block; empty where there are none. Neither
  // these nor those below are cached; when salvaging, damaged ones are left out.
  [[nodiscard]] FrameResiduals residuals(int channel, uint64_t frame) const;
  // Return corrections in bricks: the table of a frame, by rising brick, and the voxels of one of its bricks.
  [[nodiscard]] std::vector<CorrectionBrick> correction_bricks(int channel, uint64_t frame) const;
  [[nodiscard]] ResidualList corrections(int channel, const CorrectionBrick& brick) const;
  // Calls body for each run of samples that are missing in a source frame. Damage throws, also when
  // salvaging.
  void mask_runs(int channel, uint64_t frame, const MaskRunBody& body) const;
  // A block of corrections, or a mask, as the file holds it, with zeros up to a multiple of 8; its checksum
  // is right. `what` names it in error texts.
  [[nodiscard]] std::vector<std::byte> stored_block(const BlockRef& block, std::string_view what) const;
  // The base of a channel's field (field_base.h), at all levels.
  [[nodiscard]] float base(int channel) const;
  // Returns what sites that are not stored hold, relative to that base.
  [[nodiscard]] float absent(int channel) const;
  // The brick of one layer of a chunk, 0 .. slab_layers - 1; null where all of it is air.
  [[nodiscard]] std::shared_ptr<const Brick> brick(const ChannelLevel& at, const ChunkData& data,
                                                   int layer_of_slab, RelativeTo to = RelativeTo::air) const;
  // The same in the form that takes least memory.
  [[nodiscard]] SampleBrick samples(const ChannelLevel& at, const ChunkData& data, int layer_of_slab,
                                    RelativeTo to = RelativeTo::air) const;
  // The same of a brick of a tile.
  [[nodiscard]] SampleBrick samples(const ChannelLevel& at, const OpenTile& tile, int brick,
                                    int layer_of_slab, RelativeTo to = RelativeTo::air) const;

  // Reads and checks everything; damage is listed, not thrown.
  [[nodiscard]] Bcc4VerifyResult verify_all(const Context& context) const;

 private:
  struct State;
  explicit Bcc4Reader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

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
  const std::string& coefficient_kernel() const override;

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
  void lose_neighbours(int channel, int32_t layer, const BrickBox& region, const Context& context,
                       BrickLayer& out) const;
  [[nodiscard]] std::string shown_kernel() const;
  // The slabs that it looks at for a layer, in a region that is wider than the layer's.
  [[nodiscard]] std::set<int32_t> slabs_beside(int32_t layer) const;

  std::shared_ptr<const Bcc4Reader> reader_;
  std::unique_ptr<Cache> cache_;
  RelativeTo to_;
  int level_;
};

} // namespace bccsplat

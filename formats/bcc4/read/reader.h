// SPDX-License-Identifier: Apache-2.0
// Reads a .bcc4 file chunk by chunk (formats/bcc4.md).
//
// A chunk is one 4D brick of one channel: the 16^3 bricks at one brick position in `slab_layers` consecutive
// layers.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/byte_range.h"
#include "base/context.h"
#include "base/files.h"
#include "formats/bcc4/coding/chunk_entry.h"
#include "formats/bcc4/coding/mask_runs.h"
#include "formats/bcc4/coding/residuals.h"
#include "formats/bcc4/correction_table.h"
#include "formats/bcc4/file_limits.h"
#include "formats/bcc4/info.h"
#include "points/brick.h"
#include "points/sample_layer.h"

namespace bccsplat {

class Attempts;   // would_block.h
struct ChunkData; // a decoded chunk, chunk.h
class OpenTile;   // open_tile.h
struct ChunkRest; // what of one is still to be decoded
struct ChunkScratch;
struct TileValues; // what samples of a linear tile are, tile_sums.h

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
  // Returns whether a copy of the root is read because the record itself is damaged; verify_all tells.
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
  // Does the same, and hands over each where it was decoded, with its place in `chunks`; not those whose
  // bytes are not there yet, which `attempts` knows. The first `layers` of each chunk are wanted: it may have
  // a rest. Chunks that are salvaged are decoded whole. Tiles come as what their bricks are made of.
  using TakeChunk = std::function<void(size_t, ChunkData&&)>;
  void read_chunks(const ChannelLevel& at, std::span<const Bcc4Chunk> chunks, const Context& context,
                   Attempts& attempts, int layers, const TakeChunk& take) const;
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
  // What the samples of a linear channel are made of.
  [[nodiscard]] TileValues tile_values(const ChannelLevel& at, RelativeTo to) const;
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

} // namespace bccsplat

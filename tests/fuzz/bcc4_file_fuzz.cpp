// SPDX-License-Identifier: Apache-2.0
// Opens fuzzed bytes as a .bcc4 file, decodes what can be decoded and verifies it.
#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/file_limits.h"
#include "formats/bcc4/read/reader.h"
#include "fuzz_target.h"
#include "sealed_file.h"

using namespace bccsplat;

namespace {

constexpr size_t largest_input = 64 << 10;

void read_masks(const Bcc4Reader& reader) {
  const auto& n = reader.info().lattice.dims;
  const auto voxels = uint64_t{n[0]} * n[1] * n[2];
  for (int channel = 0; channel < static_cast<int>(reader.info().channels.size()); ++channel)
    for (const uint64_t frame : {uint64_t{0}, uint64_t{n[3]} - 1})
      reader.mask_runs(channel, frame, [&](uint64_t begin, uint64_t end) {
        fuzz::expect(begin < end && end <= voxels, "a run beyond the frame");
      });
}

void decode(Bcc4Reader& reader, const Context& context) {
  const VolumeInfo& info = reader.info();
  for (int channel = 0; channel < static_cast<int>(info.channels.size()); ++channel) {
    for (const uint64_t frame : {uint64_t{0}, uint64_t{info.lattice.dims[3]} - 1}) {
      static_cast<void>(reader.residuals(channel, frame));
      for (const CorrectionBrick& brick : reader.correction_bricks(channel, frame))
        static_cast<void>(reader.corrections(channel, brick));
    }
    for (const int32_t slab : {0, 1, info.slabs() - 1}) {
      if (slab < 0 || slab >= info.slabs()) continue;
      std::vector<Bcc4Chunk> chunks = reader.chunks(channel, slab);
      if (chunks.size() > 64) chunks.resize(64);
      for (const auto& data : reader.read_chunks(channel, chunks, context))
        for (int m = 0; m < data->shape.layers; ++m)
          if (const auto brick = reader.brick(channel, *data, m))
            for (size_t r = 0; r < brick_rows && brick->hole; ++r)
              fuzz::expect(((*brick->hole)[r] & ~brick->kept[r]) == 0, "a hole that is not kept");
    }
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size > largest_input) return 0;
  const std::vector<std::byte> file = fuzz::sealed_file({data, size});
  Tasks tasks(1);
  MemoryBudget memory(256 << 20);
  Progress progress;
  const Context context{tasks, memory, progress};
  const Bcc4Limits limits{.metadata_bytes = 1 << 20,
                          .directory_bytes = 1 << 20,
                          .bricks_per_layer = 1 << 12,
                          .channels = 16,
                          .cached_pages = 4};
  try {
    const auto reader = Bcc4Reader::open(open_memory_source(file), limits);
    const Bcc4VerifyResult result = reader->verify_all(context);
    try {
      decode(*reader, context);
      read_masks(*reader);
    } catch (const Error&) {
      fuzz::expect(!result.damage.empty(), "a file that verifies must decode");
    }
    // What is damaged is missing; nothing else changes.
    Bcc4Limits salvaging = limits;
    salvaging.salvage = true;
    try {
      decode(*Bcc4Reader::open(open_memory_source(file), salvaging), context);
    } catch (const Error& e) {
      fuzz::expect(e.code() == Code::limit_exceeded, "salvaging must not fail");
    }
  } catch (const Error& e) {
    fuzz::expect(e.code() != Code::internal && !e.message().empty(), "an error without a cause");
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/counts.h"

#include <algorithm>

#include "formats/bcc4/correction_table.h"
#include "formats/bcc4/page.h"

namespace bccsplat {
namespace {

constexpr uint64_t least_chunk_bytes = 8; // with its zeros
constexpr uint64_t varint_bytes = 10;     // at most

// Sizes of blocks have 32 bits.
uint64_t bytes_of(uint64_t count, uint64_t each) { return std::min<uint64_t>(count, UINT32_MAX) * each; }

void check_room(const ByteReader& in, std::string_view what, uint64_t count, uint64_t each) {
  if (count > in.remaining() / each)
    fail(Code::corrupt, "metadata: ", count, " ", what, " in ", in.remaining(), " bytes");
}

} // namespace

size_t read_count(ByteReader& in, std::string_view what, uint64_t each, uint64_t most) {
  const auto count = in.read<uint32_t>();
  if (count > most) fail(Code::corrupt, "metadata: ", count, " ", what, ", there are at most ", most);
  check_room(in, what, count, each);
  return count;
}

size_t read_count(ByteReader& in, std::string_view what, uint64_t each, const OneForEach& list) {
  const auto count = in.read<uint32_t>();
  if (count != 0 && count != list.all)
    fail(Code::corrupt, "metadata: ", count, " ", what, " for ", list.all, " ", list.of);
  check_room(in, what, count, each);
  return count;
}

void check_planes_and_layers(const Lattice4& l, const std::string& name, Code code) {
  const auto bad = [&](const auto&... why) { fail(code, name, ": ", why...); };
  for (size_t a = 0; a < 4; ++a) {
    const double distance = a < 3 ? l.space_step[a] : l.time_step;
    if (a == 3 && l.is_static()) continue;
    if (!(distance >= least_distance && distance <= most_distance))
      bad(a < 3 ? "distance of planes " : "distance of layers ", distance, " on axis ", a, ", not ",
          least_distance, " .. ", most_distance);
  }
  // The last plane of an axis with several samples follows from its distance.
  for (size_t a = 0; a < 3; ++a)
    if (l.dims[a] == 1 && l.space.last[a] > most_beyond)
      bad("last plane ", l.space.last[a], " on axis ", a, ", which has one sample");
  if (l.is_static() || l.periodic) return;
  if ((l.last_layer - l.lead - most_beyond) * l.time_step > l.dims[3])
    bad("layer ", l.last_layer, " stands at frame ", l.layer_frame(l.last_layer), ", the last frame is ",
        l.dims[3] - 1);
}

void check_index_counts(const Root& root) {
  // Each chunk has a byte of runs and one of values at least, each page a chunk.
  const uint64_t most =
      std::min({root.runs_bytes, root.values_bytes, (root.file_bytes - preamble_bytes) / least_chunk_bytes});
  if (root.chunks > most)
    fail(Code::corrupt, "root record: ", root.chunks, " chunks of ", root.runs_bytes, " and ",
         root.values_bytes, " bytes in a file of ", root.file_bytes);
  if (root.directory.decoded / page_ref_bytes > root.chunks)
    fail(Code::corrupt, "index directory at offset ", root.directory.offset, ": ",
         root.directory.decoded / page_ref_bytes, " pages of ", root.chunks, " chunks");
}

uint64_t most_run_bytes(uint64_t sites, uint64_t kept, uint64_t holes) {
  return sites + 1 + (holes > 0 ? kept + 1 : 0);
}

uint64_t most_correction_bytes(uint64_t samples) {
  return 2 * sizeof(uint32_t) + bytes_of(samples, 2 * varint_bytes);
}

uint64_t most_table_bytes(uint64_t bricks) { return sizeof(uint32_t) + bytes_of(bricks, table_entry_bytes); }

void check_block_ref(const BlockRef& ref, std::string_view what, uint64_t file_bytes, uint64_t most) {
  check_block_ref(ref, what, file_bytes);
  if (ref.decoded > most)
    fail(Code::corrupt, what, " at offset ", ref.offset, ": ", ref.decoded, " bytes, at most ", most,
         " have a meaning");
}

} // namespace bccsplat

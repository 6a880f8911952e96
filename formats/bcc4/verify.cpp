#include <algorithm>
#include <mutex>
#include <utility>

#include "formats/bcc4/explain.h"
#include "formats/bcc4/reader_state.h"

namespace bccsplat {
namespace {

struct Extent {
  uint64_t offset, end;
};

struct Totals {
  uint64_t kept = 0, holes = 0;
  uint32_t min_code = UINT32_MAX, max_code = 0;
};

} // namespace

Bcc4VerifyResult Bcc4Reader::verify_all(const Context& context) const {
  const State& s = *state_;
  const VolumeInfo& info = s.info;
  Bcc4VerifyResult result;
  result.bytes_checked = preamble_bytes + s.root.metadata.padded() + s.root.directory.padded();
  const auto file_damage = [&](Code code, std::string message, uint64_t offset) {
    Bcc4Damage d;
    d.code = code, d.message = std::move(message), d.offset = offset;
    result.damage.push_back(std::move(d));
  };
  if (s.root_damaged)
    file_damage(Code::checksum_mismatch,
                "one of the two root records is damaged, or an append was interrupted", root_offsets[0]);

  std::vector<Extent> extents{{s.root.metadata.offset, s.root.metadata.offset + s.root.metadata.padded()},
                              {s.root.directory.offset, s.root.directory.offset + s.root.directory.padded()}};
  for (size_t c = 0; c < info.channels.size(); ++c)
    for (uint64_t f = 0; f < info.channels[c].residuals.frames.size(); ++f) {
      const BlockRef& ref = info.channels[c].residuals.frames[f];
      if (ref.stored == 0) continue;
      result.bytes_checked += ref.padded();
      extents.push_back({ref.offset, ref.offset + ref.padded()});
      try {
        static_cast<void>(residuals(static_cast<int>(c), f));
      } catch (const Error& e) {
        file_damage(e.code(), e.message(), ref.offset);
      }
    }
  std::vector<Totals> totals(info.channels.size());
  uint64_t runs = 0, values = 0;
  const auto last_of = [&](int32_t slab) {
    return std::min((slab + 1) * info.slab_layers, info.lattice.layers()) - 1;
  };
  for (size_t p = 0; p < s.pages.size(); ++p) {
    context.progress.report(static_cast<double>(p) / static_cast<double>(s.pages.size()));
    const PageRef& ref = s.pages[p];
    const auto channel = static_cast<int>(ref.channel);
    result.chunks += ref.entries;
    result.bytes_checked += ref.block.padded();
    extents.push_back({ref.block.offset, ref.block.offset + ref.block.padded()});
    std::shared_ptr<const Page> page;
    try {
      page = s.load_page(p);
    } catch (const Error& e) {
      result.chunks_damaged += ref.entries;
      result.damage.push_back({e.code(),
                               e.message(),
                               ref.block.offset,
                               channel,
                               ref.first_slab * info.slab_layers,
                               last_of(ref.last_slab),
                               true,
                               {}});
      continue;
    }
    std::mutex mutex;
    const std::vector<ChunkGroup> groups = group_chunks(*page);
    context.tasks.parallel_for(groups.size(), [&](uint64_t g) {
      context.progress.check();
      ChunkScratch scratch;
      for (const size_t i : groups[g].members) {
        const Bcc4Chunk& c = (*page)[i];
        try {
          std::vector<std::byte> stored(c.stored());
          s.read(c.offset, stored);
          static_cast<void>(s.decode(channel, c, stored, scratch));
        } catch (const Error& e) {
          const std::scoped_lock lock(mutex);
          ++result.chunks_damaged;
          result.damage.push_back({e.code(), e.message(), c.offset, channel, c.slab * info.slab_layers,
                                   last_of(c.slab), false, slot_brick(s.slots, c.slot)});
        }
      }
    });
    Totals& t = totals[ref.channel];
    for (const Bcc4Chunk& c : *page) {
      extents.push_back({c.offset, c.offset + c.stored()});
      result.bytes_checked += c.stored();
      runs += c.runs_bytes, values += c.values_bytes;
      t.kept += c.kept, t.holes += c.holes;
      t.min_code = std::min(t.min_code, c.min_code), t.max_code = std::max(t.max_code, c.max_code);
    }
  }
  const bool pages_whole = std::none_of(result.damage.begin(), result.damage.end(),
                                        [](const Bcc4Damage& d) { return d.whole_layers; });
  std::stable_sort(result.damage.begin(), result.damage.end(),
                   [](const Bcc4Damage& a, const Bcc4Damage& b) { return a.offset < b.offset; });

  std::sort(extents.begin(), extents.end(),
            [](const Extent& a, const Extent& b) { return a.offset < b.offset; });
  uint64_t end = preamble_bytes, unused = 0;
  for (const Extent& e : extents) {
    if (e.offset < end && e.end > e.offset)
      file_damage(Code::corrupt, concat("two parts share the bytes at offset ", e.offset), e.offset);
    unused += e.offset > end ? e.offset - end : 0;
    end = std::max(end, e.end);
  }
  unused += s.root.file_bytes - end;
  if (pages_whole) {
    if (unused != s.bytes.unused || runs != s.root.runs_bytes || values != s.root.values_bytes)
      file_damage(Code::corrupt, "the root's sums of bytes differ from the index", root_offsets[0]);
    for (size_t c = 0; c < totals.size(); ++c) {
      const ChannelInfo& channel = info.channels[c];
      const Range range =
          totals[c].kept ? Range{s.coders[c].value(totals[c].min_code), s.coders[c].value(totals[c].max_code)}
                         : Range{};
      if (totals[c].kept != channel.sites_kept || totals[c].holes != channel.holes ||
          range != channel.kept_range)
        file_damage(Code::corrupt,
                    concat("channel ", channel.name, ": counts or range differ from the index"),
                    s.root.metadata.offset);
    }
  }
  for (Bcc4Damage& d : result.damage) d.message += describe_loss(info, d);
  if (!result.damage.empty()) result.survivors = describe_survivors(info, result.damage);
  context.progress.report(1);
  return result;
}

} // namespace bccsplat

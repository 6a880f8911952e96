// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/recorded_reads.h"

#include "base/would_block.h"

namespace bccsplat {

BrickLayer RecordedReads::read_layer(int channel, int32_t layer, const BrickBox& region,
                                     const Context& context) const {
  context.progress.check();
  const Lattice4& l = lattice();
  if (layer < 0 || layer >= l.layers()) fail(Code::out_of_domain, "no layer ", layer);
  {
    const std::scoped_lock lock(mutex_);
    reads_.insert({channel, layer, region.begin, region.end});
  }
  return {l.space, l.coset(layer)};
}

void RecordedReads::list(bool missing, std::vector<ByteRange>& out) const {
  const std::scoped_lock lock(mutex_);
  const int32_t slab_layers = samples_.reader().info().level(samples_.level()).slab_layers;
  Attempts attempts;
  // Salvaging looks at what lies beside a layer, too, and layers of a chunk may be missing one by one.
  const bool by_slabs = !missing && !samples_.reader().salvages();
  std::set<Read> listed;
  for (Read r : reads_) {
    if (by_slabs) // whose layers stand in the same chunks
      r.layer -= r.layer % slab_layers;
    if (listed.insert(r).second)
      attempts.attempt([&] { samples_.list_reads(r.channel, r.layer, {r.begin, r.end}, missing, out); });
  }
  attempts.throw_if_waiting();
}

} // namespace bccsplat

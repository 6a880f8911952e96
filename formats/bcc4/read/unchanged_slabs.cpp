// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/read/unchanged_slabs.h"

#include "formats/bcc4/same_coding.h"

namespace bccsplat {
namespace {

// Returns whether equal chunks of two files are the same samples.
bool same_meaning(const Bcc4Reader& a, const Bcc4Reader& b) {
  if (a.salvages() || b.salvages()) return false; // what is lost of one may be whole in the other
  if (!same_coding(a.info(), b.info())) return false;
  for (int c = 0; c < static_cast<int>(a.info().channels.size()); ++c)
    if (a.base(c) != b.base(c) || a.absent(c) != b.absent(c)) return false;
  return true;
}

} // namespace

UnchangedSlabs::UnchangedSlabs(const Bcc4Reader& older, const Bcc4Reader& newer)
    : older_(older), newer_(newer), comparable_(same_meaning(older, newer)) {}

bool UnchangedSlabs::slab(const ChannelLevel& at, int32_t slab) const {
  if (!comparable_) return false;
  const std::scoped_lock lock(mutex_);
  const auto key = std::pair(at, slab);
  if (const auto found = known_.find(key); found != known_.end()) return found->second;
  return known_[key] = compare(at, slab);
}

bool UnchangedSlabs::layer(const ChannelLevel& at, int32_t layer) const {
  return slab(at, older_.info().level(at.level).slab_of(layer));
}

bool UnchangedSlabs::compare(const ChannelLevel& at, int32_t slab) const {
  const StoredLattice &a = older_.info().level(at.level), &b = newer_.info().level(at.level);
  if (slab >= a.slabs() || slab >= b.slabs() || a.layers_of(slab) != b.layers_of(slab)) return false;
  return older_.chunks(at, slab) == newer_.chunks(at, slab);
}

} // namespace bccsplat

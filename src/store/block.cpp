// SPDX-License-Identifier: Apache-2.0
#include "store/block.h"

#include "base/error.h"

namespace bccsplat {

SeriesBlock block_in(const std::array<uint32_t, 4>& dims, const SeriesBlock& asked) {
  SeriesBlock block = asked;
  bool whole = true;
  for (size_t a = 0; a < 3; ++a) {
    if (block.end[a] == SeriesBlock::to_the_end) block.end[a] = dims[a];
    if (block.begin[a] >= block.end[a] || block.end[a] > dims[a])
      fail(Code::invalid_argument, "a block of samples ", block.begin[a], " to ", block.end[a],
           " (excluded) along ", "xyz"[a], ": the volume has ", dims[a], ", and a block has at least one");
    whole = whole && block.begin[a] == 0 && block.end[a] == dims[a];
  }
  return whole ? SeriesBlock::of_frames(block.first_frame(), block.end_frame()) : block;
}

void check_block(const WriterSettings& s) {
  const auto refuse = [](const auto&... why) { fail(Code::unsupported, "a block of space: ", why...); };
  if (s.wavelets)
    refuse("the steps of wavelets follow from all tiles of a slab; store samples, or divide the series by ",
           "frames");
  if (s.lowpass) refuse("lowpass holds whole frames; divide the series by frames, or leave it out");
  if (s.nonfinite == NonFinite::hole && !s.fixed_predictions)
    refuse("holes are filled from data however far away; set fixed_predictions, for all blocks alike, or ",
           "clamp what is not finite");
  if (s.measure == Measure::some)
    refuse(
        "measure SOME compares boxes that are picked from whole frames; choose ALL, or divide the series by ",
        "frames");
  if (s.turning[0] || s.turning[1] || s.turning[2])
    refuse("what follows the last sample of a periodic axis is far away; divide the series by frames");
  if (s.levels > 0 && !s.fixed_predictions)
    fail(Code::unsupported, "a block of space: frames are halved as their difference from the least of all ",
         "their samples; set fixed_predictions, for all blocks alike, or store no coarser levels");
  for (const ChannelSettings& c : s.channels)
    if (!c.source_type)
      fail(Code::invalid_argument, "channel ", c.name, ": a block may begin with air, which has no type; ",
           "give source_type");
}

void check_block_lattice(const WriterSettings& s, const Lattice4& lattice) {
  if (s.fixed_predictions || (lattice.lead == 0 && !lattice.has_margins())) return;
  fail(Code::unsupported, "a block of space: how boldly samples beyond faces and ends are predicted is ",
       "chosen by whole frames; set fixed_predictions, for all blocks alike, or ends and faces to MIRROR");
}

} // namespace bccsplat

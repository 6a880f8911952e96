// SPDX-License-Identifier: Apache-2.0
#include "store/fingerprint.h"

#include <array>
#include <span>
#include <string>

#include "base/text.h"
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/metadata.h"

namespace bccsplat {

std::string bounds_text(const WriterSettings& settings) {
  const double first = settings.channels.front().abs_error;
  std::string each;
  bool alike = true;
  for (const ChannelSettings& c : settings.channels) {
    each += concat(each.empty() ? "" : ",", c.abs_error);
    alike = alike && c.abs_error == first;
  }
  return alike ? concat(first) : each;
}

uint32_t options_checksum(const FitOptions& options, uint32_t levels, const std::string& bounds,
                          std::optional<double> psnr, const Rules& rules) {
  std::string text =
      concat("1 ", static_cast<int>(options.nonfinite), " ", bounds, " rules ", rules.resampling);
  if (rules.tiles > 1) text += concat(" of tiles ", rules.tiles);
  if (options.lowpass) text += " lowpass";
  if (options.masks) text += " masks";
  if (psnr) text += concat(" psnr ", *psnr);
  if (options.lead > 0) text += concat(" lead ", options.lead);
  if (levels > 0) text += " of halved frames";
  if (options.periodic) text += " periodic";
  if (options.fixed_predictions) text += " fixed predictions";
  if (options.fill.bounded()) text += concat(" fill ", options.fill.halvings);
  for (size_t a = 0; a < 3; ++a)
    if (options.turning[a]) text += concat(" periodic ", a);
  if (const Int3& m = options.margins; m != Int3{}) text += concat(" margins ", m[0], ' ', m[1], ' ', m[2]);
  for (const FitChannel& c : options.channels) {
    text += concat(" ", c.threshold, " ", c.ringing);
    if (c.range) text += concat(" ", c.range->low, " ", c.range->high);
  }
  return crc32_of(std::as_bytes(std::span(text)));
}

uint32_t part_checksum(uint32_t options, const FitPart& part) {
  const SeriesBlock& block = part.counted;
  const std::array<uint32_t, 3> sums{options, block.first_frame(), block.end_frame()};
  const uint32_t frames = crc32_of(std::as_bytes(std::span(sums)));
  return block.all_space() ? frames : frames ^ crc32_of(std::as_bytes(std::span(&block, 1)));
}

uint32_t series_checksum(VolumeInfo info, uint32_t options) {
  info.part.reset();
  for (ChannelInfo& c : info.channels) {
    ChannelInfo fixed;
    static_cast<Quantiser&>(fixed) = static_cast<const Quantiser&>(c);
    fixed.name = c.name, fixed.quantity = c.quantity, fixed.unit = c.unit;
    fixed.threshold = c.threshold, fixed.source_type = c.source_type;
    fixed.wavelet_error = c.wavelet_error, fixed.linear = c.linear;
    c = std::move(fixed);
  }
  for (LevelInfo& level : info.levels)
    for (LevelChannel& c : level.channels) c = {};
  tidy(info);
  const std::array<uint32_t, 2> sums{crc32_of(write_metadata(info)), options};
  return crc32_of(std::as_bytes(std::span(sums)));
}

} // namespace bccsplat

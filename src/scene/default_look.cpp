// SPDX-License-Identifier: Apache-2.0
#include "scene/default_look.h"

#include <algorithm>
#include <cmath>

#include "shade/gradient_noise.h"

namespace bccsplat {

TransferFunction default_function(const OpenVolume& volume, uint32_t channel, const Slice& slice,
                                  const RenderOptions& options) {
  TransferFunction f = look_function(survey_values(value_counts(volume, channel)), Look::automatic,
                                     options.surfaces.size() > 1 ? RenderMode::composite : options.mode);
  f.unit_distance = distance_of_look(volume, slice);
  return f;
}

namespace {

// The values of a slice's points in bins over the range of the channel.
class SliceCounts {
 public:
  SliceCounts(const Slice& slice, const ValueCounts& of_channel) : counts_(of_channel), base_(slice.base) {
    counts_.stored = counts_.source;
    counts_.bins.assign(part_bins, 0);
    counts_.air_sites = 0;
    for (const BrickLayer& layer : slice.coset)
      for (size_t s = 0; s < layer.brick_slots(); ++s)
        if (const Brick* b = layer.brick(s)) add(*b);
    if (slice.scattered)
      slice.scattered->each_point([&](const Vec3&, float value, float share) {
        if (share > least_share) add(value);
      });
  }
  [[nodiscard]] const ValueCounts& get() const { return counts_; }

 private:
  static constexpr size_t part_bins = 256;
  static constexpr float least_share = 0.5; // of a scattered point: it is near the slice

  void add(const Brick& brick) {
    for (int s = 0; s < brick_sites; ++s)
      if ((brick.kept[s / brick_edge] >> s % brick_edge & 1) && !brick.is_hole(s)) add(brick.value[s]);
  }
  void add(float value) {
    const Range& r = counts_.source;
    const double at = (base_ + static_cast<double>(value) - r.low) / (r.high - r.low) * part_bins;
    if (std::isfinite(at)) ++counts_.bins[static_cast<size_t>(std::clamp(at, 0.0, part_bins - 1.0))];
  }

  ValueCounts counts_;
  double base_;
};

} // namespace

ValueSurvey survey_of_slice(const OpenVolume& volume, const OpenSlice& slice, Look look) {
  const ValueCounts counts = value_counts(volume, slice.channel);
  ValueSurvey whole = survey_for(counts, look);
  if (slice.slice.is_time_slice()) return whole;
  return survey_part(whole, SliceCounts(slice.slice, counts).get());
}

double distance_of_look(const OpenVolume& volume, const Slice& slice) {
  if (slice.is_time_slice() && !one_sample_thick(slice)) return 0;
  const Vec3 samples = samples_across(slice);
  double frame = 1;
  for (size_t a = 0; a < 3; ++a) frame *= volume.info().lattice.dims[a];
  return mean_voxel(slice) * std::max(1.0, std::min({samples[0], samples[1], samples[2]})) / std::cbrt(frame);
}

GradientNoise noise_of(const OpenVolume& volume, const OpenSlice& slice, const std::optional<double>& asked) {
  return per_length(asked ? GradientNoise{*asked, 0} : channel_noise(volume, slice.channel),
                    mean_voxel(slice.slice));
}

} // namespace bccsplat

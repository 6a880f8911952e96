// SPDX-License-Identifier: Apache-2.0
// Between two depths at which a sample begins or ends, each sample absorbs evenly: its optical depth there is
// its share of -ln(1 - opacity). The sum of the shares absorbs what the picture absorbs, and each sample's
// colour has its part of the light. A surface is a sample without length, composited where it is met.
#include "scene/merge_deep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/grid.h"

namespace bccsplat {
namespace {

// An opaque sample's optical depth: nothing passes that a float would tell.
constexpr double most_depth = 40, least_passage = 1e-17;

struct Sample {
  double front, back, depth; // the last one optical
  std::array<double, 3> straight;
};

class PixelMerge {
 public:
  explicit PixelMerge(double depth_opacity) : passes_at_(1 - depth_opacity) {}
  void add(const float* sample) {
    const double opacity = sample[2];
    if (!(opacity > 0)) return;
    Sample s{sample[0], sample[1], std::min(-std::log1p(-opacity), most_depth), {}};
    for (size_t c = 0; c < 3; ++c) s.straight[c] = sample[3 + c] / opacity;
    samples_.push_back(s);
    ends_.push_back(s.front), ends_.push_back(s.back);
  }

  // Composites what was added front to back and begins anew.
  void finish(float* rgba, float* depth) {
    std::sort(samples_.begin(), samples_.end(),
              [](const Sample& a, const Sample& b) { return a.front < b.front; });
    std::sort(ends_.begin(), ends_.end());
    ends_.erase(std::unique(ends_.begin(), ends_.end()), ends_.end());
    passes_ = 1, color_ = {}, depth_ = std::numeric_limits<double>::infinity();
    size_t next = 0;
    active_.clear();
    for (size_t n = 0; n < ends_.size(); ++n) {
      const double at = ends_[n];
      std::erase_if(active_, [&](size_t s) { return samples_[s].back <= at; });
      for (; next < samples_.size() && samples_[next].front <= at; ++next) {
        const Sample& s = samples_[next];
        if (s.back > s.front)
          active_.push_back(next);
        else
          composite(s.depth, s.straight, at, at);
      }
      if (n + 1 < ends_.size() && !active_.empty()) composite_part(at, ends_[n + 1]);
    }
    for (size_t c = 0; c < 3; ++c) rgba[c] = static_cast<float>(color_[c]);
    rgba[3] = static_cast<float>(1 - passes_);
    if (depth) *depth = static_cast<float>(depth_);
    samples_.clear(), ends_.clear();
  }

 private:
  void composite_part(double from, double to) {
    double sum = 0;
    std::array<double, 3> color{};
    for (const size_t n : active_) {
      const Sample& s = samples_[n];
      const double part = s.depth * (to - from) / (s.back - s.front);
      sum += part;
      for (size_t c = 0; c < 3; ++c) color[c] += part * s.straight[c];
    }
    for (double& c : color) c /= sum;
    composite(sum, color, from, to);
  }
  void composite(double optical_depth, const std::array<double, 3>& straight, double from, double to) {
    const double share = -std::expm1(-optical_depth) * passes_;
    for (size_t c = 0; c < 3; ++c) color_[c] += share * straight[c];
    if (std::isinf(depth_) && share > 0 && passes_ - share <= passes_at_)
      depth_ = from + (to - from) * std::log(passes_ / std::max(passes_at_, least_passage)) / optical_depth;
    passes_ -= share;
  }

  std::vector<Sample> samples_;
  std::vector<double> ends_;
  std::vector<size_t> active_;
  double passes_at_; // of the light, at the depth of a pixel
  double passes_ = 1, depth_ = 0;
  std::array<double, 3> color_{};
};

} // namespace

void merge_deep(std::span<const DeepImage* const> pictures, double depth_opacity, const Context& context,
                Image& image) {
  context.tasks.parallel_for(static_cast<uint64_t>(image.height), [&](uint64_t row) {
    context.progress.check();
    PixelMerge merge(depth_opacity);
    const int y = static_cast<int>(row);
    for (int x = 0; x < image.width; ++x) {
      const size_t p = plane_index(x, y, image.width);
      for (const DeepImage* picture : pictures)
        for (uint64_t n = picture->first[p]; n < picture->first[p + 1]; ++n)
          merge.add(picture->samples.data() + n * DeepImage::components);
      merge.finish(image.rgba.at(x, y), image.depth.pixels ? image.depth.at(x, y) : nullptr);
    }
  });
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// A picture within a budget of time. A coarse one comes first: a quarter of the pixels along each side,
// draft, of a level that is enough for that. Then the slices of the complete picture are cut, and it is drawn
// band by band of rows; a call that follows goes on with the next band. A slice that takes longer to cut than
// a budget is given twice the time by each call, so that it is cut in the end.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "draw/smooth_edges.h"
#include "draw/stage_clock.h"
#include "scene/host_scene.h"
#include "scene/host_scene_parts.h"

namespace bccsplat {
namespace {

constexpr int coarse_pixels = 4; // along each side of a pixel of the first picture
// Rows of a band: what a splat reaches over is drawn twice where bands meet.
constexpr int fewest_rows = 8, most_rows = 32;
constexpr double least_ms = 2; // for cutting
// Parts of the work, for progress alone.
constexpr double coarse_share = 0.1, cut_share = 0.4;

using Clock = StageClock;

// FNV-1a, by whole numbers instead of bytes.
uint64_t hash_of(const RayEnds& ends, int width, int height) {
  constexpr uint64_t offset_basis = 0xcbf29ce484222325, prime = 0x100000001b3;
  uint64_t hash = offset_basis;
  for (int y = 0; ends.distance && y < height; ++y)
    for (int x = 0; x < width; ++x) {
      uint32_t bits;
      const float d = ends.at(x, y);
      std::memcpy(&bits, &d, sizeof bits);
      hash = (hash ^ bits) * prime;
    }
  return hash;
}

// Rows of an image, from `begin` on.
Image rows_of(const Image& image, int begin, int count) {
  Image part = image;
  part.height = count;
  for (Plane* plane : {&part.rgba, &part.depth, &part.value, &part.time})
    if (plane->pixels) plane->pixels = plane->at(0, begin);
  return part;
}

void copy_planes(const Image& from, const Image& to, int pixels) {
  const auto copy = [&](const Plane& source, const Plane& target) {
    if (!target.pixels) return;
    const size_t floats = static_cast<size_t>(source.components);
    for (int y = 0; y < to.height; ++y)
      for (int x = 0; x < to.width; ++x)
        std::copy_n(source.at(std::min(x / pixels, from.width - 1), std::min(y / pixels, from.height - 1)),
                    floats, target.at(x, y));
  };
  copy(from.rgba, to.rgba), copy(from.depth, to.depth), copy(from.value, to.value), copy(from.time, to.time);
}

uint64_t bytes_like(const Image& image, int width, int height) {
  uint64_t floats = 4; // a pixel
  for (const Plane* plane : {&image.depth, &image.value, &image.time}) floats += plane->pixels ? 1 : 0;
  return floats * sizeof(float) * plane_size(width, height);
}

std::unique_ptr<ImageStorage> like(const Image& image, int width, int height) {
  return std::make_unique<ImageStorage>(width, height, image.depth.pixels, image.value.pixels,
                                        image.time.pixels);
}

} // namespace

void HostScene::Frame::begin(const Image& image, const Context& context) {
  memory = {}; // gives its bytes back first
  memory = Reservation(context.memory, bytes_like(image, image.width, image.height),
                       "a picture that is drawn in several calls");
  done = like(image, image.width, image.height);
}

// How much of a call's time is left.
class HostScene::Budget {
 public:
  Budget(double ms, Clock::time_point start) : start_(start), ms_(ms) {}
  [[nodiscard]] double left() const { return ms_ - ms_since(start_); }
  [[nodiscard]] static Clock::time_point after(double ms) {
    return Clock::now() +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::milli>(ms));
  }

 private:
  Clock::time_point start_;
  double ms_;
};

// Cuts what is needed, for at most so many milliseconds; returns whether all of it is there.
bool HostScene::cut_within(double ms, std::span<const Need> shown, CutOf into, const Context& context,
                           SceneStats& stats) const {
  Progress until(context.progress, Budget::after(ms));
  try {
    for (const Need& need : shown) cut(need, need.placed->*into, context.with(until), stats);
  } catch (const Error& e) {
    if (e.code() != Code::cancelled) throw;
    context.progress.throw_if_cancelled(); // by the host
    return false;
  }
  return true;
}

// Draws the first picture of a view; returns whether there was time to cut what it is made of.
bool HostScene::draw_coarse(const ScenePicture& picture, const Sight& sight, double ms,
                            const Context& context, const Image& image, SceneStats& stats) {
  const int width = (image.width + coarse_pixels - 1) / coarse_pixels,
            height = (image.height + coarse_pixels - 1) / coarse_pixels;
  constexpr double middle = (coarse_pixels - 1) / 2.0;
  Sight coarse = sight;
  coarse.corner = sight.corner + (middle * sight.across + middle * sight.down);
  coarse.across = static_cast<double>(coarse_pixels) * sight.across;
  coarse.down = static_cast<double>(coarse_pixels) * sight.down;
  std::vector<float> ends;
  if (sight.ends.distance) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        ends.push_back(sight.ends.at(std::min(coarse_pixels * x + coarse_pixels / 2, image.width - 1),
                                     std::min(coarse_pixels * y + coarse_pixels / 2, image.height - 1)));
    coarse.ends = {ends.data(), static_cast<size_t>(width)};
  }
  ScenePicture draft = picture;
  draft.options.quality = Quality::draft, draft.options.sheet_step = 0, draft.options.smooth_edges = false;
  const std::vector<Need> shown = needs(coarse, draft.options, time_, width, height);
  if (!cut_within(ms, shown, &Placed::coarse, context, stats)) return false;
  const Reservation memory(context.memory, bytes_like(image, width, height), "a coarse picture");
  const auto small = like(image, width, height);
  draw(draft, shown, &Placed::coarse, context, small->image, stats);
  frame_->begin(image, context);
  copy_planes(small->image, frame_->done->image, coarse_pixels);
  return true;
}

// Copies rows of the picture so far to where the host sees them.
void HostScene::show_rows(int begin, int end, const Image& image, SceneStats& stats) const {
  if (begin == end) return;
  copy_planes(rows_of(frame_->done->image, begin, end - begin), rows_of(image, begin, end - begin), 1);
  image.tell_drawn({0, begin, image.width, end});
  stats.drew = true;
}

// Draws rows of the picture, with the rows beside them where edges are smoothed by these.
void HostScene::draw_band(const ScenePicture& picture, std::span<const Need> shown, int begin, int end,
                          const Context& context, const Image& image, SceneStats& stats) {
  const bool smoothed = picture.options.smooth_edges && picture.options.mode == RenderMode::isosurface;
  const int around = smoothed ? edge_reach : 0, first = std::max(begin - around, 0),
            last = std::min(end + around, image.height);
  std::vector<Need> of_band(shown.begin(), shown.end());
  for (Need& need : of_band) need.sight = need.sight.region(0, first);
  const Image rows = rows_of(frame_->done->image, begin, end - begin);
  if (!smoothed) {
    Image band = rows;
    return draw(picture, of_band, &Placed::fine, context, band, stats);
  }
  const Reservation memory(context.memory, bytes_like(image, image.width, last - first), "a band of rows");
  const auto wider = like(image, image.width, last - first);
  draw(picture, of_band, &Placed::fine, context, wider->image, stats);
  copy_planes(rows_of(wider->image, begin - first, end - begin), rows, 1);
}

// Draws bands of rows, one at least.
void HostScene::draw_bands(const ScenePicture& picture, std::span<const Need> shown, const Budget& budget,
                           const Context& context, const Image& image, SceneStats& stats) {
  Frame& frame = *frame_;
  const bool blank = !frame.done; // it begins without a coarse one
  if (blank) frame.begin(image, context), clear(frame.done->image);
  stats.progress = cut_share;
  const auto rows_in = [&](double ms) {
    return frame.row_ms > 0 ? static_cast<int>(std::clamp(ms / frame.row_ms, 0.0, 1.0 * most_rows)) : 0;
  };
  bool first = true;
  while (frame.rows < image.height && (first || rows_in(budget.left()) >= fewest_rows)) {
    const double before = budget.left();
    const int rows = std::min(std::max(rows_in(before), fewest_rows), image.height - frame.rows);
    draw_band(picture, shown, frame.rows, frame.rows + rows, context, image, stats);
    frame.rows += rows, first = false;
    frame.row_ms = (before - budget.left()) / rows;
    show_rows(frame.rows - rows, frame.rows, image, stats);
  }
  if (blank) show_rows(frame.rows, image.height, image, stats);
  stats.progress = cut_share + (1 - cut_share) * frame.rows / image.height;
}

void HostScene::draw_within(const ScenePicture& picture, const Sight& sight, std::span<const Need> shown,
                            Clock::time_point start, const Context& context, Image& image,
                            SceneStats& stats) {
  if (image.deep) fail(Code::unsupported, "scene: a deep picture has no budget");
  const Budget budget(picture.budget_ms, start);
  Frame& frame = *frame_;
  Frame::Key key{version_,
                 hash_of(sight.ends, image.width, image.height),
                 time_,
                 image.width,
                 image.height,
                 {image.depth.pixels != nullptr, image.value.pixels != nullptr, image.time.pixels != nullptr},
                 sight,
                 picture.options,
                 picture.gradient_noise};
  key.sight.ends = {};
  if (!frame.key || !(*frame.key == key)) {
    frame.forget();
    frame.key = key, frame.rows = 0, frame.allowance_ms = 0, frame.spent_ms = 0;
  }
  const bool was_complete = frame.done && frame.rows == image.height;
  stats.complete = false, stats.progress = 0;
  // Where a complete picture fits, a coarse one is not worth its time.
  const bool fits = frame.complete_ms && *frame.complete_ms < budget.left();
  if (!frame.done && !fits) {
    frame.allowance_ms = std::max({2 * frame.allowance_ms, budget.left(), least_ms});
    if (!draw_coarse(picture, sight, frame.allowance_ms, context, image, stats)) return;
    frame.allowance_ms = 0;
  }
  if (frame.done) show_rows(0, image.height, image, stats);
  stats.progress = frame.done ? coarse_share : 0;
  const auto after_coarse = Clock::now();
  if (!frame.done || budget.left() > 0 || stats.cut == 0) {
    const bool there = std::all_of(shown.begin(), shown.end(),
                                   [](const Need& need) { return need.ready(need.placed->fine); });
    if (!there) frame.allowance_ms = std::max({2 * frame.allowance_ms, budget.left(), least_ms});
    if (there || cut_within(frame.allowance_ms, shown, &Placed::fine, context, stats))
      draw_bands(picture, shown, budget, context, image, stats);
  }
  stats.complete = frame.done && frame.rows == image.height;
  frame.spent_ms += ms_since(after_coarse);
  if (stats.complete && !was_complete) frame.complete_ms = frame.spent_ms;
}

} // namespace bccsplat

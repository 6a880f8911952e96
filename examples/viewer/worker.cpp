// SPDX-License-Identifier: Apache-2.0
// Makes pictures in a thread of their own: waits for a wish that is newer than the picture under way, cancels
// that one, and draws first a draft and then the fine picture.
#include "viewer/worker.h"

#include "viewer/palette.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace viewer {
namespace {

uint32_t srgb_byte(float linear) {
  const float v = std::clamp(linear, 0.f, 1.f);
  const float s = v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
  return static_cast<uint32_t>(s * 255 + 0.5f);
}

} // namespace

void check(bccsplat_status status) {
  if (status == BCCSPLAT_CANCELLED) throw Cancelled{};
  bccsplat::client::check(status);
}

Worker::Worker(bccsplat_device* device, const bccsplat_volume* volume, std::array<double, 2> range)
    : device_(device), volume_(volume), range_(range) {
  bccsplat_cancel_token* t = nullptr;
  check(bccsplat_cancel_token_create(&t));
  token_.reset(t);
  bccsplat_renderer* r = nullptr;
  check(bccsplat_renderer_create(device, &r));
  renderer_.reset(r);
  auto info = sized<bccsplat_volume_info>();
  check(bccsplat_volume_get_info(volume, &info));
  coarsest_ = info.level_count;
  thread_ = std::thread([this] { run(); });
}

Worker::~Worker() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
    (void)bccsplat_cancel_token_cancel(token_.get());
  }
  changed_.notify_all();
  thread_.join();
}

bool Worker::wish(const Wish& wish) {
  {
    const std::scoped_lock lock(mutex_);
    if (wish == wish_) return false;
    wish_ = wish;
    newer_ = true;
    (void)bccsplat_cancel_token_cancel(token_.get());
  }
  changed_.notify_all();
  return true;
}

std::unique_ptr<Picture> Worker::take() {
  const std::scoped_lock lock(mutex_);
  return std::move(picture_);
}

void Worker::run() {
  for (;;) {
    Wish wish;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stop_ || newer_; });
      if (stop_) return;
      wish = wish_;
      newer_ = false;
      (void)bccsplat_cancel_token_reset(token_.get());
    }
    try {
      draw(wish, false);
      if (!wish.playing) draw(wish, true);
    } catch (const Cancelled&) {
      ++counts_.cancelled;
    } catch (const std::exception& e) {
      const std::scoped_lock lock(mutex_);
      picture_ = std::make_unique<Picture>();
      picture_->error = e.what();
    }
  }
}

void Worker::cut(const Wish& wish, uint32_t level) {
  if (slice_is_made_ && wish.frame == drawn_.frame && wish.tilt == drawn_.tilt && level == level_) return;
  auto info = sized<bccsplat_volume_info>();
  check(bccsplat_volume_get_info(volume_, &info));
  // t = frame + sum of tilt (x - centre) / (n - 1).
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -wish.frame;
  double* const normal[] = {&plane.a, &plane.b, &plane.c};
  for (size_t a = 0; a < 3; ++a) {
    if (info.dims[a] < 2) continue;
    const double last = static_cast<double>(info.dims[a] - 1);
    *normal[a] = -wish.tilt[a] / last;
    plane.e += wish.tilt[a] / 2;
  }
  auto options = sized<bccsplat_slice_options>();
  options.level = level;
  options.cancel_token = token_.get();
  bccsplat_slice* slice = nullptr;
  slice_is_made_ = false;
  check(bccsplat_slice_create(volume_, &plane, &options, &slice));
  slice_.reset(slice);
  check(bccsplat_renderer_set_slice(renderer_.get(), slice));
  slice_is_made_ = true, level_ = level;
  drawn_.frame = wish.frame, drawn_.tilt = wish.tilt;
}

bccsplat_camera Worker::camera(const Wish& wish) const {
  auto camera = sized<bccsplat_camera>();
  check(bccsplat_slice_fit_camera(slice_.get(), BCCSPLAT_PROJECTION_ORTHOGRAPHIC, wish.rotate_x,
                                  wish.rotate_y, wish.width, wish.height, &camera));
  camera.ortho_height /= wish.zoom;
  return camera;
}

uint32_t Worker::level(const Wish& wish, const bccsplat_camera& camera,
                       const bccsplat_render_options& options) const {
  auto needs = sized<bccsplat_picture_needs>();
  check(bccsplat_slice_get_picture_needs(slice_.get(), &camera, wish.width, wish.height, &options, &needs));
  return needs.level;
}

// Time slices only: of others nothing is kept. What fails here is told by the slice itself.
void Worker::look_ahead(const Wish& wish) {
  if (!wish.playing || wish.tilt != std::array<double, 3>{}) return;
  if (ahead_.valid() && ahead_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  ahead_ = std::async(std::launch::async, [volume = volume_, frame = wish.frame + wish.step, level = level_] {
    auto plane = sized<bccsplat_hyperplane>();
    plane.d = 1, plane.e = -frame;
    auto options = sized<bccsplat_slice_options>();
    options.level = level;
    (void)bccsplat_volume_prefetch(volume, &plane, &options);
  });
}

void Worker::classify(const Wish& wish) {
  std::vector<double> colors, opacities;
  for (int i = 0; i < curve_points; ++i) {
    const double f = static_cast<double>(i) / (curve_points - 1),
                 value = range_[0] + f * (range_[1] - range_[0]);
    const auto rgb = palette_color(wish.palette, f);
    colors.insert(colors.end(), {value, rgb[0], rgb[1], rgb[2]});
    opacities.insert(opacities.end(), {value, static_cast<double>(wish.opacity[i])});
  }
  auto function = sized<bccsplat_transfer_function>();
  function.color_count = function.opacity_count = curve_points;
  function.colors = colors.data(), function.opacities = opacities.data();
  check(bccsplat_renderer_set_transfer_function(renderer_.get(), &function));
}

// The renderer copies the surfaces; the options without them say enough of what a picture needs.
void Worker::set_options(const Wish& wish, bccsplat_render_options& options) {
  std::vector<bccsplat_iso_surface> surfaces;
  for (const Surface& s : wish.surfaces) {
    bccsplat_iso_surface& made = surfaces.emplace_back();
    made.value = s.value, made.opacity = s.opacity, made.use_color = s.colored ? 1 : 0;
    std::copy(s.color.begin(), s.color.end(), made.color);
  }
  if (wish.iso && !surfaces.empty()) {
    options.mode = BCCSPLAT_MODE_ISOSURFACE;
    options.set_mask = BCCSPLAT_RENDER_SET_ISO, options.iso_value = surfaces.front().value;
    options.surfaces = surfaces.data(), options.surface_count = static_cast<uint32_t>(surfaces.size());
  }
  check(bccsplat_renderer_set_options(renderer_.get(), &options));
  options.surfaces = nullptr, options.surface_count = 0;
}

void Worker::draw(const Wish& wish, bool fine) {
  const bool time_slice = wish.tilt == std::array<double, 3>{};
  auto options = sized<bccsplat_render_options>();
  options.quality = fine ? BCCSPLAT_QUALITY_FINE : BCCSPLAT_QUALITY_DRAFT;
  options.cancel_token = token_.get();
  set_options(wish, options);
  // A slice of any level and moment tells what the picture needs; the coarsest is there at once.
  if (!slice_is_made_ || wish.tilt != drawn_.tilt) cut(wish, time_slice ? coarsest_ : 0);
  const bccsplat_camera seen_by = camera(wish);
  cut(wish, time_slice ? level(wish, seen_by, options) : 0);
  check(bccsplat_renderer_set_camera(renderer_.get(), &seen_by));
  look_ahead(wish);
  classify(wish);
  drawn_ = wish;
  auto picture = std::make_unique<Picture>();
  picture->wish = wish;
  picture->width = wish.width, picture->height = wish.height, picture->fine = fine;
  picture->slice = sized<bccsplat_slice_info>();
  check(bccsplat_slice_get_info(slice_.get(), &picture->slice));

  const uint32_t width = wish.width, height = wish.height;
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -wish.trail_frames;
  check(bccsplat_renderer_set_trail(renderer_.get(), wish.trail && time_slice ? &trail : nullptr));
  std::vector<float>& rgba = picture->rgba;
  rgba.resize(size_t{width} * height * 4);
  bccsplat_frame* f = nullptr;
  check(bccsplat_frame_wrap(device_, width, height, rgba.data(), 0, &f));
  picture->frame.reset(f);
  check(bccsplat_renderer_render(renderer_.get(), f));
  picture->stats = sized<bccsplat_render_stats>();
  check(bccsplat_renderer_get_stats(renderer_.get(), &picture->stats));

  picture->pixels.resize(size_t{width} * height);
  for (size_t i = 0; i < picture->pixels.size(); ++i) // premultiplied: over black as it is
    picture->pixels[i] = srgb_byte(rgba[4 * i]) | srgb_byte(rgba[4 * i + 1]) << 8 |
                         srgb_byte(rgba[4 * i + 2]) << 16 | 0xff000000u;
  ++(fine ? counts_.fine : counts_.drafts);
  const std::scoped_lock lock(mutex_);
  picture_ = std::move(picture);
}

} // namespace viewer

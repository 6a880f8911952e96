// SPDX-License-Identifier: Apache-2.0
// Makes pictures in a thread of their own: waits for a wish that is newer than the picture under way, cancels
// that one, and draws: moments by a scene, a little at a time, until the fine picture is complete; other
// planes and trails by a renderer, first a draft.
#include "viewer/worker.h"

#include <algorithm>
#include <cmath>

namespace viewer {
namespace {

// What a call to a scene may take: newer wishes are heard of between two.
constexpr double budget_ms = 40;

uint32_t srgb_byte(float linear) {
  const float v = std::clamp(linear, 0.f, 1.f);
  const float s = v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
  return static_cast<uint32_t>(s * 255 + 0.5f);
}

} // namespace

Worker::Worker(bccsplat_device* device, const bccsplat_volume* volume, std::array<double, 2> range)
    : device_(device), volume_(volume), range_(range), scene_(device, volume, range) {
  bccsplat_cancel_token* t = nullptr;
  check(bccsplat_cancel_token_create(&t));
  token_.reset(t);
  bccsplat_renderer* r = nullptr;
  check(bccsplat_renderer_create(device, &r));
  renderer_.reset(r);
  auto info = sized<bccsplat_volume_info>();
  check(bccsplat_volume_get_info(volume, &info));
  coarsest_ = info.level_count;
  reader_ = std::make_unique<Reader>([this](const Wish& w) { scene_.read(w); },
                                     [this] {
                                       {
                                         const std::scoped_lock lock(mutex_);
                                         newer_ = true; // the wish that waits for it
                                       }
                                       changed_.notify_all();
                                     });
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
  reader_.reset(); // before what it reads for
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
      if (wish.of_scene()) {
        draw_scene(wish);
        continue;
      }
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
  options.space = BCCSPLAT_SPACE_EVEN; // what is drawn stands where its coordinates say
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
  if (wish.upright()) return scene_.camera(wish);
  // All of a tilted plane, in a world of its own: what a function shows that hides nothing.
  const double color[] = {0, 1, 1, 1}, opacity[] = {0, 1};
  auto everything = sized<bccsplat_transfer_function>();
  everything.color_count = everything.opacity_count = 1;
  everything.colors = color, everything.opacities = opacity;
  double box[6];
  check(bccsplat_slice_get_seen_bounds(slice_.get(), &everything, box));
  return camera_of_box(wish, BCCSPLAT_SIDE_FRONT, box);
}

uint32_t Worker::level(const Wish& wish, const bccsplat_camera& camera,
                       const bccsplat_render_options& options) const {
  auto needs = sized<bccsplat_picture_needs>();
  check(bccsplat_slice_get_picture_needs(slice_.get(), &camera, wish.width, wish.height, &options, &needs));
  return needs.level;
}

std::unique_ptr<Picture> Worker::begin(const Wish& wish, bool fine) const {
  auto picture = std::make_unique<Picture>();
  picture->wish = wish;
  picture->width = wish.width, picture->height = wish.height, picture->fine = fine;
  picture->rgba.resize(static_cast<size_t>(wish.width) * static_cast<size_t>(wish.height) * 4);
  bccsplat_frame* f = nullptr;
  check(bccsplat_frame_wrap(device_, wish.width, wish.height, picture->rgba.data(), 0, &f));
  picture->frame.reset(f);
  return picture;
}

void Worker::show(std::unique_ptr<Picture> picture) {
  const std::vector<float>& rgba = picture->rgba;
  picture->pixels.resize(rgba.size() / 4);
  for (size_t i = 0; i < picture->pixels.size(); ++i) // premultiplied: over black as it is
    picture->pixels[i] = srgb_byte(rgba[4 * i]) | srgb_byte(rgba[4 * i + 1]) << 8 |
                         srgb_byte(rgba[4 * i + 2]) << 16 | 0xff000000u;
  ++(picture->fine ? counts_.fine : counts_.drafts);
  const std::scoped_lock lock(mutex_);
  picture_ = std::move(picture);
}

void Worker::draw_scene(const Wish& wish) {
  if (wish.playing) return draw_playing(wish);
  played_.reset();
  const Options of(wish, BCCSPLAT_QUALITY_FINE, token_.get());
  scene_.apply(wish);
  auto status = sized<bccsplat_scene_status>();
  do {
    auto picture = begin(wish, false);
    status = scene_.draw(wish, of.options, budget_ms, picture->frame.get());
    if (status.progress == 0) continue; // nothing is there yet
    picture->fine = status.complete;
    picture->scene = status;
    show(std::move(picture));
  } while (!status.complete);
}

void Worker::draw_playing(const Wish& wish) {
  if (!reader_->has(wish)) return draw_meanwhile(wish);
  draw_draft(wish);
  Wish next = wish;
  next.frame += wish.step;
  reader_->look_ahead(next);
}

void Worker::draw_meanwhile(const Wish& wish) {
  if (!played_) return;
  Wish still = wish;
  still.frame = played_->frame, still.step = played_->step;
  if (still != *played_) draw_draft(still);
}

void Worker::draw_draft(const Wish& wish) {
  const Options of(wish, BCCSPLAT_QUALITY_DRAFT, token_.get());
  scene_.apply(wish);
  auto picture = begin(wish, false);
  picture->scene = scene_.draw(wish, of.options, 0, picture->frame.get());
  counts_.waited_for += picture->scene.bytes_read;
  counts_.by_gpu = picture->scene.backend == BCCSPLAT_BACKEND_GPU;
  played_ = wish;
  show(std::move(picture));
}

void Worker::draw(const Wish& wish, bool fine) {
  const Options of(wish, fine ? BCCSPLAT_QUALITY_FINE : BCCSPLAT_QUALITY_DRAFT, token_.get());
  check(bccsplat_renderer_set_options(renderer_.get(), &of.options));
  // A slice of any level and moment tells what the picture needs; the coarsest is there at once.
  if (!slice_is_made_ || wish.tilt != drawn_.tilt) cut(wish, wish.upright() ? coarsest_ : 0);
  const bccsplat_camera seen_by = camera(wish);
  cut(wish, wish.upright() ? level(wish, seen_by, of.options) : 0);
  check(bccsplat_renderer_set_camera(renderer_.get(), &seen_by));
  // Other planes have a world of their own.
  const std::vector<bccsplat_clip> clips =
      wish.upright() ? clips_of(wish, scene_.box()) : std::vector<bccsplat_clip>();
  check(bccsplat_renderer_set_clips(renderer_.get(), clips.data(), clips.size()));
  const Look look(wish, range_);
  check(bccsplat_renderer_set_transfer_function(renderer_.get(), &look.function));
  drawn_ = wish;
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -wish.trail_frames;
  check(bccsplat_renderer_set_trail(renderer_.get(), wish.trail && wish.upright() ? &trail : nullptr));
  auto picture = begin(wish, fine);
  picture->slice = sized<bccsplat_slice_info>();
  check(bccsplat_slice_get_info(slice_.get(), &picture->slice));
  check(bccsplat_renderer_render(renderer_.get(), picture->frame.get()));
  picture->stats = sized<bccsplat_render_stats>();
  check(bccsplat_renderer_get_stats(renderer_.get(), &picture->stats));
  show(std::move(picture));
}

} // namespace viewer

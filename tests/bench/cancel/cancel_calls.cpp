// SPDX-License-Identifier: Apache-2.0
// The long calls of the C API, each on a series made for it: opening, slices, evaluation, pictures of all
// kinds, writing, joining.
#include "tests/bench/cancel/cancel_calls.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/bench/scale/scale_host.h"

namespace bccsplat::bench {
namespace {

using host::sized;

constexpr uint32_t frame_count = 8;

// Waves everywhere: no brick is empty.
std::vector<uint8_t> waves(uint32_t n, double frame) {
  std::vector<uint8_t> values(size_t{n} * n * n);
  std::vector<double> along(n), across(n);
  for (uint32_t i = 0; i < n; ++i)
    along[i] = std::sin(0.21 * i + 0.3 * frame), across[i] = std::cos(0.13 * i - 0.2 * frame);
  size_t at = 0;
  for (uint32_t z = 0; z < n; ++z)
    for (uint32_t y = 0; y < n; ++y)
      for (uint32_t x = 0; x < n; ++x)
        values[at++] = static_cast<uint8_t>(
            std::lround(127 + 60 * along[x] * across[y] + 60 * along[z] * across[(x + y) / 2]));
  return values;
}

bccsplat_hyperplane plane_of(double a, double b, double c, double d, double e) {
  auto plane = sized<bccsplat_hyperplane>();
  plane.a = a, plane.b = b, plane.c = c, plane.d = d, plane.e = e;
  return plane;
}

host::Handle<bccsplat_volume> open(bccsplat_device* device, const std::string& path,
                                   bccsplat_cancel_token* token = nullptr) {
  auto options = sized<bccsplat_volume_options>();
  options.cancel_token = token;
  bccsplat_volume* volume = nullptr;
  const bccsplat_status status = bccsplat_volume_open_file(device, path.c_str(), &options, &volume);
  if (status != BCCSPLAT_CANCELLED) api(status);
  return host::Handle<bccsplat_volume>(volume);
}

} // namespace

LongCalls::LongCalls(uint32_t size, const std::string& folder, int threads)
    : size_(size), folder_(folder), device_(make_api_device(threads)) {
  for (uint32_t f = 0; f < frame_count; ++f) frames_.push_back(waves(size, f));
  auto options = sized<bccsplat_writer_options>();
  options.dims[3] = frame_count;
  api(write(folder_ + "/whole.bcc4", options, 0, frame_count));
  write_parts();
  volume_ = open(device_.get(), folder_ + "/whole.bcc4");
  const bccsplat_hyperplane plane = plane_of(0, 0, 0, 1, -3.4);
  bccsplat_slice* slice = nullptr;
  api(bccsplat_slice_create(volume_.get(), &plane, nullptr, &slice));
  slice_.reset(slice);
  add_readers();
  add_pictures();
  add_writers();
}

bccsplat_status LongCalls::write(const std::string& path, const bccsplat_writer_options& how, uint32_t first,
                                 uint32_t end) const {
  bccsplat_writer_options options = how;
  for (int a = 0; a < 3; ++a) options.dims[a] = size_;
  options.lattice = BCCSPLAT_LATTICE_D4STAR, options.overwrite = 1;
  bccsplat_writer* made = nullptr;
  bccsplat_status status = bccsplat_writer_create(device_.get(), path.c_str(), &options, &made);
  const host::Handle<bccsplat_writer> writer(made);
  for (uint32_t f = first; f < end && status == BCCSPLAT_OK; ++f) {
    auto box = sized<bccsplat_box>();
    box.type = BCCSPLAT_TYPE_U8, box.data = frames_[f].data();
    for (int64_t& n : box.dims) n = size_;
    status = bccsplat_writer_add_frame(made, 0, f, &box, 1);
  }
  return status == BCCSPLAT_OK ? bccsplat_writer_finish(made, nullptr) : status;
}

void LongCalls::write_parts() {
  std::vector<double> times(frame_count);
  for (uint32_t f = 0; f < frame_count; ++f) times[f] = f;
  for (uint32_t n = 0; n < 2; ++n) {
    auto part = sized<bccsplat_series_part>();
    part.first = n * frame_count / 2, part.end = (n + 1) * frame_count / 2, part.times = times.data();
    auto options = sized<bccsplat_writer_options>();
    for (int a = 0; a < 3; ++a) options.dims[a] = size_;
    options.dims[3] = frame_count, options.part = &part, options.overwrite = 1;
    options.lattice = BCCSPLAT_LATTICE_D4STAR;
    const std::string path = folder_ + "/part" + std::to_string(n) + ".bcc4";
    bccsplat_writer* writer = nullptr;
    api(bccsplat_writer_create(device_.get(), path.c_str(), &options, &writer));
    uint64_t begin = 0, end = 0;
    api(bccsplat_writer_get_part_frames(writer, &begin, &end));
    bccsplat_writer_release(writer);
    api(write(path, options, static_cast<uint32_t>(begin), static_cast<uint32_t>(end)));
  }
}

void LongCalls::add_readers() {
  const std::string path = folder_ + "/whole.bcc4";
  calls_.push_back({"open", nullptr, [this, path](bccsplat_cancel_token* token) {
                      return open(device_.get(), path, token) ? BCCSPLAT_OK : BCCSPLAT_CANCELLED;
                    }});
  const auto slice = [this, path](const char* name, const bccsplat_hyperplane& plane, double thickness,
                                  int32_t slab) {
    calls_.push_back({name, [this, path] { volume_ = open(device_.get(), path); },
                      [this, plane, thickness, slab](bccsplat_cancel_token* token) {
                        auto options = sized<bccsplat_slice_options>();
                        options.cancel_token = token, options.thickness = thickness, options.slab = slab;
                        bccsplat_slice* made = nullptr;
                        const auto status = bccsplat_slice_create(volume_.get(), &plane, &options, &made);
                        bccsplat_slice_release(made);
                        return status;
                      }});
  };
  const double middle = 0.5 * size_;
  slice("slice in time", plane_of(0, 0, 0, 1, -3.4), 0, 0);
  slice("slice in time, maximum", plane_of(0, 0, 0, 1, -3.4), 3, BCCSPLAT_SLAB_MAXIMUM);
  slice("slice x = constant", plane_of(1, 0, 0, 0, -middle), 0, 0);
  slice("oblique slice", plane_of(0.2, 0.1, 0, 1, -0.3 * middle - 3.4), 0, 0);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0, size_ - 1.0), moment(0, frame_count - 1.0);
  for (int i = 0; i < 4000000; ++i)
    points_.push_back(place(random)), points_.push_back(place(random)), points_.push_back(place(random)),
        points_.push_back(moment(random));
  values_.resize(std::max(size_t{size_} * size_ * size_ * 4, points_.size() / 4));
  const auto with_volume = [this, path](const char* name, std::function<bccsplat_status()> run) {
    calls_.push_back({name, nullptr, [this, path, run = std::move(run)](bccsplat_cancel_token* token) {
                        volume_ = open(device_.get(), path, token);
                        return volume_ ? run() : BCCSPLAT_CANCELLED;
                      }});
  };
  with_volume("evaluate scattered points", [this] {
    return bccsplat_volume_evaluate(volume_.get(), points_.size() / 4, points_.data(), values_.data(),
                                    nullptr);
  });
  with_volume("verify", [this] {
    auto report = sized<bccsplat_verify_report>();
    return bccsplat_volume_verify(volume_.get(), nullptr, nullptr, &report);
  });
  const auto with_slice = [this](const char* name, std::function<bccsplat_status(bccsplat_slice*)> run) {
    calls_.push_back({name, nullptr, [this, run = std::move(run)](bccsplat_cancel_token* token) {
                        const bccsplat_hyperplane plane = plane_of(0, 0, 0, 1, -3.4);
                        auto options = sized<bccsplat_slice_options>();
                        options.cancel_token = token;
                        bccsplat_slice* made = nullptr;
                        const auto status = bccsplat_slice_create(volume_.get(), &plane, &options, &made);
                        const host::Handle<bccsplat_slice> held(made);
                        return status == BCCSPLAT_OK ? run(made) : status;
                      }});
  };
  with_slice("sample_grid of a slice",
             [this](bccsplat_slice* s) { return bccsplat_slice_sample_grid(s, nullptr, values_.data()); });
  with_slice("evaluate on a slice", [this](bccsplat_slice* s) {
    return bccsplat_slice_evaluate(s, points_.size() / 4, points_.data(), values_.data(), nullptr);
  });
  with_slice("get_points of a slice", [this](bccsplat_slice* s) {
    return bccsplat_slice_get_points(s, values_.size() / 4, values_.data(),
                                     values_.data() + values_.size() / 4 * 3, nullptr);
  });
}

void LongCalls::add_pictures() {
  struct Picture {
    const char* name;
    uint32_t pixels;
    int32_t mode, quality;
    bool deep, trail;
  };
  constexpr uint32_t small = 256, large = 1024;
  for (const Picture& p :
       {Picture{"picture, small", small, 0, 0, false, false}, Picture{"picture", large, 0, 0, false, false},
        Picture{"picture, fine", large, 0, BCCSPLAT_QUALITY_FINE, false, false},
        Picture{"picture, deep", large, 0, 0, true, false},
        Picture{"picture, X-ray", large, BCCSPLAT_MODE_XRAY, 0, false, false},
        Picture{"picture, maximum", large, BCCSPLAT_MODE_MAXIMUM, 0, false, false},
        Picture{"picture, isosurface", large, BCCSPLAT_MODE_ISOSURFACE, 0, false, false},
        Picture{"picture, trail", large, 0, 0, false, true}})
    calls_.push_back({p.name,
                      [this] { // the points, too, are made within the call
                        const bccsplat_hyperplane plane = plane_of(0, 0, 0, 1, -3.4);
                        bccsplat_slice* made = nullptr;
                        api(bccsplat_slice_create(volume_.get(), &plane, nullptr, &made));
                        slice_.reset(made);
                      },
                      [this, p](bccsplat_cancel_token* token) {
                        bccsplat_renderer* r = nullptr;
                        api(bccsplat_renderer_create(device_.get(), &r));
                        const host::Handle<bccsplat_renderer> renderer(r);
                        bccsplat_frame* f = nullptr;
                        const uint32_t channels = BCCSPLAT_FRAME_RGBA | (p.deep ? BCCSPLAT_FRAME_DEEP : 0);
                        api(bccsplat_frame_create(device_.get(), p.pixels, p.pixels, channels, &f));
                        const host::Handle<bccsplat_frame> frame(f);
                        auto options = sized<bccsplat_render_options>();
                        options.mode = p.mode, options.quality = p.quality, options.cancel_token = token;
                        options.set_mask = BCCSPLAT_RENDER_SET_ISO, options.iso_value = 150;
                        api(bccsplat_renderer_set_slice(r, slice_.get()));
                        api(bccsplat_renderer_set_options(r, &options));
                        auto trail = sized<bccsplat_trail>();
                        trail.interval[0] = -2;
                        if (p.trail) api(bccsplat_renderer_set_trail(r, &trail));
                        return bccsplat_renderer_render(r, f);
                      }});
}

void LongCalls::add_writers() {
  const auto writer = [this](const char* name, const bccsplat_writer_options& how) {
    calls_.push_back({name, nullptr, [this, how](bccsplat_cancel_token* token) {
                        bccsplat_writer_options options = how;
                        options.cancel_token = token, options.dims[3] = frame_count;
                        return write(folder_ + "/new.bcc4", options, 0, frame_count);
                      }});
  };
  auto options = sized<bccsplat_writer_options>();
  writer("write", options);
  options.levels = 2;
  writer("write with levels", options);
  options.levels = 0, options.abs_error = 3;
  writer("write with a bound", options);
  calls_.push_back({"join parts", nullptr, [this](bccsplat_cancel_token* token) {
                      auto join = sized<bccsplat_join_options>();
                      join.overwrite = 1, join.cancel_token = token;
                      const std::string a = folder_ + "/part0.bcc4", b = folder_ + "/part1.bcc4";
                      const char* const parts[] = {a.c_str(), b.c_str()};
                      return bccsplat_join_parts(device_.get(), 2, parts, (folder_ + "/joined.bcc4").c_str(),
                                                 &join, nullptr);
                    }});
}

} // namespace bccsplat::bench

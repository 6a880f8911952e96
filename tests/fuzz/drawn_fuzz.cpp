// SPDX-License-Identifier: Apache-2.0
// Files that are changed part by part and sealed again, through all that a host does with one: they are
// verified, cut along every axis and obliquely, sampled frame by frame and drawn, from memory and as a page
// does it from a stream. What verifies is drawn; nothing takes memory beside the budget.
#include <bccsplat.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "changed_file.h"
#include "fuzz_target.h"
#include "sealed_file.h"

namespace {

constexpr size_t largest_input = 64 << 10;
constexpr uint64_t budget = 96 << 20;
constexpr uint32_t side = 24; // of pictures

template<class T> T sized() {
  T t{};
  t.struct_size = sizeof(T);
  return t;
}

bool is_damage(bccsplat_status status) {
  return status == BCCSPLAT_ERROR_CORRUPT || status == BCCSPLAT_ERROR_TRUNCATED ||
         status == BCCSPLAT_ERROR_CHECKSUM_MISMATCH;
}

// a x + b y + c z + d t + e = 0; around: of an interval of time. Slices of uneven axes are drawn in even
// positions.
struct Cut {
  std::array<double, 5> plane;
  double around = 0;
  uint32_t channel = 0, level = 0;
  bccsplat_space space = BCCSPLAT_SPACE_EVEN;
};

// One file, opened; everything that is asked of it has a status that says why not.
class Host {
 public:
  explicit Host(const std::vector<std::byte>& file) : file_(file) {
    auto o = sized<bccsplat_device_options>();
    o.thread_count = 1, o.memory_budget = budget;
    check(bccsplat_device_create(&o, &device_));
  }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;
  ~Host() {
    bccsplat_frame_release(frame_), bccsplat_renderer_release(renderer_), bccsplat_slice_release(slice_);
    bccsplat_volume_release(volume_), bccsplat_device_release(device_);
  }

  void open(bool as_stream, bool salvage) {
    bccsplat_slice_release(slice_), bccsplat_volume_release(volume_);
    slice_ = nullptr, volume_ = nullptr;
    auto o = sized<bccsplat_volume_options>();
    o.salvage = salvage;
    auto stream = sized<bccsplat_read_stream>();
    stream.size = file_.size(), stream.read_at = read_at, stream.user = this, stream.merge_gap = 256 << 10;
    check(as_stream ? bccsplat_volume_open_stream(device_, &stream, &o, &volume_)
                    : bccsplat_volume_open_memory(device_, file_.data(), file_.size(), &o, &volume_));
    salvages_ = salvage;
    if (!volume_) return;
    info_ = sized<bccsplat_volume_info>();
    check(bccsplat_volume_get_info(volume_, &info_));
  }
  [[nodiscard]] bool is_open() const { return volume_ != nullptr; }

  void verify() {
    auto report = sized<bccsplat_verify_report>();
    const bccsplat_status status = bccsplat_volume_verify(volume_, nullptr, nullptr, &report);
    check(status);
    whole_ = status == BCCSPLAT_OK && report.damages == 0;
  }

  // What `bcc4 info` and a page ask for first.
  void describe() {
    for (uint32_t c = 0; c < info_.channel_count; ++c) {
      auto channel = sized<bccsplat_channel_info>();
      check(bccsplat_volume_get_channel_info(volume_, c, &channel));
      auto look = sized<bccsplat_look>();
      check(bccsplat_volume_get_look(volume_, c, 0, 0, &look));
    }
    for (uint32_t a = 0; a < 3; ++a) {
      auto axis = sized<bccsplat_axis>();
      check(bccsplat_volume_get_axis(volume_, a, &axis));
    }
    for (uint32_t level = 0; level <= info_.level_count; ++level) {
      auto of = sized<bccsplat_level_info>();
      check(bccsplat_volume_get_level_info(volume_, level, &of));
    }
    std::vector<double> times(std::min<uint64_t>(info_.dims[3], 64));
    check(bccsplat_volume_get_times(volume_, times.data(), times.size(), nullptr));
  }

  void evaluate() {
    constexpr size_t count = 27;
    std::vector<double> at;
    for (size_t i = 0; i < count; ++i)
      for (size_t a = 0; a < 4; ++a)
        at.push_back((static_cast<double>(info_.dims[a]) - 1) * static_cast<double>((i * (a + 3)) % 7) / 6);
    std::vector<float> values(count), slopes(4 * count);
    for (uint32_t c = 0; c < std::min(info_.channel_count, 2u); ++c)
      check(bccsplat_volume_evaluate_channel(volume_, c, count, at.data(), values.data(), slopes.data()));
  }

  // Cuts, and reads what an export or the planes of a page read of it.
  void cut(const Cut& cut) {
    auto plane = sized<bccsplat_hyperplane>();
    const auto [a, b, c, d, e] = cut.plane;
    plane.a = a, plane.b = b, plane.c = c, plane.d = d, plane.e = e;
    auto o = sized<bccsplat_slice_options>();
    o.channel = cut.channel, o.level = cut.level, o.space = cut.space;
    o.interval[0] = -cut.around, o.interval[1] = cut.around;
    bccsplat_slice_release(slice_);
    slice_ = nullptr;
    uint64_t ranges = 0;
    check(bccsplat_volume_get_ranges(volume_, &plane, &o, 0, nullptr, 0, &ranges));
    check(bccsplat_slice_create(volume_, &plane, &o, &slice_));
    if (slice_) sample();
  }

  void draw(int32_t mode) {
    if (!slice_) return;
    if (!renderer_) check(bccsplat_renderer_create(device_, &renderer_));
    auto camera = sized<bccsplat_camera>();
    check(bccsplat_slice_fit_camera(slice_, 0, 0, 0, side, side, &camera));
    check(bccsplat_renderer_set_slice(renderer_, slice_));
    check(bccsplat_renderer_set_camera(renderer_, &camera));
    auto options = sized<bccsplat_render_options>();
    options.mode = mode;
    check(bccsplat_renderer_set_options(renderer_, &options));
    if (!frame_) check(bccsplat_frame_create(device_, side, side, BCCSPLAT_FRAME_RGBA, &frame_));
    check(bccsplat_renderer_render(renderer_, frame_));
  }

  void draw_scene(double time) {
    bccsplat_scene* scene = nullptr;
    check(bccsplat_scene_create(device_, &scene));
    auto instance = sized<bccsplat_instance>();
    uint64_t id = 0;
    check(bccsplat_scene_add(scene, volume_, &instance, &id));
    check(bccsplat_scene_set_time(scene, time));
    auto view = sized<bccsplat_view>();
    auto status = sized<bccsplat_scene_status>();
    if (!frame_) check(bccsplat_frame_create(device_, side, side, BCCSPLAT_FRAME_RGBA, &frame_));
    check(bccsplat_scene_render(scene, &view, frame_, nullptr, 0, &status));
    bccsplat_scene_release(scene);
  }

  [[nodiscard]] const bccsplat_volume_info& info() const { return info_; }

 private:
  void check(bccsplat_status status) const {
    fuzz::expect(status != BCCSPLAT_ERROR_INTERNAL, "internal error");
    fuzz::expect(status != BCCSPLAT_ERROR_OUT_OF_MEMORY, "memory that the budget did not know of");
    fuzz::expect(status == BCCSPLAT_OK || *bccsplat_last_error() != 0, "a failure without a text");
    fuzz::expect(!whole_ || !is_damage(status), "a file that verifies must be drawn");
    fuzz::expect(!salvages_ || !volume_ || !is_damage(status), "salvaging must not fail");
  }
  static int64_t read_at(void* user, uint64_t offset, void* buffer, uint64_t size) {
    const auto& file = static_cast<const Host*>(user)->file_;
    if (offset > file.size()) return -1;
    const auto n = std::min<uint64_t>(size, file.size() - offset);
    std::memcpy(buffer, file.data() + offset, n);
    return static_cast<int64_t>(n);
  }
  void sample() {
    auto slice = sized<bccsplat_slice_info>();
    check(bccsplat_slice_get_info(slice_, &slice));
    auto grid = sized<bccsplat_grid>();
    uint64_t values = 1;
    for (size_t a = 0; a < 3; ++a) {
      const double length = slice.extent[a][1] - slice.extent[a][0];
      grid.dims[a] = 7, grid.origin[a] = slice.extent[a][0], grid.step[a] = length > 0 ? length / 6 : 1;
      values *= grid.dims[a];
    }
    std::vector<float> out(values);
    check(bccsplat_slice_sample_grid(slice_, &grid, out.data()));
  }

  const std::vector<std::byte>& file_;
  bccsplat_device* device_ = nullptr;
  bccsplat_volume* volume_ = nullptr;
  bccsplat_slice* slice_ = nullptr;
  bccsplat_renderer* renderer_ = nullptr;
  bccsplat_frame* frame_ = nullptr;
  bccsplat_volume_info info_{};
  bool whole_ = false, salvages_ = false;
};

void look(Host& host) {
  const bccsplat_volume_info& info = host.info();
  const double last = static_cast<double>(info.dims[3]) - 1;
  const auto middle = [&](size_t a) { return (static_cast<double>(info.dims[a]) - 1) / 2; };
  host.describe();
  host.evaluate();
  host.cut({.plane = {0, 0, 0, 1, 0}});
  host.draw(BCCSPLAT_MODE_DEFAULT);
  host.cut({.plane = {0, 0, 0, 1, -last / 2}, .around = last / 4, .channel = info.channel_count - 1});
  host.draw(BCCSPLAT_MODE_MAXIMUM);
  host.cut({.plane = {1, 0, 0, 0, -middle(0)}});
  host.draw(BCCSPLAT_MODE_DEFAULT);
  host.cut({.plane = {0, 1, 0, 0, -middle(1)}});
  host.cut({.plane = {0, 0, 1, 0, -middle(2)}});
  host.cut({.plane = {.6, .3, 0, .7, -.6 * middle(0) - .3 * middle(1) - .7 * middle(3)},
            .space = BCCSPLAT_SPACE_INDEX});
  if (info.level_count > 0) host.cut({.plane = {0, 0, 0, 1, -last}, .level = info.level_count});
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size > largest_input) return 0;
  const std::vector<std::byte> file = fuzz::sealed_file({data, size});
  Host host(file);
  host.open(false, false);
  if (!host.is_open()) return 0;
  host.verify();
  look(host);
  host.open(true, true);
  if (!host.is_open()) return 0;
  host.cut({.plane = {0, 0, 0, 1, 0}});
  host.draw_scene(0);
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t /*most*/, unsigned seed) {
  fuzz::change_file({data, size}, seed);
  return size;
}

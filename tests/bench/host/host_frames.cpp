// SPDX-License-Identifier: Apache-2.0
// A host's loop, 30 pictures of a scene at a time: what of each is read, cut and drawn.
#include "tests/bench/host/host_frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <sstream>
#include <vector>

#include <bccsplat.h>

#include "base/error.h"
#include "tests/bench/moments/moments_series.h"
#include "tests/support/api_handles.h"

namespace bccsplat::bench {
namespace {

using host::Handle;
using host::sized;

constexpr uint32_t width = 640, height = 360;
constexpr double mebibyte = 1 << 20;

void check(bccsplat_status status) {
  if (status != BCCSPLAT_OK) fail(Code::internal, "scene: ", bccsplat_last_error());
}

// The moving camera and time of a row, and what is asked of each picture.
struct Wish {
  const char* name;
  bool depth = false, clip = false, deep = false, still = false;
  int instances = 1;
  double budget_ms = 0;
  int32_t quality = BCCSPLAT_QUALITY_DEFAULT;
};

struct Sums {
  int pictures = 0, calls = 0, cut = 0;
  double mebibytes = 0, cut_ms = 0, draw_ms = 0, ms = 0, longest_ms = 0;
  uint32_t level = 0;
  void add(const bccsplat_scene_status& s) {
    ++calls, cut += static_cast<int>(s.cut), mebibytes += static_cast<double>(s.bytes_read) / mebibyte;
    cut_ms += s.ms_cut, draw_ms += s.ms_draw, ms += s.ms_total, longest_ms = std::max(longest_ms, s.ms_total);
    if (s.complete) ++pictures, level = s.level;
  }
};

class HostFrames {
 public:
  HostFrames(const std::vector<std::byte>& file, uint32_t edge, int frames) : edge_(edge), frames_(frames) {
    auto o = sized<bccsplat_device_options>();
    o.thread_count = 2;
    bccsplat_device* d = nullptr;
    check(bccsplat_device_create(&o, &d));
    device_.reset(d);
    bccsplat_volume* v = nullptr;
    check(bccsplat_volume_open_memory(d, file.data(), file.size(), nullptr, &v));
    volume_.reset(v);
    check(bccsplat_volume_get_info(v, &info_));
    depth_.resize(size_t{width} * height);
  }

  // Of the device's memory, MiB, since the start.
  [[nodiscard]] double peak() const {
    auto info = sized<bccsplat_device_info>();
    check(bccsplat_device_get_info(device_.get(), &info));
    return static_cast<double>(info.memory_peak) / mebibyte;
  }
  Sums run(const Wish& wish) {
    bccsplat_scene* created = nullptr;
    check(bccsplat_scene_create(device_.get(), &created));
    const Handle<bccsplat_scene> scene(created);
    for (int n = 0; n < wish.instances; ++n) {
      auto i = sized<bccsplat_instance>();
      for (size_t a = 0; a < 4; ++a) i.placement[5 * a] = 1;
      i.placement[3] = 0.5 * n * edge_; // half of it in the one before
      uint64_t id;
      check(bccsplat_scene_add(created, volume_.get(), &i, &id));
    }
    if (wish.clip) {
      bccsplat_clip half{};
      half.normal[0] = 1, half.normal[2] = 0.5, half.offset = -0.75 * edge_;
      check(bccsplat_scene_set_clips(created, &half, 1));
    }
    bccsplat_frame* made = nullptr;
    check(bccsplat_frame_create(device_.get(), width, height,
                                wish.deep ? BCCSPLAT_FRAME_DEEP : BCCSPLAT_FRAME_DEPTH, &made));
    const Handle<bccsplat_frame> frame(made);
    Sums sums;
    for (int n = 0; n < frames_; ++n) {
      auto camera = sized<bccsplat_camera>();
      check(bccsplat_scene_fit_camera(created, BCCSPLAT_PROJECTION_PERSPECTIVE, 20, 3.0 * n, width, height,
                                      &camera));
      auto view = sized<bccsplat_view>();
      view.camera = &camera;
      if (wish.depth) set_depth(camera, view);
      const double last = info_.time_last - info_.time_first;
      check(bccsplat_scene_set_time(created, info_.time_first +
                                                 (wish.still ? 0.37 : 0.02 + 0.9 * n / frames_) * last));
      auto options = sized<bccsplat_render_options>();
      options.quality = wish.quality;
      auto status = sized<bccsplat_scene_status>();
      do {
        check(bccsplat_scene_render(created, &view, made, &options, wish.budget_ms, &status));
        sums.add(status);
      } while (!status.complete);
    }
    return sums;
  }

 private:
  // A wall through the middle of what is seen, in the right half of the picture.
  void set_depth(const bccsplat_camera& c, bccsplat_view& view) {
    const auto far = static_cast<float>(
        std::hypot(c.target[0] - c.position[0], c.target[1] - c.position[1], c.target[2] - c.position[2]));
    for (size_t p = 0; p < depth_.size(); ++p) depth_[p] = p % width < width / 2 ? INFINITY : far;
    view.depth = depth_.data();
  }

  uint32_t edge_;
  int frames_;
  Handle<bccsplat_device> device_;
  Handle<bccsplat_volume> volume_;
  bccsplat_volume_info info_ = sized<bccsplat_volume_info>();
  std::vector<float> depth_;
};

std::vector<Row> rows_of(uint32_t edge, int frames, int levels) {
  MomentSeries series;
  series.edge = edge, series.frames = 16, series.levels = levels;
  const WrittenSeries written = write_series(series);
  HostFrames hosts(written.file, edge, frames);
  // The volume's caches are shared: the first row reads and decodes.
  const Wish wishes[] = {{.name = "the first time"},
                         {.name = "time stands, camera moves", .still = true},
                         {.name = "time and camera move"},
                         {.name = "draft", .quality = BCCSPLAT_QUALITY_DRAFT},
                         {.name = "with the host's depths", .depth = true},
                         {.name = "half of it clipped away", .clip = true},
                         {.name = "both", .depth = true, .clip = true},
                         {.name = "two volumes, half in each other", .instances = 2},
                         {.name = "as a deep picture", .deep = true},
                         {.name = "20 ms at a time", .budget_ms = 20}};
  std::vector<Row> rows;
  for (const Wish& w : wishes) {
    const Sums s = hosts.run(w);
    const double n = s.pictures;
    rows.push_back({figure("voxels a side", edge, 0), word("pictures", w.name), figure("level", s.level, 0),
                    figure("calls", s.calls / n, 1), figure("slices cut", s.cut / n, 2),
                    figure("MiB read", s.mebibytes / n, 2), figure("ms cut", s.cut_ms / n, 1),
                    figure("ms drawn", s.draw_ms / n, 1), figure("ms in all", s.ms / n, 1),
                    figure("longest call, ms", s.longest_ms, 1), figure("peak, MiB", hosts.peak(), 0)});
  }
  return rows;
}

} // namespace

int run_scene_suite(std::span<const std::string> args, const Report& report) {
  std::vector<uint32_t> edges{128, 256};
  int frames = 30;
  if (report.quick) edges = {32}, frames = 2;
  for (size_t i = 0; i < args.size(); ++i) {
    if (args[i] == "--edges" && i + 1 < args.size()) {
      edges.clear();
      std::istringstream list(args[++i]);
      for (std::string edge; std::getline(list, edge, ',');)
        edges.push_back(static_cast<uint32_t>(std::stoul(edge)));
    } else if (args[i] == "--frames" && i + 1 < args.size()) {
      frames = std::stoi(args[++i]);
    } else {
      fail(Code::invalid_argument, "scene: unknown option ", args[i]);
    }
  }
  std::vector<Row> rows;
  constexpr uint32_t levels_from = 192; // as bcc4 import does
  for (const uint32_t edge : edges) {
    const auto more = rows_of(edge, frames, edge < levels_from ? 0 : edge >= 2 * levels_from ? 3 : 2);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  report.table("a host's frames, 640 x 360, per picture", rows);
  return 0;
}

} // namespace bccsplat::bench

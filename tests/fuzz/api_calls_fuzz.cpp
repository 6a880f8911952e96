// SPDX-License-Identifier: Apache-2.0
// Fuzzed sequences of calls of the C ABI: whatever a host does in whatever order, every call answers with a
// status, failures leave a text, and nothing leaks.
#include <bccsplat.h>
#include <cstring>

#include <cmath>
#include <string>
#include <vector>

#include "fuzz_target.h"

namespace {

constexpr uint32_t edge = 20; // samples per axis at most
constexpr size_t most_calls = 24;

template<class T> T sized() {
  T t{};
  t.struct_size = sizeof(T);
  return t;
}

void check(bccsplat_status status) {
  fuzz::expect(std::string(bccsplat_status_name(status)).find("UNKNOWN") == std::string::npos,
               "unknown status");
  fuzz::expect(status != BCCSPLAT_ERROR_INTERNAL, "internal error");
  fuzz::expect(status == BCCSPLAT_OK || *bccsplat_last_error() != 0, "a failure without a text");
}

// Mostly sensible numbers, sometimes those that break things.
double number(fuzz::Input& in) {
  static constexpr double odd[] = {0.0, -0.0, 1e-300, 1e300, -1e300, HUGE_VAL, -HUGE_VAL, 0.5, 1e-12, 1e9};
  const auto kind = in.take<uint8_t>();
  if (kind < 16) return odd[kind % 10];
  if (kind == 16) return std::nan("");
  if (kind < 32) return in.take<double>();
  return (kind - 128) / 8.0;
}

// One of each object, and what came of the writer.
struct Host {
  bccsplat_device* device = nullptr;
  bccsplat_writer* writer = nullptr;
  bccsplat_volume* volume = nullptr;
  bccsplat_slice* slice = nullptr;
  bccsplat_renderer* renderer = nullptr;
  bccsplat_frame* frame = nullptr;
  std::vector<char> file, open_file; // open_file outlives the volume
  int64_t next_layer = 0;
  uint32_t dims[4] = {1, 1, 1, 0};
  double time = 0;

  Host() = default;
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;
  ~Host() {
    bccsplat_frame_release(frame), bccsplat_renderer_release(renderer), bccsplat_slice_release(slice);
    bccsplat_volume_release(volume), bccsplat_writer_release(writer), bccsplat_device_release(device);
  }

  static int64_t write_at(void* user, uint64_t offset, const void* bytes, uint64_t size) {
    auto& file = *static_cast<std::vector<char>*>(user);
    if (file.size() < offset + size) file.resize(offset + size);
    std::memcpy(file.data() + offset, bytes, size);
    return size;
  }

  void make_device(fuzz::Input& in) {
    auto o = sized<bccsplat_device_options>();
    o.thread_count = in.below(3);
    o.memory_budget = in.below(4) == 0 ? in.take<uint16_t>() * 64u : 256u << 20;
    bccsplat_device_release(device);
    device = nullptr;
    check(bccsplat_device_create(in.below(8) == 0 ? nullptr : &o, &device));
  }

  void make_writer(fuzz::Input& in) {
    auto o = sized<bccsplat_writer_options>();
    auto c = sized<bccsplat_channel_options>();
    for (size_t a = 0; a < 4; ++a) o.dims[a] = dims[a] = in.below(a < 3 ? edge : 8);
    o.lattice = in.below(5);
    const uint32_t store = in.below(12);
    static constexpr int32_t stores[] = {BCCSPLAT_STORE_DEFAULT, BCCSPLAT_STORE_SAMPLES,
                                         BCCSPLAT_STORE_WAVELETS};
    static constexpr double error = 1;
    o.store = stores[store % 3], o.ends = store / 3;
    if (o.store == BCCSPLAT_STORE_WAVELETS) o.wavelet_errors = &error;
    o.nonfinite = in.below(5);
    if (in.below(4) == 0) {
      o.scale = number(in), o.time_scale = number(in);
      o.scales[in.below(4)] = number(in);
    }
    // A finer lattice than this is only work.
    if (o.scale > 0 && o.scale < 0.5) o.scale = 0.5;
    if (o.time_scale > 0 && o.time_scale < 0.5) o.time_scale = 0.5;
    for (double& scale : o.scales)
      if (scale > 0 && scale < 0.5) scale = 0.5;
    if (in.below(2) == 0) {
      c.source_type = in.below(11), c.value_type = in.below(6);
      c.set_mask = in.below(5);
      c.air = number(in), c.air_threshold = number(in), c.range[0] = number(in), c.range[1] = number(in);
      c.name = in.below(4) == 0 ? "\xff" : "density";
      o.channels = &c, o.channel_count = 1;
    }
    if (in.below(8) == 0)
      for (double& v : o.affine) v = number(in);
    if (in.below(8) == 0) o.recommended_kernel = "no such kernel";
    auto stream = sized<bccsplat_write_stream>();
    stream.write_at = write_at, stream.user = &file;
    bccsplat_writer_release(writer);
    writer = nullptr;
    next_layer = 0;
    check(bccsplat_writer_create_stream(device, &stream, &o, &writer));
  }

  void add_frame(fuzz::Input& in) {
    std::vector<double> values(size_t{edge} * edge * edge);
    const double a = number(in), b = number(in);
    for (size_t i = 0; i < values.size(); ++i)
      values[i] = i % 7 < 3 ? 0 : a + b * static_cast<double>(i % 11);
    auto box = sized<bccsplat_box>();
    box.type = in.below(11);
    box.data = values.data();
    for (size_t k = 0; k < 3; ++k) {
      box.begin[k] = in.below(8) == 0 ? in.take<int8_t>() : 0;
      box.dims[k] = in.below(8) == 0 ? in.take<int8_t>() : dims[k] - box.begin[k];
    }
    time += in.below(16) == 0 ? number(in) : 1;
    const uint32_t channel = in.below(16) == 0, count = in.below(8) != 0;
    check(bccsplat_writer_add_frame(writer, channel, time, &box, count));
  }

  void add_layer(fuzz::Input& in) {
    auto geometry = sized<bccsplat_layer_geometry>();
    const bccsplat_status status = bccsplat_writer_get_layer_geometry(writer, next_layer, &geometry);
    check(status);
    if (status != BCCSPLAT_OK) return;
    const uint64_t n = geometry.dims[0] * geometry.dims[1] * geometry.dims[2];
    if (n > 1 << 20) return;
    const std::vector<float> samples(n, static_cast<float>(number(in)));
    check(bccsplat_writer_add_layer(writer, 0, next_layer++, samples.data(), n));
  }

  void open(fuzz::Input& in) {
    bccsplat_volume_release(volume);
    volume = nullptr;
    auto o = sized<bccsplat_volume_options>();
    o.cache_bytes = in.below(4) == 0 ? in.take<uint16_t>() : 0;
    static constexpr const char* kernels[] = {nullptr, "", "paper", "fine", "default", "what"};
    o.kernel = kernels[in.below(6)];
    open_file = file;
    check(bccsplat_volume_open_memory(device, open_file.data(), open_file.size(), &o, &volume));
    if (!volume) return;
    auto info = sized<bccsplat_volume_info>();
    check(bccsplat_volume_get_info(volume, &info));
    auto channel = sized<bccsplat_channel_info>();
    const uint32_t looks = in.below(4);
    check(bccsplat_volume_get_channel_info(volume, looks % 2, &channel));
    if (looks < 2) return;
    auto look = sized<bccsplat_look>();
    const int32_t kind = in.below(9), mode = in.below(6);
    check(bccsplat_volume_get_look(volume, looks % 2, kind, mode, &look));
  }

  void evaluate(fuzz::Input& in) {
    std::vector<double> at(4 * in.below(4));
    for (double& v : at) v = number(in);
    std::vector<float> values(at.size() / 4), slopes(at.size());
    float* const gradients = in.below(2) ? slopes.data() : nullptr;
    check(bccsplat_volume_evaluate(volume, values.size(), at.data(), values.data(), gradients));
    uint64_t missing = 0;
    check(bccsplat_volume_evaluate_world(volume, 0, values.size(), at.data(), values.data(), gradients,
                                         in.below(2) ? &missing : nullptr));
    const uint64_t begin[] = {0, 0, 0}, end[] = {1, 2, 1}, number = values.size() % 8; // of a frame
    float few[2];
    check(bccsplat_volume_read_frame(volume, 0, number, begin, end, few));
  }

  void cut(fuzz::Input& in) {
    auto h = sized<bccsplat_hyperplane>();
    h.d = 1, h.e = -number(in);
    if (in.below(4) == 0) h.a = number(in), h.b = number(in), h.c = number(in), h.d = number(in);
    auto o = sized<bccsplat_slice_options>();
    if (in.below(4) == 0) o.interval[0] = number(in), o.interval[1] = number(in);
    if (in.below(8) == 0) {
      o.spacing = number(in);
      if (o.spacing > 0 && o.spacing < 0.5) o.spacing = 0.5;
      o.time_length = number(in);
    }
    bccsplat_slice_release(slice);
    slice = nullptr;
    check(bccsplat_slice_create(volume, &h, &o, &slice));
  }

  void sample(fuzz::Input& in) {
    auto info = sized<bccsplat_slice_info>();
    const bccsplat_status status = bccsplat_slice_get_info(slice, &info);
    check(status);
    if (status != BCCSPLAT_OK) return;
    auto grid = sized<bccsplat_grid>();
    for (size_t a = 0; a < 3; ++a)
      grid.origin[a] = number(in), grid.step[a] = number(in), grid.dims[a] = in.below(6);
    std::vector<float> values(grid.dims[0] * grid.dims[1] * grid.dims[2] + 1);
    check(bccsplat_slice_sample_grid(slice, &grid, values.data()));
    uint64_t points = 0;
    check(bccsplat_slice_get_points(slice, 0, nullptr, nullptr, &points));
    fuzz::expect(points == info.points, "the number of points");
  }

  void set_up(fuzz::Input& in) {
    if (!renderer) check(bccsplat_renderer_create(device, &renderer));
    switch (in.below(5)) {
    case 0: {
      auto o = sized<bccsplat_render_options>();
      o.mode = in.below(6), o.quality = in.below(6);
      o.set_mask = in.below(3), o.iso_value = number(in);
      o.sheet_step = in.below(4) == 0 ? number(in) : 0;
      if (o.sheet_step > 0 && o.sheet_step < 0.1) o.sheet_step = 0.1;
      o.opacity_stop = in.below(4) == 0 ? number(in) : 0;
      o.tile_size = in.below(4) == 0 ? in.take<int8_t>() : 0;
      o.smooth_edges = o.set_mask == BCCSPLAT_RENDER_SET_ISO ? o.quality % 4 : BCCSPLAT_SMOOTH_EDGES_DEFAULT;
      o.preintegrate = o.set_mask == 0 ? o.quality % 4 : BCCSPLAT_PREINTEGRATE_DEFAULT;
      check(bccsplat_renderer_set_options(renderer, &o));
      break;
    }
    case 1: {
      auto c = sized<bccsplat_camera>();
      c.projection = in.below(4);
      for (size_t a = 0; a < 3; ++a)
        c.position[a] = number(in), c.target[a] = number(in), c.up[a] = number(in);
      c.fovy_degrees = number(in), c.ortho_height = number(in);
      check(bccsplat_renderer_set_camera(renderer, &c));
      break;
    }
    case 2: {
      double colors[8], opacities[4];
      for (double& v : colors) v = number(in);
      for (double& v : opacities) v = number(in);
      auto f = sized<bccsplat_transfer_function>();
      f.colors = colors, f.color_count = in.below(3), f.opacities = opacities, f.opacity_count = in.below(3);
      f.unit_distance = number(in);
      check(bccsplat_renderer_set_transfer_function(renderer, &f));
      break;
    }
    case 3: {
      auto t = sized<bccsplat_trail>();
      t.content = in.below(5), t.combine = in.below(6);
      t.samples = in.below(4), t.interval[0] = number(in), t.interval[1] = number(in);
      t.intervals = in.below(4);
      check(bccsplat_renderer_set_trail(renderer, &t));
      break;
    }
    default:
      check(bccsplat_renderer_set_slice(renderer, slice));
    }
  }

  void render(fuzz::Input& in) {
    bccsplat_frame_release(frame);
    frame = nullptr;
    const uint32_t width = in.below(24), height = in.below(24), channels = in.below(17);
    check(bccsplat_frame_create(device, width, height, channels, &frame));
    const bccsplat_status drawn = bccsplat_renderer_render(renderer, frame);
    check(drawn);
    auto stats = sized<bccsplat_render_stats>();
    check(bccsplat_renderer_get_stats(renderer, &stats));
    if (drawn == BCCSPLAT_OK) render_again(size_t{width} * height);
  }

  static bccsplat_instance any_instance(fuzz::Input& in) {
    auto i = sized<bccsplat_instance>();
    const uint32_t kind = in.below(8);
    if (kind >= 4)
      for (double& v : i.placement) v = kind == 4 ? number(in) : 0;
    if (kind >= 6)
      for (size_t a = 0; a < 3; ++a) i.placement[5 * a] = 1, i.placement[4 * a + 3] = number(in);
    if (kind >= 6) i.placement[15] = 1;
    i.channel = in.below(9) == 8, i.outside = in.below(5), i.hidden = in.below(9) == 8;
    if (in.below(4) == 3) i.time_scale = number(in), i.time_offset = number(in), i.density = number(in);
    return i;
  }

  // Up to three instances, one of which changes and goes, seen by the default view or by anything.
  void draw_scene(fuzz::Input& in) {
    bccsplat_scene* scene = nullptr;
    check(bccsplat_scene_create(device, &scene));
    uint64_t id = 0;
    for (uint32_t n = in.below(3) + 1; n > 0; --n) {
      const auto i = any_instance(in);
      check(bccsplat_scene_add(scene, volume, &i, &id));
    }
    check(bccsplat_scene_set_time(scene, number(in)));
    bccsplat_clip clip{};
    for (double& v : clip.normal) v = number(in);
    clip.offset = number(in), clip.space = in.below(3), clip.instance = in.below(4);
    check(bccsplat_scene_set_clips(scene, &clip, in.below(2)));
    auto camera = sized<bccsplat_camera>();
    check(bccsplat_scene_fit_camera(scene, in.below(4), number(in), number(in), 24, 16, &camera));
    auto view = sized<bccsplat_view>();
    if (in.below(2)) view.camera = &camera;
    if (in.below(8) == 7) camera.position[0] = number(in);
    auto options = sized<bccsplat_render_options>();
    options.mode = in.below(6), options.quality = in.below(6);
    bccsplat_frame_release(frame);
    frame = nullptr;
    check(bccsplat_frame_create(device, 24, 16, in.below(32), &frame));
    auto status = sized<bccsplat_scene_status>();
    for (int n = 0; n < 3; ++n) {
      check(bccsplat_scene_render(scene, &view, frame, &options, in.below(4) * 2.0, &status));
      const auto i = any_instance(in);
      if (n == 0) check(bccsplat_scene_set_instance(scene, id, &i));
      if (n == 1) check(bccsplat_scene_remove(scene, in.below(3) + 1));
    }
    check(bccsplat_scene_prefetch(scene, &view, 24, 16, &options, number(in)));
    bccsplat_scene_release(scene);
  }

  // The same picture twice more: the last one from the sheets that the one before it kept.
  void render_again(size_t pixels) {
    auto plane = sized<bccsplat_plane>();
    if (bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_RGBA, &plane) != BCCSPLAT_OK) return;
    fuzz::expect(plane.row_bytes == plane.width * 4 * sizeof(float), "rows without gaps");
    const std::vector<float> first(plane.pixels, plane.pixels + 4 * pixels);
    for (int n = 0; n < 2; ++n) {
      if (bccsplat_renderer_render(renderer, frame) != BCCSPLAT_OK) return;
      fuzz::expect(std::memcmp(first.data(), plane.pixels, first.size() * sizeof(float)) == 0,
                   "the same picture");
    }
  }
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size > 4096) return 0;
  fuzz::Input in(data, size);
  Host host;
  host.make_device(in);
  for (size_t call = 0; call < most_calls && !in.empty(); ++call) switch (in.below(12)) {
    case 0:
      host.make_writer(in);
      break;
    case 1:
    case 2:
    case 3:
      host.add_frame(in);
      break;
    case 4:
      host.add_layer(in);
      break;
    case 5: {
      auto report = sized<bccsplat_writer_report>();
      const uint32_t how = in.below(4);
      const auto finish = how / 2 ? bccsplat_writer_finish_short : bccsplat_writer_finish;
      check(finish(host.writer, how % 2 ? &report : nullptr));
      break;
    }
    case 6:
      host.open(in);
      break;
    case 7:
      host.evaluate(in);
      break;
    case 8:
      host.cut(in);
      break;
    case 9:
      host.sample(in);
      break;
    case 10:
      host.set_up(in);
      break;
    default:
      host.render(in);
    }
  host.draw_scene(in); // what is left of the input tells how
  return 0;
}

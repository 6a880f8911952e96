// SPDX-License-Identifier: Apache-2.0
// The statuses that the header names behind "Also:", call by call: tables of how each is provoked, and the
// scene on which that is tried.
#pragma once

#include "host_streams.h"

namespace host::statuses {

// A finished series, a slice of it, and what else calls are made on.
struct Scene {
  Folder folder;
  Device device = make_device();
  Series series;
  std::string path = folder.file("whole.bcc4");
  Volume volume;
  Slice slice, oblique;
  Renderer renderer;
  Frame frame;

  Scene() {
    write_series(device, path, series);
    volume = open(device, path);
    slice = cut_time(volume, 2.5), oblique = cut(volume, 0.5, 0.3, 0.2, 1, -12);
    bccsplat_renderer* r = nullptr;
    EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
    renderer.reset(r);
    frame = make_frame(BCCSPLAT_FRAME_RGBA);
  }
  [[nodiscard]] Frame make_frame(uint32_t channels) const {
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_create(device.get(), 16, 16, channels, &f));
    return Frame(f);
  }
  [[nodiscard]] bccsplat_writer_options options() const { return options_of(series); }
  [[nodiscard]] Writer writer(const bccsplat_writer_options& o, const std::string& name = "new.bcc4") const {
    return make_writer(device, folder.file(name), o);
  }
  // A writer that has written the series and finished.
  [[nodiscard]] Writer finished(const bccsplat_writer_options& o) const {
    Writer w = writer(o);
    EXPECT_OK(add_frames(w.get(), series));
    EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
    return w;
  }
  // Of the frame, 4 floats each.
  [[nodiscard]] const float* pixels() const {
    auto plane = sized<bccsplat_plane>();
    EXPECT_OK(bccsplat_frame_get_channel(frame.get(), BCCSPLAT_FRAME_RGBA, &plane));
    return plane.pixels;
  }
  bccsplat_status create(const std::string& at, const bccsplat_writer_options& o) const {
    bccsplat_writer* w = nullptr;
    const bccsplat_status status = bccsplat_writer_create(device.get(), at.c_str(), &o, &w);
    EXPECT_EQ(w != nullptr, status == BCCSPLAT_OK);
    const Writer made(w);
    return status;
  }
  bccsplat_status open_at(const std::string& at, const char* kernel = nullptr) const {
    auto o = sized<bccsplat_volume_options>();
    o.kernel = kernel;
    bccsplat_volume* v = nullptr;
    const bccsplat_status status = bccsplat_volume_open_file(device.get(), at.c_str(), &o, &v);
    EXPECT_EQ(v != nullptr, status == BCCSPLAT_OK);
    const Volume opened(v);
    return status;
  }
  // The file with some of its bytes changed.
  bccsplat_status open_spoilt(const std::function<void(std::vector<char>&)>& spoil) const {
    std::vector<char> bytes = file_bytes(path);
    spoil(bytes);
    bccsplat_volume* v = nullptr;
    const bccsplat_status status =
        bccsplat_volume_open_memory(device.get(), bytes.data(), bytes.size(), nullptr, &v);
    const Volume opened(v);
    return status;
  }
  template<class Set> bccsplat_status cut_with(const bccsplat_hyperplane& plane, const Set& set) const {
    auto o = sized<bccsplat_slice_options>();
    set(o);
    bccsplat_slice* s = nullptr;
    const bccsplat_status status = bccsplat_slice_create(volume.get(), &plane, &o, &s);
    EXPECT_EQ(s != nullptr, status == BCCSPLAT_OK);
    const Slice made(s);
    return status;
  }
  template<class Set> bccsplat_status render_with(const Set& set, const Slice* of = nullptr) const {
    EXPECT_OK(bccsplat_renderer_set_slice(renderer.get(), (of ? *of : slice).get()));
    auto o = sized<bccsplat_render_options>();
    set(o);
    EXPECT_OK(bccsplat_renderer_set_options(renderer.get(), &o));
    return bccsplat_renderer_render(renderer.get(), frame.get());
  }
};

inline const auto now = plane_of(0, 0, 0, 1, -2.5), tilted = plane_of(0.5, 0.3, 0.2, 1, -12);

struct Row {
  const char* name;
  bccsplat_status status;
  std::function<bccsplat_status(Scene&)> call;
};

inline void expect_rows(const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    Scene scene;
    EXPECT_EQ(row.call(scene), row.status) << bccsplat_last_error();
    EXPECT_STRNE(bccsplat_last_error(), "");
  }
}

} // namespace host::statuses

// SPDX-License-Identifier: Apache-2.0
// Writes the file of a case in the way that it asks for; all ways but live, layers and fields give
// the bytes of the whole in one go.
#pragma once

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

#include "asked.h"

namespace host::pairs {

class Writing {
 public:
  Writing(const Device& device, const Folder& folder, Asked asked)
      : device_(device), folder_(folder), asked_(std::move(asked)) {}

  // Returns the path of the file.
  std::string write() {
    switch (asked_.way) {
    case Way::whole:
      return whole("whole");
    case Way::parts:
      return same_as_whole(in_parts());
    case Way::blocks:
      return same_as_whole(in_blocks());
    case Way::appended:
      return same_as_whole(appended());
    case Way::resumed:
      return same_as_whole(resumed());
    case Way::live:
      return live();
    case Way::layers:
      return by_layers();
    case Way::field:
      return by_field();
    }
    return {};
  }
  // What the writer measured of each channel, where it did.
  [[nodiscard]] const std::vector<bccsplat_error_report>& errors() const { return errors_; }

 private:
  [[nodiscard]] std::string file(const std::string& name) const { return folder_.file(name + ".bcc4"); }

  Writer begin(const std::string& name, uint32_t frames,
               const std::function<void(bccsplat_writer_options&)>& change) {
    const Asked& a = asked_;
    auto o = a.file;
    std::copy(a.dims.begin(), a.dims.end(), o.dims);
    o.dims[3] = frames;
    o.overwrite = 1;
    std::array<bccsplat_channel_options, 2> channels{a.channel, sized<bccsplat_channel_options>()};
    channels[0].name = "value", channels[1].name = "label";
    channels[0].source_type = a.type;
    // With what filters overshoot by.
    const double most = a.data == Data::labels ? 3 : a.data == Data::far_from_air ? 1100 : 100;
    channels[0].range[0] = -.05 * most, channels[0].range[1] = 1.05 * most;
    channels[1].source_type = BCCSPLAT_TYPE_U8;
    channels[1].set_mask = a.channel.set_mask & BCCSPLAT_CHANNEL_SET_RANGE, channels[1].range[1] = 255;
    o.channels = channels.data(), o.channel_count = a.channels;
    std::array<bccsplat_axis, 3> axes{sized<bccsplat_axis>(), sized<bccsplat_axis>(), sized<bccsplat_axis>()};
    std::vector<double> places;
    for (uint32_t i = 0; i < a.dims[1]; ++i) places.push_back(i + .02 * i * i);
    axes[1].count = places.size(), axes[1].coordinates = places.data();
    if (a.uneven) o.axes = axes.data();
    // For one channel each: more than steps of bytes round by; labels stay apart.
    const std::array<double, 2> wavelet_errors{a.channel.value_type == BCCSPLAT_TYPE_U8 ? 1.7 : .8, .15};
    if (o.store == BCCSPLAT_STORE_WAVELETS) o.wavelet_errors = wavelet_errors.data();
    change(o);
    bccsplat_writer* w = nullptr;
    check(bccsplat_writer_create(device_.get(), file(name).c_str(), &o, &w));
    return Writer(w);
  }
  template<class T> static void store(std::vector<std::byte>& to, double v) {
    const auto value = static_cast<T>(v);
    const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
    to.insert(to.end(), bytes, bytes + sizeof value);
  }
  // The frames that the writer takes, all channels of each in order.
  void add_frames(bccsplat_writer* writer, uint32_t frames) {
    uint64_t begin = 0, end = 0;
    check(bccsplat_writer_get_part_frames(writer, &begin, &end));
    if (asked_.unknown_length && end == 0) end = frames;
    for (auto t = static_cast<uint32_t>(begin); t < std::min<uint64_t>(end, frames); ++t)
      add_frame(writer, t);
  }
  void add_frame(bccsplat_writer* writer, uint32_t t) {
    std::array<uint64_t, 3> lo{}, hi{};
    check(bccsplat_writer_get_part_box(writer, lo.data(), hi.data()));
    for (uint32_t c = 0; c < asked_.channels; ++c) {
      auto box = sized<bccsplat_box>();
      box.type = c == 1 ? BCCSPLAT_TYPE_U8 : asked_.type;
      std::vector<std::byte> data;
      for (uint64_t z = lo[2]; z < hi[2]; ++z)
        for (uint64_t y = lo[1]; y < hi[1]; ++y)
          for (uint64_t x = lo[0]; x < hi[0]; ++x) {
            const double v = value_at(asked_, c, double(x), double(y), double(z), t);
            if (box.type == BCCSPLAT_TYPE_U8) store<uint8_t>(data, v);
            if (box.type == BCCSPLAT_TYPE_I16) store<int16_t>(data, v);
            if (box.type == BCCSPLAT_TYPE_F32) store<float>(data, v);
          }
      box.data = data.data();
      for (size_t k = 0; k < 3; ++k)
        box.begin[k] = static_cast<int64_t>(lo[k]), box.dims[k] = static_cast<int64_t>(hi[k] - lo[k]);
      check(bccsplat_writer_add_frame(writer, c, .5 * t, &box, 1));
    }
  }
  void finish(bccsplat_writer* writer) {
    auto report = sized<bccsplat_writer_report>();
    check(bccsplat_writer_finish(writer, &report));
    errors_.clear();
    for (uint32_t c = 0; report.frames_measured > 0 && c < asked_.channels; ++c) {
      errors_.push_back(sized<bccsplat_error_report>());
      check(bccsplat_writer_get_error(writer, c, -1, &errors_.back()));
    }
  }
  std::string whole(const std::string& name, uint32_t frames = 0) {
    if (frames == 0) frames = asked_.dims[3];
    const Writer w = begin(name, asked_.unknown_length ? 0 : frames, [](auto&) {});
    add_frames(w.get(), frames);
    finish(w.get());
    return file(name);
  }
  static std::vector<char> bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::string same_as_whole(const std::string& path) {
    // Parts do not know each other's values, which choose the base of a field with a bound
    // (bccsplat_join_parts).
    const bool own_base = asked_.way == Way::parts && asked_.data == Data::far_from_air &&
                          (asked_.file.abs_error > 0 || asked_.file.psnr > 0) &&
                          !asked_.file.fixed_predictions;
    if (own_base) errors_.clear();
    if (own_base) return path;
    const std::vector<char> got = bytes_of(path), want = bytes_of(whole("whole"));
    const auto [at, other] = std::mismatch(got.begin(), got.end(), want.begin(), want.end());
    demand(at == got.end() && other == want.end(), got.size(), " bytes, in one go ", want.size(),
           ", differing from byte ", at - got.begin());
    return path;
  }
  std::string join(const std::vector<std::string>& names) {
    std::vector<std::string> paths;
    std::vector<const char*> texts;
    for (auto n = names.rbegin(); n != names.rend(); ++n) paths.push_back(file(*n));
    for (const std::string& p : paths) texts.push_back(p.c_str());
    auto o = sized<bccsplat_join_options>();
    o.overwrite = 1;
    check(
        bccsplat_join_parts(device_.get(), texts.size(), texts.data(), file("joined").c_str(), &o, nullptr));
    return file("joined");
  }
  void part(const std::string& name, uint64_t first, uint64_t end, uint64_t from_x, uint64_t to_x) {
    std::vector<double> times;
    for (uint32_t t = 0; t < asked_.dims[3]; ++t) times.push_back(.5 * t);
    auto p = sized<bccsplat_series_part>();
    p.first = first, p.end = end, p.times = times.data();
    if (to_x > 0) {
      p.box_begin[0] = from_x, p.box_end[0] = to_x;
      p.box_end[1] = asked_.dims[1], p.box_end[2] = asked_.dims[2];
    }
    const Writer w = begin(name, asked_.unknown_length ? 0 : asked_.dims[3], [&](auto& o) { o.part = &p; });
    add_frames(w.get(), asked_.dims[3]);
    finish(w.get());
  }
  std::string in_parts() {
    const uint64_t half = (asked_.dims[3] + 1) / 2;
    part("a", 0, half, 0, 0);
    if (half < asked_.dims[3]) part("b", half, asked_.dims[3], 0, 0);
    return join(half < asked_.dims[3] ? std::vector<std::string>{"a", "b"} : std::vector<std::string>{"a"});
  }
  std::string in_blocks() {
    part("a", 0, asked_.dims[3], 0, 9);
    part("b", 0, asked_.dims[3], 9, asked_.dims[0]);
    return join({"a", "b"});
  }
  std::string appended() {
    whole("grown", asked_.dims[3] - 3);
    const Writer w = begin("grown", asked_.unknown_length ? 0 : asked_.dims[3],
                           [](auto& o) { o.partial = BCCSPLAT_PARTIAL_APPEND; });
    add_frames(w.get(), asked_.dims[3]);
    finish(w.get());
    return file("grown");
  }
  std::string resumed() {
    const auto go_on = [&](bccsplat_partial partial, uint32_t frames) {
      Writer w =
          begin("resumed", asked_.unknown_length ? 0 : asked_.dims[3], [&](auto& o) { o.partial = partial; });
      add_frames(w.get(), frames);
      return w;
    };
    (void)go_on(BCCSPLAT_PARTIAL_KEEP, (asked_.dims[3] + 1) / 2);
    finish(go_on(BCCSPLAT_PARTIAL_RESUME, asked_.dims[3]).get());
    return file("resumed");
  }
  // What is seen before the end is what the finished file has.
  std::string live() {
    std::vector<float> early;
    std::vector<double> places;
    {
      const Writer w = begin("live", asked_.unknown_length ? 0 : asked_.dims[3], [](auto& o) { o.live = 1; });
      add_frames(w.get(), asked_.dims[3]);
      bccsplat_volume* v = nullptr;
      const bccsplat_status status =
          bccsplat_volume_open_file(device_.get(), (file("live") + ".partial").c_str(), nullptr, &v);
      if (status != BCCSPLAT_ERROR_NOT_BCC4) {
        check(status);
        const Volume under_way(v);
        auto info = sized<bccsplat_volume_info>();
        check(bccsplat_volume_get_info(v, &info));
        places = samples_of(static_cast<uint32_t>(info.dims[3]));
        early = values_at(under_way, places);
      }
      finish(w.get());
    }
    const std::vector<float> late = values_at(open(device_, file("live")), places);
    for (size_t n = 0; n < early.size(); ++n)
      demand(std::isnan(early[n]) ? std::isnan(late[n]) : std::fabs(early[n] - late[n]) <= 1e-3, "under way ",
             early[n], ", finished ", late[n], " at sample ", n);
    return file("live");
  }
  [[nodiscard]] std::vector<double> samples_of(uint32_t frames) const {
    std::vector<double> places;
    for (uint32_t t = 0; t < frames; ++t)
      for (uint32_t z = 0; z < asked_.dims[2]; ++z)
        for (uint32_t y = 0; y < asked_.dims[1]; ++y)
          for (uint32_t x = 0; x < asked_.dims[0]; ++x)
            for (const uint32_t i : {x, y, z, t}) places.push_back(i);
    return places;
  }
  static std::vector<float> values_at(const Volume& volume, const std::vector<double>& places) {
    std::vector<float> values(places.size() / 4);
    const bccsplat_status status =
        bccsplat_volume_evaluate(volume.get(), values.size(), places.data(), values.data(), nullptr);
    if (status != BCCSPLAT_ERROR_HOLE) check(status);
    return values;
  }
  std::string by_layers() {
    const Writer w = begin("layers", asked_.unknown_length ? 0 : asked_.dims[3], [](auto&) {});
    check(bccsplat_writer_set_times(w.get(), 0, .5));
    auto g = sized<bccsplat_layer_geometry>();
    for (int64_t layer = 0, count = 1; layer < count; ++layer) {
      check(bccsplat_writer_get_layer_geometry(w.get(), layer, &g));
      count = g.layer_count;
      for (uint32_t c = 0; c < asked_.channels; ++c) {
        std::vector<float> samples;
        for (int64_t k = 0; k < g.dims[2]; ++k)
          for (int64_t j = 0; j < g.dims[1]; ++j)
            for (int64_t i = 0; i < g.dims[0]; ++i)
              samples.push_back(static_cast<float>(value_at(asked_, c, g.origin[0] + g.step[0] * double(i),
                                                            g.origin[1] + g.step[1] * double(j),
                                                            g.origin[2] + g.step[2] * double(k), g.frame)));
        check(bccsplat_writer_add_layer(w.get(), c, layer, samples.data(), samples.size()));
      }
    }
    finish(w.get());
    return file("layers");
  }
  std::string by_field() {
    const Writer w = begin("field", asked_.unknown_length ? 0 : asked_.dims[3], [](auto&) {});
    check(bccsplat_writer_set_times(w.get(), 0, .5));
    for (uint32_t c = 0; c < asked_.channels; ++c) {
      std::pair<const Asked*, uint32_t> user{&asked_, c};
      check(bccsplat_writer_add_field(
          w.get(), c,
          [](void* to, uint64_t n, const double* p, float* values) -> int32_t {
            const auto& [asked, channel] = *static_cast<std::pair<const Asked*, uint32_t>*>(to);
            for (uint64_t i = 0; i < n; ++i, p += 4)
              values[i] = static_cast<float>(value_at(*asked, channel, p[0], p[1], p[2], p[3]));
            return 0;
          },
          &user));
    }
    finish(w.get());
    return file("field");
  }

  const Device& device_;
  const Folder& folder_;
  Asked asked_;
  std::vector<bccsplat_error_report> errors_;
};

} // namespace host::pairs

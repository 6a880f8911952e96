#include <algorithm>
#include <cmath>

#include "api/writer.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

constexpr uint64_t field_points = 1 << 16; // asked of a host's field at a time

} // namespace

void bccsplat_writer::add_frame(uint32_t channel, double time, const bccsplat_box* boxes, uint64_t count) {
  if (feeding != Feeding::nothing && feeding != Feeding::frames) // `added` counts layers then
    fail(Code::wrong_state, "writer: frames and layers do not mix");
  const uint64_t frame = added[channel];
  if (!std::isfinite(time)) fail(Code::invalid_argument, "frame ", frame, ": the time is not finite");
  if (part && frame >= part->fit.end_given)
    fail(Code::wrong_state, "frame ", frame, ": the part takes frames ", part->fit.first_given, " to ",
         part->fit.end_given - 1);
  if (fit_options.dims[3] > 0 && frame >= fit_options.dims[3])
    fail(Code::wrong_state, "frame ", frame, ": the writer was made for ", fit_options.dims[3], " frames");
  if (frame == times.size()) {
    if (!times.empty() && !(time > times.back()))
      fail(Code::invalid_argument, "frame ", frame, ": time ", time, " does not rise above ", times.back(),
           " of the frame before");
    times.push_back(time);
  } else if (times[frame] != time) {
    fail(Code::invalid_argument, "frame ", frame, ": time ", time, " differs from ", times[frame],
         fit_options.part ? " of the part's times" : " of another channel");
  }
  std::vector<FrameBox> parts;
  parts.reserve(count);
  for (uint64_t i = 0; i < count; ++i) {
    const auto box = read_struct(element(boxes, i), "bccsplat_box");
    FrameBox dense;
    if (box.type < 1 || box.type > 9)
      fail(Code::invalid_argument, "box ", i, ": type ", box.type, " is not a type of values");
    dense.type = static_cast<SourceType>(box.type);
    dense.data = box.data;
    require(box.data, "box.data");
    for (size_t a = 0; a < 3; ++a) {
      const int64_t n = fit_options.dims[a];
      if (box.begin[a] < 0 || box.dims[a] < 1 || box.begin[a] > n || box.dims[a] > n - box.begin[a])
        fail(Code::invalid_argument, "box ", i, " of frame ", frame, ": begin ", box.begin[a], " and dims ",
             box.dims[a], " along axis ", a, " do not fit into 0 .. ", n);
      dense.begin[a] = box.begin[a], dense.dims[a] = box.dims[a], dense.stride[a] = box.stride_bytes[a];
    }
    parts.push_back(dense);
  }
  now.trigger = static_cast<uint32_t>(frame);
  begin(Feeding::frames, channel, parts.empty() ? SourceType::f32 : parts.front().type);
  start_measuring(true);
  if (round_trip)
    measuring([&] { round_trip->add_frame(static_cast<int>(channel), static_cast<uint32_t>(frame), parts); });
  fit->add_frame(static_cast<int>(channel), parts);
  ++added[channel];
  const uint64_t first = fit_options.part ? fit_options.part->first_given : 0;
  if (fit_options.dims[3] > 0)
    progress.report(0.99 * static_cast<double>(*std::min_element(added.begin(), added.end()) - first) /
                    static_cast<double>((part ? part->fit.end_given : fit_options.dims[3]) - first));
  progress.check();
}

void bccsplat_writer::add_layer(uint32_t channel, int64_t layer, std::span<const float> samples) {
  if (fit_options.part) fail(Code::unsupported, "a part of a series is made of frames");
  if (fit_options.dims[3] == 0) fail(Code::wrong_state, "layers need the number of frames: set dims[3]");
  if (layer != static_cast<int64_t>(added[channel]))
    fail(Code::wrong_state, "layer ", layer, " given, ", added[channel], " is next");
  begin(Feeding::layers, channel, SourceType::f32);
  start_measuring(false);
  fit->add_layer(static_cast<int>(channel), static_cast<int32_t>(layer), samples);
  ++added[channel];
  progress.report(static_cast<double>(*std::min_element(added.begin(), added.end())) /
                  initial.lattice.layers() * 0.99);
  progress.check();
}

void bccsplat_writer::add_field(uint32_t channel, bccsplat_field_fn field, void* user) {
  if (fit_options.part) fail(Code::unsupported, "a part of a series is made of frames");
  if (fit_options.dims[3] == 0) fail(Code::wrong_state, "a field needs the number of frames: set dims[3]");
  if (added[channel] != 0) fail(Code::wrong_state, "channel ", channel, " has data already");
  begin(Feeding::layers, channel, SourceType::f32);
  start_measuring(true);
  const Lattice4& lattice = fit->lattice();
  std::vector<double> points;
  // Values at origin + step * (i, j, k), x fastest, at frame t.
  const auto ask = [&](const Vec3& origin, const Vec3& step, const Int3& n, double t) {
    std::vector<float> values(static_cast<size_t>(n[0]) * static_cast<size_t>(n[1]) *
                              static_cast<size_t>(n[2]));
    const Reservation memory(context->memory, values.size() * sizeof(float), "a layer of a field");
    const auto nx = static_cast<uint64_t>(n[0]), ny = static_cast<uint64_t>(n[1]);
    for (uint64_t first = 0; first < values.size(); first += field_points) {
      const uint64_t count = std::min<uint64_t>(field_points, values.size() - first);
      points.resize(4 * count);
      for (uint64_t i = 0; i < count; ++i) {
        const uint64_t at = first + i, row = at / nx, plane = row / ny;
        points[4 * i] = origin[0] + step[0] * static_cast<double>(at % nx);
        points[4 * i + 1] = origin[1] + step[1] * static_cast<double>(row % ny);
        points[4 * i + 2] = origin[2] + step[2] * static_cast<double>(plane);
        points[4 * i + 3] = t;
      }
      if (field(user, count, points.data(), values.data() + first) != 0)
        fail(Code::cancelled, "the field of channel ", channel, " gave up");
      progress.check();
    }
    return values;
  };
  size_t next_frame = 0;
  for (int32_t layer = 0; layer < lattice.layers(); ++layer) {
    const double t = lattice.is_static() ? 0 : lattice.layer_frame(layer);
    for (;
         round_trip && next_frame < round_trip->frames().size() && round_trip->frames()[next_frame] <= t + 1;
         ++next_frame) {
      const uint32_t frame = round_trip->frames()[next_frame];
      const auto& d = lattice.dims;
      const std::vector<float> values =
          ask({}, {1, 1, 1},
              {static_cast<int32_t>(d[0]), static_cast<int32_t>(d[1]), static_cast<int32_t>(d[2])}, frame);
      FrameBox box;
      box.data = values.data(), box.dims = {d[0], d[1], d[2]};
      measuring([&] { round_trip->add_frame(static_cast<int>(channel), frame, {&box, 1}); });
    }
    const int coset = lattice.coset(layer);
    const Vec3 origin = lattice.site_position(coset, {0, 0, 0}),
               next = lattice.site_position(coset, {1, 1, 1});
    const Vec3 step{next[0] - origin[0], next[1] - origin[1], next[2] - origin[2]};
    fit->add_layer(static_cast<int>(channel), layer, ask(origin, step, lattice.space.dims(coset), t));
    ++added[channel];
    progress.report(static_cast<double>(*std::min_element(added.begin(), added.end())) / lattice.layers() *
                    0.99);
  }
}

void bccsplat::api::add_counts(const FitChannelReport& r, uint64_t cc_samples, SourceType type,
                               bccsplat_writer_report& report) {
  report.cc_relevant += r.cc_relevant;
  report.sites_total += r.sites_total;
  report.sites_kept += r.sites_kept;
  report.holes += r.holes;
  report.clamped += r.clamped;
  report.nonfinite += r.nonfinite;
  report.coding_max = std::max(report.coding_max, r.coding_max);
  constexpr uint64_t bytes_of[] = {0, 1, 2, 2, 4, 2, 4, 8, 1, 4};
  report.cc_samples += cc_samples;
  report.bytes_source += cc_samples * bytes_of[static_cast<size_t>(type)];
}

void bccsplat::api::add_bytes(const VolumeInfo& info, const Bcc4Report& written,
                              bccsplat_writer_report& report) {
  for (const ChannelInfo& c : info.channels)
    for (const BlockRef& ref : c.residuals.frames) report.bytes_corrections += ref.padded();
  report.bytes_file = written.bytes.file, report.bytes_runs = written.bytes.runs;
  report.bytes_values = written.bytes.values, report.bytes_index = written.bytes.index;
}

void bccsplat_writer::check_bounds(const FitReport& result) const {
  if (!(psnr > 0) || part) return; // a part knows nothing of the rest of the series
  for (size_t c = 0; c < channels.size(); ++c)
    require_psnr(initial.channels[c].name, round_trip->errors(static_cast<int>(c)),
                 result.channels[c].source_range, psnr);
}

bccsplat_writer_report bccsplat_writer::finish() {
  if (!fit) fail(Code::wrong_state, "writer: nothing was added");
  now.trigger = fit_options.dims[3];
  FitReport result = fit->finish();
  make_container();
  // The error of coding is known of what was coded.
  double squares = 0;
  uint64_t coded = 0;
  for (const FitChannelReport& r : result.channels) {
    squares += r.coding_rmse * r.coding_rmse * static_cast<double>(r.sites_total);
    coded += r.sites_total;
  }
  if (continued) add_continued(result);
  VolumeInfo& info = container->info();
  info.lattice = result.lattice;
  if (feeding == Feeding::frames) {
    TimeMap map{
        .uniform = true, .first = times.front(), .step = 1, .times = {}, .unit = info.time.unit, .epoch = {}};
    if (times.size() > 1) map.step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
    for (size_t i = 0; i < times.size() && map.uniform; ++i)
      map.uniform = std::fabs(times[i] - map.at(i)) <= 1e-9 * map.step;
    if (!map.uniform) map.times = times;
    info.time = std::move(map);
  } else {
    info.time = initial.time;
  }
  check_bounds(result);
  info.sources = initial.sources;
  info.attributes = initial.attributes;

  bccsplat_writer_report report{};
  report.frames = result.lattice.dims[3];
  for (size_t c = 0; c < result.channels.size(); ++c) {
    const FitChannelReport& r = result.channels[c];
    describe(r, info.channels[c]);
    add_counts(r, part ? r.source_samples : info.cc_samples(), info.channels[c].source_type, report);
    source_ranges.push_back(r.source_range);
    if (round_trip) report.corrected += round_trip->errors(static_cast<int>(c)).corrected;
  }
  if (part) {
    report.frames = part->fit.end_counted - part->fit.first_counted;
    describe_part(result);
  } else if (!coefficients && feeding == Feeding::frames) {
    info.tail =
        tail_of_series(lasting_slabs(result.lattice, fit_options, result.lattice.dims[3]), result.channels);
  }
  const Bcc4Report written = container->finish(*context);
  if (coded > 0) report.coding_rmse = std::sqrt(squares / static_cast<double>(coded));
  if (round_trip) report.frames_measured = round_trip->frames().size();
  const uint64_t copied = continued ? static_cast<uint64_t>(continued->slabs) * channels.size() : 0;
  report.slabs_reused = static_cast<uint32_t>(std::min<uint64_t>(written.slabs_reused + copied, UINT32_MAX));
  add_bytes(info, written, report);
  finished = true;
  try {
    progress.report(1);
  } catch (const Error&) {
    // Too late to cancel: the file has its name.
  }
  return report;
}

// SPDX-License-Identifier: Apache-2.0
// Plans a series: which frames of the source it takes, what stands in for missing ones, and at which times;
// PlannedReader reads the source by that plan.
#include "readers/frame_plan.h"

#include <algorithm>
#include <cmath>

#include "readers/error.h"

namespace bcc4 {
namespace {

class PlannedReader : public FrameReader {
 public:
  PlannedReader(std::unique_ptr<FrameReader> source, std::vector<PlannedFrame> frames,
                SeriesDescription description)
      : source_(std::move(source)), frames_(std::move(frames)), description_(std::move(description)) {}

  const SeriesDescription& description() const override { return description_; }
  std::string frame_name(uint64_t frame) const override { return source_->frame_name(frames_[frame].a); }

  bool frames_fit() const override { return source_->frames_fit(); }

  Frame read_box(uint64_t frame, size_t channel, const SampleBox& wanted) override {
    const PlannedFrame& p = frames_[frame];
    return p.weight == 0 ? source_->read_box(p.a, channel, wanted) : read(frame, channel);
  }

  Frame read(uint64_t frame, size_t channel) override {
    const PlannedFrame& p = frames_[frame];
    if (p.weight == 0) return source_->read(p.a, channel);
    // A frame between two others is dense, as f32.
    const auto& dims = description_.dims;
    const double air = description_.channels[channel].air;
    const Frame a = source_->read(p.a, channel), b = source_->read(p.b, channel);
    const uint64_t plane = dims[0] * dims[1];
    std::vector<double> from(plane), to(plane);
    auto bytes = std::make_shared<Bytes>(plane * dims[2] * sizeof(float));
    auto* out = reinterpret_cast<float*>(bytes->data());
    for (uint64_t z = 0; z < dims[2]; ++z) {
      gather_plane(a, dims, z, air, from.data());
      gather_plane(b, dims, z, air, to.data());
      for (uint64_t i = 0; i < plane; ++i)
        out[z * plane + i] = static_cast<float>((1 - p.weight) * from[i] + p.weight * to[i]);
    }
    return dense_frame(Type::f32, std::move(bytes),
                       {{AxisRole::x, dims[0]}, {AxisRole::y, dims[1]}, {AxisRole::z, dims[2]}});
  }

 private:
  std::unique_ptr<FrameReader> source_;
  std::vector<PlannedFrame> frames_;
  SeriesDescription description_;
};

SeriesTimes plan_times(const SeriesTimes& source, const FramePlan& plan, const ReaderOptions& options) {
  SeriesTimes times;
  times.unit = source.unit;
  if (options.times) {
    if (options.times->size() != plan.frames.size())
      fail_usage("--times gives ", options.times->size(), " times for ", plan.frames.size(), " frames");
    times.values = *options.times;
    times.origin = "--times";
    return times;
  }
  const int64_t first = plan.frames.front().number;
  // Where the source says when its first frame is, that stays.
  double begin = source.values.empty() ? 0 : source.values[plan.frames.front().a];
  if (!std::isfinite(begin)) begin = 0;
  for (const PlannedFrame& p : plan.frames) {
    const double index = static_cast<double>(p.number - first) / static_cast<double>(plan.stride);
    if (options.dt)
      times.values.push_back(begin + index * *options.dt);
    else if (!source.values.empty())
      times.values.push_back((1 - p.weight) * source.values[p.a] + p.weight * source.values[p.b]);
    else if (!plan.decimals.empty())
      times.values.push_back(plan.decimals[p.a]);
    else
      times.values.push_back(plan.times_by_number ? static_cast<double>(p.number) : index);
  }
  times.counted = !options.dt && source.values.empty() && plan.decimals.empty() && !plan.times_by_number;
  times.origin = options.dt                ? concat("--dt ", *options.dt, ", from ", begin)
                 : !source.values.empty()  ? source.origin
                 : plan.frames.size() == 1 ? "one frame, no time given"
                 : !plan.decimals.empty()  ? "the decimals in the names (or use --dt or --times)"
                 : plan.times_by_number    ? "none given: the numbers in the names (use --dt or --times)"
                                           : "none given: the frame index (use --dt or --times)";
  return times;
}

// The frames before one that has no time, as --frames takes them; "" where there are none.
std::string frames_before(const FramePlan& plan, size_t frame) {
  const auto number = [&](size_t i) { return plan.frames[i].number; };
  if (frame == 0) return "";
  return concat(", or take those before it by --frames ", number(0),
                frame > 1 ? concat("-", number(frame - 1)) : "");
}

void check_rising(const SeriesTimes& times, const FramePlan& plan) {
  for (size_t i = 0; i < times.values.size(); ++i) {
    if (!std::isfinite(times.values[i]))
      fail_input("time of frame ", plan.frames[i].number, " is not a finite number (", times.origin,
                 "): give the times of all frames by --times", frames_before(plan, i));
    if (i > 0 && times.values[i] == times.values[i - 1])
      fail_input("times must rise, but frames ", i - 1, " and ", i, " are both at ", times.values[i], " (",
                 times.origin, "): leave one out with --frames, or give other times by --dt or --times");
    if (i > 0 && times.values[i] < times.values[i - 1])
      fail_input("times must rise, but frame ", i - 1, " is at ", times.values[i - 1], " and frame ", i,
                 " at ", times.values[i], " (", times.origin,
                 "): sort the frames by time first (files by the order in which they are given, a NetCDF "
                 "file by cdo sorttimestamp); --dt and --times would keep them in this order");
  }
}

std::vector<uint64_t> plan_counts(const std::vector<uint64_t>& source, const FramePlan& plan) {
  std::vector<uint64_t> counts;
  if (source.empty()) return counts;
  for (const PlannedFrame& p : plan.frames)
    counts.push_back(p.weight == 0 ? source[p.a] : std::max(source[p.a], source[p.b]));
  return counts;
}

// Where times come from headers, a frame that is held over a gap gets a time between those of its neighbours.
void spread_held_times(std::vector<PlannedFrame>& frames, std::vector<double>& values) {
  for (size_t i = 1; i + 1 < frames.size(); ++i) {
    if (frames[i].weight != 0 || frames[i].a != frames[i - 1].a) continue;
    size_t next = i;
    while (next < frames.size() && frames[next].a == frames[i - 1].a && frames[next].weight == 0) ++next;
    if (next == frames.size()) return;
    const auto span = static_cast<double>(next - (i - 1));
    for (size_t k = i; k < next; ++k)
      values[k] = values[i - 1] + (values[next] - values[i - 1]) * static_cast<double>(k - (i - 1)) / span;
    i = next;
  }
}

} // namespace

FramePlan plan_files(const Sequence& sequence, const ReaderOptions& options) {
  if (sequence.files.size() == 1 && !sequence.numbered)
    return plan_selection(1, options.frames, sequence.files.front().path);
  const GapPolicy gaps = options.gaps;
  FramePlan plan;
  plan.stride = sequence.natural_stride;
  plan.times_by_number = sequence.numbered && sequence.stride > 1;
  if (sequence.order == NameOrder::decimals)
    for (const SequenceFile& file : sequence.files) plan.decimals.push_back(file.decimal);
  if (!sequence.missing.empty() && gaps == GapPolicy::error)
    fail_input("frames missing from the sequence: ", range_text(sequence.missing, sequence.stride), " (",
               sequence.missing.size(), " of ", sequence.missing.size() + sequence.files.size(),
               "); choose --gaps hold, skip or interpolate, or another --frames");
  for (size_t i = 0; i < sequence.files.size(); ++i) {
    const SequenceFile& file = sequence.files[i];
    if (i > 0 && gaps != GapPolicy::skip) {
      const SequenceFile& before = sequence.files[i - 1];
      for (int64_t number = before.number + sequence.stride;
           number < file.number && !sequence.missing.empty(); number += sequence.stride) {
        const double weight = gaps == GapPolicy::hold ? 0
                                                      : static_cast<double>(number - before.number) /
                                                            static_cast<double>(file.number - before.number);
        plan.frames.push_back({i - 1, gaps == GapPolicy::hold ? i - 1 : i, weight, number});
      }
    }
    plan.frames.push_back({i, i, 0, file.number});
  }
  if (!sequence.missing.empty()) {
    static constexpr const char* how[] = {"", "the frame before is repeated",
                                          "left out; times are uneven there",
                                          "interpolated linearly between the neighbours"};
    std::vector<int64_t> inner, outer;
    for (const int64_t number : sequence.missing)
      (number > sequence.files.front().number && number < sequence.files.back().number ? inner : outer)
          .push_back(number);
    if (!inner.empty())
      plan.gaps.push_back(concat(range_text(inner, sequence.stride), ": ", how[static_cast<int>(gaps)]));
    if (!outer.empty())
      plan.gaps.push_back(
          concat(range_text(outer, sequence.stride), ": outside the files there are, left out"));
  }
  return plan;
}

FramePlan plan_frames(const Sequence& sequence, uint64_t count, const ReaderOptions& options) {
  const uint64_t files = sequence.files.size();
  return files > 1 && count == files ? plan_files(sequence, options)
                                     : plan_selection(count, options.frames, sequence.files.front().path);
}

void check_frame_count(uint64_t count, const std::string& path) {
  if (count > most_frames)
    fail_input(path, ": ", count, " frames, more than the ", most_frames, " a series may have");
}

FramePlan plan_selection(uint64_t count, const FrameSelection& selection, const std::string& path) {
  check_frame_count(count, path);
  FramePlan plan;
  const int64_t origin = selection.first == INT64_MIN ? 0 : selection.first;
  const auto last = static_cast<int64_t>(count) - 1;
  if (selection.given &&
      (origin < 0 || origin > last || (selection.last != INT64_MAX && selection.last > last)))
    fail_usage("--frames: ", path, " has frames 0 to ", last);
  for (int64_t number = origin; number <= std::min(last, selection.last); number += selection.step) {
    const uint64_t index = number;
    plan.frames.push_back({index, index, 0, number});
  }
  return plan;
}

std::unique_ptr<FrameReader> planned_series(std::unique_ptr<FrameReader> source, FramePlan plan,
                                            const ReaderOptions& options) {
  SeriesDescription d = source->description();
  const bool header_times = !d.times.values.empty() && !options.dt && !options.times;
  d.times = plan_times(d.times, plan, options);
  if (header_times) spread_held_times(plan.frames, d.times.values);
  check_rising(d.times, plan);
  for (Channel& c : d.channels) c.active = plan_counts(c.active, plan);
  d.dims[3] = plan.frames.size();
  d.gaps = plan.gaps;
  d.blended = std::any_of(plan.frames.begin(), plan.frames.end(), [](const auto& f) { return f.weight > 0; });
  d.frame_numbers.clear();
  for (const PlannedFrame& p : plan.frames) d.frame_numbers.push_back(p.number);
  if (options.spacing) {
    auto s = *options.spacing;
    // Coordinates keep their direction: --spacing says how large the box is.
    for (size_t a = 0; a < s.size(); ++a)
      if (has_coordinates(d)) s[a] = std::copysign(s[a], d.affine[5 * a]);
    d.affine = {s[0], 0, 0, 0, 0, s[1], 0, 0, 0, 0, s[2], 0, 0, 0, 0, 1};
    d.affine_origin = "--spacing";
  }
  if (options.origin) {
    for (size_t a = 0; a < 3; ++a) d.affine[4 * a + 3] = (*options.origin)[a];
    d.affine_origin += d.affine_origin.empty() ? "--origin" : "; --origin";
  }
  return std::make_unique<PlannedReader>(std::move(source), std::move(plan.frames), std::move(d));
}

} // namespace bcc4

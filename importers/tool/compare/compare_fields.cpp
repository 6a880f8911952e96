// SPDX-License-Identifier: Apache-2.0
// Samples are looked up in the first file's grid: through the world, both of whose sides are turned to one
// space where both tell theirs. On one grid the planes of a slice are compared as they are; elsewhere the
// field is evaluated at each sample.
#include "tool/compare/compare_fields.h"

#include <algorithm>
#include <cmath>

#include "readers/error.h"
#include "tool/interrupt.h"
#include "tool/json.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

constexpr double kPartOfStep = 1e-3; // places that differ by less are one

// The world with x to the right and y forward, where the file tells its space.
Affine to_right_anterior(Affine m, const std::string& space, const std::string& other) {
  const bool both = !space.empty() && !other.empty();
  if (both && space.starts_with("left-posterior"))
    for (size_t i = 0; i < 8; ++i) m[i] = -m[i];
  return m;
}

// Returns world -> index.
Affine inverse(const Affine& m) {
  const double d = determinant(m);
  Affine out{};
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c) {
      const size_t r1 = (c + 1) % 3, r2 = (c + 2) % 3, c1 = (r + 1) % 3, c2 = (r + 2) % 3;
      out[4 * r + c] = (m[4 * r1 + c1] * m[4 * r2 + c2] - m[4 * r1 + c2] * m[4 * r2 + c1]) / d;
    }
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c) out[4 * r + 3] -= out[4 * r + c] * m[4 * c + 3];
  out[15] = 1;
  return out;
}

Affine product(const Affine& a, const Affine& b) {
  Affine out{};
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 4; ++c)
      for (size_t k = 0; k < 3; ++k) out[4 * r + c] += a[4 * r + k] * b[4 * k + c];
    out[4 * r + 3] += a[4 * r + 3];
  }
  out[15] = 1;
  return out;
}

// Where samples of the second are in the first: index -> index.
struct Meeting {
  Affine to_first{};
  std::array<uint64_t, 3> first_dims{};
  bool same = false; // one grid

  [[nodiscard]] std::array<double, 3> at(const std::array<uint64_t, 3>& i) const {
    std::array<double, 3> p{};
    for (size_t r = 0; r < 3; ++r) {
      p[r] = to_first[4 * r + 3];
      for (size_t c = 0; c < 3; ++c) p[r] += to_first[4 * r + c] * static_cast<double>(i[c]);
    }
    return p;
  }
  // Moves what lies next to a face onto it; false: outside.
  [[nodiscard]] bool clamp_inside(std::array<double, 3>& p) const {
    for (size_t a = 0; a < 3; ++a) {
      const auto last = static_cast<double>(first_dims[a] - 1);
      if (!(p[a] >= -kPartOfStep && p[a] <= last + kPartOfStep)) return false;
      p[a] = std::clamp(p[a], 0.0, last);
    }
    return true;
  }
};

Meeting meeting_of(const SampledSeries& first, const SampledSeries& second) {
  Meeting m;
  m.first_dims = first.dims;
  m.to_first = product(inverse(to_right_anterior(first.affine, first.space, second.space)),
                       to_right_anterior(second.affine, second.space, first.space));
  m.same = first.dims == second.dims;
  // The farthest corners of one grid are at one place.
  for (const uint64_t corner : {uint64_t{0}, uint64_t{1}, uint64_t{2}, uint64_t{3}, uint64_t{7}}) {
    std::array<uint64_t, 3> i{};
    for (size_t a = 0; a < 3; ++a) i[a] = (corner >> a & 1) * (second.dims[a] - 1);
    const std::array<double, 3> p = m.at(i);
    for (size_t a = 0; a < 3; ++a)
      m.same = m.same && std::abs(p[a] - static_cast<double>(i[a])) <= kPartOfStep;
  }
  return m;
}

void refuse_other_units(const std::string& what, const std::string& a, const std::string& b,
                        const std::string& first, const std::string& second) {
  if (!a.empty() && !b.empty() && a != b)
    fail_input(first, " and ", second, ": the ", what, " of one are in ", a, ", of the other in ", b,
               ": import one of them anew in the other's unit");
}

struct ChannelPair {
  uint32_t first = 0, second = 0;
};

// Pairs the channels of one name; two files of one channel each have a pair whatever its names.
std::vector<ChannelPair> pairs_of(const SampledSeries& first, const SampledSeries& second) {
  if (first.channels.size() == 1 && second.channels.size() == 1) return {{}};
  std::vector<ChannelPair> pairs;
  for (uint32_t s = 0; s < second.channels.size(); ++s)
    for (uint32_t f = 0; f < first.channels.size(); ++f)
      if (first.channels[f].name == second.channels[s].name) pairs.push_back({f, s});
  if (!pairs.empty()) return pairs;
  const auto names = [](const SampledSeries& series) {
    std::vector<std::string> list;
    for (const SampledChannel& c : series.channels) list.push_back(c.name);
    return join(list);
  };
  fail_input("no channel of ", first.name, " (", names(first), ") is called as one of ", second.name, " (",
             names(second), ")");
}

// One frame of the second against the slice of the first at its time.
class FrameComparer {
 public:
  FrameComparer(const Slice& slice, const SampledSeries& second, const Meeting& meeting, FieldDifference& out)
      : slice_(slice), second_(second), meeting_(meeting), out_(out) {}

  void take(uint64_t first_plane, std::span<const double> values) {
    const uint64_t plane = second_.dims[0] * second_.dims[1];
    for (uint64_t z = 0; z < values.size() / plane; ++z)
      compare_plane(first_plane + z, values.subspan(z * plane, plane));
  }

 private:
  void compare_plane(uint64_t z, std::span<const double> values) {
    if (meeting_.same) return compare_whole(z, values);
    find_points(z);
    got_.resize(points_.size() / 3);
    if (got_.empty()) return;
    const bccsplat_status status =
        bccsplat_slice_evaluate(slice_.get(), got_.size(), points_.data(), got_.data(), nullptr);
    if (status != BCCSPLAT_ERROR_OUT_OF_DOMAIN && status != BCCSPLAT_ERROR_HOLE)
      check(status, "slice"); // NaN there
    for (size_t i = 0; i < got_.size(); ++i)
      add(samples_[i], got_[i], values[samples_[i][0] + second_.dims[0] * samples_[i][1]]);
  }

  // A plane of one grid.
  void compare_whole(uint64_t z, std::span<const double> values) {
    auto grid = sized<bccsplat_grid>();
    const std::array<uint64_t, 3> dims{second_.dims[0], second_.dims[1], 1};
    for (size_t a = 0; a < 3; ++a) grid.step[a] = 1, grid.dims[a] = dims[a];
    grid.origin[2] = static_cast<double>(z);
    got_.resize(values.size());
    check(bccsplat_slice_sample_grid(slice_.get(), &grid, got_.data()), "slice");
    for (size_t i = 0; i < got_.size(); ++i) add({i % dims[0], i / dims[0], z}, got_[i], values[i]);
  }

  void find_points(uint64_t z) {
    points_.clear(), samples_.clear();
    for (uint64_t y = 0; y < second_.dims[1]; ++y)
      for (uint64_t x = 0; x < second_.dims[0]; ++x) {
        std::array<double, 3> p = meeting_.at({x, y, z});
        if (!meeting_.clamp_inside(p)) {
          ++out_.samples_outside;
          continue;
        }
        points_.insert(points_.end(), p.begin(), p.end());
        samples_.push_back({x, y, z});
      }
  }

  void add(const std::array<uint64_t, 3>& sample, double first, double second) {
    if (std::isnan(first) || std::isnan(second)) {
      if (!std::isnan(second)) ++out_.missing[0];
      if (!std::isnan(first)) ++out_.missing[1];
      return;
    }
    if (out_.all.count == 0) out_.range = {second, second};
    out_.range = {std::min(out_.range[0], second), std::max(out_.range[1], second)};
    if (out_.all.count == 0 || std::abs(first - second) > out_.all.max)
      out_.worst.sample = sample, out_.worst.first = first, out_.worst.second = second;
    out_.all.add(first - second);
  }

  const Slice& slice_;
  const SampledSeries& second_;
  const Meeting& meeting_;
  FieldDifference& out_;
  std::vector<double> points_;
  std::vector<std::array<uint64_t, 3>> samples_;
  std::vector<float> got_;
};

// Gives the second what its files do not tell, where its sizes are those of the first.
void borrow_place_and_times(const SampledSeries& first, SampledSeries& second) {
  if (!second.has_place && second.dims == first.dims) second.affine = first.affine;
  if (!second.has_times && second.times.size() == first.times.size()) second.times = first.times;
}

std::string run_text(const std::vector<double>& times, const std::string& unit) {
  return concat(time_text(times.front()), " to ", time_text(times.back()), unit.empty() ? "" : " ", unit);
}

// Returns the frame index of the first file at a time of the second; negative: it has none.
double index_at(const Volume& first, double time) {
  double index = -1;
  return bccsplat_volume_time_to_index(first.get(), time, &index) == BCCSPLAT_OK ? index : -1;
}

FieldDifference compare_channel(const Volume& first, SampledSeries& second, const Meeting& meeting,
                                const ChannelPair& pair, Progress& progress) {
  FieldDifference all;
  all.name = second.channels[pair.second].name;
  for (uint64_t f = 0; f < second.times.size(); ++f) {
    stop_if_interrupted();
    const double index = index_at(first, second.times[f]);
    if (index < 0) {
      ++all.frames_outside;
      continue;
    }
    FieldDifference frame;
    frame.worst.frame = f, frame.worst.time = second.times[f];
    const Slice slice = cut_frame(first, index, pair.first);
    FrameComparer comparer(slice, second, meeting, frame);
    second.read(f, pair.second,
                [&](uint64_t z, std::span<const double> values) { comparer.take(z, values); });
    all.add(frame);
    progress.update(f + 1, concat("frame ", f + 1, "/", second.times.size()));
  }
  return all;
}

void refuse_apart(const FieldDifference& d, const SampledSeries& first, const SampledSeries& second) {
  const std::string files = concat(first.name, " and ", second.name);
  if (d.frames_outside == second.times.size())
    fail_input(files, ": no moment in common: one runs from ", run_text(first.times, first.time_unit),
               ", the other from ", run_text(second.times, second.time_unit));
  if (d.samples_outside > 0 && d.all.count == 0 && d.missing[0] + d.missing[1] == 0)
    fail_input(files, ": no place in common: no sample of the second lies in the box of the first");
}

Json one_json(const FieldDifference& d) {
  return {{"max_abs", d.all.max},
          {"rmse", d.all.rmse()},
          {"psnr", d.all.count > 0 ? Json(d.all.psnr(d.peak())) : Json()},
          {"samples_compared", d.all.count},
          {"worst",
           {{"frame", d.worst.frame},
            {"time", d.worst.time},
            {"sample", d.worst.sample},
            {"first", d.worst.first},
            {"second", d.worst.second}}},
          {"missing", {{"first", d.missing[0]}, {"second", d.missing[1]}}}};
}

} // namespace

void FieldDifference::add(const FieldDifference& frame) {
  if (frame.all.count > 0) {
    if (all.count == 0) range = frame.range;
    range = {std::min(range[0], frame.range[0]), std::max(range[1], frame.range[1])};
    if (all.count == 0 || frame.all.max > all.max) worst = frame.worst;
  }
  all.add(frame.all);
  samples_outside = frame.samples_outside;
  for (size_t i = 0; i < 2; ++i) missing[i] += frame.missing[i];
  frames.push_back(frame);
}

std::vector<FieldDifference> compare_fields(const Volume& first, const std::string& first_name,
                                            SampledSeries& second, Progress& progress) {
  const auto grid = series_of_volume(first, first_name);
  borrow_place_and_times(*grid, second);
  refuse_other_units("lengths", grid->spatial_unit, second.spatial_unit, first_name, second.name);
  refuse_other_units("times", grid->time_unit, second.time_unit, first_name, second.name);
  const Meeting meeting = meeting_of(*grid, second);
  std::vector<FieldDifference> out;
  for (const ChannelPair& pair : pairs_of(*grid, second)) {
    refuse_other_units("values", grid->channels[pair.first].unit, second.channels[pair.second].unit,
                       first_name, second.name);
    out.push_back(compare_channel(first, second, meeting, pair, progress));
    refuse_apart(out.back(), *grid, second);
  }
  return out;
}

std::string psnr_words(const FieldDifference& d) {
  if (d.all.count == 0) return "nothing to compare";
  if (d.all.sum_of_squares == 0) return "equal";
  return d.peak() > 0 ? concat("PSNR ", short_number(d.all.psnr(d.peak()), 4), " dB (peak ",
                               short_number(d.peak()), ")")
                      : "no PSNR of a constant";
}

Json field_difference_json(const FieldDifference& d, bool frames) {
  Json j = one_json(d);
  j["peak"] = d.peak();
  if (!frames) return j;
  j["frames"] = Json::array();
  for (const FieldDifference& f : d.frames) j["frames"].push_back(one_json(f));
  return j;
}

} // namespace bcc4

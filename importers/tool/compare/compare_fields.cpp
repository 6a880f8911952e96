// SPDX-License-Identifier: Apache-2.0
// Samples are looked up in the first file's grid: through the world, which is turned to the first one's space
// and unit where both tell theirs, at moments by the first one's clock. On one grid the planes of a slice are
// compared as they are; elsewhere the field is evaluated at each sample.
#include "tool/compare/compare_fields.h"

#include <algorithm>
#include <cmath>

#include "readers/error.h"
#include "readers/lengths.h"
#include "tool/interrupt.h"
#include "tool/json.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

constexpr double kPartOfStep = 1e-3; // places that differ by less are one

// Whether one counts its world to the left and back, the other to the right and forward.
bool is_turned(const std::string& a, const std::string& b) {
  return !a.empty() && !b.empty() && a.starts_with("left-posterior") != b.starts_with("left-posterior");
}

[[noreturn]] void refuse_units(const std::string& what, const std::string& a, const std::string& b,
                               const std::string& first, const std::string& second) {
  fail_input(first, " and ", second, ": the ", what, " of one are in ", a, ", of the other in ", b,
             ": import one of them anew in the other's unit");
}

// Returns how lengths of the second become those of the first along each axis of the world.
std::array<double, 3> world_change(const SampledSeries& first, const SampledSeries& second) {
  std::array<double, 3> change{1, 1, 1};
  for (size_t a = 0; a < 3; ++a) {
    if (a < 2 && is_turned(first.space, second.space)) change[a] = -1;
    if (first.units[a].empty() || second.units[a].empty()) continue;
    const auto ratio = length_ratio(second.units[a], first.units[a]);
    if (!ratio) refuse_units("lengths", first.units[a], second.units[a], first.name, second.name);
    change[a] *= *ratio;
  }
  return change;
}

// Where samples of the second are in the first, through the world.
class Meeting {
 public:
  Meeting(const Volume& first, const SampledSeries& grid, const SampledSeries& second)
      : first_(first), grid_(grid), second_(second), change_(world_change(grid, second)),
        astray_(find_astray()) {}

  // One grid: no sample is elsewhere.
  [[nodiscard]] bool same() const { return !astray_ && grid_.dims == second_.dims; }
  // The first sample, along an axis, that is not where the first file has the one of its number.
  [[nodiscard]] const std::optional<std::array<uint64_t, 3>>& astray() const { return astray_; }

  // Returns where they are, x, y and z after each other, as indices of the first.
  [[nodiscard]] std::vector<double> at(std::span<const std::array<uint64_t, 3>> samples) const {
    std::vector<double> places;
    places.reserve(3 * samples.size());
    for (const auto& i : samples) {
      std::array<double, 3> even{};
      for (size_t a = 0; a < 3; ++a)
        even[a] = second_.even[a].empty() ? static_cast<double>(i[a]) : second_.even[a][i[a]];
      for (size_t r = 0; r < 3; ++r) {
        const double* const row = second_.affine.data() + 4 * r;
        places.push_back(change_[r] * (row[0] * even[0] + row[1] * even[1] + row[2] * even[2] + row[3]));
      }
    }
    check(bccsplat_volume_world_to_index(first_.get(), samples.size(), places.data(), places.data()), "");
    return places;
  }
  // Moves what lies next to a face of the first onto it; false: outside.
  [[nodiscard]] bool clamp_inside(std::span<double, 3> p) const {
    for (size_t a = 0; a < 3; ++a) {
      const auto last = static_cast<double>(grid_.dims[a] - 1);
      if (!(p[a] >= -kPartOfStep && p[a] <= last + kPartOfStep)) return false;
      p[a] = std::clamp(p[a], 0.0, last);
    }
    return true;
  }

 private:
  // Along each axis by itself, and in the far corner.
  [[nodiscard]] std::optional<std::array<uint64_t, 3>> find_astray() const {
    std::vector<std::array<uint64_t, 3>> samples;
    for (size_t a = 0; a < 3; ++a)
      for (uint64_t i = 0; i < second_.dims[a]; ++i) samples.emplace_back()[a] = i;
    auto& corner = samples.emplace_back(second_.dims);
    for (uint64_t& i : corner) --i;
    const std::vector<double> places = at(samples);
    for (size_t n = 0; n < samples.size(); ++n)
      for (size_t a = 0; a < 3; ++a)
        if (!(std::abs(places[3 * n + a] - static_cast<double>(samples[n][a])) <= kPartOfStep))
          return samples[n];
    return std::nullopt;
  }

  const Volume& first_;
  const SampledSeries &grid_, &second_;
  std::array<double, 3> change_;
  std::optional<std::array<uint64_t, 3>> astray_;
};

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

// One frame of the second against the frame of the first at its time, or a slice of it.
class FrameComparer {
 public:
  FrameComparer(const Volume& first, uint32_t channel, double index, const SampledSeries& second,
                const Meeting& meeting, FieldDifference& out)
      : second_(second), meeting_(meeting), out_(out) {
    const uint64_t plane = second.dims[0] * second.dims[1];
    if (meeting.same() && index == std::floor(index) && plane * second.dims[2] <= kMostHeld)
      sample_frame(first, index, channel, SampleBox{{0, 0, 0}, second.dims},
                   [&](uint64_t, std::span<const float> values) {
                     frame_.insert(frame_.end(), values.begin(), values.end());
                   });
    else
      slice_ = cut_frame(first, index, channel);
  }

  void take(uint64_t first_plane, std::span<const double> values) {
    const uint64_t plane = second_.dims[0] * second_.dims[1];
    for (uint64_t z = 0; z < values.size() / plane; ++z)
      compare_plane(first_plane + z, values.subspan(z * plane, plane));
  }

 private:
  void compare_plane(uint64_t z, std::span<const double> values) {
    if (meeting_.same()) return compare_whole(z, values);
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
    const std::array<uint64_t, 3> dims{second_.dims[0], second_.dims[1], 1};
    const float* got = frame_.data() + z * values.size();
    if (frame_.empty()) {
      auto grid = sized<bccsplat_grid>();
      for (size_t a = 0; a < 3; ++a) grid.step[a] = 1, grid.dims[a] = dims[a];
      grid.origin[2] = static_cast<double>(z);
      got_.resize(values.size());
      check(bccsplat_slice_sample_grid(slice_.get(), &grid, got_.data()), "slice");
      got = got_.data();
    }
    for (size_t i = 0; i < values.size(); ++i) add({i % dims[0], i / dims[0], z}, got[i], values[i]);
  }

  void find_points(uint64_t z) {
    std::vector<std::array<uint64_t, 3>> samples;
    for (uint64_t y = 0; y < second_.dims[1]; ++y)
      for (uint64_t x = 0; x < second_.dims[0]; ++x) samples.push_back({x, y, z});
    std::vector<double> places = meeting_.at(samples);
    points_.clear(), samples_.clear();
    for (size_t i = 0; i < samples.size(); ++i) {
      const std::span<double, 3> p(places.data() + 3 * i, 3);
      if (!meeting_.clamp_inside(p)) {
        ++out_.samples_outside;
        continue;
      }
      points_.insert(points_.end(), p.begin(), p.end());
      samples_.push_back(samples[i]);
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

  static constexpr uint64_t kMostHeld = uint64_t{1} << 26; // samples of a frame

  std::vector<float> frame_; // of the first, or none
  Slice slice_;              // where there is none
  const SampledSeries& second_;
  const Meeting& meeting_;
  FieldDifference& out_;
  std::vector<double> points_;
  std::vector<std::array<uint64_t, 3>> samples_;
  std::vector<float> got_;
};

// Gives the second what its files do not tell, where its sizes are those of the first, and its times by the
// clock of the first.
void borrow_place_and_times(const SampledSeries& first, SampledSeries& second) {
  if (!second.has_place && second.dims == first.dims)
    second.affine = first.affine, second.even = first.even, second.units = first.units,
    second.space = first.space;
  if (!second.has_times) {
    if (second.times.size() == first.times.size()) second.times = first.times;
    return;
  }
  const auto [to, from] = told_by_both(first.clock, second.clock);
  if (!convert_times(second.times, from, to))
    refuse_units("times", clock_text(to), clock_text(from), first.name, second.name);
}

std::string run_text(const std::vector<double>& times, const Clock& clock) {
  const std::string unit = clock_text(clock);
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
    FrameComparer comparer(first, pair.first, index, second, meeting, frame);
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
    fail_input(files, ": no moment in common: one runs from ", run_text(first.times, first.clock),
               ", the other from ", run_text(second.times, first.clock));
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
  const Meeting meeting(first, *grid, second);
  std::vector<FieldDifference> out;
  for (const ChannelPair& pair : pairs_of(*grid, second)) {
    const std::string &a = grid->channels[pair.first].unit, &b = second.channels[pair.second].unit;
    if (!a.empty() && !b.empty() && a != b) refuse_units("values", a, b, first_name, second.name);
    out.push_back(compare_channel(first, second, meeting, pair, progress));
    refuse_apart(out.back(), *grid, second);
  }
  return out;
}

void require_same_grid(const Volume& first, const std::string& first_name, SampledSeries& second) {
  const auto grid = series_of_volume(first, first_name);
  borrow_place_and_times(*grid, second);
  const Meeting meeting(first, *grid, second);
  const auto text = [](const auto& place) {
    return concat("(", place[0], ", ", place[1], ", ", place[2], ")");
  };
  if (const auto& sample = meeting.astray())
    fail_input("sample ", text(*sample), " of ", second.name, " stands where ", first_name, " has ",
               text(meeting.at({&*sample, 1})), ": it was made from another source");
  constexpr double rounding = 1e-12; // of times that were converted
  const double step = (grid->times.back() - grid->times.front()) / static_cast<double>(grid->times.size());
  for (size_t f = 0; f < second.times.size(); ++f)
    if (!(std::abs(second.times[f] - grid->times[f]) <=
          kPartOfStep * step + rounding * std::abs(grid->times[f])))
      fail_input("frame ", f, " of ", second.name, " is at ", time_text(second.times[f]), ", that of ",
                 first_name, " at ", time_text(grid->times[f]), " ", clock_text(grid->clock),
                 ": it was made from another source");
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

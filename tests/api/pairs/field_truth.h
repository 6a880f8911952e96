// SPDX-License-Identifier: Apache-2.0
// Whether the file of a case holds its series: values against the source, slices and bricks against values.
#pragma once

#include <limits>

#include "asked.h"

namespace host::pairs {

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double v) { low = std::min(low, v), high = std::max(high, v); }
  [[nodiscard]] double length() const { return std::max(high - low, 1e-9); }
};

class FieldTruth {
 public:
  FieldTruth(const Device& device, const Asked& asked, const std::string& path,
             const std::vector<bccsplat_error_report>& errors)
      : asked_(asked), errors_(errors) {
    auto o = sized<bccsplat_volume_options>();
    o.kernel = asked.slice.kernel;
    bccsplat_volume* v = nullptr;
    check(bccsplat_volume_open_file(device.get(), path.c_str(), &o, &v));
    volume_ = Volume(v);
  }
  [[nodiscard]] const Volume& volume() const { return volume_; }
  [[nodiscard]] const Range& range() const { return range_; }

  void check_bytes() {
    auto report = sized<bccsplat_verify_report>();
    check(bccsplat_volume_verify(volume_.get(), nullptr, nullptr, &report));
    demand(report.damages == 0, "verify finds ", report.damages, " damages");
  }
  // At the samples of the source: what is promised, what was measured, and what is usual.
  void check_values() {
    for (uint32_t c = 0; c < asked_.channels; ++c) check_channel(c);
    if (asked_.whole_time()) demand_same_turn(3);
    if (asked_.file.periodic_axes == BCCSPLAT_PERIODIC_Y) demand_same_turn(1);
  }
  // The slice that the case asks for; of pictures, along uneven axes at even positions.
  [[nodiscard]] Slice cut(bool of_picture) const {
    const Asked& a = asked_;
    auto h = sized<bccsplat_hyperplane>();
    auto o = a.slice;
    h.d = 1, h.e = a.still() ? 0 : -moment;
    if (a.uneven && of_picture) o.space = BCCSPLAT_SPACE_EVEN;
    static constexpr double box[6] = {3.4, 2, 0, 11, 9.25, 8};
    if (a.cut == Cut::box) o.box = box;
    if (a.cut == Cut::mean) o.interval[0] = -1, o.interval[1] = 1.5;
    if (a.cut == Cut::oblique) h.a = .5, h.e = -.5 * 7.5 - 3.5;
    if (a.cut == Cut::axis) h.a = 1, h.d = 0, h.e = -8;
    bccsplat_slice* s = nullptr;
    check(bccsplat_slice_create(volume_.get(), &h, &o, &s));
    return Slice(s);
  }
  // Values of the slice against those of the volume at the same places.
  void check_slice() {
    const Slice slice = cut(false);
    auto info = sized<bccsplat_slice_info>();
    check(bccsplat_slice_get_info(slice.get(), &info));
    demand(info.dims[0] > 0, "the slice is empty");
    std::vector<double> uvw, places;
    for (int n = 0; n < 400; ++n) {
      std::array<double, 4> p{info.origin[0], info.origin[1], info.origin[2], info.origin[3]};
      for (size_t k = 0; k < 3; ++k) {
        const double share = std::fmod(n * std::array{.618, .414, .732}[k], 1.);
        uvw.push_back(info.extent[k][0] + share * (info.extent[k][1] - info.extent[k][0]));
        for (size_t i = 0; i < 4; ++i) p[i] += uvw.back() * info.basis[k][i];
      }
      places.insert(places.end(), p.begin(), p.end());
    }
    const std::vector<float> got = slice_values(slice, uvw);
    if (asked_.slice.level == 0) compare(got, mean_values(places), slice_error(), "the slice has ");
    if (asked_.bricks) check_bricks(slice);
  }
  static constexpr double moment = 3.25;

 private:
  static constexpr int mean_steps = 200; // of a mean over time
  // Of layers and fields what is missing is told by the lattice, where places stand between two sites.
  [[nodiscard]] bool missing_by_sites() const {
    return asked_.missing && (asked_.way == Way::layers || asked_.way == Way::field);
  }
  [[nodiscard]] double slice_error() const {
    const bool resampled = asked_.cut == Cut::oblique || asked_.cut == Cut::axis;
    // A lattice in an oblique slice rings where the field jumps, and the rule of a mean misses by a step
    // there.
    const bool jumps = asked_.data == Data::labels || asked_.file.nonfinite == BCCSPLAT_NONFINITE_CLAMP;
    const bool missed = asked_.data == Data::labels && asked_.cut == Cut::mean;
    return (!resampled ? (missed ? 4. / mean_steps : 2e-3)
            : jumps    ? .5
                       : asked_.usual_error) *
               range_.length() +
           1e-6 * std::fabs(range_.high);
  }
  void compare(const std::vector<float>& got, const std::vector<float>& want, double most,
               const char* what) const {
    // A mean has what there is of moments.
    const bool unsure = missing_by_sites() || asked_.cut == Cut::mean;
    for (size_t n = 0; n < got.size(); ++n) {
      if (std::isnan(got[n]) && std::isnan(want[n])) continue;
      if (unsure && (std::isnan(got[n]) || std::isnan(want[n]))) continue;
      demand(std::fabs(got[n] - want[n]) <= most, what, got[n], " where the field is ", want[n], ", place ",
             n);
    }
  }
  [[nodiscard]] std::vector<float> values_at(uint32_t channel, const std::vector<double>& places) const {
    std::vector<float> values(places.size() / 4);
    const bccsplat_status status = bccsplat_volume_evaluate_channel(volume_.get(), channel, values.size(),
                                                                    places.data(), values.data(), nullptr);
    if (status != BCCSPLAT_ERROR_HOLE && status != BCCSPLAT_ERROR_OUT_OF_DOMAIN) check(status);
    return values;
  }
  // Of a mean over time the mean of values at moments, by Simpson's rule between layers of half a frame.
  [[nodiscard]] std::vector<float> mean_values(const std::vector<double>& places) const {
    if (asked_.cut != Cut::mean) return values_at(0, places);
    std::vector<double> sum(places.size() / 4);
    for (int n = 0; n <= mean_steps; ++n) {
      std::vector<double> moved = places;
      for (size_t i = 3; i < moved.size(); i += 4) moved[i] = moment - 1 + 2.5 * n / mean_steps;
      const std::vector<float> v = values_at(0, moved);
      for (size_t i = 0; i < sum.size(); ++i)
        sum[i] += v[i] * (n == 0 || n == mean_steps ? 1 : n % 2 ? 4 : 2) / (3. * mean_steps);
    }
    return {sum.begin(), sum.end()};
  }
  static std::vector<float> slice_values(const Slice& slice, const std::vector<double>& uvw) {
    std::vector<float> values(uvw.size() / 3);
    const bccsplat_status status =
        bccsplat_slice_evaluate(slice.get(), values.size(), uvw.data(), values.data(), nullptr);
    if (status != BCCSPLAT_ERROR_HOLE && status != BCCSPLAT_ERROR_OUT_OF_DOMAIN) check(status);
    return values;
  }
  // Bricks of samples have the slice's values, and none outside the bounds that are told.
  void check_bricks(const Slice& slice) {
    auto o = sized<bccsplat_brick_options>();
    o.edge = 8, o.border = 1;
    auto info = sized<bccsplat_brick_info>();
    check(bccsplat_slice_get_brick_info(slice.get(), &o, &info));
    const uint32_t cells = info.bricks[0] * info.bricks[1] * info.bricks[2];
    std::vector<uint32_t> index(cells), all(cells);
    std::vector<float> bounds(2 * cells), values(cells * info.brick_bytes / 4);
    check(bccsplat_slice_find_bricks(slice.get(), &o, index.data(), bounds.data(), nullptr));
    for (uint32_t n = 0; n < cells; ++n) all[n] = n;
    check(bccsplat_slice_get_bricks(slice.get(), &o, cells, all.data(), values.data(), nullptr));
    const size_t edge = info.edge, samples = edge * edge * edge;
    std::vector<double> uvw;
    std::vector<float> got;
    for (uint32_t cell = 0; cell < cells; ++cell)
      for (size_t n = 0; n < samples; ++n) {
        const std::array<size_t, 3> at{n % edge, n / edge % edge, n / edge / edge};
        const std::array<uint32_t, 3> brick{cell % info.bricks[0], cell / info.bricks[0] % info.bricks[1],
                                            cell / info.bricks[0] / info.bricks[1]};
        const float value = values[cell * samples + n];
        bool inside = true;
        std::array<double, 3> p{};
        for (size_t k = 0; k < 3; ++k) {
          const auto i = static_cast<int64_t>(brick[k] * o.edge + at[k]) - o.border;
          inside = inside && i >= 0 && i < static_cast<int64_t>(info.dims[k]);
          p[k] = info.origin[0][k] + info.step[k] * double(i);
        }
        if (!inside) continue;
        const double slack = 1e-5 * std::max(1., std::fabs(range_.high));
        demand(std::isnan(value) ||
                   (value >= bounds[2 * cell] - slack && value <= bounds[2 * cell + 1] + slack),
               "brick ", cell, " has ", value, ", its bounds are ", bounds[2 * cell], " and ",
               bounds[2 * cell + 1]);
        uvw.insert(uvw.end(), p.begin(), p.end()), got.push_back(value);
      }
    compare(got, slice_values(slice, uvw), 1e-4 * range_.length() + 1e-6 * std::fabs(range_.high),
            "a brick has ");
  }
  // At the end of a periodic axis the field is that of its beginning.
  void demand_same_turn(size_t axis) {
    std::vector<double> begin, end;
    for (int n = 0; n < 50; ++n) {
      std::array<double, 4> p{};
      for (size_t k = 0; k < 4; ++k)
        p[k] = std::fmod(n * std::array{.618, .414, .732, .271}[k], 1.) * (asked_.dims[k] - 1);
      p[axis] = 0, begin.insert(begin.end(), p.begin(), p.end());
      p[axis] = asked_.dims[axis], end.insert(end.end(), p.begin(), p.end());
    }
    compare(values_at(0, end), values_at(0, begin), 1e-4 * range_.length() + 1e-6 * std::fabs(range_.high),
            "behind a turn there is ");
  }
  void check_channel(uint32_t channel) {
    std::vector<double> places;
    std::vector<double> source;
    Range range;
    for (uint32_t t = 0; t < asked_.dims[3]; ++t)
      for (uint32_t z = 0; z < asked_.dims[2]; ++z)
        for (uint32_t y = 0; y < asked_.dims[1]; ++y)
          for (uint32_t x = 0; x < asked_.dims[0]; ++x) {
            for (const uint32_t i : {x, y, z, t}) places.push_back(i);
            double v = value_at(asked_, channel, x, y, z, t);
            if (std::isfinite(v)) range.add(v);
            // What is clamped is air, and no sample of the source that anything is promised of.
            if (std::isnan(v) && asked_.file.nonfinite == BCCSPLAT_NONFINITE_CLAMP) range.add(0);
            source.push_back(v);
          }
    if (channel == 0) range_ = range;
    compare_with_source(channel, values_at(channel, places), source, range);
  }
  void compare_with_source(uint32_t channel, const std::vector<float>& got, const std::vector<double>& source,
                           const Range& range) const {
    const Asked& a = asked_;
    const bool by_sites = missing_by_sites();
    const bool clamped = a.file.nonfinite == BCCSPLAT_NONFINITE_CLAMP;
    double most = 0, squares = 0;
    size_t count = 0, where = 0;
    for (size_t n = 0; n < got.size(); ++n) {
      if (by_sites && (std::isnan(source[n]) || std::isnan(got[n]))) continue;
      if (clamped && std::isnan(source[n]) && !std::isnan(got[n])) continue;
      demand(std::isnan(source[n]) == std::isnan(got[n]), "channel ", channel, " has ", got[n], " at sample ",
             n, ", the source ", source[n]);
      if (std::isnan(source[n])) continue;
      const double off = std::fabs(got[n] - source[n]);
      if (off > most) most = off, where = n;
      squares += off * off, ++count;
    }
    const double rmse = std::sqrt(squares / double(std::max<size_t>(count, 1)));
    const auto at = [&] {
      return " (channel " + std::to_string(channel) + ", sample " + std::to_string(where) + ": " +
             std::to_string(got[where]) + " for " + std::to_string(source[where]) + ")";
    };
    const bool own_kernel = !a.slice.kernel;
    if (own_kernel && a.file.abs_error > 0)
      demand(most <= a.file.abs_error * (1 + 1e-6), "off by ", most, ", promised ", a.file.abs_error, at());
    if (own_kernel && a.file.psnr > 0) {
      const double psnr = 20 * std::log10(range.length() / rmse);
      demand(psnr >= a.file.psnr - 1e-6, "PSNR ", psnr, ", promised ", a.file.psnr, at());
    }
    if (own_kernel && a.file.measure != BCCSPLAT_MEASURE_SOME && channel < errors_.size()) {
      const bccsplat_error_report& e = errors_[channel];
      // The writer knows the base of a field far from air by its first layers.
      // What it takes for what a reader gets of linear samples is rounded to a 64th of a code.
      constexpr double bytes = 255, rounded = 1.0 / 64;
      const bool linear = a.file.store == BCCSPLAT_STORE_WAVELETS && a.file.lattice == BCCSPLAT_LATTICE_CC;
      const double slack =
          (1e-6 + (linear ? rounded / bytes : 0)) * range.length() + 4e-6 * std::fabs(range.high);
      // Labels on their own grid come back whole, whatever the field is off by.
      const bool labels = a.file.lattice == BCCSPLAT_LATTICE_CC && (channel == 1 || a.data == Data::labels);
      demand(most - e.max_abs <= slack && (labels || e.max_abs - most <= slack), "off by ", most,
             ", the writer measured ", e.max_abs, at());
      demand(labels || std::fabs(e.rmse - rmse) <= slack, "RMSE ", rmse, ", the writer measured ", e.rmse);
      demand(e.samples == count, count, " samples, the writer compared ", e.samples);
    }
    if (channel == 0 && a.data != Data::labels && !clamped)
      demand(most <= a.usual_error * range.length(), "off by ", most, ", usual is ",
             a.usual_error * range.length(), at());
  }

  const Asked& asked_;
  const std::vector<bccsplat_error_report>& errors_;
  Volume volume_;
  Range range_;
};

} // namespace host::pairs

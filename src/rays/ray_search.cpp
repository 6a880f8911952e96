// SPDX-License-Identifier: Apache-2.0
// Rays go on slab by slab in squares of pixels, so that samples lie side by side: all samples that a slab
// asks for are summed at once. Between samples beside each other a ray looks for a change of side, and for a
// turn that may pass the value twice; both ends of what it looks at lie on whole sheets, so that cells which
// are passed over change nothing that it finds.
#include "rays/ray_search.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace bccsplat {
namespace {

// A root may lie this far outside of its ray's part of the domain, sheets.
constexpr double outside_tolerance = 1e-5;

constexpr float infinity = std::numeric_limits<float>::infinity();

// The whole number below a sheet number.
int below(double k) {
  constexpr int lift = 1 << 24;
  return static_cast<int>(k + lift) - lift;
}

constexpr int together = 4; // samples that are written down without asking whether there are so many

// The least float that is not below a target.
float side_of(double target) {
  const auto near = static_cast<float>(target);
  return near < target ? std::nextafter(near, infinity) : near;
}

// Samples of a slab that there is room for.
size_t rooms(size_t most_sheets) {
  constexpr size_t rays = size_t{RaySearch::square} * RaySearch::square;
  return rays * most_sheets + PairArgs::room + together;
}

} // namespace

RaySearch::RaySearch(const RayField& of)
    : f_(of), view_(*of.view), side_(side_of(of.target)), roots_(of.field->footprints, side_),
      to_lattice_(of.view->lattice_to_world.inverse()) {
  const size_t room = rooms(of.most_sheets);
  samples_.resize(room), places_.resize(room), steps_.resize(room), values_.resize(room),
      slopes_.resize(room);
  gradients_.resize(room), found_.resize(room / 64 + 1);
}

uint64_t RaySearch::buffers(size_t most_sheets) {
  constexpr uint64_t sample =
      sizeof(int) + sizeof(Vec4) + 2 * sizeof(float) + 2 * sizeof(std::array<float, 4>);
  constexpr uint64_t ray =
      sizeof(Part) + sizeof(uint32_t) + 2 * sizeof(RayHit) + 2 * sizeof(Vec3) + sizeof(double);
  return rooms(most_sheets) * sample + rooms(most_sheets) / 8 + pixels * ray;
}

std::span<const RayHit> RaySearch::find(const RayWay& way, int x, int y, int width, int height,
                                        Progress& progress) {
  hits_.clear(), unlit_.clear();
  way_ = &way;
  x_ = x, y_ = y;
  begin(width, height);
  for (size_t word = 0; word < way_->words(); ++word) {
    const auto left = [&](int from) { // slabs that pieces with open rays need
      uint64_t slabs = 0;
      for (const Piece& p : piece_)
        if (p.open != 0) slabs |= p.slabs[word];
      return from < 64 ? slabs >> from << from : 0;
    };
    for (uint64_t slabs = left(0); slabs != 0;) {
      progress.check();
      const int bit = std::countr_zero(slabs);
      draw_slab(word, bit);
      slabs = left(bit + 1);
    }
  }
  light();
  counts_.hits += hits_.size();
  return hits_;
}

void RaySearch::begin(int width, int height) {
  uint32_t p = 0;
  for (int j = 0; j < square; j += piece_edge)
    for (int i = 0; i < square; i += piece_edge, ++p) {
      Piece& piece = piece_[p];
      piece.open = 0;
      if (i >= width || j >= height || !way_->any(x_ + i, y_ + j)) continue;
      piece.slabs = way_->slabs(x_ + i, y_ + j);
      piece.open = way_->find_rays(x_ + i, y_ + j, piece.way);
      // Pieces at the far edges keep only the rays that are in the picture.
      constexpr uint64_t row = 0xff;
      for (int n = 0; n < piece_edge; ++n) {
        const int there = j + n < height ? std::min(width - i, piece_edge) : 0;
        piece.open &= ~(row >> there << there << n * piece_edge);
      }
      if (view_.cut()) cut(piece, x_ + i, y_ + j);
      std::fill_n(last_.begin() + p * piece_rays, piece_rays, Station());
    }
}

// Shortens the open rays of the piece at pixel (x, y) by what cuts them beside the box.
void RaySearch::cut(Piece& piece, int x, int y) const {
  PieceRays& rays = piece.way.rays;
  for (uint64_t left = piece.open; left != 0; left &= left - 1) {
    const int n = std::countr_zero(left);
    const auto [enter, leave] = ray_interval(f_.field->slice, view_, x + n % piece_edge, y + n / piece_edge);
    rays.enter[n] = std::max(rays.enter[n], enter), rays.leave[n] = std::min(rays.leave[n], leave);
    if (!(rays.enter[n] < rays.leave[n])) piece.open &= ~(uint64_t{1} << n);
  }
}

void RaySearch::draw_slab(size_t word, int bit) {
  const int slab = static_cast<int>(word) * 64 + bit;
  count_ = 0, parts_.clear();
  std::array<uint64_t, piece_rays> layers;
  for (uint32_t p = 0; p < piece_.size(); ++p) {
    const Piece& piece = piece_[p];
    if (piece.open == 0 || (piece.slabs[word] >> bit & 1) == 0) continue;
    const auto first = static_cast<uint32_t>(p * piece_rays);
    uint64_t asking = piece.open & way_->find_layers(piece.way, slab, layers);
    for (; asking != 0; asking &= asking - 1) {
      const uint32_t n = std::countr_zero(asking);
      ask(first + n, slab, layers[n]);
    }
  }
  search();
}

// Notes the sheets that the ray's layers lie between and that it has not looked at yet.
void RaySearch::ask(uint32_t r, int slab, uint64_t layers) {
  const Vec3 at = view_.sample(column(r), row(r), 0), ray = view_.ray(column(r), row(r));
  const std::array<float, 4> step{static_cast<float>(ray[0]), static_cast<float>(ray[1]),
                                  static_cast<float>(ray[2]), 0};
  const PieceRays& rays = piece_[r / piece_rays].way.rays;
  const double enter = rays.enter[r % piece_rays], leave = rays.leave[r % piece_rays];
  const uint32_t first = count_;
  uint32_t count = first;
  int next = last_[r].k + 1;
  way_->each_run(rays, r % piece_rays, slab, layers, [&](double from, double to) {
    from = std::max(from, enter), to = std::min(to, leave);
    if (to < from) return;
    const int low = std::max(below(from), next), high = -below(-to);
    for (int k = low; k <= high; k += together)
      for (uint32_t n = 0; n < together; ++n) { // those behind the last one are written over
        const int sheet = k + static_cast<int>(n);
        const uint32_t to_n = count + (k - low) + n;
        samples_[to_n] = sheet, steps_[to_n] = step;
        places_[to_n] = {at[0] + sheet * ray[0], at[1] + sheet * ray[1], at[2] + sheet * ray[2], 0};
      }
    next = std::max(next, high + 1);
    count += std::max(high - low + 1, 0);
  });
  count_ = count;
  if (count > first) parts_.push_back({r, first, count, first, last_[r].k == samples_[first] - 1});
}

void RaySearch::search() {
  if (count_ == 0) return;
  counts_.samples += count_;
  sum_footprints(f_.field->footprints, std::span(places_).first(count_), values_.data(), gradients_.data());
  find_pairs(
      {count_, values_.data(), gradients_.data(), steps_.data(), side_, slopes_.data(), found_.data()});
  scanned_.resize(parts_.size());
  for (uint32_t p = 0; p < scanned_.size(); ++p) scanned_[p] = p;
  while (!scanned_.empty()) {
    roots_.clear(), grazes_.clear();
    for (const uint32_t p : scanned_) scan(p);
    scanned_.clear();
    settle();
  }
  for (const Part& part : parts_) last_[part.ray] = station(part.end - 1);
}

// Goes on along the samples of a part until something is found.
void RaySearch::scan(uint32_t p) {
  Part& part = parts_[p];
  if (part.joins) {
    part.joins = false;
    if (note(last_[part.ray], station(part.begin), p)) return;
  }
  const uint32_t last = part.end - 1;
  for (uint32_t n = part.next; n < last;) {
    const uint64_t found = found_[n / 64] >> n % 64;
    if (found == 0) {
      n = (n / 64 + 1) * 64;
      continue;
    }
    n += std::countr_zero(found);
    if (n >= last) break;
    part.next = n + 1;
    if (samples_[n] == samples_[n + 1] - 1 && note(station(n), station(n + 1), p)) return;
    ++n;
  }
  part.next = last;
}

// Notes two neighbours whose sides differ, or between which the field comes closer, goes away, and the
// tangents meet beyond the target; false where there is neither.
bool RaySearch::note(const Station& before, const Station& here, uint32_t p) {
  const auto rises = [&](float value) { return value - f_.target; };
  const double d0 = rises(before.value), d1 = rises(here.value);
  const uint32_t r = parts_[p].ray;
  if ((d0 < 0) != (d1 < 0)) {
    const auto end = [&](const Station& s) { return RootEnd{s.value - side_, s.slope}; };
    const int i = column(r), j = row(r);
    roots_.add({view_.sample(i, j, 0), view_.ray(i, j), before.k, end(before), end(here), p});
    return true;
  }
  const double side = std::copysign(1.0, -d0), s0 = side * before.slope, s1 = side * here.slope;
  if (!(s0 > 0 && s1 < 0 && side * d0 * (s0 - s1) + s0 * (side * (d1 - d0) - s1) > 0)) return false;
  grazes_.push_back({.i = 1.0 * column(r),
                     .j = 1.0 * row(r),
                     .low = 1.0 * before.k,
                     .high = 1.0 * here.k,
                     .value_low = static_cast<double>(before.value),
                     .value_high = static_cast<double>(here.value),
                     .slope_low = static_cast<double>(before.slope),
                     .slope_high = static_cast<double>(here.slope),
                     .number = p});
  return true;
}

// Whether what was found on the ray of a part lies in its part of the domain; then the ray ends.
bool RaySearch::hit(uint32_t p, double k) {
  const uint32_t r = parts_[p].ray;
  Piece& piece = piece_[r / piece_rays];
  const PieceRays& rays = piece.way.rays;
  if (k < rays.enter[r % piece_rays] - outside_tolerance ||
      k > rays.leave[r % piece_rays] + outside_tolerance) {
    scanned_.push_back(p);
    return false;
  }
  piece.open &= ~(uint64_t{1} << r % piece_rays);
  return true;
}

// Finds which of the intervals that may hold two crossings do; the others are scanned on.
void RaySearch::find_turns() {
  counts_.grazes += grazes_.size();
  const auto found = find_grazes(*f_.field, view_, f_.target, grazes_);
  passed_.assign(parts_.size(), 0);
  for (const Crossing& c : found) passed_[c.number] = 1;
  for (const Crossing& c : grazes_)
    if (passed_[c.number] == 0) scanned_.push_back(c.number);
  if (found.empty()) return;
  const auto points = refine_crossings(*f_.field, view_, f_.target, found, root_tolerance);
  for (size_t n = 0; n < points.size(); ++n)
    if (hit(found[n].number, points[n].k))
      hits_.push_back({static_cast<int>(found[n].i), static_cast<int>(found[n].j), points[n]});
}

// Refines what was found; parts for which that was nothing are scanned on.
void RaySearch::settle() {
  if (!grazes_.empty()) find_turns();
  if (roots_.empty()) return;
  for (const RayRoot& root : roots_.find()) {
    const uint32_t r = parts_[root.number].ray;
    if (!hit(root.number, root.k)) continue;
    unlit_.hits.push_back({column(r), row(r), {root.k, root.position, {}}});
    unlit_.positions.push_back(root.sample.position), unlit_.gradients.push_back(root.sample.gradient);
    unlit_.values.push_back(root.sample.value);
  }
}

// Makes the gradients of hits those that they are lit by, in world space.
void RaySearch::light() {
  f_.field->make_lit(unlit_.positions, unlit_.values, unlit_.gradients);
  for (size_t n = 0; n < unlit_.hits.size(); ++n) {
    RayHit& hit = hits_.emplace_back(unlit_.hits[n]);
    hit.point.gradient = to_lattice_.transposed(unlit_.gradients[n]);
  }
}

} // namespace bccsplat

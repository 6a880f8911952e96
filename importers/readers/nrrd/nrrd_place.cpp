// SPDX-License-Identifier: Apache-2.0
// Makes an affine of directions, spacings and ends of axes, coordinates of what the keys of axes say, and
// right-handed spaces of left-handed ones.
#include "readers/nrrd/nrrd_place.h"

#include <algorithm>
#include <cmath>

#include "readers/affine.h"
#include "readers/error.h"
#include "readers/lengths.h"
#include "readers/places.h"
#include "readers/same_place.h"
#include "readers/text.h"

namespace bcc4 {
namespace {

using Columns = std::array<std::array<double, 3>, 3>;

// Whether samples are cells, told by the ends where there is a spacing as well.
std::optional<bool> cells_by_ends(const NrrdAxis& axis) {
  if (!axis.min || !axis.max || !axis.spacing || *axis.spacing == 0) return std::nullopt;
  const double steps = std::abs((*axis.max - *axis.min) / *axis.spacing);
  const auto size = static_cast<double>(axis.size);
  if (std::abs(steps - size) < 0.01) return true;
  return std::abs(steps - (size - 1)) < 0.01 ? std::optional(false) : std::nullopt;
}

// A plane in space: the missing axis is across it.
void add_across(Columns& columns) {
  const auto &u = columns[0], &v = columns[1];
  columns[2] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const double length = std::hypot(columns[2][0], columns[2][1], columns[2][2]);
  for (double& c : columns[2]) c = length > 0 ? c / length : 0;
}

// In left-handed coordinates things are drawn as their mirror images: one axis of the space is turned round.
std::string right_handed(SeriesDescription& d, const std::string& space) {
  struct Turn {
    std::string_view from, to;
    size_t axis;
  };
  static constexpr Turn turns[] = {{"left-anterior-superior", "right-anterior-superior", 0},
                                   {"3d-left-handed", "3d-right-handed", 2}};
  for (const Turn& turn : turns) {
    if (!space.starts_with(turn.from)) continue;
    std::string now = concat(turn.to, space.substr(turn.from.size()));
    for (size_t i = 4 * turn.axis; i < 4 * turn.axis + 4; ++i)
      if (d.affine[i] != 0) d.affine[i] = -d.affine[i];
    d.notes.push_back(concat("the file's space is ", space, ", which is left-handed: its axis ",
                             "xyz"[turn.axis], " is turned round, which makes it ", now));
    return now;
  }
  return space;
}

} // namespace

AxisPlace axis_place(const NrrdAxis& axis, bool cells) {
  cells = axis.cells ? *axis.cells : cells_by_ends(axis).value_or(cells);
  const double steps = static_cast<double>(axis.size) - (cells ? 0 : 1); // from min to max
  AxisPlace place{axis.spacing, std::nullopt};
  if (axis.min && axis.max && !place.step && steps > 0) place.step = (*axis.max - *axis.min) / steps;
  const double step = place.step.value_or(1), inwards = cells ? step / 2 : 0;
  if (axis.min)
    place.first = *axis.min + inwards;
  else if (axis.max)
    place.first = *axis.max - steps * step + inwards;
  return place;
}

namespace {

std::string key_of(const NrrdHeader& h, size_t axis, const char* name) {
  const auto found = h.keys.find(concat("axis ", axis, " index ", name));
  return found == h.keys.end() ? "" : std::string(trim(found->second));
}

// The places that "axis N index values" tells of axes of space, as it does of time, where they are uneven.
void set_places(SeriesDescription& d, const NrrdHeader& h, const std::vector<AxisRole>& roles) {
  for (size_t a = 0; a < roles.size(); ++a) {
    const std::string values = key_of(h, a, "values"), kind = key_of(h, a, "type");
    if (roles[a] > AxisRole::z || values.empty() || (!kind.empty() && lower(kind) != "numeric")) continue;
    const auto numbers = parse_numbers(split(values, " \t,;"));
    if (!numbers || numbers->size() != h.axes[a].size || numbers->size() < 2 || !strictly_monotonic(*numbers))
      fail_input(h.path, ": \"axis ", a, " index values\" should give ", h.axes[a].size,
                 " numbers that rise or fall throughout: correct or remove it");
    if (evenly_spaced(*numbers)) continue;
    Places& places = d.places[static_cast<size_t>(roles[a])];
    places.down = key_of(h, a, "positive") == "down", places.coordinates = *numbers;
    if (const std::string unit = key_of(h, a, "unit"); !unit.empty()) places.unit = unit;
  }
}

// Gives space the unit of its axes where those that have one have the same.
void set_unit(SeriesDescription& d) {
  std::string unit;
  for (Places& p : d.places) {
    p.unit = length_unit(p.unit);
    if (unit.empty()) unit = p.unit;
    if (!p.unit.empty() && p.unit != unit) return;
  }
  d.spatial_unit = unit;
}

} // namespace

void set_affine(SeriesDescription& d, const NrrdHeader& h, const std::vector<AxisRole>& roles,
                const ReaderOptions& options) {
  Columns columns{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::array<double, 3> origin{};
  bool spacing = false, directions = false, has_z = false;
  for (size_t a = 0; a < roles.size(); ++a) {
    if (roles[a] > AxisRole::z) continue;
    const auto r = static_cast<size_t>(roles[a]);
    const NrrdAxis& axis = h.axes[a];
    has_z |= r == 2;
    if (axis.direction) {
      columns[r] = {};
      for (size_t i = 0; i < std::min<size_t>(3, axis.direction->size()); ++i)
        columns[r][i] = (*axis.direction)[i];
      directions = true;
    } else {
      const AxisPlace place = axis_place(axis, true); // as in Teem
      if (place.step) columns[r][r] = *place.step, spacing = true;
      origin[r] = place.first.value_or(0);
    }
    if (!axis.unit.empty()) d.places[r].unit = axis.unit;
    if (r < h.space_units.size() && !h.space_units[r].empty()) d.places[r].unit = h.space_units[r];
  }
  if (directions && !has_z) add_across(columns);
  if (h.origin)
    for (size_t i = 0; i < std::min<size_t>(3, h.origin->size()); ++i) origin[i] = (*h.origin)[i];
  d.affine = affine_from_columns(columns, origin);
  require_volume(d.affine, options, h.path, "its affine (space directions, or spacings)");
  d.affine_origin = directions ? "space directions and origin"
                    : spacing  ? "spacings and ends of the axes"
                               : "none given: one unit per voxel";
  set_places(d, h, roles);
  set_unit(d);
  if (const std::string space = right_handed(d, h.space); !space.empty())
    d.attributes.emplace_back("space", space);
}

} // namespace bcc4

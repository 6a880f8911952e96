// SPDX-License-Identifier: Apache-2.0
// Coordinates become an affine where they are evenly spaced, and are kept beside one where they are not.
// Files of a series must have their samples at the same places, but one may count an axis from its other end,
// as latitudes are counted.
#include "readers/netcdf/netcdf_space.h"

#include <algorithm>
#include <cmath>

#include "readers/affine.h"
#include "readers/error.h"
#include "readers/lengths.h"
#include "readers/netcdf/netcdf_values.h"
#include "readers/places.h"

namespace bcc4 {
namespace {

constexpr double kPartOfStep = 1e-3; // places that differ by less are one

const char* letter_of(const NetcdfLine& line) {
  static constexpr const char* letters[] = {"x", "y", "z"};
  return letters[static_cast<size_t>(line.role)];
}

NetcdfLine line_of(const NetcdfFile& file, const NetcdfVariable& v, const NetcdfDimension& dim,
                   AxisRole role) {
  NetcdfLine line{.role = role, .name = dim.name, .size = dim.size, .at = {}, .unit = "", .down = false};
  const NetcdfVariable* coordinate = file.coordinate(v, dim);
  if (!coordinate) return line;
  line.at = coordinate_values(file, *coordinate);
  line.unit = file.text(*coordinate, "units");
  line.down = role == AxisRole::z && lower(file.text(*coordinate, "positive")) == "down";
  return line;
}

// Is `other` over two or more of the variable's axes of space?
bool tells_places(const NetcdfVariable& v, const std::vector<AxisRole>& roles, const NetcdfVariable& other) {
  size_t shared = 0;
  for (size_t a = 0; a < roles.size(); ++a)
    for (const NetcdfDimension& d : other.dims)
      shared += roles[a] != AxisRole::t && v.dims[a].size > 1 && d.id == v.dims[a].id ? 1 : 0;
  return shared >= 2;
}

bool of_the_globe(const NetcdfFile& file, const NetcdfVariable& v) {
  const std::string units = lower(file.text(v, "units")), standard = file.text(v, "standard_name");
  return units.starts_with("degrees_") || units.starts_with("degree_") || standard == "longitude" ||
         standard == "latitude";
}

std::vector<std::string> curvilinear(const NetcdfFile& file, const NetcdfVariable& v,
                                     const std::vector<AxisRole>& roles) {
  std::vector<std::string> names;
  const std::string coordinates = file.text(v, "coordinates");
  for (const std::string_view name : split(coordinates))
    if (const NetcdfVariable* other = file.near(v, std::string(name));
        other && other->type && tells_places(v, roles, *other))
      names.push_back(other->name);
  if (names.empty())
    for (const NetcdfVariable& other : file.variables())
      if (other.type && other.name != v.name && tells_places(v, roles, other) && of_the_globe(file, other))
        names.push_back(other.name);
  return names;
}

void warn_of_uneven(SeriesDescription& d, const NetcdfLine& line) {
  d.warnings.push_back(
      concat(line.name, " is not evenly spaced (", short_number(line.at.front()), " to ",
             short_number(line.at.back()),
             ") and does not rise or fall throughout: its index is the coordinate; --spacing sets another"));
}

void note_uneven(SeriesDescription& d, const NetcdfLine& line) {
  d.notes.push_back(concat(line.name, ": ", line.size, " samples at uneven places, ",
                           short_number(line.at.front()), " to ", short_number(line.at.back()),
                           line.unit.empty() ? "" : " ", line.unit, ", which are kept"));
}

// Says of which axes the places are not known, where some are or would be.
void describe_unknown(SeriesDescription& d, const NetcdfSpace& space, const std::vector<std::string>& unknown,
                      bool some_known) {
  if (unknown.empty()) return;
  const std::string instead =
      concat("along ", join(unknown),
             " the index is the coordinate, without a unit; --spacing SX,SY,SZ sets another");
  if (!space.curvilinear.empty())
    d.warnings.push_back(concat("a curvilinear grid: ", join(space.curvilinear),
                                " tell places over several axes together, which cannot be kept; ", instead));
  else if (some_known)
    d.notes.push_back("not all axes have coordinates: " + instead);
}

// Axes of one unit give the world that unit; `axes` is how many there are, those without a unit included.
void describe_units(SeriesDescription& d, const std::vector<std::string>& units, size_t axes) {
  const bool agree = std::all_of(units.begin(), units.end(),
                                 [&](const auto& u) { return length_unit(u) == length_unit(units[0]); });
  if (agree && !units.empty() && units.size() == axes) d.spatial_unit = length_unit(units[0]);
  if (!agree)
    d.notes.push_back(concat("the axes have different units: ", join(units),
                             "; bcc4 render --shape says in which proportions they are drawn"));
}

// The samples of both are at one place each, one after the other or from the other end.
bool same_places(const NetcdfLine& a, const NetcdfLine& b, bool turned) {
  const double sign = a.down == b.down ? 1 : -1, step = std::abs(mean_step(a.at));
  const double close = step > 0 ? kPartOfStep * step : 1e-6 * std::abs(a.at.front());
  for (size_t i = 0; i < a.at.size(); ++i)
    if (!(std::abs(a.at[i] - sign * b.at[turned ? b.at.size() - 1 - i : i]) <= close)) return false;
  return true;
}

// What holds for the first file alone is not said of the series.
void forget_places(SeriesDescription& d, const NetcdfLine& line, const std::string& path) {
  std::vector<double>& at = d.places[static_cast<size_t>(line.role)].coordinates;
  if (at.empty()) return;
  at.clear();
  d.warnings.push_back(concat("the samples along ", line.name, " of ", path,
                              " are not at the places of the first file: no coordinates are kept of it"));
}

std::string run_text(const NetcdfLine& line) {
  if (line.at.empty()) return "not told";
  return concat(short_number(line.at.front(), 6), " to ", short_number(line.at.back(), 6),
                line.unit.empty() ? "" : " ", line.unit, line.down ? ", down" : "");
}

} // namespace

NetcdfSpace netcdf_space(const NetcdfFile& file, const NetcdfVariable& v,
                         const std::vector<AxisRole>& roles) {
  NetcdfSpace space;
  for (size_t a = 0; a < roles.size(); ++a)
    if (roles[a] != AxisRole::t) space.lines.push_back(line_of(file, v, v.dims[a], roles[a]));
  space.curvilinear = curvilinear(file, v, roles);
  return space;
}

void describe_space(SeriesDescription& d, const NetcdfSpace& space) {
  std::array<std::array<double, 3>, 3> columns{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::array<double, 3> origin{};
  std::vector<std::string> known, unknown, units;
  size_t axes = 0;
  for (const NetcdfLine& line : space.lines) {
    if (line.size < 2) continue;
    ++axes;
    if (line.at.empty()) {
      unknown.emplace_back(letter_of(line));
      continue;
    }
    const auto r = static_cast<size_t>(line.role);
    d.places[r].unit = length_unit(line.unit), d.places[r].down = line.down;
    if (!evenly_spaced(line.at)) {
      if (!strictly_monotonic(line.at)) {
        warn_of_uneven(d, line);
        continue;
      }
      d.places[r].coordinates = line.at;
      note_uneven(d, line);
    }
    if (line.down) d.notes.push_back(concat(line.name, " counts down: z is what is above its 0"));
    const double sign = line.down ? -1 : 1;
    columns[r][r] = sign * mean_step(line.at);
    origin[r] = sign * line.at[0] + 0.0; // not -0
    known.push_back(line.name);
    if (!line.unit.empty()) units.push_back(line.unit);
  }
  d.affine = affine_from_columns(columns, origin);
  d.affine_origin = known.empty() ? "none given: one unit per voxel" : "coordinate variables " + join(known);
  describe_unknown(d, space, unknown, !known.empty());
  describe_units(d, units, axes);
}

std::array<bool, 3> turned_axes(SeriesDescription& d, const NetcdfSpace& first, const NetcdfSpace& space,
                                const std::string& path, bool any_place) {
  std::array<bool, 3> turned{};
  for (size_t i = 0; i < space.lines.size(); ++i) {
    const NetcdfLine &a = first.lines[i], &b = space.lines[i];
    if (a.size != b.size)
      fail_input(path, ": dimension ", b.name, " has ", b.size, " samples, not ", a.size,
                 " as in the first file: import them one by one");
    const bool comparable = a.at.size() == b.at.size() && length_unit(a.unit) == length_unit(b.unit);
    if (comparable && (a.at.empty() || same_places(a, b, false))) continue;
    if (comparable && same_places(a, b, true))
      turned[static_cast<size_t>(b.role)] = true;
    else if (!any_place)
      fail_input(path, ": the samples along ", b.name, " are not at the places of the first file (",
                 run_text(b), ", there ", run_text(a),
                 "): import them one by one, or say by --spacing that their indices are the coordinates");
    else
      forget_places(d, b, path);
  }
  return turned;
}

} // namespace bcc4

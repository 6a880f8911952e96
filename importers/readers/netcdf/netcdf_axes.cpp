// SPDX-License-Identifier: Apache-2.0
#include "readers/netcdf/netcdf_axes.h"

#include <algorithm>
#include <array>
#include <optional>

#include "readers/error.h"

namespace bcc4 {
namespace {

bool one_of(const std::string& text, std::initializer_list<const char*> words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

// Tells a role by the attributes of the coordinate variable (CF conventions, chapter 4).
std::optional<AxisRole> by_attributes(const NetcdfFile& file, const NetcdfVariable& variable,
                                      const NetcdfDimension& dim) {
  const NetcdfVariable* coordinate = file.near(variable, dim.name);
  if (!coordinate) return std::nullopt;
  const std::string axis = lower(file.text(*coordinate, "axis"));
  if (axis.size() == 1 && std::string("xyzt").find(axis) != std::string::npos)
    return static_cast<AxisRole>(std::string("xyzt").find(axis));
  const std::string units = lower(file.text(*coordinate, "units"));
  const std::string standard = file.text(*coordinate, "standard_name");
  if (units.find(" since ") != std::string::npos || units.find(" as %y") != std::string::npos ||
      standard == "time" || standard == "forecast_period")
    return AxisRole::t;
  if (one_of(units, {"degrees_east", "degree_east", "degree_e", "degrees_e"}) ||
      one_of(standard, {"longitude", "grid_longitude", "projection_x_coordinate"}))
    return AxisRole::x;
  if (one_of(units, {"degrees_north", "degree_north", "degree_n", "degrees_n"}) ||
      one_of(standard, {"latitude", "grid_latitude", "projection_y_coordinate"}))
    return AxisRole::y;
  if (one_of(lower(file.text(*coordinate, "positive")), {"up", "down"}) ||
      one_of(units, {"hpa", "pa", "mbar", "millibar", "millibars"}))
    return AxisRole::z;
  if (one_of(units, {"s", "sec", "second", "seconds", "min", "minute", "minutes", "h", "hr", "hour", "hours",
                     "d", "day", "days", "ms"}))
    return AxisRole::t;
  return std::nullopt;
}

std::optional<AxisRole> by_name(const NetcdfDimension& dim) {
  const std::string name = lower(dim.name);
  if (one_of(name, {"t", "time", "times", "frame", "frames", "step", "timestep"})) return AxisRole::t;
  if (one_of(name, {"x", "lon", "longitude", "nx", "xdim"})) return AxisRole::x;
  if (one_of(name, {"y", "lat", "latitude", "ny", "ydim"})) return AxisRole::y;
  if (one_of(name, {"z", "lev", "level", "depth", "height", "altitude", "nz", "zdim"})) return AxisRole::z;
  if (dim.record) return AxisRole::t;
  return std::nullopt;
}

} // namespace

NetcdfAxes find_axes(const NetcdfFile& file, const NetcdfVariable& variable, const std::string& letters) {
  const size_t n = variable.dims.size();
  NetcdfAxes axes;
  axes.roles.resize(n);
  if (!letters.empty()) {
    axes.roles = roles_from_letters(letters, n, concat(variable.name, " in ", file.path()));
    std::reverse(axes.roles.begin(), axes.roles.end());
    axes.why = "axes by --axes";
    return axes;
  }
  if (n > 4) fail_input(file.path(), ": ", variable.name, " has ", n, " dimensions; four can be read");
  std::vector<std::optional<AxisRole>> found(n);
  std::array<bool, 4> taken{};
  for (const bool attributes : {true, false})
    for (size_t a = 0; a < n; ++a) {
      if (found[a]) continue;
      const auto role =
          attributes ? by_attributes(file, variable, variable.dims[a]) : by_name(variable.dims[a]);
      if (!role || (!attributes && taken[static_cast<size_t>(*role)])) continue;
      if (taken[static_cast<size_t>(*role)])
        fail_input(file.path(), ": two dimensions of ", variable.name, " are ",
                   "xyzt"[static_cast<size_t>(*role)],
                   " by their attributes; name them, fastest first, such as --axes ",
                   std::string("xyzt").substr(0, n));
      found[a] = role;
      taken[static_cast<size_t>(*role)] = true;
      axes.why +=
          concat(axes.why.empty() ? "" : ", ", variable.dims[a].name, " is ",
                 "xyzt"[static_cast<size_t>(*role)], attributes ? " by its attributes" : " by its name");
    }
  // What is left is in the order of the convention: x fastest, then y, z, time.
  size_t next = 0;
  for (size_t a = n; a-- > 0;) {
    if (!found[a]) {
      while (next < 4 && taken[next]) ++next;
      found[a] = static_cast<AxisRole>(next);
      taken[next] = true;
      axes.why +=
          concat(axes.why.empty() ? "" : ", ", variable.dims[a].name, " is ", "xyzt"[next], " by its place");
    }
    axes.roles[a] = *found[a];
  }
  return axes;
}

} // namespace bcc4

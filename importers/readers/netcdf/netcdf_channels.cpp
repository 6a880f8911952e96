// SPDX-License-Identifier: Apache-2.0
// Files of one series may scale their numbers each in its own way: what they share is the type of the values.
#include "readers/netcdf/netcdf_channels.h"

#include <algorithm>

#include "readers/error.h"
#include "readers/netcdf/netcdf_values.h"

namespace bcc4 {
namespace {

// Returns the names of what other variables call their coordinates.
std::vector<std::string> auxiliary_coordinates(const NetcdfFile& file) {
  std::vector<std::string> names;
  for (const NetcdfVariable& v : file.variables()) {
    const std::string coordinates = file.text(v, "coordinates");
    for (const std::string_view name : split(coordinates))
      if (const NetcdfVariable* found = file.near(v, std::string(name)); found && found->name != v.name)
        names.push_back(found->name);
  }
  return names;
}

// Those over three axes or more of several values each; where there are none, those over three axes of which
// one or two have a single value, as a flat picture is exported.
std::vector<std::string> candidates(const NetcdfFile& file) {
  const std::vector<std::string> others = auxiliary_coordinates(file);
  std::vector<std::string> names, flat;
  for (const NetcdfVariable& v : file.variables()) {
    if (!v.type || v.dims.size() < 3 || is_coordinate(v) ||
        std::find(others.begin(), others.end(), v.name) != others.end())
      continue;
    const auto wide = std::count_if(v.dims.begin(), v.dims.end(), [](const auto& d) { return d.size > 1; });
    (wide >= 3 ? names : flat).push_back(v.name);
  }
  return names.empty() ? flat : names;
}

bool same_scale(const StoredValues& a, const StoredValues& b) {
  return a.type == b.type && a.slope == b.slope && a.intercept == b.intercept;
}

// Returns the type that holds the values of all files.
Type common_type(const std::vector<StoredValues>& files) {
  const auto equal = [&](const StoredValues& s) { return s.value_type() == files[0].value_type(); };
  if (std::all_of(files.begin(), files.end(), equal)) return files[0].value_type();
  const auto wide = [](const StoredValues& s) {
    return s.value_type() != Type::f32 && type_size(s.value_type()) >= 4;
  };
  return std::any_of(files.begin(), files.end(), wide) ? Type::f64 : Type::f32;
}

bool has_holes(const StoredValues& s) { return !s.fills.empty() || s.valid; }

} // namespace

std::vector<std::string> chosen_variables(const NetcdfFile& file, const ReaderOptions& options) {
  std::vector<std::string> names = candidates(file);
  if (options.channels.empty()) {
    if (names.empty()) fail_input(file.path(), ": no variable of numbers over three or four dimensions");
    if (names.size() > 1)
      fail_usage(file.path(), ": ", names.size(), " variables: choose with --channel among ", join(names));
    return names;
  }
  std::vector<std::string> chosen;
  for (const std::string& name : options.channels) {
    const NetcdfVariable* v = file.find(name);
    if (!v || !v->type)
      fail_usage(file.path(), ": no variable \"", name, "\"", did_you_mean(name, names), "; it has ",
                 names.empty() ? "none of numbers over three or four dimensions" : join(names));
    chosen.push_back(v->name);
  }
  return chosen;
}

std::vector<const NetcdfVariable*> find_variables(const NetcdfFile& file,
                                                  const std::vector<std::string>& names) {
  std::vector<const NetcdfVariable*> found;
  const auto same = [](const NetcdfDimension& p, const NetcdfDimension& q) { return p.id == q.id; };
  for (const std::string& name : names) {
    const NetcdfVariable* v = file.find(name);
    if (!v || !v->type)
      fail_input(file.path(), ": no variable \"", name, "\" of numbers as in the first file");
    found.push_back(v);
    const auto &first = found[0]->dims, &own = v->dims;
    if (!std::equal(own.begin(), own.end(), first.begin(), first.end(), same))
      fail_usage(file.path(), ": ", v->name, " and ", found[0]->name,
                 " have different dimensions: import them one by one");
  }
  return found;
}

void add_file(NetcdfChannel& channel, const NetcdfFile& file, const NetcdfVariable& v) {
  const std::string unit = file.text(v, "units");
  if (channel.of_files.empty()) channel.unit = unit;
  if (unit != channel.unit)
    fail_input(file.path(), ": ", v.name, " is in \"", unit, "\", not in \"", channel.unit,
               "\" as in the first file: convert one of them, or import them one by one");
  channel.of_files.push_back(stored_values(file, v));
}

void describe_channel(SeriesDescription& d, const NetcdfChannel& channel) {
  const std::vector<StoredValues>& files = channel.of_files;
  Channel c{.name = channel.name,
            .unit = channel.unit,
            .type = common_type(files),
            .has_fill = std::any_of(files.begin(), files.end(), has_holes)};
  const auto same = [&](const StoredValues& s) { return same_scale(s, files[0]); };
  if (std::all_of(files.begin(), files.end(), same)) {
    files[0].describe(c, d);
  } else {
    c.precision = c.type;
    d.notes.push_back(concat(c.name, ": the files store it in different ways, by type, scale or offset; ",
                             "each is read in its own, as floats"));
  }
  const auto limited =
      std::find_if(files.begin(), files.end(), [](const StoredValues& s) { return s.valid.has_value(); });
  if (limited != files.end())
    d.notes.push_back(concat(c.name, ": stored values outside ", short_number((*limited->valid)[0]), " to ",
                             short_number((*limited->valid)[1]), " are holes (valid range)"));
  d.channels.push_back(std::move(c));
}

} // namespace bcc4

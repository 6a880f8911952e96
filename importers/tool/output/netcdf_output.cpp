// SPDX-License-Identifier: Apache-2.0
// A variable over time, z, y and x with a coordinate variable for each, in NetCDF-4. Axes are called by the
// axis of the world that they run along.
#include "tool/output/netcdf_output.h"

#include <netcdf.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>

#include "readers/error.h"
#include "readers/records.h"
#include "readers/text.h"
#include "tool/exit.h"

namespace bcc4 {
namespace {

nc_type netcdf_type(Type type) {
  switch (type) {
  case Type::u8:
    return NC_UBYTE;
  case Type::i8:
    return NC_BYTE;
  case Type::u16:
    return NC_USHORT;
  case Type::i16:
    return NC_SHORT;
  case Type::u32:
    return NC_UINT;
  case Type::i32:
    return NC_INT;
  default:
    return NC_FLOAT;
  }
}

// Returns the axis of the world that one of the grid runs along; 3: along none.
size_t world_axis(const Affine& m, size_t a) {
  size_t found = 3, count = 0;
  for (size_t row = 0; row < 3; ++row)
    if (m[4 * row + a] != 0) found = row, ++count;
  return count == 1 ? found : 3;
}

// Returns the places of the samples along an axis of the grid.
std::vector<double> coordinates_of(const VolumeOutput& o, size_t a) {
  if (!o.coordinates[a].empty()) return o.coordinates[a];
  const size_t row = world_axis(o.affine, a);
  std::vector<double> at(o.dims[a]);
  for (size_t i = 0; i < at.size(); ++i)
    at[i] = o.affine[4 * row + 3] + o.affine[4 * row + a] * static_cast<double>(i);
  return at;
}

// Names are letters, digits and underscores, with a letter first, wherever they are read.
std::string legal_name(const std::string& text) {
  std::string name;
  for (const char c : text) name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  if (name.empty() || std::isalpha(static_cast<unsigned char>(name[0])) == 0) name.insert(0, "v_");
  return name;
}

struct Axis {
  std::string name; // of the dimension and its variable
  Record attributes;
  std::vector<double> at;
};

// The axis that a record speaks of, and what has to be said of it where the record does not.
Axis axis_of(const std::string& record, const std::string& usual_name, char letter, const std::string& unit) {
  Axis axis{usual_name, read_record(record), {}};
  if (const std::string name = text_in(axis.attributes, "name"); !name.empty()) axis.name = legal_name(name);
  axis.attributes.erase("name");
  if (!unit.empty() && text_in(axis.attributes, "units").empty()) axis.attributes["units"] = unit;
  if (!axis.attributes.contains("axis")) axis.attributes["axis"] = std::string(1, letter);
  return axis;
}

// Makes an axis one of dates, where the file knows the date of its 0.
void set_date(Axis& axis, const VolumeOutput& o) {
  if (o.epoch.empty() || o.time_unit.empty() || text_in(axis.attributes, "units") != o.time_unit) return;
  axis.attributes["units"] = concat(o.time_unit, " since ", o.epoch);
  if (!axis.attributes.contains("standard_name")) axis.attributes["standard_name"] = "time";
  axis.attributes["calendar"] = o.calendar.empty() ? "standard" : o.calendar;
}

// The axes of time, z, y and x, as the file has them.
std::vector<Axis> axes_of(const VolumeOutput& o) {
  std::vector<Axis> axes;
  std::vector<std::string> usual;
  if (!o.times.empty()) {
    axes.push_back(axis_of(o.axis_records[3], usual.emplace_back("time"), 'T', o.time_unit));
    axes[0].at = o.times;
    set_date(axes[0], o);
  }
  for (size_t a = 3; a-- > 0;) {
    const size_t row = world_axis(o.affine, a);
    const bool of_slice = !o.axis_names[a].empty();
    usual.push_back(of_slice ? o.axis_names[a] : std::string(1, "xyz"[row]));
    const auto letter = static_cast<char>(std::toupper(static_cast<unsigned char>(usual.back()[0])));
    Axis axis = axis_of(o.axis_records[a], usual.back(), letter, o.axis_units[of_slice ? a : row]);
    axis.at = coordinates_of(o, a);
    if (o.coordinates_down[a]) axis.attributes["positive"] = "down";
    if (letter == 'Z' && o.coordinates[a].empty() && lower(text_in(axis.attributes, "positive")) == "down")
      for (double& at : axis.at) at = -at + 0.0; // not -0
    if (letter == 'T') set_date(axis, o);
    axes.push_back(std::move(axis));
  }
  std::set<std::string> names{legal_name(o.name)};
  for (const Axis& axis : axes) names.insert(axis.name);
  for (size_t i = 0; i < axes.size() && names.size() <= axes.size(); ++i) axes[i].name = usual[i];
  return axes;
}

// A file that HDF5 could not write it cannot close either: it crashes, be it at the end of the program. Such
// a file stays open, and the program ends before HDF5 comes to it.
void end_without_hdf5() {
  std::fflush(nullptr);
  std::_Exit(static_cast<int>(Exit::no_resources));
}

class NetcdfOutputFile : public VolumeFile {
 public:
  NetcdfOutputFile(const std::string& path, const std::string& name, const VolumeOutput& o)
      : name_(name), type_(o.type), plane_bytes_(o.dims[0] * o.dims[1] * type_size(o.type)) {
    check(nc_create(path.c_str(), NC_NETCDF4 | NC_CLOBBER, &id_), "cannot be made");
    open_ = true;
    define(o);
  }
  NetcdfOutputFile(const NetcdfOutputFile&) = delete;
  NetcdfOutputFile& operator=(const NetcdfOutputFile&) = delete;
  ~NetcdfOutputFile() override {
    if (open_) nc_abort(id_), nc_close(id_);
  }

  void write(std::span<const std::byte> planes) override {
    const size_t count = planes.size() / plane_bytes_;
    std::vector<size_t> start{plane_ / sizes_[1], plane_ % sizes_[1], 0, 0},
        counts{1, count, sizes_[2], sizes_[3]};
    if (!has_time_) start.erase(start.begin()), counts.erase(counts.begin());
    check(nc_put_vara(id_, variable_, start.data(), counts.data(), planes.data()), "cannot be written");
    plane_ += count;
  }

  void finish() override {
    open_ = false;
    check(nc_close(id_), "cannot be written");
  }

 private:
  void check(int status, const char* doing) {
    if (status == NC_NOERR) return;
    if (status > NC_EHDFERR || status < NC_EVARMETA) // those between are of HDF5
      fail_input(name_, ": ", doing, ": ", nc_strerror(status));
    open_ = false;
    std::atexit(end_without_hdf5);
    fail_resources(name_, ": ", doing, ": ", nc_strerror(status), " (is the disk full?)");
  }
  // Some names NetCDF keeps for itself, others are too long for it.
  void check_attribute(int status) {
    if (status != NC_EBADNAME && status != NC_ENAMEINUSE && status != NC_EMAXNAME)
      check(status, "cannot be written");
  }
  void text(int variable, const char* key, const std::string& value) {
    if (!value.empty()) check_attribute(nc_put_att_text(id_, variable, key, value.size(), value.c_str()));
  }

  void put(int variable, const std::string& key, const Record& value) {
    if (value.is_string()) return text(variable, key.c_str(), value.get<std::string>());
    const Record list = value.is_array() ? value : Record::array({value});
    const auto all = [&](auto is) { return !list.empty() && std::all_of(list.begin(), list.end(), is); };
    if (!all([](const Record& n) { return n.is_number(); })) return text(variable, key.c_str(), value.dump());
    const bool whole =
        all([](const Record& n) { return n.is_number_integer() && std::abs(n.get<double>()) < 0x1p31; });
    const auto numbers = list.get<std::vector<double>>();
    check_attribute(nc_put_att_double(id_, variable, key.c_str(), whole ? NC_INT : NC_DOUBLE, numbers.size(),
                                      numbers.data()));
  }

  // Defines a dimension and its variable; returns both numbers.
  std::pair<int, int> define_axis(const Axis& axis) {
    int dimension = 0, variable = 0;
    check(nc_def_dim(id_, axis.name.c_str(), axis.at.size(), &dimension), "cannot be written");
    check(nc_def_var(id_, axis.name.c_str(), NC_DOUBLE, 1, &dimension, &variable), "cannot be written");
    for (const auto& [key, value] : axis.attributes.items())
      if (in_record(key, false)) put(variable, key, value);
    return {dimension, variable};
  }

  void define(const VolumeOutput& o) {
    text(NC_GLOBAL, "Conventions", "CF-1.8");
    text(NC_GLOBAL, "source", "bcc4");
    for (const auto& [key, value] : o.keys) {
      std::string name = key;
      std::replace(name.begin(), name.end(), ' ', '_');
      text(NC_GLOBAL, name.c_str(), value);
    }
    has_time_ = !o.times.empty();
    const std::vector<Axis> axes = axes_of(o);
    std::vector<int> dimensions, variables;
    for (const Axis& axis : axes) {
      const auto [dimension, variable] = define_axis(axis);
      dimensions.push_back(dimension), variables.push_back(variable);
    }
    std::string name = legal_name(o.name);
    const auto is_axis = [&](const Axis& axis) { return axis.name == name; };
    if (std::any_of(axes.begin(), axes.end(), is_axis)) name += "_values";
    define_values(o, name, dimensions);
    check(nc_enddef(id_), "cannot be written");
    for (size_t i = 0; i < axes.size(); ++i)
      check(nc_put_var_double(id_, variables[i], axes[i].at.data()), "cannot be written");
    sizes_ = {axes.size() == 4 ? axes[0].at.size() : 1, o.dims[2], o.dims[1], o.dims[0]};
  }

  void define_values(const VolumeOutput& o, const std::string& name, const std::vector<int>& dimensions) {
    check(nc_def_var(id_, name.c_str(), netcdf_type(type_), static_cast<int>(dimensions.size()),
                     dimensions.data(), &variable_),
          "cannot be written");
    Record said = read_record(o.record);
    if (said.empty()) said["long_name"] = o.name;
    if (!o.unit.empty()) said["units"] = o.unit;
    for (const auto& [key, value] : said.items())
      if (in_record(key, false)) put(variable_, key, value);
    if (!o.fill) return;
    std::vector<std::byte> fill(type_size(type_));
    visit_type(type_, [&](auto zero) {
      using T = decltype(zero);
      if constexpr (std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) <= 4))
        store_as<T>(*o.fill, fill.data());
    });
    check(nc_put_att(id_, variable_, "_FillValue", netcdf_type(type_), 1, fill.data()), "cannot be written");
  }

  std::string name_;
  Type type_;
  size_t plane_bytes_;
  int id_ = 0, variable_ = 0;
  bool open_ = false, has_time_ = false;
  std::array<size_t, 4> sizes_{}; // time, z, y, x
  size_t plane_ = 0;              // the next one, counted through all frames
};

} // namespace

void require_netcdf_axes(const VolumeOutput& o, const std::string& name) {
  bool used[4]{};
  for (size_t a = 0; a < 3; ++a) {
    const size_t row = world_axis(o.affine, a);
    if (row == 3 || used[row])
      fail_input(name,
                 ": its axes do not run along those of the world, which coordinates of NetCDF cannot say: ",
                 "write .nii, .vti or .nrrd");
    used[row] = true;
  }
}

std::unique_ptr<VolumeFile> create_netcdf(const std::string& path, const std::string& name,
                                          const VolumeOutput& output) {
  require_netcdf_axes(output, name);
  return std::make_unique<NetcdfOutputFile>(path, name, output);
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// NetCDF files for the tests of their reader.
#pragma once

#include <netcdf.h>

#include <cstring>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "scratch.h"

namespace bcc4::test {

inline void check_nc(int status) { ASSERT_EQ(status, NC_NOERR) << nc_strerror(status); }

struct NcDim {
  const char* name;
  size_t size;
  const char* units = nullptr; // of a coordinate variable: 0, step, 2 step ...
  double step = 1;
  nc_type type = NC_DOUBLE; // of the coordinate variable
};

// A file with one variable `v` over the dimensions, slowest first, holding 0, 1, 2 ...
struct NcFile {
  explicit NcFile(const std::string& path, const std::vector<NcDim>& dims, nc_type type = NC_FLOAT,
                  int format = NC_CLASSIC_MODEL, double first_time = 0) {
    check_nc(nc_create(path.c_str(), NC_CLOBBER | format, &id));
    std::vector<int> ids(dims.size());
    for (size_t d = 0; d < dims.size(); ++d) {
      check_nc(nc_def_dim(id, dims[d].name, dims[d].size, &ids[d]));
      count *= dims[d].size;
      if (!dims[d].units) continue;
      int axis = 0;
      check_nc(nc_def_var(id, dims[d].name, dims[d].type, 1, &ids[d], &axis));
      check_nc(nc_put_att_text(id, axis, "units", std::strlen(dims[d].units), dims[d].units));
      axes.push_back({axis, d});
    }
    check_nc(nc_def_var(id, "v", type, static_cast<int>(dims.size()), ids.data(), &variable));
    lines = dims;
    start = first_time;
  }
  // Writes 0, 1, 2 ... or the values.
  void finish(std::vector<double> values = {}) {
    check_nc(nc_enddef(id));
    for (const auto& [axis, d] : axes) {
      std::vector<double> at(lines[d].size);
      for (size_t i = 0; i < at.size(); ++i)
        at[i] = (d == 0 ? start : 0) + lines[d].step * static_cast<double>(i);
      check_nc(nc_put_var_double(id, axis, at.data()));
    }
    if (values.empty()) {
      values.resize(count);
      std::iota(values.begin(), values.end(), 0.0);
    }
    check_nc(nc_put_var_double(id, variable, values.data()));
    check_nc(nc_close(id));
  }
  // The attributes of a variable; those of `v` without one.
  void put(const char* name, const char* text, int of = -1) const {
    check_nc(nc_put_att_text(id, of < 0 ? variable : of, name, std::strlen(text), text));
  }
  void put(const char* name, double number, int of = -1, nc_type type = NC_DOUBLE) const {
    check_nc(nc_put_att_double(id, of < 0 ? variable : of, name, type, 1, &number));
  }
  int id = -1, variable = -1;
  size_t count = 1;
  double start = 0;
  std::vector<std::pair<int, size_t>> axes;
  std::vector<NcDim> lines;
};

inline const std::vector<NcDim> plain_dims{{"time", 5}, {"z", 4}, {"y", 3}, {"x", 2}};

} // namespace bcc4::test

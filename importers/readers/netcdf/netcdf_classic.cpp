// SPDX-License-Identifier: Apache-2.0
// Counts the header to the byte (the format's specification, appendix B of the NetCDF user's guide) and the
// values of all variables, without the padding between them.
#include "readers/netcdf/netcdf_classic.h"

#include <cstring>

#include <netcdf.h>

namespace bcc4 {
namespace {

uint64_t padded(uint64_t bytes) { return (bytes + 3) / 4 * 4; }

// Sizes in a header of which counts take `word` bytes.
struct ClassicHeader {
  int id;
  uint64_t word;

  uint64_t named(const char* name) const { return word + padded(std::strlen(name)); }
  uint64_t attributes(int variable) const {
    int count = 0;
    uint64_t bytes = 4 + word;
    if (nc_inq_varnatts(id, variable, &count) != NC_NOERR) return bytes;
    for (int a = 0; a < count; ++a) {
      char name[NC_MAX_NAME + 1] = "";
      nc_type type = NC_NAT;
      size_t length = 0, size = 0;
      if (nc_inq_attname(id, variable, a, name) != NC_NOERR ||
          nc_inq_att(id, variable, name, &type, &length) != NC_NOERR ||
          nc_inq_type(id, type, nullptr, &size) != NC_NOERR)
        continue;
      bytes += named(name) + 4 + word + padded(length * size);
    }
    return bytes;
  }
  uint64_t dimensions() const {
    uint64_t bytes = 0;
    int dims = 0;
    if (nc_inq_ndims(id, &dims) != NC_NOERR) return bytes;
    for (int d = 0; d < dims; ++d) {
      char name[NC_MAX_NAME + 1] = "";
      if (nc_inq_dimname(id, d, name) == NC_NOERR) bytes += named(name) + word;
    }
    return bytes;
  }
};

} // namespace

uint64_t least_classic_bytes(int id, const std::vector<NetcdfVariable>& variables) {
  int format = 0;
  if (nc_inq_format(id, &format) != NC_NOERR || format == NC_FORMAT_NETCDF4 ||
      format == NC_FORMAT_NETCDF4_CLASSIC)
    return 0;
  const uint64_t word = format == NC_FORMAT_CDF5 ? 8 : 4;
  const ClassicHeader header{id, word};
  uint64_t bytes = 4 + word + 2 * (4 + word) + header.attributes(NC_GLOBAL) + header.dimensions();
  for (const NetcdfVariable& v : variables) {
    bytes += header.named(v.name.c_str()) + word + v.dims.size() * word + header.attributes(v.id) + 4 + word +
             word;
    uint64_t values = v.type ? type_size(*v.type) : 1;
    for (const NetcdfDimension& d : v.dims) {
      if (d.size > 0 && values > UINT64_MAX / 4 / d.size) return UINT64_MAX;
      values *= d.size;
    }
    bytes += values;
  }
  return bytes;
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// Wraps libnetcdf: what a file holds is read once when it is opened, values when they are asked for. Classic
// files that were cut off are found by their size, because the library reads zeros beyond their end.
#include "readers/netcdf/netcdf_file.h"

#include <algorithm>
#include <cstring>

#include <netcdf.h>

#include "readers/byte_stream.h"
#include "readers/error.h"

namespace bcc4 {
namespace {

std::optional<Type> type_of(nc_type type) {
  switch (type) {
  case NC_BYTE:
    return Type::i8;
  case NC_UBYTE:
    return Type::u8;
  case NC_SHORT:
    return Type::i16;
  case NC_USHORT:
    return Type::u16;
  case NC_INT:
    return Type::i32;
  case NC_UINT:
    return Type::u32;
  case NC_INT64:
    return Type::i64;
  case NC_UINT64:
    return Type::u64;
  case NC_FLOAT:
    return Type::f32;
  case NC_DOUBLE:
    return Type::f64;
  default:
    return std::nullopt;
  }
}

constexpr size_t kAttributeLimit = 1 << 20; // values
constexpr size_t kLineLimit = 1 << 24;

// Returns the bytes that a classic file holds at the very least: its header to the byte (the format's
// specification, appendix B of the NetCDF user's guide) and the values of all variables, without the padding
// between them. The library reads what lies beyond the end of a file as zeros, so a file that was cut off
// must be found by its size.
uint64_t least_classic_bytes(int id, bool wide, const std::vector<NetcdfVariable>& variables) {
  const uint64_t word = wide ? 8 : 4; // counts and sizes
  const auto padded = [](uint64_t n) { return (n + 3) / 4 * 4; };
  const auto named = [&](const char* name) { return word + padded(std::strlen(name)); };
  const auto attributes = [&](int variable) {
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
  };
  uint64_t bytes = 4 + word + 2 * (4 + word) + attributes(NC_GLOBAL);
  int dims = 0;
  if (nc_inq_ndims(id, &dims) == NC_NOERR)
    for (int d = 0; d < dims; ++d) {
      char name[NC_MAX_NAME + 1] = "";
      if (nc_inq_dimname(id, d, name) == NC_NOERR) bytes += named(name) + word;
    }
  for (const NetcdfVariable& v : variables) {
    bytes += named(v.name.c_str()) + word + v.dims.size() * word + attributes(v.id) + 4 + word + word;
    uint64_t values = v.type ? type_size(*v.type) : 1;
    for (const NetcdfDimension& d : v.dims) {
      if (d.size > 0 && values > UINT64_MAX / 4 / d.size) return UINT64_MAX;
      values *= d.size;
    }
    bytes += values;
  }
  return bytes;
}

} // namespace

template<class... Parts> void NetcdfFile::check(int status, const Parts&... doing) const {
  if (status != NC_NOERR) fail_input(path_, ": ", doing..., ": ", nc_strerror(status));
}

NetcdfFile::NetcdfFile(const std::string& path) : path_(path) {
  check(nc_open(path.c_str(), NC_NOWRITE, &id_), "cannot be read as NetCDF");
  try {
    int variables = 0, unlimited = 0;
    check(nc_inq_nvars(id_, &variables), "its variables");
    check(nc_inq_unlimdims(id_, &unlimited, nullptr), "its dimensions");
    std::vector<int> records(static_cast<size_t>(unlimited));
    check(nc_inq_unlimdims(id_, &unlimited, records.data()), "its dimensions");
    for (int v = 0; v < variables; ++v) {
      char name[NC_MAX_NAME + 1] = "";
      nc_type type = NC_NAT;
      int count = 0;
      int ids[NC_MAX_VAR_DIMS];
      check(nc_inq_var(id_, v, name, &type, &count, ids, nullptr), "variable ", v);
      NetcdfVariable variable{.id = v, .name = name, .type = type_of(type), .dims = {}};
      for (int d = 0; d < count; ++d) {
        size_t size = 0;
        char dim[NC_MAX_NAME + 1] = "";
        check(nc_inq_dim(id_, ids[d], dim, &size), "a dimension of ", name);
        variable.dims.push_back(
            {.id = ids[d],
             .name = dim,
             .size = size,
             .record = std::find(records.begin(), records.end(), ids[d]) != records.end()});
      }
      variables_.push_back(std::move(variable));
    }
    int format = 0;
    check(nc_inq_format(id_, &format), "its format");
    if (format != NC_FORMAT_NETCDF4 && format != NC_FORMAT_NETCDF4_CLASSIC) {
      const uint64_t least = least_classic_bytes(id_, format == NC_FORMAT_CDF5, variables_);
      if (file_size(path) < least)
        fail_input(path, ": ", file_size(path), " bytes cannot hold the ", least,
                   " its header speaks of: it is cut off");
    }
  } catch (...) {
    nc_close(id_);
    throw;
  }
}

NetcdfFile::~NetcdfFile() { nc_close(id_); }

const NetcdfVariable* NetcdfFile::find(const std::string& name) const {
  for (const NetcdfVariable& v : variables_)
    if (v.name == name) return &v;
  return nullptr;
}

std::string NetcdfFile::text(const NetcdfVariable& variable, const char* name) const {
  nc_type type = NC_NAT;
  size_t length = 0;
  if (nc_inq_att(id_, variable.id, name, &type, &length) != NC_NOERR || length > kAttributeLimit) return "";
  if (type == NC_CHAR) {
    std::string value(length, '\0');
    check(nc_get_att_text(id_, variable.id, name, value.data()), name, " of ", variable.name);
    while (!value.empty() && value.back() == '\0') value.pop_back();
    return value;
  }
  if (type == NC_STRING && length == 1) {
    char* value = nullptr;
    check(nc_get_att_string(id_, variable.id, name, &value), name, " of ", variable.name);
    std::string out = value ? value : "";
    nc_free_string(1, &value);
    return out;
  }
  return "";
}

std::vector<double> NetcdfFile::numbers(const NetcdfVariable& variable, const char* name) const {
  nc_type type = NC_NAT;
  size_t length = 0;
  if (nc_inq_att(id_, variable.id, name, &type, &length) != NC_NOERR || !type_of(type) ||
      length > kAttributeLimit)
    return {};
  std::vector<double> values(length);
  check(nc_get_att_double(id_, variable.id, name, values.data()), name, " of ", variable.name);
  return values;
}

std::optional<double> NetcdfFile::default_fill(const NetcdfVariable& variable) const {
  // Bytes have no value to spare: by the library's convention they have no default.
  if (!variable.type || type_size(*variable.type) == 1) return std::nullopt;
  int off = 0;
  std::byte value[8]{};
  check(nc_inq_var_fill(id_, variable.id, &off, value), "the fill value of ", variable.name);
  if (off) return std::nullopt;
  return visit_type(*variable.type, [&](auto zero) { return load_as<decltype(zero)>(value); });
}

void NetcdfFile::read(const NetcdfVariable& variable, std::span<const size_t> start,
                      std::span<const size_t> count, std::span<std::byte> out) const {
  size_t bytes = type_size(variable.type.value());
  for (const size_t n : count) bytes *= n;
  if (bytes != out.size()) fail_input(path_, ": a hyperslab of ", bytes, " bytes into ", out.size());
  check(nc_get_vara(id_, variable.id, start.data(), count.data(), out.data()), "reading ", variable.name);
}

std::vector<double> NetcdfFile::line(const NetcdfVariable& variable) const {
  if (variable.dims.size() != 1 || variable.dims[0].size > kLineLimit)
    fail_input(path_, ": ", variable.name, " is no coordinate variable");
  std::vector<double> values(variable.dims[0].size);
  check(nc_get_var_double(id_, variable.id, values.data()), "reading ", variable.name);
  return values;
}

uint64_t NetcdfFile::chunk_bytes(const NetcdfVariable& variable) const {
  int storage = NC_CONTIGUOUS;
  std::vector<size_t> sizes(variable.dims.size());
  if (nc_inq_var_chunking(id_, variable.id, &storage, sizes.data()) != NC_NOERR || storage != NC_CHUNKED)
    return 0;
  uint64_t bytes = type_size(variable.type.value());
  for (const size_t n : sizes) {
    if (n > 0 && bytes > UINT64_MAX / n) return UINT64_MAX;
    bytes *= n;
  }
  return bytes;
}

} // namespace bcc4

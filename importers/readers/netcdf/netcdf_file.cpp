// SPDX-License-Identifier: Apache-2.0
// Wraps libnetcdf: what a file holds is read once when it is opened, values when they are asked for.
#include "readers/netcdf/netcdf_file.h"

#include <dlfcn.h>

#include <algorithm>
#include <cmath>

#include <netcdf.h>

#include "readers/byte_stream.h"
#include "readers/error.h"
#include "readers/netcdf/netcdf_classic.h"
#include "readers/text.h"

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

// HDF5 prints an error that it meets, and libnetcdf keeps it from that in the thread of the first opening
// only. Frames are read in threads of their own, so each asks for itself. libnetcdf need not be built with
// HDF5: the function is looked up.
void keep_hdf5_quiet() {
  using SetAuto = int(int64_t stack, void* function, void* data);
  static auto* const set_auto = reinterpret_cast<SetAuto*>(dlsym(RTLD_DEFAULT, "H5Eset_auto2"));
  thread_local bool quiet = false;
  if (!quiet && set_auto) set_auto(0, nullptr, nullptr);
  quiet = true;
}

} // namespace

template<class... Parts> void NetcdfFile::check(int status, const Parts&... doing) const {
  if (status == NC_NOERR) return;
  fail_input(path_, ": ", doing..., ": ", nc_strerror(status),
             status == NC_EHDFERR ? " (the file is damaged or cut off: copy it anew)" : "");
}

NetcdfFile::NetcdfFile(const std::string& path) : path_(path) {
  keep_hdf5_quiet();
  check(nc_open(path.c_str(), NC_NOWRITE, &id_), "cannot be read as NetCDF");
  try {
    add_group(id_, "", {});
    if (const uint64_t least = least_classic_bytes(id_, variables_); file_size(path) < least)
      fail_input(path, ": ", file_size(path), " bytes cannot hold the ", least,
                 " its header speaks of: it is cut off");
  } catch (...) {
    nc_close(id_);
    throw;
  }
}

NetcdfFile::~NetcdfFile() { nc_close(id_); }

// `folder` is the group's name with a slash behind it, `records` are the unlimited dimensions of the groups
// that it is in.
void NetcdfFile::add_group(int group, const std::string& folder, std::vector<int> records) {
  int count = 0;
  check(nc_inq_unlimdims(group, &count, nullptr), "its dimensions");
  std::vector<int> own(static_cast<size_t>(count));
  check(nc_inq_unlimdims(group, &count, own.data()), "its dimensions");
  records.insert(records.end(), own.begin(), own.end());
  check(nc_inq_nvars(group, &count), "its variables");
  std::vector<int> ids(static_cast<size_t>(count));
  check(nc_inq_varids(group, &count, ids.data()), "its variables");
  for (const int id : ids) add_variable(group, id, folder, records);
  check(nc_inq_grps(group, &count, nullptr), "its groups");
  std::vector<int> groups(static_cast<size_t>(count));
  check(nc_inq_grps(group, &count, groups.data()), "its groups");
  for (const int inner : groups) {
    char name[NC_MAX_NAME + 1] = "";
    check(nc_inq_grpname(inner, name), "the name of a group");
    add_group(inner, concat(folder, name, '/'), records);
  }
}

void NetcdfFile::add_variable(int group, int id, const std::string& folder, const std::vector<int>& records) {
  char name[NC_MAX_NAME + 1] = "";
  nc_type type = NC_NAT;
  int count = 0;
  int ids[NC_MAX_VAR_DIMS];
  check(nc_inq_var(group, id, name, &type, &count, ids, nullptr), "variable ", id);
  NetcdfVariable variable{.group = group,
                          .id = id,
                          .name = folder + name,
                          .leaf = name,
                          .type = type_of(type),
                          .dims = {},
                          .text = type == NC_CHAR || type == NC_STRING};
  for (int d = 0; d < count; ++d) {
    size_t size = 0;
    char dim[NC_MAX_NAME + 1] = "";
    check(nc_inq_dim(group, ids[d], dim, &size), "a dimension of ", name);
    variable.dims.push_back({.id = ids[d],
                             .name = dim,
                             .size = size,
                             .record = std::find(records.begin(), records.end(), ids[d]) != records.end()});
  }
  variables_.push_back(std::move(variable));
}

const NetcdfVariable* NetcdfFile::find(const std::string& name) const {
  const std::string_view wanted = std::string_view(name).substr(name.starts_with('/') ? 1 : 0);
  for (const NetcdfVariable& v : variables_)
    if (v.name == wanted) return &v;
  return nullptr;
}

const NetcdfVariable* NetcdfFile::near(const NetcdfVariable& variable, const std::string& name) const {
  std::string folder = variable.name.substr(0, variable.name.size() - variable.leaf.size());
  while (true) {
    if (const NetcdfVariable* found = find(folder + name)) return found;
    if (folder.empty()) return nullptr;
    folder.pop_back();
    folder.resize(folder.rfind('/') + 1); // to nothing where there is no slash
  }
}

const NetcdfVariable* NetcdfFile::coordinate(const NetcdfVariable& variable,
                                             const NetcdfDimension& dim) const {
  const NetcdfVariable* found = near(variable, dim.name);
  return found && found->type && is_coordinate(*found) && found->dims[0].id == dim.id ? found : nullptr;
}

std::vector<std::string> NetcdfFile::texts(const NetcdfVariable& variable, const char* name) const {
  nc_type type = NC_NAT;
  size_t length = 0;
  if (nc_inq_att(variable.group, variable.id, name, &type, &length) != NC_NOERR || length > kAttributeLimit)
    return {};
  if (type == NC_CHAR) {
    std::string value(length, '\0');
    check(nc_get_att_text(variable.group, variable.id, name, value.data()), name, " of ", variable.name);
    while (!value.empty() && value.back() == '\0') value.pop_back();
    return {value};
  }
  if (type != NC_STRING) return {};
  std::vector<char*> values(length);
  check(nc_get_att_string(variable.group, variable.id, name, values.data()), name, " of ", variable.name);
  std::vector<std::string> out;
  for (const char* value : values) out.emplace_back(value ? value : "");
  nc_free_string(values.size(), values.data());
  return out;
}

std::string NetcdfFile::text(const NetcdfVariable& variable, const char* name) const {
  const std::vector<std::string> all = texts(variable, name);
  return all.size() == 1 ? all[0] : "";
}

std::vector<double> NetcdfFile::numbers(const NetcdfVariable& variable, const char* name) const {
  nc_type type = NC_NAT;
  size_t length = 0;
  if (nc_inq_att(variable.group, variable.id, name, &type, &length) != NC_NOERR || !type_of(type) ||
      length > kAttributeLimit)
    return {};
  std::vector<double> values(length);
  check(nc_get_att_double(variable.group, variable.id, name, values.data()), name, " of ", variable.name);
  return values;
}

std::optional<Type> NetcdfFile::type_of_numbers(const NetcdfVariable& variable, const char* name) const {
  nc_type type = NC_NAT;
  if (nc_inq_atttype(variable.group, variable.id, name, &type) != NC_NOERR) return std::nullopt;
  return type_of(type);
}

Record NetcdfFile::attributes(const NetcdfVariable& variable, bool of_time) const {
  Record all = Record::object();
  int count = 0;
  check(nc_inq_varnatts(variable.group, variable.id, &count), "attributes of ", variable.name);
  for (int i = 0; i < count; ++i) {
    char name[NC_MAX_NAME + 1] = "";
    check(nc_inq_attname(variable.group, variable.id, i, name), "an attribute of ", variable.name);
    if (!in_record(name, of_time)) continue;
    Record value = Record::array();
    for (const std::string& text : texts(variable, name)) value.push_back(utf8_of(text));
    const auto type = type_of_numbers(variable, name);
    for (const double n : numbers(variable, name))
      if (!std::isfinite(n))
        value.push_back(concat(n)); // JSON has no such numbers
      else if (is_float(type.value()) || std::abs(n) > 0x1p53)
        value.push_back(n);
      else
        value.push_back(static_cast<int64_t>(n));
    if (!value.empty()) all[utf8_of(name)] = value.size() == 1 ? value[0] : value;
  }
  return all;
}

std::optional<double> NetcdfFile::default_fill(const NetcdfVariable& variable) const {
  // Bytes have no value to spare: by the library's convention they have no default.
  if (!variable.type || type_size(*variable.type) == 1) return std::nullopt;
  int off = 0;
  std::byte value[8]{};
  check(nc_inq_var_fill(variable.group, variable.id, &off, value), "the fill value of ", variable.name);
  if (off) return std::nullopt;
  return visit_type(*variable.type, [&](auto zero) { return load_as<decltype(zero)>(value); });
}

void NetcdfFile::read(const NetcdfVariable& variable, std::span<const size_t> start,
                      std::span<const size_t> count, std::span<std::byte> out) const {
  keep_hdf5_quiet();
  size_t bytes = type_size(variable.type.value());
  for (const size_t n : count) bytes *= n;
  if (bytes != out.size()) fail_input(path_, ": a hyperslab of ", bytes, " bytes into ", out.size());
  check(nc_get_vara(variable.group, variable.id, start.data(), count.data(), out.data()), "reading ",
        variable.name);
}

std::vector<double> NetcdfFile::line(const NetcdfVariable& variable) const {
  const uint64_t count = variable.dims.empty() ? 1 : variable.dims[0].size;
  if (variable.dims.size() > 1 || count > kLineLimit)
    fail_input(path_, ": ", variable.name, " is no coordinate variable");
  std::vector<double> values(count);
  check(nc_get_var_double(variable.group, variable.id, values.data()), "reading ", variable.name);
  return values;
}

std::vector<std::string> NetcdfFile::lines(const NetcdfVariable& variable) const {
  uint64_t letters = 1; // all of them, or all strings
  for (const NetcdfDimension& d : variable.dims) letters *= std::min<uint64_t>(d.size, kLineLimit);
  if (!variable.text || variable.dims.empty() || variable.dims.size() > 2 || letters > kLineLimit)
    fail_input(path_, ": ", variable.name, " is no list of texts");
  nc_type type = NC_NAT;
  check(nc_inq_vartype(variable.group, variable.id, &type), "the type of ", variable.name);
  std::vector<std::string> out;
  if (type == NC_STRING) {
    std::vector<char*> strings(letters);
    check(nc_get_var_string(variable.group, variable.id, strings.data()), "reading ", variable.name);
    for (const char* s : strings) out.emplace_back(s ? s : "");
    nc_free_string(strings.size(), strings.data());
    return out;
  }
  std::string all(letters, '\0');
  check(nc_get_var_text(variable.group, variable.id, all.data()), "reading ", variable.name);
  const size_t width = variable.dims.back().size;
  for (size_t at = 0; at < all.size(); at += width) out.emplace_back(all.substr(at, width).c_str());
  return out;
}

uint64_t NetcdfFile::chunk_bytes(const NetcdfVariable& variable) const {
  int storage = NC_CONTIGUOUS;
  std::vector<size_t> sizes(variable.dims.size());
  if (nc_inq_var_chunking(variable.group, variable.id, &storage, sizes.data()) != NC_NOERR ||
      storage != NC_CHUNKED)
    return 0;
  uint64_t bytes = type_size(variable.type.value());
  for (const size_t n : sizes) {
    if (n > 0 && bytes > UINT64_MAX / n) return UINT64_MAX;
    bytes *= n;
  }
  return bytes;
}

} // namespace bcc4

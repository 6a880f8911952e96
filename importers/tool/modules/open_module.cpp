// SPDX-License-Identifier: Apache-2.0
// The functions of the modules as the tool calls them: the first call finds and opens the module.
#include <dlfcn.h>

#include <filesystem>

#include "readers/error.h"
#include "tool/modules/module.h"
#include "tool/system.h"
#if BCCSPLAT_WITH_NETCDF
#include "readers/netcdf/netcdf_reader.h"
#include "tool/output/netcdf_output.h"
#endif
#if BCCSPLAT_WITH_TIFF
#include "readers/tiff/tiff_reader.h"
#include "tool/output/tiff_output.h"
#endif
#if BCCSPLAT_WITH_OPENVDB
#include "readers/vdb/vdb_reader.h"
#include "tool/output/vdb_writer.h"
#endif

namespace bcc4 {
namespace {

// Modules are beside the program, as in the build folder, or where they are installed. They stay open.
const Module& open_module(const std::string& file, const char* library) {
  const auto folder = program_folder();
  auto path = folder / file;
  if (!std::filesystem::exists(path)) path = (folder / BCC4_MODULE_FOLDER / file).lexically_normal();
  if (!std::filesystem::exists(path) &&
      std::filesystem::exists(folder / "../library_path")) // of a Python package
    fail_input("a wheel has no module for ", library,
               ": open the file in Python, as with xarray, and write it by dataset.bcc4.to_file or "
               "bccsplat.save; the package bccsplat-tools has one");
  void* const module = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!module)
    fail_input("this bcc4 was built with ", library, ", but its module ", path.string(),
               " cannot be opened: ", dlerror());
  const void* const entry = dlsym(module, BCC4_MODULE_ENTRY);
  if (!entry) fail_input("the module ", path.string(), " is of another build than this bcc4");
  return *static_cast<const Module*>(entry);
}

} // namespace

#if BCCSPLAT_WITH_MICROHTTPD
void serve_files(const Serving& serving) {
  open_module("bcc4_microhttpd.so", "libmicrohttpd").serve(serving);
}
#endif

#if BCCSPLAT_WITH_NETCDF
static const Module& netcdf_module() {
  static const Module& module = open_module("bcc4_netcdf.so", "NetCDF");
  return module;
}

std::unique_ptr<FrameReader> open_netcdf(const Sequence& sequence, const ReaderOptions& options) {
  return netcdf_module().open(sequence, options);
}

std::unique_ptr<VolumeFile> create_netcdf(const std::string& path, const std::string& name,
                                          const VolumeOutput& output) {
  return netcdf_module().create(path, name, output);
}
#endif

#if BCCSPLAT_WITH_TIFF
static const Module& tiff_module() {
  static const Module& module = open_module("bcc4_tiff.so", "TIFF");
  return module;
}

std::unique_ptr<FrameReader> open_tiff(const Sequence& sequence, const ReaderOptions& options) {
  return tiff_module().open(sequence, options);
}

std::unique_ptr<VolumeFile> create_tiff(const std::string& path, const std::string& name,
                                        const VolumeOutput& output) {
  return tiff_module().create(path, name, output);
}
#endif

#if BCCSPLAT_WITH_OPENVDB
static const Module& openvdb_module() {
  static const Module& module = open_module("bcc4_openvdb.so", "OpenVDB");
  return module;
}

std::unique_ptr<FrameReader> open_vdb(const Sequence& sequence, const ReaderOptions& options) {
  return openvdb_module().open(sequence, options);
}

void write_vdb_grid(std::ostream& stream, const std::string& path, const VdbOutput& output,
                    std::span<const float> values) {
  openvdb_module().write_grid(stream, path, output, values);
}
#endif

} // namespace bcc4

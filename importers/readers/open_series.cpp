// SPDX-License-Identifier: Apache-2.0
// Which reader reads what. A new format takes three places:
//   - readers/NAME/NAME_reader.{h,cpp} with open_NAME, after the model of metaimage (the build finds them),
//   - a line of the table below,
//   - tests/tool/readers/NAME_reader_test.cpp, which opens its files by open_series.
#include "readers/open_series.h"

#include <filesystem>
#include <vector>

#include "readers/decoders.h"
#include "readers/error.h"
#include "readers/metaimage/metaimage_reader.h"
#include "readers/nifti/nifti_reader.h"
#include "readers/nrrd/nrrd_reader.h"
#include "readers/raw/raw_reader.h"
#include "readers/sequence.h"
#include "readers/system.h"
#include "readers/unpacked.h"
#include "readers/vti/vti_reader.h"
#if BCCSPLAT_WITH_NETCDF
#include <netcdf_meta.h>

#include "readers/netcdf/netcdf_reader.h"
#endif
#if BCCSPLAT_WITH_OPENVDB
#include <openvdb/version.h>

#include "readers/vdb/vdb_reader.h"
#endif
#if BCCSPLAT_WITH_TIFF
#include "readers/tiff/tiff_reader.h"
#endif

namespace bcc4 {
namespace {

constexpr size_t kStartBytes = 352; // of a file, to recognise it by: a NIfTI-1 header and what follows it

using Open = std::unique_ptr<FrameReader>(const Sequence& sequence, const ReaderOptions& options);

// Versions are those of the headers: to ask a library it has to be loaded.
#if BCCSPLAT_WITH_NETCDF
constexpr const char* netcdf_version = NC_VERSION;
#else
constexpr Open* open_netcdf = nullptr;
constexpr const char* netcdf_version = "BCCSPLAT_WITH_NETCDF is off";
#endif
#if BCCSPLAT_WITH_OPENVDB
constexpr const char* openvdb_version = OPENVDB_LIBRARY_VERSION_STRING;
#else
constexpr Open* open_vdb = nullptr;
constexpr const char* openvdb_version = "BCCSPLAT_WITH_OPENVDB is off";
#endif
#if BCCSPLAT_WITH_TIFF
constexpr const char* tiff_detail = "stacks, series, ImageJ and OME";
#else
constexpr Open* open_tiff = nullptr;
constexpr const char* tiff_detail = "BCCSPLAT_WITH_TIFF is off";
#endif

struct Format {
  const char* name;
  std::vector<const char*> extensions;
  bool (*begins)(std::string_view start); // is this the start of such a file, unpacked when gzip?
  Open* open;                             // null: this build left it out
  std::string detail;                     // in the list of readers
  const char* absent = "";                // what is told of a file that this build cannot open
  bool reads_gzip = false;
};

bool is_vdb(std::string_view start) {
  return start.starts_with(std::string_view("\x20\x42\x44\x56\0\0\0\0", 8));
}

bool is_netcdf(std::string_view start) {
  for (const std::string_view magic : {"CDF\x01", "CDF\x02", "CDF\x05", "\x89HDF"})
    if (start.starts_with(magic)) return true;
  return false;
}

bool is_tiff(std::string_view start) {
  for (const std::string_view magic : {std::string_view("II*\0", 4), std::string_view("MM\0*", 4),
                                       std::string_view("II+\0", 4), std::string_view("MM\0+", 4)})
    if (start.starts_with(magic)) return true;
  return false;
}

bool is_nrrd(std::string_view start) { return start.starts_with("NRRD000"); }

bool is_vtk(std::string_view start) { return start.find("<VTKFile") != std::string_view::npos; }

// The table is in the order of the list of readers. Raw is what none of the others recognises.
const std::vector<Format>& formats() {
  static const std::vector<Format> table{
      {"raw", {}, nullptr, open_raw, "plain or gzip"},
      {"nrrd", {".nrrd", ".nhdr"}, is_nrrd, open_nrrd, "attached and detached; raw, gzip, ascii"},
      {"vti",
       {".vti", ".vtr", ".pvd"},
       is_vtk,
       open_vti,
       "VTK ImageData, RectilinearGrid and .pvd; ascii, binary, appended, zlib"},
      {"nifti", {".nii", ".nii.gz"}, is_nifti, open_nifti, "NIfTI-1 and -2, pairs; plain or gzip", "", true},
      {"metaimage", {".mha", ".mhd"}, is_metaimage, open_metaimage, ".mha and .mhd; raw, zlib, text"},
      {"netcdf",
       {".nc"},
       is_netcdf,
       open_netcdf,
       netcdf_version,
       "a NetCDF or HDF5 file, but this bcc4 was built without NetCDF (BCCSPLAT_WITH_NETCDF)"},
      {"tiff",
       {".tif", ".tiff"},
       is_tiff,
       open_tiff,
       tiff_detail,
       "a TIFF file, but this bcc4 was built without TIFF (BCCSPLAT_WITH_TIFF)"},
      {"openvdb",
       {".vdb"},
       is_vdb,
       open_vdb,
       openvdb_version,
       "an OpenVDB file, but this bcc4 was built without OpenVDB (BCCSPLAT_WITH_OPENVDB)"},
  };
  return table;
}

// What begins like none of the formats is raw, unless its name or its first bytes promise something else.
void check_raw(const std::string& path, std::string_view start) {
  if (start.starts_with("NanoVDB"))
    fail_input(path, ": a NanoVDB file, which no reader knows; convert it with nanovdb_convert to OpenVDB");
  if (start.starts_with("BCC4") || lower(path).ends_with(".bcc4"))
    fail_input(path, ": is a .bcc4 file already");
  if (lower(path).ends_with(".series"))
    fail_input(path,
               ": a list of files and times for ParaView: give the files themselves, and the times with "
               "--times");
  if (is_analyze(start) && lower(path).ends_with(".hdr"))
    fail_input(path, ": an ANALYZE header, which does not say where left is: convert it to NIfTI (.nii), or "
                     "read its .img as raw values with --dims, --dtype and --skip");
  if (const std::string format = format_of_name(path); !format.empty())
    fail_input(path, ": does not begin as a file of ", format, " does: damaged or misnamed");
}

// The values of a pair have no beginning of their own.
void refuse_image_of_pair(const std::string& path) {
  if (!lower(path).ends_with(".img")) return;
  const std::string header = path.substr(0, path.size() - 3) + "hdr";
  if (std::filesystem::exists(to_path(header)))
    fail_input(path, ": the values of a pair of files: give its header, ", header);
}

} // namespace

std::unique_ptr<FrameReader> open_series(const ReaderOptions& options) {
  if (options.inputs.empty()) fail_usage("no input given");
  const Sequence sequence = find_sequence(options.inputs, options.frames);
  const std::string& path = sequence.files.front().path;
  const auto [start, gzip] = read_start(path, kStartBytes);
  for (const Format& format : formats()) {
    if (!format.begins || !format.begins(start)) continue;
    if (!format.open) fail_input(path, ": ", format.absent);
    if (gzip && !format.reads_gzip)
      return open_unpacked(sequence,
                           [&](const Sequence& unpacked) { return format.open(unpacked, options); });
    return format.open(sequence, options);
  }
  check_raw(path, start);
  if (!options.dims && !options.dtype) refuse_image_of_pair(path);
  return open_raw(sequence, options);
}

std::string format_of_name(const std::string& path) {
  const std::string name = lower(path);
  for (const Format& format : formats())
    for (const char* extension : format.extensions)
      if (name.ends_with(extension)) return format.name;
  return {};
}

std::vector<ReaderInfo> reader_list() {
  std::vector<ReaderInfo> list;
  for (const Format& format : formats()) list.push_back({format.name, format.open != nullptr, format.detail});
  return list;
}

} // namespace bcc4

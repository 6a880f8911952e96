#include "readers/open_series.h"

#include <array>
#include <cstring>
#include <functional>

#include "readers/byte_stream.h"
#include "readers/decoders.h"
#include "readers/error.h"
#include "readers/metaimage/metaimage_reader.h"
#include "readers/nifti/nifti_reader.h"
#include "readers/nrrd/nrrd_reader.h"
#include "readers/raw/raw_reader.h"
#include "readers/sequence.h"
#include "readers/vti/vti_reader.h"
#if BCCSPLAT_WITH_NETCDF
#include "readers/netcdf/netcdf_reader.h"
#endif
#if BCCSPLAT_WITH_OPENVDB
#include "readers/vdb/vdb_reader.h"
#endif

namespace bcc4 {
namespace {

// The first bytes of a file, unpacked when it is gzip.
std::string first_bytes(const std::string& path, size_t count) {
  auto file = std::make_unique<InputFile>(path);
  std::string bytes(count, '\0');
  const auto into = std::as_writable_bytes(std::span(bytes));
  bytes.resize(file->read_some(0, into));
  if (!bytes.starts_with("\x1f\x8b")) return bytes;
  bytes.assign(count, '\0');
  bytes.resize(open_gzip(std::move(file), 0)->read(std::as_writable_bytes(std::span(bytes))));
  return bytes;
}

bool is_vdb(std::string_view start) {
  return start.starts_with(std::string_view("\x20\x42\x44\x56\0\0\0\0", 8));
}

bool is_netcdf(std::string_view start) {
  for (const std::string_view magic : {"CDF\x01", "CDF\x02", "CDF\x05", "\x89HDF"})
    if (start.starts_with(magic)) return true;
  return false;
}

} // namespace

std::unique_ptr<FrameReader> open_series(const ReaderOptions& options) {
  if (options.inputs.empty()) fail_usage("no input given");
  const std::string path = find_sequence(options.inputs, options.frames).files.front().path;
  const std::string start = first_bytes(path, 352);
  const std::string name = lower(path);
  if (start.starts_with("NRRD000")) return open_nrrd(options);
  if (is_vdb(start)) {
#if BCCSPLAT_WITH_OPENVDB
    return open_vdb(options);
#else
    fail_input(path, ": an OpenVDB file, but this bcc4 was built without OpenVDB (BCCSPLAT_WITH_OPENVDB)");
#endif
  }
  if (is_nifti(start)) return open_nifti(options);
  if (start.find("<VTKFile") != std::string::npos)
    return name.ends_with(".pvd") ? open_pvd(options) : open_vti(options);
  if (start.starts_with("NanoVDB"))
    fail_input(path, ": a NanoVDB file, which no reader knows; convert it with nanovdb_convert to OpenVDB");
  if (is_netcdf(start)) {
#if BCCSPLAT_WITH_NETCDF
    return open_netcdf(options);
#else
    fail_input(path,
               ": a NetCDF or HDF5 file, but this bcc4 was built without NetCDF (BCCSPLAT_WITH_NETCDF)");
#endif
  }
  if (is_metaimage(start)) return open_metaimage(options);
  if (start.starts_with("BCC4") || name.ends_with(".bcc4")) fail_input(path, ": is a .bcc4 file already");
  for (const char* known :
       {".nrrd", ".nhdr", ".vdb", ".vti", ".nii", ".nii.gz", ".pvd", ".mha", ".mhd", ".nc"})
    if (name.ends_with(known))
      fail_input(path, ": does not begin as a ", known, " file does: damaged or misnamed");
  return open_raw(options);
}

std::vector<ReaderInfo> reader_list() {
  std::vector<ReaderInfo> list{{"raw", true, "plain or gzip"},
                               {"nrrd", true, "attached and detached; raw, gzip, ascii"},
                               {"vti", true, "VTK ImageData and .pvd; ascii, binary, appended, zlib"},
                               {"nifti", true, "NIfTI-1 and -2, plain or gzip"},
                               {"metaimage", true, ".mha and .mhd; raw, zlib, text"}};
#if BCCSPLAT_WITH_NETCDF
  list.push_back({"netcdf", true, netcdf_version()});
#else
  list.push_back({"netcdf", false, "BCCSPLAT_WITH_NETCDF is off"});
#endif
#if BCCSPLAT_WITH_OPENVDB
  list.push_back({"openvdb", true, openvdb_version()});
#else
  list.push_back({"openvdb", false, "BCCSPLAT_WITH_OPENVDB is off"});
#endif
  return list;
}

} // namespace bcc4

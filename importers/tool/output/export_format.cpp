// SPDX-License-Identifier: Apache-2.0
// The formats that volumes are written in: their suffixes, what they have no place for, and who makes their
// files.
#include "tool/output/export_format.h"

#include <cstdio>

#include "readers/error.h"
#include "tool/output/flat_file.h"
#include "tool/output/gzip_file.h"
#include "tool/output/nifti_output.h"
#include "tool/output/nrrd_output.h"
#include "tool/output/output_file.h"
#include "tool/output/vti_output.h"
#if BCCSPLAT_WITH_NETCDF || BCCSPLAT_WITH_TIFF
#include "tool/output/named_file.h"
#endif
#if BCCSPLAT_WITH_NETCDF
#include "tool/output/netcdf_output.h"
#endif
#if BCCSPLAT_WITH_TIFF
#include "tool/output/tiff_output.h"
#endif

namespace bcc4 {
namespace {

struct Suffix {
  const char* suffix;
  ExportFormat format;
};
// The first of each format is that of files that export names itself.
constexpr Suffix kSuffixes[] = {{".raw", ExportFormat::raw},      {".nrrd", ExportFormat::nrrd},
                                {".vdb", ExportFormat::vdb},      {".nii", ExportFormat::nifti},
                                {".nii.gz", ExportFormat::nifti}, {".nc", ExportFormat::netcdf},
                                {".vti", ExportFormat::vti},      {".pvd", ExportFormat::vti},
                                {".tif", ExportFormat::tiff},     {".tiff", ExportFormat::tiff}};

// Its name where it cannot say where uneven samples stand; null where it can.
const char* without_coordinates(ExportFormat format) {
  switch (format) {
  case ExportFormat::vdb:
    return "OpenVDB";
  case ExportFormat::nifti:
    return "NIfTI";
  case ExportFormat::vti:
    return "VTI";
  case ExportFormat::tiff:
    return "TIFF";
  case ExportFormat::nrrd:
  case ExportFormat::netcdf:
    return nullptr;
  default:
    return "a raw file";
  }
}

std::unique_ptr<ByteSink> create_sink(const std::string& path, bool overwrite) {
  if (lower(path).ends_with(".gz")) return create_gzip(path, overwrite);
  return std::make_unique<OutputFile>(path, overwrite);
}

std::unique_ptr<VolumeFile> create_nifti(const std::string& path, const VolumeOutput& o, bool overwrite,
                                         bool quiet) {
  const NiftiText text = nifti_header_text(o);
  for (const std::string& note : text.notes)
    if (!quiet) std::fprintf(stderr, "bcc4: %s: %s\n", path.c_str(), note.c_str());
  return create_flat(create_sink(path, overwrite), o.type, text.header);
}

} // namespace

ExportFormat format_of_suffix(const std::string& name) {
  const std::string low = lower(name);
  for (const auto& [suffix, format] : kSuffixes)
    if (low.ends_with(suffix)) return format;
  return ExportFormat::unset;
}

void warn_of_uneven_samples(ExportFormat format) {
  if (const char* const name = without_coordinates(format))
    std::fprintf(stderr,
                 "bcc4: warning: samples are unevenly spaced along an axis, which %s cannot say: they stand "
                 "evenly in it; NRRD and NetCDF keep their coordinates, and bcc4 info tells them\n",
                 name);
}

const char* suffix_of(ExportFormat format) {
  for (const Suffix& s : kSuffixes)
    if (s.format == format) return s.suffix;
  return "";
}

Choices<ExportFormat> export_formats() {
  return {{"raw", ExportFormat::raw},     {"nrrd", ExportFormat::nrrd},     {"vdb", ExportFormat::vdb},
          {"nifti", ExportFormat::nifti}, {"netcdf", ExportFormat::netcdf}, {"vti", ExportFormat::vti},
          {"tiff", ExportFormat::tiff}};
}

void require_format([[maybe_unused]] ExportFormat format, [[maybe_unused]] const std::string& option) {
  [[maybe_unused]] const auto refuse = [&](ExportFormat absent, const char* library,
                                           const char* switch_name) {
    if (format == absent)
      fail_usage(option, ": this bcc4 was built without ", library, " (", switch_name, "); .nrrd works");
  };
#if !BCCSPLAT_WITH_OPENVDB
  refuse(ExportFormat::vdb, "OpenVDB", "BCCSPLAT_WITH_OPENVDB");
#endif
#if !BCCSPLAT_WITH_NETCDF
  refuse(ExportFormat::netcdf, "NetCDF", "BCCSPLAT_WITH_NETCDF");
#endif
#if !BCCSPLAT_WITH_TIFF
  refuse(ExportFormat::tiff, "TIFF", "BCCSPLAT_WITH_TIFF");
#endif
}

bool holds_series(ExportFormat format) { return format != ExportFormat::vdb && format != ExportFormat::vti; }

std::unique_ptr<VolumeFile> create_volume_file(ExportFormat format, const std::string& path,
                                               const VolumeOutput& o, bool overwrite, bool quiet) {
  switch (format) {
  case ExportFormat::nrrd:
    return create_flat(create_sink(path, overwrite), o.type, nrrd_header_text(o));
  case ExportFormat::nifti:
    return create_nifti(path, o, overwrite, quiet);
  case ExportFormat::vti: {
    const VtiText text = vti_text(o);
    return create_flat(create_sink(path, overwrite), o.type, text.head, text.tail);
  }
#if BCCSPLAT_WITH_NETCDF
  case ExportFormat::netcdf:
    return create_named(path, overwrite,
                        [&](const std::string& partial) { return create_netcdf(partial, path, o); });
#endif
#if BCCSPLAT_WITH_TIFF
  case ExportFormat::tiff:
    return create_named(path, overwrite,
                        [&](const std::string& partial) { return create_tiff(partial, path, o); });
#endif
  default:
    return create_flat(create_sink(path, overwrite), o.type, "");
  }
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// What a shared module of the tool gives. OpenVDB, NetCDF, TIFF and libmicrohttpd (with all of TLS) take
// longer to load than most commands to run: what uses them is in bcc4_openvdb.so, bcc4_netcdf.so,
// bcc4_tiff.so and bcc4_microhttpd.so, which are opened when a file, or `bcc4 view`, asks for them.
#pragma once

#include <iosfwd>
#include <memory>
#include <span>
#include <string>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/sequence.h"
#include "tool/output/vdb_output.h"
#include "tool/output/volume_file.h"
#include "tool/serve/http_server.h"

namespace bcc4 {

// A module exports one, whose name, BCC4_MODULE_ENTRY, only the tool of the same build asks for.
struct Module {
  std::unique_ptr<FrameReader> (*open)(const Sequence& sequence, const ReaderOptions& options) = nullptr;
  void (*write_grid)(std::ostream& stream, const std::string& path, const VdbOutput& output,
                     std::span<const float> values) = nullptr;
  std::unique_ptr<VolumeFile> (*create)(const std::string& path, const std::string& name,
                                        const VolumeOutput& output) = nullptr;
  void (*serve)(const Serving& serving) = nullptr;
};

} // namespace bcc4

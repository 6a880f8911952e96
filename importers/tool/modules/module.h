// SPDX-License-Identifier: Apache-2.0
// What a shared module of the tool gives. OpenVDB and NetCDF take longer to load than most commands to run:
// what uses them is in bcc4_openvdb.so and bcc4_netcdf.so, which are opened when a file asks for them.
#pragma once

#include <iosfwd>
#include <memory>
#include <span>
#include <string>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/sequence.h"
#include "tool/output/vdb_output.h"

namespace bcc4 {

// A module exports one, whose name, BCC4_MODULE_ENTRY, only the tool of the same build asks for.
struct Module {
  std::unique_ptr<FrameReader> (*open)(const Sequence& sequence, const ReaderOptions& options);
  void (*write_grid)(std::ostream& stream, const std::string& path, const VdbOutput& output,
                     std::span<const float> values) = nullptr;
};

} // namespace bcc4

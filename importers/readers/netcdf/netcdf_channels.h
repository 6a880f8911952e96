// SPDX-License-Identifier: Apache-2.0
// Which variables of NetCDF files are the channels of a series, and what their values are.
#pragma once

#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "readers/netcdf/netcdf_file.h"
#include "readers/reader_options.h"
#include "readers/stored_values.h"

namespace bcc4 {

// Returns the names of the variables that --channel asks for, else of the only one that may be meant; throws
// when there are none or more.
[[nodiscard]] std::vector<std::string> chosen_variables(const NetcdfFile& file, const ReaderOptions& options);

// Returns the variables of these names; throws when one is not there or their dimensions differ.
[[nodiscard]] std::vector<const NetcdfVariable*> find_variables(const NetcdfFile& file,
                                                                const std::vector<std::string>& names);

// A channel as each of the files has it.
struct NetcdfChannel {
  std::string name, unit;
  std::vector<StoredValues> of_files;
};
// Adds the channel of the next file; throws, in the name of the file, where it has another unit.
void add_file(NetcdfChannel& channel, const NetcdfFile& file, const NetcdfVariable& v);

// Makes one channel of what the files have: of their own steps where these are the same in all, else floats.
void describe_channel(SeriesDescription& d, const NetcdfChannel& channel);

} // namespace bcc4

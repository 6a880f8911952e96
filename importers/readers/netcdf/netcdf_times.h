// SPDX-License-Identifier: Apache-2.0
// When the frames of NetCDF files are: numbers since a date, dates as text (as WRF writes them) or dates as
// numbers.
#pragma once

#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "readers/netcdf/netcdf_file.h"

namespace bcc4 {

struct NetcdfTimes {
  std::vector<double> values; // one per frame; none where the file does not tell them
  std::string unit, epoch;    // epoch: the date of 0, "" when there is none
  std::string calendar;       // as the file calls it, "" when it does not
  std::string origin;         // where they came from, for the report
  std::string unread;         // why what may be times is not taken for them, "" otherwise
  bool guessed = false;       // of a variable that may be something else
};

// Tells the times along the dimension of the variable, or where it has none of time (null) the one moment
// that a variable of a single number tells. Dates become hours or days since the first of them.
[[nodiscard]] NetcdfTimes netcdf_times(const NetcdfFile& file, const NetcdfVariable& v,
                                       const NetcdfDimension* dim);

// The times of the files of a series, in the unit and since the date of the first one.
class NetcdfClock {
 public:
  // By the user's own times nothing depends on those of the files but the unit.
  explicit NetcdfClock(bool told_by_user) : told_by_user_(told_by_user) {}
  // Adds the times of the next file, which holds `frames`; throws, in its name, where there is no telling how
  // they follow those of the first one.
  void add(NetcdfTimes times, uint64_t frames, const std::string& path);
  // Files without times leave the whole series without; a warning says why where others have them.
  void describe(SeriesDescription& d) const;

 private:
  bool told_by_user_;
  bool begun_ = false, told_ = false; // told: by one of the files
  NetcdfTimes all_;
  std::string untold_; // the first file that has none
};

} // namespace bcc4

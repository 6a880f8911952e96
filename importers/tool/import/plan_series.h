// SPDX-License-Identifier: Apache-2.0
// What is known about a series and has been chosen for it: by a plan of the library, or read from a file.
#pragma once

#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "tool/import/writer_settings.h"
#include "tool/json.h"

namespace bcc4 {

// What is asked of a plan beside the settings of a writer.
struct PlanWish {
  double density = 0;           // sites per source sample; 0: as the data need
  bool exact = false;           // values as precise as the source's
  bool auto_time_scale = false; // the distance along time
  bool auto_levels = false;     // their number
  bool everything = false;      // whatever a plan can show
  bool any_memory = false;      // else half of the machine's, beside the device's budget
  std::vector<uint32_t> kinds;  // by channel: labels or quantities, as the source says
};

struct ImportPlan {
  const SeriesDescription& series;
  // To be tried one after the other, where a PSNR is missed; those that missed are taken out.
  std::vector<WriterSettings> attempts{};
  Json found = Json::object(); // as the library tells it
  bool auto_levels = false;    // nobody said how many
  [[nodiscard]] const WriterSettings& settings() const { return attempts.front(); }
};

// Asks the library for a plan; shown: is there a line of progress? Refuses settings by the name of the file
// that they are for.
void plan_series(FrameReader& reader, const Device& device, const WriterSettings& settings,
                 const PlanWish& wish, const std::string& output, bool shown, ImportPlan& plan);

// Frames before `first` back to one that is there in every channel. found: of a plan.
[[nodiscard]] uint64_t lead_of(const Json& found, uint64_t first);

} // namespace bcc4

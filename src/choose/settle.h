// SPDX-License-Identifier: Apache-2.0
// What an import has to find out about a series before it can write it.
#pragma once

#include "choose/plan.h"
#include "choose/search.h"
#include "choose/series_writer.h"
#include "series/frame_reader.h"

namespace bccsplat::series {

struct Unsettled {
  ErrorBound bound;             // to be kept by the smallest file that does
  bool open_store = false;      // may the store be one that was not asked for?
  bool auto_time_scale = false; // the distance along time
  bool auto_lattice = false;    // the lattice, or its distances
  double density = 0;        // sites per source sample; 0: half of them, or as the lattice has at distance 1
  bool exact = false;        // values as precise as the source's
  bool everything = false;   // whatever a plan can show
  Watch* progress = nullptr; // whoever waits; never null
  uint64_t memory = UINT64_MAX; // bytes that what is chosen may take, beside the device's budget
};

// Scans and samples the series as far as something is left to find out, and completes the settings and the
// plan.
void settle_import(FrameReader& reader, const Device& device, const Unsettled& unsettled,
                   WriterSettings& settings, ImportPlan& plan);

} // namespace bccsplat::series

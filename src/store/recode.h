// SPDX-License-Identifier: Apache-2.0
// One file made of another, without the source: samples become coefficients or the reverse, another kernel,
// another step, an older version of the format.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "formats/bcc4/layout.h"
#include "formats/bcc4/read/samples.h"
#include "store/write_report.h"

namespace bccsplat {

struct RecodeSettings {
  std::string path; // unless it is given a sink
  bool overwrite = false;
  std::optional<bool> coefficients; // none: what the file stores
  std::string kernel;               // of the coefficients, and recommended; empty: the file's
  std::optional<ValueType>
      value_type;        // none: as the channel has it, or as its coefficients or samples ask for
  double value_step = 0; // value of one code of integer types; 0: as the channel has it
  uint16_t format = 0;   // highest version of the format that may be needed; 0: any
};

// Writes `samples`' file anew. What it said of its source and of its frames stays; corrections, and the bound
// they kept, belong to the numbers that were stored and are left out. Throws unsupported for parts of a
// series, and where what is asked for needs a newer version of the format.
WriteReport recode(const Bcc4Samples& samples, const RecodeSettings& settings, const Context& context);
// make_sink is called once nothing is refused any more.
WriteReport recode(const Bcc4Samples& samples, const RecodeSettings& settings,
                   const std::function<std::unique_ptr<ByteSink>()>& make_sink, const Context& context);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "kernel/prefilter_tables.h"

#include "base/error.h"

namespace bccsplat {
namespace {

struct Entry {
  std::string_view name;
  std::span<const PrefilterStage> on_d4star, on_bcc;
  double gain;
};

#include "kernel/prefilter_tables.inc"

} // namespace

PrefilterTable shipped_prefilters(std::string_view kernel_name) {
  for (const Entry& entry : entries)
    if (entry.name == kernel_name)
      return {{entry.on_d4star.begin(), entry.on_d4star.end()},
              {entry.on_bcc.begin(), entry.on_bcc.end()},
              entry.gain};
  fail(Code::internal, "no prefilter for kernel '", kernel_name, "'");
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "choose/status.h"

namespace bccsplat::series {

void check(bccsplat_status status, const std::string& what) {
  if (status == BCCSPLAT_OK) return;
  if (status == BCCSPLAT_CANCELLED) throw Error(Code::cancelled, "interrupted");
  const std::string text = bccsplat_last_error();
  const std::string subject = what.empty() || text.find(what) != std::string::npos ? "" : what + ": ";
  throw Error(static_cast<Code>(status), subject + (text.empty() ? bccsplat_status_name(status) : text));
}

const char* lattice_name(int32_t lattice) {
  static constexpr const char* names[] = {"default", "d4star", "bcc", "cc"};
  return lattice >= 0 && lattice < 4 ? names[lattice] : "unknown";
}

} // namespace bccsplat::series

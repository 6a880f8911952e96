// SPDX-License-Identifier: Apache-2.0
#include "choose/status.h"

namespace bcc4 {

Exit exit_of(bccsplat_status status) {
  switch (status) {
  case BCCSPLAT_OK:
    return Exit::ok;
  case BCCSPLAT_CANCELLED:
    return Exit::interrupted;
  case BCCSPLAT_ERROR_OUT_OF_MEMORY:
  case BCCSPLAT_ERROR_MEMORY_BUDGET:
  case BCCSPLAT_ERROR_NO_SPACE:
    return Exit::no_resources;
  case BCCSPLAT_ERROR_FILE_EXISTS:
    return Exit::usage;
  case BCCSPLAT_ERROR_BOUND_NOT_MET:
    return Exit::check_failed;
  default:
    return status < 16 ? Exit::usage : Exit::bad_input;
  }
}

void check(bccsplat_status status, const std::string& what) {
  if (status == BCCSPLAT_OK) return;
  if (status == BCCSPLAT_CANCELLED) throw StatusError(status, Exit::interrupted, "interrupted");
  const std::string text = bccsplat_last_error();
  const std::string subject = what.empty() || text.find(what) != std::string::npos ? "" : what + ": ";
  throw StatusError(status, exit_of(status),
                    concat(subject, text.empty() ? bccsplat_status_name(status) : text));
}

const char* lattice_name(int32_t lattice) {
  static constexpr const char* names[] = {"default", "d4star", "bcc", "cc"};
  return lattice >= 0 && lattice < 4 ? names[lattice] : "unknown";
}

} // namespace bcc4

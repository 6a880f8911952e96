// SPDX-License-Identifier: Apache-2.0
// The edge of the library: no exception leaves it, every failure becomes a status and a text; and the host's
// floating-point environment stays outside.
#pragma once

#include <new>
#include <span>
#include <string_view>

#include "bccsplat.h"

#include "base/error.h"
#include "base/usual_floats.h"
#include "base/would_block.h"

namespace bccsplat::api {

// Sets this thread's last error; texts are cut at 1 KiB (a plain array: no destructor at dlclose).
void set_last_error(std::string_view text) noexcept;
// Sets what this thread's last call lacked; of more than 256 ranges the first ones.
void set_last_lacking(std::span<const ByteRange> ranges) noexcept;

// Runs the body and turns what it throws into a status.
template<class Body> [[nodiscard]] bccsplat_status guard(const Body& body) noexcept {
  const UsualFloats floats;
  try {
    body();
    return BCCSPLAT_OK;
  } catch (const WouldBlock& e) {
    set_last_error(e.message());
    set_last_lacking(e.lacking());
    return BCCSPLAT_ERROR_WOULD_BLOCK;
  } catch (const Error& e) {
    set_last_error(e.message());
    return static_cast<bccsplat_status>(e.code());
  } catch (const std::bad_alloc&) {
    set_last_error("out of memory");
    return BCCSPLAT_ERROR_OUT_OF_MEMORY;
  } catch (const std::exception& e) {
    set_last_error(e.what());
    return BCCSPLAT_ERROR_INTERNAL;
  } catch (...) {
    set_last_error("unknown exception");
    return BCCSPLAT_ERROR_INTERNAL;
  }
}

template<class T> void require(const T* pointer, const char* name) {
  if (!pointer) fail(Code::invalid_argument, name, " is NULL");
}

} // namespace bccsplat::api

// SPDX-License-Identifier: Apache-2.0
// What libFuzzer and the replay of the corpus call, and how a target takes its input apart.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace fuzz {

// A target found something wrong: a crash both under libFuzzer and in the replay.
[[noreturn]] void broken(const char* what);
inline void expect(bool holds, const char* what) {
  if (!holds) broken(what);
}

// Numbers from the front of the input; zeros behind its end.
class Input {
 public:
  Input(const uint8_t* data, size_t size) : bytes_(data, size) {}
  [[nodiscard]] bool empty() const { return bytes_.empty(); }
  [[nodiscard]] std::span<const uint8_t> rest() const { return bytes_; }

  template<class T>
  requires std::is_arithmetic_v<T>
  [[nodiscard]] T take() {
    T value{};
    const size_t n = std::min(sizeof(T), bytes_.size());
    if (n > 0) std::memcpy(&value, bytes_.data(), n);
    bytes_ = bytes_.subspan(n);
    return value;
  }
  // Of a byte, so that small inputs reach every choice.
  [[nodiscard]] uint32_t below(uint32_t count) { return take<uint8_t>() % count; }

 private:
  std::span<const uint8_t> bytes_;
};

} // namespace fuzz

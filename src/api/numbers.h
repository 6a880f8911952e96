// SPDX-License-Identifier: Apache-2.0
// What the header says of the numbers and counts that a host hands in, in one place: each is refused, by the
// name of its field, before anything is done with it.
#pragma once

#include <cfloat>
#include <cmath>
#include <cstdint>

#include "base/error.h"

namespace bccsplat::api {

inline constexpr double largest_number = 1e30;   // coordinates, lengths, times: products of three are numbers
inline constexpr double smallest_length = 1e-30; // where one must not be 0
inline constexpr double largest_view = 1e36;     // what looks at volumes of many voxels of largest_number
inline constexpr double largest_distance = 1e30; // what is multiplied by lengths in views, in floats
inline constexpr double largest_value = FLT_MAX; // of fields, which are kept as floats
inline constexpr double least_opacity_stop = 1e-3; // less is seen by nobody, so that no picture is left
inline constexpr double largest_colour = 1e9;      // products of three stay floats
inline constexpr int32_t most_threads = 4096;
inline constexpr uint32_t most_pixels = 65536; // along an edge of a picture
inline constexpr double largest_turn = 1e6;    // degrees
inline constexpr int32_t largest_tile = 4096;  // pixels along an edge
inline constexpr uint32_t most_stills = 4096, most_intervals = 256, most_lights = 8;
inline constexpr uint64_t memory_end = uint64_t{1} << 57; // that a process of any kind can see

inline void require_range(double v, double low, double high, const char* name) {
  if (!(v >= low && v <= high)) fail(Code::invalid_argument, name, " is ", v, ", not in ", low, " .. ", high);
}

inline void require_number(double v, const char* name, double largest = largest_number) {
  if (!(std::fabs(v) <= largest))
    fail(Code::invalid_argument, name, " is ", v, ", not finite and at most ", largest);
}

// A field whose 0 means something else.
inline void require_zero_or(double v, double low, double high, const char* name) {
  if (v != 0 && !(v >= low && v <= high))
    fail(Code::invalid_argument, name, " is ", v, ", neither 0 nor in ", low, " .. ", high);
}

// One of an enum of the header, whose last number is `last`.
inline void require_choice(int32_t v, int32_t last, const char* name) {
  if (v < 0 || v > last) fail(Code::invalid_argument, name, " is ", v, ", not one of 0 .. ", last);
}

template<size_t n>
void require_numbers(const double (&v)[n], const char* name, double largest = largest_number) {
  for (size_t i = 0; i < n; ++i)
    if (!(std::fabs(v[i]) <= largest))
      fail(Code::invalid_argument, name, '[', i, "] is ", v[i], ", not finite and at most ", largest);
}

template<size_t n> void require_range(const double (&v)[n], double low, double high, const char* name) {
  for (size_t i = 0; i < n; ++i)
    if (!(v[i] >= low && v[i] <= high))
      fail(Code::invalid_argument, name, '[', i, "] is ", v[i], ", not in ", low, " .. ", high);
}

// An array of the host's: as many elements as it says fit into memory.
inline void require_count(uint64_t n, uint64_t bytes_each, const char* name) {
  if (n > memory_end / bytes_each) fail(Code::invalid_argument, name, " is ", n, ": more than memory holds");
}

// name: of what has so many pixels.
inline void require_pixels(uint32_t width, uint32_t height, const char* name) {
  if (width == 0 || height == 0 || width > most_pixels || height > most_pixels)
    fail(Code::invalid_argument, name, ": ", width, " x ", height, " pixels are not 1 to ", most_pixels,
         " a side");
}

} // namespace bccsplat::api

// SPDX-License-Identifier: Apache-2.0
// Compares how much neighbouring samples differ as declared, with the bytes of each value reversed, and with
// the axes in another order; values that would be smooth in one of these other ways are suspicious.
#include "readers/raw/roughness.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <set>

#include "readers/text.h"

namespace bcc4 {
namespace {

constexpr uint64_t kProbes = 1 << 16; // pairs looked at: more make opening a file slower
// A warning is given when the data are this many times smoother read in another way. Lower ones would warn of
// noise, higher ones miss a wrong order in data with little structure.
constexpr double kSmootherSwapped = 1.25, kSmootherTurned = 2;
constexpr double kSmootherSigned = 4,
                 kFewBetween = 0.02; // with noise about 0 the steps are 10 times larger and more
constexpr double kAbsurdStep = 1e30; // sum of steps: floats of the other byte order are as large
constexpr size_t kFewBytes = 16;     // and of bytes that are labels
constexpr size_t kMostLabels = 256;  // of so few values the steps are as they happen to be numbered

double value_at(const Bytes& bytes, Type type, uint64_t i, bool swapped) {
  std::byte element[8];
  const size_t size = type_size(type);
  std::copy_n(bytes.data() + i * size, size, element);
  if (swapped) std::reverse(element, element + size);
  return visit_type(type, [&](auto zero) { return load_as<decltype(zero)>(element); });
}

// Returns the mean |difference| of samples `stride` apart over their mean deviation: about 1 for noise, small
// for smooth data; infinite when there are non-finite or absurd values.
double relative_step(const Bytes& bytes, Type type, uint64_t stride, bool swapped) {
  const uint64_t count = bytes.size() / type_size(type);
  if (count <= stride) return 0;
  const uint64_t pairs = count - stride, skip = std::max<uint64_t>(1, pairs / kProbes);
  double mean = 0, step = 0, deviation = 0, n = 0;
  for (uint64_t i = 0; i < pairs; i += skip, ++n) mean += value_at(bytes, type, i, swapped);
  mean /= n;
  for (uint64_t i = 0; i < pairs; i += skip) {
    const double v = value_at(bytes, type, i, swapped);
    step += std::abs(value_at(bytes, type, i + stride, swapped) - v);
    deviation += std::abs(v - mean);
  }
  if (!std::isfinite(step) || !std::isfinite(deviation) || step > kAbsurdStep) return HUGE_VAL;
  return deviation > 0 ? step / deviation : 0;
}

// Returns whether the values looked at are labels, or all one: no byte order makes these smooth.
bool are_labels(const Bytes& bytes, Type type, size_t most = kMostLabels) {
  std::set<uint64_t> patterns;
  const size_t size = type_size(type);
  const uint64_t count = bytes.size() / size, skip = std::max<uint64_t>(1, count / kProbes);
  for (uint64_t i = 0; i < count && patterns.size() <= most; i += skip) {
    uint64_t pattern = 0;
    std::memcpy(&pattern, bytes.data() + i * size, size);
    patterns.insert(pattern);
  }
  return patterns.size() <= most;
}

// Returns whether all values are whole multiples of what the other byte order reads as small numbers.
bool only_high_bytes(const Bytes& bytes, Type type) {
  if (is_float(type)) return false;
  const size_t size = type_size(type);
  const uint64_t count = bytes.size() / size;
  const size_t low = std::endian::native == std::endian::little ? 0 : size - 1;
  bool any = false;
  for (uint64_t i = 0; i < count; ++i) {
    if (bytes[i * size + low] != std::byte{}) return false;
    any = any || value_at(bytes, type, i, false) != 0;
  }
  return any;
}

Type of_other_sign(Type type) {
  return type == Type::u16   ? Type::i16
         : type == Type::i16 ? Type::u16
         : type == Type::u32 ? Type::i32
                             : Type::u32;
}

// Returns the mean |difference| of neighbours along x.
double neighbour_step(const Bytes& bytes, Type type) {
  const uint64_t count = bytes.size() / type_size(type);
  const uint64_t skip = std::max<uint64_t>(1, count / kProbes);
  double step = 0, n = 0;
  for (uint64_t i = 0; i + 1 < count; i += skip, ++n)
    step += std::abs(value_at(bytes, type, i + 1, false) - value_at(bytes, type, i, false));
  return n > 0 ? step / n : 0;
}

// Returns whether the type looks as if it had the other sign. Integers are then near both ends of the type,
// with nothing between, or with little between and steps that are much smaller read the other way. Bytes may
// well be so.
bool split_by_sign(const Bytes& bytes, Type type) {
  if (is_float(type) || type_size(type) == 1) return false;
  const double range = std::exp2(8.0 * static_cast<double>(type_size(type)));
  const bool is_signed = type == Type::i16 || type == Type::i32;
  std::array<uint64_t, 4> quarters{};
  double first = HUGE_VAL, last = -HUGE_VAL; // of the upper quarter: a mask has one value there
  const uint64_t count = bytes.size() / type_size(type);
  for (uint64_t i = 0; i < count; ++i) {
    const double v = value_at(bytes, type, i, false) + (is_signed ? range / 2 : 0);
    const auto quarter = static_cast<size_t>(4 * v / range);
    ++quarters[std::min<size_t>(quarter, 3)];
    if (quarter == 3) first = std::min(first, v), last = std::max(last, v);
  }
  if (quarters[0] == 0 || last - first <= 1) return false;
  const auto between = static_cast<double>(quarters[1] + quarters[2]),
             least = static_cast<double>(std::min(quarters[0], quarters[3]));
  return between == 0 || (between < kFewBetween * least && neighbour_step(bytes, of_other_sign(type)) <
                                                               neighbour_step(bytes, type) / kSmootherSigned);
}

// Returns whether values of two bytes look like twice as many of one: smooth along the bytes, and more so
// from one byte to the next than from a value to the next. Bytes of real pairs, a fine and a coarse one,
// differ wildly.
bool are_single_bytes(const Bytes& bytes, Type type) {
  constexpr double smooth = 0.7, nearer = 0.9; // real pairs have 1.3 and more of the first
  if (type_size(type) != 2 || are_labels(bytes, Type::u8, kFewBytes)) return false;
  const double next = relative_step(bytes, Type::u8, 1, false),
               over = relative_step(bytes, Type::u8, 2, false);
  return next < smooth && next < nearer * over;
}

} // namespace

std::vector<std::string> find_suspicions(const Bytes& bytes, Type type, const std::vector<FileAxis>& axes) {
  std::vector<std::string> out;
  if (type_size(type) > 1) {
    const double given = relative_step(bytes, type, 1, false), swapped = relative_step(bytes, type, 1, true);
    const bool smoother = swapped < given / kSmootherSwapped && !are_labels(bytes, type);
    if (smoother || only_high_bytes(bytes, type))
      out.push_back("the values jump about as declared and are smooth with the bytes of each value reversed: "
                    "is --endian right?");
  }
  if (are_single_bytes(bytes, type))
    out = {concat("the two bytes of each ", type_name(type),
                  " are as close to each other as neighbours are: as u8 ",
                  "the values would be smooth: is --dtype right?")};
  if (out.empty() && split_by_sign(bytes, type))
    out.push_back(concat("the values are near both ends of ", type_name(type), " and hardly between: as ",
                         type_name(of_other_sign(type)), " they would be close: is --dtype right?"));
  std::vector<uint64_t> sizes;
  for (const FileAxis& axis : axes) sizes.push_back(axis.size);
  const auto roughness = [&](const std::vector<uint64_t>& s) {
    double sum = 0;
    uint64_t stride = 1;
    for (size_t a = 0; a + 1 < s.size(); ++a) sum += relative_step(bytes, type, stride *= s[a], false);
    return sum;
  };
  const double given = roughness(sizes);
  std::vector<uint64_t> other = sizes, best = sizes;
  double smoothest = given;
  std::sort(other.begin(), other.end());
  do {
    const double r = roughness(other);
    if (r < smoothest) {
      smoothest = r;
      best = other;
    }
  } while (std::next_permutation(other.begin(), other.end()));
  if (out.empty() && smoothest < given / kSmootherTurned) {
    std::string text;
    for (const uint64_t n : best) text += concat(text.empty() ? "" : ",", n);
    out.push_back(concat("the data are much smoother when the sizes, fastest first, are ", text,
                         ": are --dims and --axes right?"));
  }
  return out;
}

} // namespace bcc4

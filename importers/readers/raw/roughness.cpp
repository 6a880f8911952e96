#include "readers/raw/roughness.h"

#include <algorithm>
#include <cmath>

#include "readers/text.h"

namespace bcc4 {
namespace {

constexpr uint64_t kProbes = 1 << 16; // pairs looked at: more make opening a file slower
// A warning is given when the data are this many times smoother read in another way. Lower ones would warn of
// noise, higher ones miss a wrong order in data with little structure.
constexpr double kSmootherSwapped = 4, kSmootherTurned = 2;
constexpr double kAbsurdStep = 1e30; // sum of steps: floats of the other byte order are as large

double value_at(const Bytes& bytes, Type type, uint64_t i, bool swapped) {
  std::byte element[8];
  const size_t size = type_size(type);
  std::copy_n(bytes.data() + i * size, size, element);
  if (swapped) std::reverse(element, element + size);
  return visit_type(type, [&](auto zero) { return load_as<decltype(zero)>(element); });
}

// Mean |difference| of samples `stride` apart over their mean deviation: about 1 for noise, small for smooth
// data; infinite when there are non-finite or absurd values.
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

} // namespace

std::vector<std::string> find_suspicions(const Bytes& bytes, Type type, const std::vector<FileAxis>& axes) {
  std::vector<std::string> out;
  if (type_size(type) > 1) {
    const double given = relative_step(bytes, type, 1, false), swapped = relative_step(bytes, type, 1, true);
    if (swapped < given / kSmootherSwapped)
      out.push_back("the values jump about as declared and are smooth with the bytes of each value reversed: "
                    "is --endian right?");
  }
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

// SPDX-License-Identifier: Apache-2.0
// Fields are put where the reader looks for them (NiftiFields), little-endian. Places and times are floats in
// NIfTI-1, doubles in NIfTI-2.
#include "tool/output/nifti_output.h"

#include <algorithm>
#include <cmath>

#include "readers/calendar.h"
#include "readers/nifti/nifti_header.h"
#include "readers/text.h"

namespace bcc4 {
namespace {

constexpr uint64_t kMostSamples = 32767; // of an axis of NIfTI-1

struct TypeCode {
  Type type;
  int code;
};
constexpr TypeCode kCodes[] = {{Type::u8, 2},   {Type::i16, 4},   {Type::i32, 8},  {Type::f32, 16},
                               {Type::i8, 256}, {Type::u16, 512}, {Type::u32, 768}};

// Fields that the reader has no use for.
struct MoreFields {
  size_t bits, magic;
};
constexpr MoreFields kMore1{72, 344}, kMore2{14, 4};
constexpr size_t kLongestText = 79, kLongestName = 15;

// Puts numbers of either version into a header.
class Fields {
 public:
  explicit Fields(const NiftiFields& fields) : f_(fields), bytes_(fields.header + kNoExtension, '\0') {}

  template<class T> void put(size_t offset, T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof value);
    if constexpr (std::endian::native != std::endian::little) std::reverse(raw, raw + sizeof(T));
    std::copy_n(raw, sizeof(T), bytes_.data() + offset);
  }
  void real(size_t offset, size_t i, double value) {
    if (f_.wide)
      put(offset + sizeof(double) * i, value);
    else
      put(offset + sizeof(float) * i, static_cast<float>(value));
  }
  void dim(size_t i, uint64_t value) {
    if (f_.wide)
      put(f_.dim + sizeof(int64_t) * i, static_cast<int64_t>(value));
    else
      put(f_.dim + sizeof(int16_t) * i, static_cast<int16_t>(value));
  }
  void code(size_t offset, int value) {
    if (f_.wide)
      put(offset, static_cast<int32_t>(value));
    else
      put(offset, static_cast<int16_t>(value));
  }
  void text(size_t offset, std::string_view value, size_t most) {
    value.copy(bytes_.data() + offset, std::min(value.size(), most));
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  static constexpr size_t kNoExtension = 4; // zeros behind the header
  const NiftiFields& f_;
  std::string bytes_;
};

// The world as NIfTI has it: x to the right, y forward, z up.
Affine to_nifti(Affine m, const std::string& space) {
  if (space.starts_with("left-posterior-superior"))
    for (size_t i = 0; i < 8; ++i) m[i] = m[i] == 0 ? 0 : -m[i];
  return m;
}

bool known_space(const std::string& space) {
  return space.starts_with("left-posterior-superior") || space.starts_with("right-anterior-superior");
}

std::array<double, 3> steps_of(const Affine& m) {
  return {std::hypot(m[0], m[4], m[8]), std::hypot(m[1], m[5], m[9]), std::hypot(m[2], m[6], m[10])};
}

// Are the axes at right angles, as far as floats tell?
bool at_right_angles(const Affine& m, const std::array<double, 3>& steps) {
  constexpr double close = 1e-5;
  for (size_t a = 0; a < 3; ++a) {
    const size_t b = (a + 1) % 3;
    const double dot = m[a] * m[b] + m[4 + a] * m[4 + b] + m[8 + a] * m[8 + b];
    if (std::abs(dot) > close * steps[a] * steps[b]) return false;
  }
  return true;
}

// Returns the quaternion (a, b, c, d), a not negative, of the rotation with these columns: by the largest of
// its parts, which nothing is lost of.
std::array<double, 4> quaternion_of(const double (&r)[3][3]) {
  const double squares[] = {1 + r[0][0] + r[1][1] + r[2][2], 1 + r[0][0] - r[1][1] - r[2][2],
                            1 - r[0][0] + r[1][1] - r[2][2], 1 - r[0][0] - r[1][1] + r[2][2]};
  const double twice[4][4] = {{squares[0], r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]},
                              {r[2][1] - r[1][2], squares[1], r[0][1] + r[1][0], r[0][2] + r[2][0]},
                              {r[0][2] - r[2][0], r[0][1] + r[1][0], squares[2], r[1][2] + r[2][1]},
                              {r[1][0] - r[0][1], r[0][2] + r[2][0], r[1][2] + r[2][1], squares[3]}};
  const size_t largest = std::max_element(squares, squares + 4) - squares;
  std::array<double, 4> q{};
  const double length = 2 * std::sqrt(squares[largest]);
  for (size_t i = 0; i < 4; ++i) q[i] = twice[largest][i] / length;
  if (q[0] < 0)
    for (double& part : q) part = -part;
  return q;
}

// Rounds b, c and d to floats. Readers take a for what is left of 1: of half a turn, where nothing is,
// rounding must not leave anything, of which the root would be a thousandth.
void round_to_floats(std::array<double, 4>& q) {
  constexpr double half_turn = 1e-4;
  for (double& part : q) part = static_cast<float>(part);
  if (q[0] > half_turn) return;
  const auto largest =
      std::max_element(q.begin() + 1, q.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  while (q[1] * q[1] + q[2] * q[2] + q[3] * q[3] < 1)
    *largest = std::nextafter(static_cast<float>(*largest), static_cast<float>(2 * *largest));
}

void put_qform(Fields& out, const NiftiFields& f, const Affine& m, const std::array<double, 3>& steps,
               int code) {
  const double third = determinant(m) < 0 ? -1 : 1; // a left-handed third axis is turned round
  double r[3][3];
  for (size_t row = 0; row < 3; ++row)
    for (size_t a = 0; a < 3; ++a) r[row][a] = m[4 * row + a] / steps[a] * (a == 2 ? third : 1);
  std::array<double, 4> q = quaternion_of(r);
  if (!f.wide) round_to_floats(q);
  out.code(f.qform, code);
  out.real(f.pixdim, 0, third);
  for (size_t i = 0; i < 3; ++i) {
    out.real(f.quatern, i, q[i + 1]);
    out.real(f.qoffset, i, m[4 * i + 3]);
  }
}

void put_place(Fields& out, const NiftiFields& f, const VolumeOutput& o) {
  const Affine m = to_nifti(o.affine, o.space);
  const std::array<double, 3> steps = steps_of(m);
  const int code = known_space(o.space) ? 1 : 2; // of a scanner, or aligned with something
  out.real(f.pixdim, 0, 1);
  for (size_t a = 0; a < 3; ++a) out.real(f.pixdim, a + 1, steps[a]);
  out.code(f.sform, code);
  for (size_t i = 0; i < 12; ++i) out.real(f.srow, i, m[i]);
  if (at_right_angles(m, steps)) put_qform(out, f, m, steps, code);
}

int space_unit_code(const std::string& unit) {
  const std::string u = lower(trim(unit));
  if (u == "m" || u == "meter" || u == "metre" || u == "meters" || u == "metres") return 1;
  if (u == "mm" || u == "millimeter" || u == "millimetre" || u == "millimeters") return 2;
  if (u == "um" || u == "\xc2\xb5m" || u == "\xce\xbcm" || u == "micron" || u == "microns") return 3;
  return 0;
}

struct TimeUnitOfNifti {
  int code = 0;
  double factor = 1; // of the file's times
};
// Seconds, milliseconds and microseconds are its units; hours and the like become seconds.
TimeUnitOfNifti time_unit_of(const std::string& unit) {
  const std::string u = lower(trim(unit));
  if (u == "us" || u == "\xc2\xb5s") return {24, 1};
  const auto seconds = seconds_in(u);
  if (!seconds) return {};
  constexpr double milli = 1e-3;
  if (*seconds == milli) return {16, 1};
  return {8, *seconds};
}

bool even(const std::vector<double>& times, double step) {
  constexpr double close = 1e-4; // of a step: floats have no more digits of many steps
  for (size_t i = 0; i < times.size(); ++i)
    if (std::abs(times[i] - times[0] - static_cast<double>(i) * step) > close * std::abs(step)) return false;
  return true;
}

void put_times(Fields& out, const NiftiFields& f, const VolumeOutput& o, int& units,
               std::vector<std::string>& notes) {
  if (o.times.empty()) return;
  const TimeUnitOfNifti unit = time_unit_of(o.time_unit);
  units += unit.code;
  if (unit.factor != 1) notes.push_back(concat("its times in ", o.time_unit, " are written in seconds"));
  if (unit.code == 0 && !o.time_unit.empty())
    notes.push_back(
        concat("NIfTI has no code for times in ", o.time_unit, ": the numbers stand without a unit"));
  out.real(f.toffset, 0, o.times[0] * unit.factor);
  if (o.times.size() < 2) return;
  const double step = (o.times.back() - o.times[0]) / static_cast<double>(o.times.size() - 1);
  out.real(f.pixdim, 4, step * unit.factor);
  if (!even(o.times, step))
    notes.push_back("its times are uneven, for which NIfTI has no place: the mean step is written");
}

void put_kind(Fields& out, const NiftiFields& f, const MoreFields& more, const VolumeOutput& o) {
  constexpr int bits_of_byte = 8;
  for (const auto& [type, code] : kCodes)
    if (type == o.type) out.put(f.datatype, static_cast<int16_t>(code));
  out.put(more.bits, static_cast<int16_t>(type_size(o.type) * bits_of_byte));
  out.real(f.slope, 0, 1); // values are the numbers that stand there
  out.text(f.intent_name, o.name, kLongestName);
  out.text(f.text, concat("bcc4", o.unit.empty() ? "" : concat("; values in ", o.unit)), kLongestText);
}

void put_sizes(Fields& out, const VolumeOutput& o) {
  constexpr size_t axes = 7;
  const bool series = o.times.size() > 1;
  out.dim(0, series ? 4 : 3);
  for (size_t a = 1; a <= axes; ++a) out.dim(a, a <= 3 ? o.dims[a - 1] : 1);
  if (series) out.dim(4, o.times.size());
}

} // namespace

NiftiText nifti_header_text(const VolumeOutput& o) {
  const bool wide = std::max({o.dims[0], o.dims[1], o.dims[2], uint64_t{o.times.size()}}) > kMostSamples;
  const NiftiFields& f = wide ? kNifti2 : kNifti1;
  const MoreFields& more = wide ? kMore2 : kMore1;
  NiftiText text;
  Fields out(f);
  out.put(0, static_cast<int32_t>(f.header));
  put_sizes(out, o);
  put_kind(out, f, more, o);
  put_place(out, f, o);
  int units = space_unit_code(o.spatial_unit);
  if (units == 0 && !o.spatial_unit.empty())
    text.notes.push_back(
        concat("NIfTI has no code for lengths in ", o.spatial_unit, ": they stand without a unit"));
  put_times(out, f, o, units, text.notes);
  if (!o.epoch.empty()) text.notes.push_back(concat("NIfTI has no place for the date of time 0, ", o.epoch));
  constexpr size_t extension = 4;
  if (wide) {
    out.put(f.units, static_cast<int32_t>(units));
    out.put(f.vox_offset, static_cast<int64_t>(f.header + extension));
    out.text(more.magic, std::string_view("n+2\0\r\n\032\n", 8), 8);
  } else {
    out.put(f.units, static_cast<uint8_t>(units));
    out.real(f.vox_offset, 0, static_cast<double>(f.header + extension));
    out.text(more.magic, "n+1", 3);
  }
  text.header = out.take();
  return text;
}

} // namespace bcc4

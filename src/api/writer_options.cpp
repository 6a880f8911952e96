// SPDX-License-Identifier: Apache-2.0
// Options and reports of writers, between the C ABI and the core.
#include <algorithm>
#include <cmath>

#include "api/numbers.h"
#include "api/structs.h"
#include "api/texts.h"
#include "api/writer.h"

namespace bccsplat::api {
namespace {

constexpr double most_decibels = 1000;   // of a PSNR; a double has 1e15 steps, 313 dB
constexpr uint32_t most_channels = 1024; // as readers take

// choose() takes the numbers of the C ABI for those of the core.
static_assert(static_cast<int>(LatticeKind::d4star) == BCCSPLAT_LATTICE_D4STAR &&
              static_cast<int>(LatticeKind::bcc) == BCCSPLAT_LATTICE_BCC &&
              static_cast<int>(LatticeKind::cc) == BCCSPLAT_LATTICE_CC);
static_assert(static_cast<int>(NonFinite::error) == BCCSPLAT_NONFINITE_ERROR &&
              static_cast<int>(NonFinite::hole) == BCCSPLAT_NONFINITE_HOLE &&
              static_cast<int>(NonFinite::clamp) == BCCSPLAT_NONFINITE_CLAMP);
static_assert(static_cast<int>(Ends::predict) == BCCSPLAT_ENDS_PREDICT &&
              static_cast<int>(Ends::mirror) == BCCSPLAT_ENDS_MIRROR &&
              static_cast<int>(Ends::periodic) == BCCSPLAT_ENDS_PERIODIC);
static_assert(static_cast<int>(Measure::some) == BCCSPLAT_MEASURE_SOME &&
              static_cast<int>(Measure::all) == BCCSPLAT_MEASURE_ALL);
static_assert(static_cast<int>(Continuity::journal) == BCCSPLAT_PARTIAL_KEEP &&
              static_cast<int>(Continuity::resume) == BCCSPLAT_PARTIAL_RESUME &&
              static_cast<int>(Continuity::append) == BCCSPLAT_PARTIAL_APPEND);

std::string text_or(const char* text, const char* otherwise) { return text ? text : otherwise; }

// A number of the C ABI as an enum of the core; 0 is the default.
template<class Enum> Enum choose(int32_t value, Enum otherwise, int32_t last, const char* name) {
  require_choice(value, last, name);
  return value == 0 ? otherwise : static_cast<Enum>(value);
}

Affine3 read_affine(const double (&m)[16]) {
  Affine3 a;
  if (std::all_of(std::begin(m), std::end(m), [](double v) { return v == 0; })) return a;
  require_numbers(m, "bccsplat_writer_options.affine");
  if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
    fail(Code::invalid_argument,
         "bccsplat_writer_options.affine: the last row must be 0 0 0 1; it is row-major");
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) a.linear[r][c] = m[4 * r + c];
    a.offset[r] = m[4 * r + 3];
  }
  if (!(std::fabs(a.determinant()) > 0))
    fail(Code::invalid_argument, "bccsplat_writer_options.affine: the axes do not span space");
  require_range(std::cbrt(std::fabs(a.determinant())), smallest_length / 2, 2 * largest_number,
                "bccsplat_writer_options.affine: its mean voxel");
  return a;
}

// number: 0 to 2, of `samples`.
AxisInfo read_axis(const bccsplat_axis& in, size_t number, uint32_t samples) {
  const std::string name = concat("bccsplat_writer_options.axes[", number, "]");
  AxisInfo out;
  if ((in.flags & ~uint32_t{BCCSPLAT_AXIS_DOWN}) != 0)
    fail(Code::invalid_argument, name, ".flags: unknown bits ", in.flags);
  out.down = in.flags != 0;
  require_utf8(in.unit, name + ".unit");
  out.unit = text_or(in.unit, "");
  if (in.count == 0) return out;
  if (in.count != samples || in.count < 2)
    fail(Code::invalid_argument, name, " has ", in.count, " coordinates, the axis ", samples,
         " samples; an axis of two samples or more has one for each");
  require(in.coordinates, (name + ".coordinates").c_str());
  out.coordinates.assign(in.coordinates, in.coordinates + in.count);
  for (const double c : out.coordinates) require_number(c, (name + ".coordinates").c_str());
  return out;
}

// Where an axis is unevenly spaced each has its unit, and space has none.
void read_axes(const bccsplat_axis* axes, WriterSettings& s) {
  if (!axes) return;
  bool any = false;
  std::array<AxisInfo, 3> read;
  for (size_t a = 0; a < read.size(); ++a) {
    read[a] = read_axis(read_struct(element(axes, a), "bccsplat_axis"), a, s.dims[a]);
    any = any || !read[a].coordinates.empty();
    if (read[a].unit.empty()) read[a].unit = s.spatial_unit;
  }
  if (!any) return;
  s.axes = std::move(read);
  s.spatial_unit.clear();
}

// The first that is given: a distance of the axis, of space or time, 1.
LatticeScales read_scales(const bccsplat_writer_options& o) {
  constexpr double most = 65536;
  require_zero_or(o.scale, smallest_length, most, "bccsplat_writer_options.scale");
  require_zero_or(o.time_scale, smallest_length, most, "bccsplat_writer_options.time_scale");
  LatticeScales scales{};
  for (size_t a = 0; a < 4; ++a) {
    const double otherwise = a == 3 ? o.time_scale : o.scale;
    require_zero_or(o.scales[a], smallest_length, most, "bccsplat_writer_options.scales");
    scales[a] = o.scales[a] != 0 ? o.scales[a] : otherwise != 0 ? otherwise : 1;
  }
  return scales;
}

void read_faces(int32_t faces, WriterSettings& s) {
  if (faces < BCCSPLAT_FACES_PREDICT_X) {
    s.faces = choose(faces, Faces::automatic, BCCSPLAT_FACES_MIRROR, "faces");
    return;
  }
  s.faces = Faces::along;
  for (size_t a = 0; a < 3; ++a) {
    const int32_t bit = BCCSPLAT_FACES_PREDICT_X << a;
    s.faces_along[a] = (faces & bit) != 0, faces &= ~bit;
  }
  if (faces != 0) fail(Code::invalid_argument, "faces: unknown bits ", faces);
}

// A number that is too large for any series is refused like the next smaller ones.
uint32_t read_end(uint64_t end) { return static_cast<uint32_t>(std::min<uint64_t>(end, UINT32_MAX - 1)); }

SeriesBlock read_block(const bccsplat_series_part& part) {
  SeriesBlock block = SeriesBlock::of_frames(read_end(part.first), read_end(part.end));
  const auto any = [](const auto& numbers) {
    return std::any_of(std::begin(numbers), std::end(numbers), [](uint64_t n) { return n != 0; });
  };
  if (!any(part.box_begin) && !any(part.box_end)) return block;
  for (size_t a = 0; a < 3; ++a)
    block.begin[a] = read_end(part.box_begin[a]), block.end[a] = read_end(part.box_end[a]);
  return block;
}

PartSettings read_part(const bccsplat_series_part& part, uint32_t frames) {
  require_zero(part.reserved, "bccsplat_series_part.reserved");
  PartSettings out{read_block(part), part.lead, {}};
  if (frames > 0 && part.end <= frames) { // else it is refused, and there may be no times to read
    require(part.times, "part.times");
    out.times.assign(part.times, part.times + frames);
    for (const double t : out.times) require_number(t, "bccsplat_series_part.times");
  }
  return out;
}

// Its numbers and texts are refused by its number among the channels.
ChannelSettings read_channel(const bccsplat_channel_options& in, uint32_t number) {
  const std::string channel = concat("bccsplat_writer_options.channels[", number, "]");
  const auto field = [&](const char* name) { return channel + name; };
  ChannelSettings out;
  out.name = text_or(in.name, "value");
  require_utf8(in.name, field(".name").c_str());
  require_utf8(in.unit, field(".unit").c_str());
  out.unit = text_or(in.unit, "");
  constexpr uint32_t kinds = BCCSPLAT_CHANNEL_LABELS | BCCSPLAT_CHANNEL_QUANTITIES;
  if (in.set_mask & ~(kinds | BCCSPLAT_CHANNEL_SET_AIR | BCCSPLAT_CHANNEL_SET_RANGE))
    fail(Code::invalid_argument, "channel ", out.name, ": unknown bits in set_mask");
  if ((in.set_mask & kinds) == kinds)
    fail(Code::invalid_argument, "channel ", out.name, ": its values are labels or quantities, not both");
  if (in.set_mask & kinds) out.labels = (in.set_mask & BCCSPLAT_CHANNEL_LABELS) != 0;
  if (in.source_type < 0 || in.source_type > BCCSPLAT_TYPE_U32)
    fail(Code::invalid_argument, "channel ", out.name, ": source_type ", in.source_type);
  if (in.value_type < 0 || in.value_type > BCCSPLAT_TYPE_F32)
    fail(Code::invalid_argument, "channel ", out.name, ": value_type must be U8, U16, F16 or F32");
  if (in.source_type != 0) out.source_type = static_cast<SourceType>(in.source_type);
  if (in.value_type != 0) out.value_type = static_cast<ValueType>(in.value_type);
  require_number(in.air, field(".air").c_str(), largest_value);
  require_range(in.air_threshold, 0, largest_value, field(".air_threshold").c_str());
  require_range(in.value_step, 0, largest_value, field(".value_step").c_str());
  if (in.set_mask & BCCSPLAT_CHANNEL_SET_RANGE)
    require_numbers(in.range, field(".range").c_str(), largest_value);
  out.air = in.set_mask & BCCSPLAT_CHANNEL_SET_AIR ? in.air : 0;
  out.threshold = static_cast<float>(in.air_threshold);
  if (in.set_mask & BCCSPLAT_CHANNEL_SET_RANGE) out.range = Range{in.range[0], in.range[1]};
  out.value_step = in.value_step;
  return out;
}

} // namespace

WriterSettings read_writer_settings(const bccsplat_writer_options& o, const char* path) {
  require_zero(o.set_mask, "bccsplat_writer_options.set_mask");
  WriterSettings s;
  s.path = text_or(path, "");
  s.overwrite = o.overwrite != 0;
  s.continuity = choose(o.partial, Continuity::none, BCCSPLAT_PARTIAL_APPEND, "partial");
  std::copy(std::begin(o.dims), std::end(o.dims), s.dims.begin());
  s.lattice = choose(o.lattice, LatticeKind::d4star, BCCSPLAT_LATTICE_CC, "lattice");
  s.scales = read_scales(o);
  s.lowpass = o.lowpass != 0;
  s.nonfinite = choose(o.nonfinite, NonFinite::error, BCCSPLAT_NONFINITE_CLAMP, "nonfinite");
  s.ends = choose(o.ends, Ends::automatic, BCCSPLAT_ENDS_PERIODIC, "ends");
  read_faces(o.faces, s);
  s.fixed_predictions = o.fixed_predictions != 0;
  if (o.periodic_axes > (BCCSPLAT_PERIODIC_X | BCCSPLAT_PERIODIC_Y | BCCSPLAT_PERIODIC_Z))
    fail(Code::invalid_argument, "periodic_axes: unknown bits ", o.periodic_axes);
  for (size_t a = 0; a < 3; ++a) s.turning[a] = (o.periodic_axes >> a & 1) != 0;
  s.wavelets = o.store == BCCSPLAT_STORE_WAVELETS;
  if (!s.wavelets && o.store != BCCSPLAT_STORE_DEFAULT && o.store != BCCSPLAT_STORE_SAMPLES)
    fail(Code::invalid_argument, "store is ", o.store, ", not one of 0, ", BCCSPLAT_STORE_SAMPLES, " and ",
         BCCSPLAT_STORE_WAVELETS);
  if (o.levels > static_cast<uint32_t>(most_levels))
    fail(Code::invalid_argument, "writer: levels ", o.levels, ": 0 to ", most_levels);
  s.levels = o.levels;
  s.live_slabs = o.live;
  require_range(o.abs_error, 0, largest_value, "bccsplat_writer_options.abs_error");
  require_range(o.psnr, 0, most_decibels, "bccsplat_writer_options.psnr");
  s.psnr = o.psnr;
  s.measure = choose(o.measure, Measure::bounded, BCCSPLAT_MEASURE_ALL, "measure");
  s.affine = read_affine(o.affine);
  require_utf8(o.spatial_unit, "bccsplat_writer_options.spatial_unit");
  require_utf8(o.time_unit, "bccsplat_writer_options.time_unit");
  s.spatial_unit = text_or(o.spatial_unit, "");
  s.time_unit = text_or(o.time_unit, "");
  read_axes(o.axes, s);
  s.recommended_kernel = text_or(o.recommended_kernel, "");
  if (o.channel_count > 0) require(o.channels, "channels");
  if (o.channel_count > most_channels)
    fail(Code::invalid_argument, "writer: ", o.channel_count, " channels; at most ", most_channels);
  s.channels.clear();
  for (uint32_t c = 0; c < o.channel_count; ++c)
    s.channels.push_back(read_channel(read_struct(element(o.channels, c), "bccsplat_channel_options"), c));
  if (o.channel_count == 0) s.channels.resize(1);
  for (size_t c = 0; c < s.channels.size(); ++c) {
    if (o.abs_errors) require_range(o.abs_errors[c], 0, largest_value, "bccsplat_writer_options.abs_errors");
    s.channels[c].abs_error = o.abs_errors && o.abs_errors[c] > 0 ? o.abs_errors[c] : o.abs_error;
  }
  for (size_t c = 0; o.wavelet_errors && c < s.channels.size(); ++c) {
    require_range(o.wavelet_errors[c], 0, largest_value, "bccsplat_writer_options.wavelet_errors");
    s.channels[c].wavelet_error = o.wavelet_errors[c];
  }
  if (o.part) s.part = read_part(read_struct(o.part, "bccsplat_series_part"), s.dims[3]);
  return s;
}

void write_report(bccsplat_writer_report* out, const WriteReport& r) {
  if (!out) return;
  bccsplat_writer_report report{};
  report.slabs_reused = static_cast<uint32_t>(std::min<uint64_t>(r.slabs_reused, UINT32_MAX));
  report.frames = r.frames;
  report.cc_samples = r.cc_samples, report.cc_relevant = r.cc_relevant;
  report.sites_total = r.sites_total, report.sites_outside = r.sites_outside;
  report.sites_kept = r.sites_kept, report.holes = r.holes;
  report.clamped = r.clamped, report.nonfinite = r.nonfinite;
  report.bytes_source = r.bytes_source, report.bytes_file = r.bytes.file;
  report.bytes_runs = r.bytes.runs, report.bytes_values = r.bytes.values, report.bytes_index = r.bytes.index;
  report.frames_measured = r.frames_measured, report.corrected = r.corrected;
  report.bytes_corrections = r.bytes_corrections;
  report.coding_max = r.coding_max, report.coding_rmse = r.coding_rmse;
  write_struct(out, report, "report");
}

} // namespace bccsplat::api

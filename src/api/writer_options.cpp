#include <algorithm>
#include <cmath>

#include "api/writer.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

std::string text_or(const char* text, const char* otherwise) { return text ? text : otherwise; }

// A number of the C ABI as an enum of the core; 0 is the default.
template<class Enum> Enum choose(int32_t value, Enum otherwise, int32_t last, const char* name) {
  if (value < 0 || value > last) fail(Code::invalid_argument, name, " ", value, " is not one of 0 .. ", last);
  return value == 0 ? otherwise : static_cast<Enum>(value);
}

Affine3 read_affine(const double (&m)[16]) {
  Affine3 a;
  if (std::all_of(std::begin(m), std::end(m), [](double v) { return v == 0; })) return a;
  for (const double v : m)
    if (!std::isfinite(v)) fail(Code::invalid_argument, "affine: every element must be finite");
  if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
    fail(Code::invalid_argument, "affine: the last row must be 0 0 0 1");
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) a.linear[r][c] = m[4 * r + c];
    a.offset[r] = m[4 * r + 3];
  }
  if (!(std::fabs(a.determinant()) > 0)) fail(Code::invalid_argument, "affine: the axes do not span space");
  return a;
}

} // namespace

bccsplat_writer::bccsplat_writer(bccsplat_device* owner, const bccsplat_writer_options& o)
    : device(owner), progress(progress_callback(o.progress, o.progress_user)) {
  require_zero(o.set_mask, "bccsplat_writer_options.set_mask");
  for (size_t a = 0; a < 3; ++a)
    if (o.dims[a] == 0) fail(Code::invalid_argument, "writer: dims[", a, "] is 0");
  const double scale = o.scale == 0 ? 1 : o.scale, time_scale = o.time_scale == 0 ? 1 : o.time_scale;
  fit_options.lattice = choose(o.lattice, LatticeKind::d4star, 3, "lattice");
  fit_options.dims = {o.dims[0], o.dims[1], o.dims[2], o.dims[3]};
  fit_options.scale = scale, fit_options.time_scale = time_scale;
  fit_options.filter = choose(o.filter, Filter::kaiser8, 3, "filter");
  require_zero(o.reserved, "bccsplat_writer_options.reserved");
  require_zero(o.reserved_end, "bccsplat_writer_options.reserved_end");
  ends = choose(o.ends, int32_t{BCCSPLAT_ENDS_DEFAULT}, 2, "ends");
  fit_options.lowpass = o.lowpass != 0;
  if (fit_options.lowpass && fit_options.lattice == LatticeKind::cc)
    fail(Code::invalid_argument, "writer: a low-pass is of use on D4* and BCC only");
  fit_options.nonfinite = choose(o.nonfinite, NonFinite::error, 3, "nonfinite");
  fit_options.slab_layers = initial.slab_layers;
  const int32_t store = choose(o.store, BCCSPLAT_STORE_SAMPLES, 2, "store");
  coefficients = store == BCCSPLAT_STORE_COEFFICIENTS;
  if (o.partial < 0 || o.partial > BCCSPLAT_PARTIAL_APPEND)
    fail(Code::invalid_argument, "partial ", o.partial, " is not one of 0 .. 3");
  partial = o.partial;
  abs_error = o.abs_error, psnr = o.psnr, measure = o.measure;
  if (!(abs_error >= 0 && std::isfinite(abs_error)) || !(psnr >= 0 && std::isfinite(psnr)))
    fail(Code::invalid_argument, "writer: abs_error and psnr must be finite and not negative");
  if (measure < 0 || measure > BCCSPLAT_MEASURE_ALL)
    fail(Code::invalid_argument, "measure ", measure, " is not one of 0 .. 2");
  const bool bounded = abs_error > 0 || psnr > 0;
  if ((bounded || coefficients || measure == BCCSPLAT_MEASURE_ALL) && o.dims[3] == 0)
    fail(Code::invalid_argument,
         "writer: a bound, measuring, or coefficients need the number of frames in dims[3]");
  // Refuses impossible sizes before anything is written.
  initial.lattice = Lattice4::fit(
      fit_options.lattice, {o.dims[0], o.dims[1], o.dims[2], std::max(o.dims[3], 1u)}, scale, time_scale);
  if (o.lattice == BCCSPLAT_LATTICE_BCC && o.dims[3] != 1)
    fail(Code::invalid_argument, "writer: lattice BCC holds one frame; set dims[3] to 1 or choose D4STAR");
  initial.scale = scale, initial.time_scale = time_scale;
  initial.affine = read_affine(o.affine);
  initial.spatial_unit = text_or(o.spatial_unit, "");
  initial.time.unit = text_or(o.time_unit, "");
  if (o.recommended_kernel && *o.recommended_kernel)
    initial.recommended_kernel = make_kernel(o.recommended_kernel).name;
  else if (bounded || coefficients) // which must not depend on what a reader takes for the default
    initial.recommended_kernel = make_kernel("").name;
  if (coefficients) {
    const Kernel kernel = make_kernel(initial.recommended_kernel);
    initial.coefficient_parameters = kernel_parameters(kernel);
    initial.coefficient_kernel = kernel.name;
  }

  const uint32_t count = std::max(o.channel_count, 1u);
  if (o.channel_count > 0) require(o.channels, "channels");
  if (count > 1024) fail(Code::invalid_argument, "writer: ", count, " channels; at most 1024");
  for (uint32_t c = 0; c < count; ++c) {
    const auto in =
        read_struct(o.channel_count > 0 ? element(o.channels, c) : nullptr, "bccsplat_channel_options");
    ChannelInfo info;
    info.name = text_or(in.name, "value");
    info.unit = text_or(in.unit, "");
    if (info.name.empty()) fail(Code::invalid_argument, "channel ", c, ": the name is empty");
    for (const ChannelInfo& other : initial.channels)
      if (other.name == info.name) fail(Code::invalid_argument, "two channels are named ", info.name);
    if (in.set_mask & ~3u) fail(Code::invalid_argument, "channel ", info.name, ": unknown bits in set_mask");
    if (in.source_type < 0 || in.source_type > 9)
      fail(Code::invalid_argument, "channel ", info.name, ": source_type ", in.source_type);
    if (in.value_type < 0 || in.value_type > 4)
      fail(Code::invalid_argument, "channel ", info.name, ": value_type must be U8, U16, F16 or F32");
    if (!(in.air_threshold >= 0 && std::isfinite(in.air_threshold)) || !std::isfinite(in.air))
      fail(Code::invalid_argument, "channel ", info.name,
           ": air and air_threshold must be finite, the threshold >= 0");
    if ((in.set_mask & BCCSPLAT_CHANNEL_SET_RANGE) &&
        !(in.range[0] < in.range[1] && std::isfinite(in.range[0]) && std::isfinite(in.range[1])))
      fail(Code::invalid_argument, "channel ", info.name, ": range must be finite and rise");
    info.air = in.set_mask & BCCSPLAT_CHANNEL_SET_AIR ? static_cast<float>(in.air) : 0;
    info.threshold = static_cast<float>(in.air_threshold);
    initial.channels.push_back(std::move(info));
    channels.push_back(in);
  }
  added.assign(count, 0);
  if (o.part && partial != BCCSPLAT_PARTIAL_APPEND) begin_part(read_struct(o.part, "bccsplat_series_part"));
}

void bccsplat_writer::check_channel(uint32_t channel) const {
  if (channel >= channels.size())
    fail(Code::not_found, "channel ", channel, " of a writer with ", channels.size());
}

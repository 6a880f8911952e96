// SPDX-License-Identifier: Apache-2.0
// Takes the old file through slab by slab: layers are read as samples or as what is stored, cropped, rounded
// or prefiltered as the new file asks, and written. Masks are copied; levels are dropped, as there are no
// frames to make them of.
#include "store/recode.h"

#include <algorithm>

#include "field/coefficients/sampled_field.h"
#include "fit/coefficients/round_layer.h"
#include "formats/bcc4/labels_attribute.h"
#include "formats/bcc4/metadata.h"
#include "kernel/cc_kernel.h"
#include "points/crop.h"
#include "store/channel_info.h"
#include "store/coefficient_slabs.h"

namespace bccsplat {
namespace {

bool stores_coefficients(const VolumeInfo& info, const RecodeSettings& settings) {
  return settings.coefficients.value_or(!info.coefficient_kernel.empty());
}

// Returns whether the new file stores the same numbers of a channel in the same slabs.
bool keeps_numbers(const VolumeInfo& was, const VolumeInfo& now, size_t channel) {
  return was.lattice == now.lattice && was.coefficient_kernel == now.coefficient_kernel &&
         was.slab_layers == now.slab_layers && was.tile_edge == now.tile_edge &&
         static_cast<const Quantiser&>(was.channels[channel]) ==
             static_cast<const Quantiser&>(now.channels[channel]);
}

// Throws unsupported where a channel of labels would get codes that are not its numbers, or be blended.
void require_labels_kept(const VolumeInfo& was, const ChannelInfo& made, bool coefficients) {
  const auto old = std::find_if(was.channels.begin(), was.channels.end(),
                                [&](const ChannelInfo& c) { return c.name == made.name; });
  const bool same = made.scale == old->scale && made.offset == old->offset;
  if (!said_labels(was, made.name).value_or(false)) return;
  if (coefficients && was.coefficient_kernel.empty())
    fail(Code::unsupported, "channel ", made.name, ": it has labels, and coefficients blend them");
  if (made.type == ValueType::f32 || made.type == ValueType::i32) return;
  if (made.type == ValueType::f16 ? old->type == ValueType::f16 : same) return;
  fail(Code::unsupported, "channel ", made.name,
       ": it has labels, and such codes are near to them at most; leave their type as it is");
}

VolumeInfo recoded_info(const VolumeInfo& was, const RecodeSettings& settings) {
  VolumeInfo info = was;
  // Readers of earlier versions take mirror images at the faces.
  if (settings.format == 1 || settings.format == 2) info.lattice = was.lattice.without_margins();
  const bool coefficients = stores_coefficients(was, settings);
  const std::string& own = was.coefficient_kernel.empty() ? was.recommended_kernel : was.coefficient_kernel;
  if (!settings.kernel.empty()) info.recommended_kernel = make_kernel(settings.kernel).name;
  info.coefficient_kernel.clear(), info.coefficient_parameters.clear();
  if (coefficients) {
    const Kernel kernel = make_kernel(settings.kernel.empty() ? own : settings.kernel);
    info.coefficient_kernel = info.recommended_kernel = kernel.name;
    info.coefficient_parameters = kernel_parameters(kernel);
  }
  info.slab_layers = slab_layers_for(coefficients), info.tile_edge = 1;
  info.errors.clear();
  info.levels.clear(); // made of frames, which are not there
  if (info.tail) info.tail->clamped.resize(info.channels.size());
  bool all_kept = true;
  for (size_t c = 0; c < info.channels.size(); ++c) {
    ChannelInfo& channel = info.channels[c];
    static_cast<Quantiser&>(channel) =
        code_channel_anew(was.channels[c], coefficients, settings.value_type, settings.value_step);
    require_labels_kept(was, channel, coefficients);
    channel.residuals = {}, channel.wavelet_error = 0, channel.linear = false;
    const bool kept = keeps_numbers(was, info, c);
    if (!kept) channel.clamped = 0;
    all_kept &= kept;
  }
  // What a writer that goes on is told is true of the same slabs of the same numbers only.
  if (!all_kept) info.tail.reset(), info.counts.reset();
  return info;
}

// The layers of the old file, as samples or as coefficients of the new kernel.
class Layers {
 public:
  Layers(const Bcc4Samples& stored, const VolumeInfo& made) {
    const VolumeInfo& was = stored.reader().info();
    if (!(was.lattice == made.lattice)) cropped_ = made.lattice.space, first_ = was.lattice.first_inside();
    // Coefficients are those of samples that go on differently.
    kept_ =
        was.coefficient_kernel == made.coefficient_kernel && (!cropped_ || was.coefficient_kernel.empty());
    from_ = &stored;
    if (kept_ || was.coefficient_kernel.empty()) return;
    const Kernel kernel = was.lattice.space.bcc ? make_kernel(was.coefficient_kernel)
                                                : make_cc_kernel(was.coefficient_kernel).kernel;
    for (const ChannelInfo& channel : was.channels)
      fields_.push_back(std::make_unique<const SampledField>(stored, kernel, channel.threshold / 2));
  }
  // Returns whether what comes is stored as it is, but for its precision.
  [[nodiscard]] bool kept() const { return kept_; }
  [[nodiscard]] BrickLayer read(int channel, int32_t layer, const Context& context) const {
    const SampleSource& source = fields_.empty() ? *from_ : *fields_[channel];
    BrickLayer read = source.read_layer(channel, layer, {}, context);
    return cropped_ ? crop_layer(read, *cropped_, first_) : read;
  }

 private:
  bool kept_ = false;
  std::optional<Lattice3> cropped_; // without planes outside; none: all is kept
  Int3 first_{};                    // site inside
  const SampleSource* from_ = nullptr;
  std::vector<std::unique_ptr<const SampledField>> fields_;
};

// Returns what is stored of layers that stay samples, become samples, or stay coefficients.
std::vector<SampleLayer> rounded(std::vector<BrickLayer> slab, int32_t first, const VolumeInfo& info,
                                 int channel, const VolumeInfo& was, uint64_t& clamped,
                                 const Context& context) {
  const size_t c = channel;
  const ChannelInfo& to = info.channels[c];
  const bool kept = info.coefficient_kernel == was.coefficient_kernel;
  if (kept && static_cast<const Quantiser&>(to) == static_cast<const Quantiser&>(was.channels[c]))
    return {slab.begin(), slab.end()};
  if (to.type == ValueType::i32)
    return CoefficientSteps(info.lattice, to, info.coefficient_kernel).round(first, slab, context);
  for (BrickLayer& layer : slab) layer = round_layer(layer, to, kept ? 0 : to.threshold, clamped, context);
  return {slab.begin(), slab.end()};
}

bool has_masks(const VolumeInfo& info) {
  return std::any_of(info.channels.begin(), info.channels.end(),
                     [](const ChannelInfo& c) { return !c.masks.empty(); });
}

void copy_masks(const Bcc4Reader& from, Bcc4Writer& to) {
  const auto& channels = from.info().channels;
  for (uint32_t f = 0; f < from.info().lattice.dims[3]; ++f)
    for (size_t c = 0; c < channels.size(); ++c) to.copy_mask(static_cast<int>(c), f, from);
}

} // namespace

WriteReport recode(const Bcc4Samples& samples, const RecodeSettings& settings, const Context& context) {
  return recode(
      samples, settings, [&] { return create_file_sink(settings.path, settings.overwrite); }, context);
}

WriteReport recode(const Bcc4Samples& samples, const RecodeSettings& settings,
                   const std::function<std::unique_ptr<ByteSink>()>& make_sink, const Context& context) {
  const VolumeInfo& was = samples.reader().info();
  if (was.part) fail(Code::unsupported, "recode: the file is a part of a series; join its parts first");
  const VolumeInfo info = recoded_info(was, settings);
  if (const uint16_t lowest = lowest_reader(info); settings.format != 0 && lowest > settings.format)
    fail(Code::unsupported, "recode: what is asked for needs version ", lowest, " of the format, ",
         lowest == 2                         ? "as there are layers before the first frame"
         : info.lattice.periodic             ? "as the series is periodic"
         : info.lattice.space.any_periodic() ? "as an axis is periodic"
         : has_masks(info)                   ? "as masks say which source samples are missing"
                           : "as coefficients are whole steps; store samples, or coefficients as floats");
  const Layers layers(samples, info);
  Bcc4Writer writer(make_sink(), info);
  copy_masks(samples.reader(), writer);
  std::optional<CoefficientSlabs> slabs;
  if (!info.coefficient_kernel.empty() && !layers.kept()) slabs.emplace(info.lattice, info, nullptr);
  const auto store = [&](int32_t number, int of, const SlabLayers& made) {
    writer.write_slab(number, of, made.compact(), context);
  };
  const int32_t all = info.lattice.layers();
  std::vector<uint64_t> clamped(info.channels.size());
  for (int32_t first = 0; first < all; first += info.slab_layers)
    for (int c = 0; c < static_cast<int>(info.channels.size()); ++c) {
      std::vector<BrickLayer> slab;
      for (int32_t m = first; m < std::min(first + info.slab_layers, all); ++m) {
        slab.push_back(layers.read(c, m, context));
      }
      if (slabs)
        slabs->add_layers(c, first, slab, context, store);
      else
        store(first / info.slab_layers, c,
              rounded(std::move(slab), first, info, c, was, clamped[c], context));
      context.progress.report(0.99 * (first + 1) / all);
      context.progress.check();
    }
  for (int c = 0; slabs && c < static_cast<int>(info.channels.size()); ++c)
    slabs->store_ready(c, context, store);
  WriteReport report;
  report.frames = info.lattice.dims[3];
  for (size_t c = 0; c < clamped.size(); ++c) writer.info().channels[c].clamped += clamped[c];
  const Bcc4Report written = writer.finish(context);
  report.cc_samples = info.cc_samples() * info.channels.size();
  for (const ChannelInfo& channel : info.channels) report.cc_relevant += channel.cc_relevant;
  report.sites_total = written.sites_total, report.sites_kept = written.sites_kept;
  report.take_outside(info.lattice, 0, info.lattice.layers(), info.channels.size());
  report.holes = written.holes, report.clamped = 0;
  for (const ChannelInfo& channel : writer.info().channels) report.clamped += channel.clamped;
  report.set_file(written);
  return report;
}

} // namespace bccsplat

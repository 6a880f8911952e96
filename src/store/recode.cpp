#include "store/recode.h"

#include <algorithm>

#include "field/coefficients/sampled_field.h"
#include "fit/round_layer.h"
#include "formats/bcc4/metadata.h"
#include "kernel/cc_kernel.h"
#include "store/channel_info.h"
#include "store/coefficient_slabs.h"

namespace bccsplat {
namespace {

bool stores_coefficients(const VolumeInfo& info, const RecodeSettings& settings) {
  return settings.coefficients.value_or(!info.coefficient_kernel.empty());
}

VolumeInfo recoded_info(const VolumeInfo& was, const RecodeSettings& settings) {
  VolumeInfo info = was;
  const bool coefficients = stores_coefficients(was, settings);
  const std::string& own = was.coefficient_kernel.empty() ? was.recommended_kernel : was.coefficient_kernel;
  if (!settings.kernel.empty()) info.recommended_kernel = make_kernel(settings.kernel).name;
  info.coefficient_kernel.clear(), info.coefficient_parameters.clear();
  if (coefficients) {
    const Kernel kernel = make_kernel(settings.kernel.empty() ? own : settings.kernel);
    info.coefficient_kernel = info.recommended_kernel = kernel.name;
    info.coefficient_parameters = kernel_parameters(kernel);
  }
  info.slab_layers = slab_layers_for(coefficients);
  info.tail.reset();
  for (size_t c = 0; c < info.channels.size(); ++c) {
    ChannelInfo& channel = info.channels[c];
    static_cast<Quantiser&>(channel) =
        code_channel_anew(was.channels[c], coefficients, settings.value_type, settings.value_step);
    channel.residuals = {};
    channel.clamped = 0;
  }
  return info;
}

// The layers of the old file, as samples or as coefficients of the new kernel.
class Layers {
 public:
  Layers(const Bcc4Samples& stored, const VolumeInfo& made) {
    const VolumeInfo& was = stored.reader().info();
    kept_ = was.coefficient_kernel == made.coefficient_kernel;
    from_ = &stored;
    if (kept_ || was.coefficient_kernel.empty()) return;
    const Kernel kernel = was.lattice.space.bcc ? make_kernel(was.coefficient_kernel)
                                                : make_cc_kernel(was.coefficient_kernel).kernel;
    for (const ChannelInfo& channel : was.channels)
      fields_.push_back(std::make_unique<const SampledField>(stored, kernel, channel.threshold / 2));
  }
  // Whether what comes is stored as it is, but for its precision.
  [[nodiscard]] bool kept() const { return kept_; }
  [[nodiscard]] BrickLayer read(int channel, int32_t layer, const Context& context) const {
    const SampleSource& source = fields_.empty() ? *from_ : *fields_[static_cast<size_t>(channel)];
    return source.read_layer(channel, layer, {}, context);
  }

 private:
  bool kept_ = false;
  const SampleSource* from_ = nullptr;
  std::vector<std::unique_ptr<const SampledField>> fields_;
};

// What is stored of layers that stay samples, become samples, or stay coefficients.
std::vector<BrickLayer> rounded(std::vector<BrickLayer> slab, int32_t first, const VolumeInfo& info,
                                int channel, const VolumeInfo& was, const Context& context) {
  const auto c = static_cast<size_t>(channel);
  const ChannelInfo& to = info.channels[c];
  const bool kept = info.coefficient_kernel == was.coefficient_kernel;
  if (kept && static_cast<const Quantiser&>(to) == static_cast<const Quantiser&>(was.channels[c]))
    return slab;
  if (to.type == ValueType::i32)
    return CoefficientSteps(info.lattice, to, info.coefficient_kernel).round(first, slab, context);
  for (BrickLayer& layer : slab) layer = round_layer(layer, to, kept ? 0 : to.threshold, context);
  return slab;
}

} // namespace

WriteReport recode(const Bcc4Samples& samples, const RecodeSettings& settings, const Context& context) {
  const VolumeInfo& was = samples.reader().info();
  if (was.part) fail(Code::unsupported, "recode: the file is a part of a series; join its parts first");
  const VolumeInfo info = recoded_info(was, settings);
  if (settings.format != 0 && lowest_reader(info) > settings.format)
    fail(Code::unsupported, "recode: what is asked for needs version ", lowest_reader(info),
         " of the format; store samples, or coefficients as floats, for version ", settings.format);
  const Layers layers(samples, info);
  Bcc4Writer writer(create_file_sink(settings.path, settings.overwrite), info);
  std::optional<CoefficientSlabs> slabs;
  if (!info.coefficient_kernel.empty() && !layers.kept()) slabs.emplace(info.lattice, info, nullptr);
  const int32_t all = info.lattice.layers();
  for (int32_t first = 0; first < all; first += info.slab_layers)
    for (int c = 0; c < static_cast<int>(info.channels.size()); ++c) {
      std::vector<BrickLayer> slab;
      for (int32_t m = first; m < std::min(first + info.slab_layers, all); ++m) {
        slab.push_back(layers.read(c, m, context));
      }
      if (!slabs) slab = rounded(std::move(slab), first, info, c, was, context);
      const auto store = [&](int32_t number, int of, std::span<const BrickLayer> made) {
        writer.write_slab(number, of, made, context);
      };
      if (slabs)
        slabs->add_layers(c, slab, context, store);
      else
        store(first / info.slab_layers, c, slab);
      context.progress.report(0.99 * (first + 1) / all);
      context.progress.check();
    }
  WriteReport report;
  report.frames = info.lattice.dims[3];
  const Bcc4Report written = writer.finish(context);
  report.cc_samples = info.cc_samples() * info.channels.size();
  for (const ChannelInfo& channel : info.channels) report.cc_relevant += channel.cc_relevant;
  report.sites_total = written.sites_total, report.sites_kept = written.sites_kept;
  report.holes = written.holes, report.clamped = written.clamped;
  report.set_file(writer.info(), written);
  return report;
}

} // namespace bccsplat

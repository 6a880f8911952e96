#include "store/continuation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "formats/bcc4/coding/codes.h"
#include "store/part_report.h"
#include "store/series_part.h"

namespace bccsplat {
namespace {

constexpr size_t batch_chunks = 64; // decoded together: at most 8 MiB of samples

// Counts the samples of the slabs 0 .. end - 1 as the fit did.
LayerCounts count_slabs(const Bcc4Reader& file, int channel, int32_t end, const Context& context) {
  const ChannelInfo& info = file.info().channels[static_cast<size_t>(channel)];
  // Single sites of air may be kept among others; they are not counted as samples.
  const SampleCoder coder(info);
  const float air = coder.decode(coder.codes().air);
  const bool air_is_none = !(info.threshold > 0 && std::fabs(air) > info.threshold);
  LayerCounts report;
  report.samples = SampleHistogram(info);
  const Lattice4& lattice = file.info().lattice;
  for (int32_t layer = 0; layer < end * file.info().slab_layers; ++layer)
    report.sites_total += static_cast<uint64_t>(lattice.space.sites(lattice.coset(layer)));
  auto counted = std::make_unique<Brick>();
  const auto count = [&](const Brick& brick) {
    counted->value = brick.value, counted->kept = brick.kept;
    counted->hole = brick.hole ? std::make_unique<BrickMask>(*brick.hole) : nullptr;
    for (size_t site = 0; site < brick_sites; ++site)
      if (counted->value[site] == air && air_is_none && !counted->is_hole(static_cast<int>(site)))
        counted->kept[site / 16] = static_cast<uint16_t>(counted->kept[site / 16] & ~(1u << (site % 16)));
    report.samples.add(*counted);
    report.sites_kept += static_cast<uint64_t>(counted->count());
    if (counted->hole)
      for (const uint16_t row : *counted->hole) report.holes += static_cast<uint64_t>(std::popcount(row));
  };
  for (int32_t slab = 0; slab < end; ++slab) {
    const std::vector<Bcc4Chunk> chunks = file.chunks(channel, slab);
    for (size_t first = 0; first < chunks.size(); first += batch_chunks) {
      const auto batch = std::span(chunks).subspan(first, std::min(batch_chunks, chunks.size() - first));
      for (const auto& chunk : file.read_chunks(channel, batch, context))
        for (int layer = 0; layer < file.info().slab_layers; ++layer)
          if (const auto brick = file.brick(channel, *chunk, layer)) count(*brick);
      context.progress.check();
    }
  }
  return report;
}

// What the file tells of the samples that its first `slabs` slabs of coefficients were made of; none where it
// does not, or in words of another version.
std::optional<std::vector<LayerCounts>> told_counts(const VolumeInfo& info, int32_t slabs) {
  if (!info.counts || info.counts->slabs != slabs) return std::nullopt;
  try {
    std::vector<LayerCounts> counts;
    for (PartChannelReport& c : read_part_report(info.counts->counts, info.channels.size()).channels)
      counts.push_back(std::move(c.fit.lasting));
    return counts;
  } catch (const Error&) {
    return std::nullopt;
  }
}

// Throws unless the file says the same times of its frames as the series that goes on.
void require_equal_times(const std::string& path, const VolumeInfo& was, std::span<const double> times) {
  const double step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  for (uint32_t f = 0; f < was.lattice.dims[3]; ++f)
    if (!(std::fabs(was.time.at(f) - times[f]) <= 1e-6 * step))
      fail(Code::wrong_state, path, ": its frame ", f, " is at time ", was.time.at(f),
           ", that of the series at ", times[f]);
}

} // namespace

void require_continuable(const VolumeInfo& was, const VolumeInfo& now, uint32_t frames,
                         const std::string& path) {
  if (was.part) fail(Code::wrong_state, path, ": a part of a series; join all parts first");
  const Lattice4 &a = was.lattice, &b = now.lattice;
  const auto differs = [&](const char* what) {
    fail(Code::wrong_state, path, ": ", what,
         " of its series and of the one to be appended differ; import all anew");
  };
  if (a.kind != b.kind || !(a.space == b.space) || a.time_step != b.time_step || a.lead != b.lead ||
      a.is_static() || !std::equal(a.dims.begin(), a.dims.begin() + 3, b.dims.begin()) ||
      was.slab_layers != now.slab_layers)
    differs("the lattices");
  if (frames > 0 && a.dims[3] > b.dims[3]) differs("the numbers of frames");
  if (was.coefficient_kernel != now.coefficient_kernel) differs("the kernels of coefficients");
  if (was.channels.size() != now.channels.size()) differs("the channels");
  for (size_t c = 0; c < was.channels.size(); ++c) {
    const ChannelInfo &x = was.channels[c], &y = now.channels[c];
    if (x.name != y.name || x.type != y.type || x.scale != y.scale || x.offset != y.offset ||
        x.air != y.air || x.threshold != y.threshold)
      differs("the channels");
  }
}

Continuation::Continuation(const WriterSettings& settings, FitOptions options, const LayerUse& use)
    : old_(Bcc4Reader::open(open_file_source(settings.path))) {
  const VolumeInfo& was = old_->info();
  const PartSettings& part = *settings.part;
  const auto refuse = [&](const auto&... why) {
    fail(Code::wrong_state, settings.path, ": ", why..., "; give all frames, without a part");
  };
  const uint32_t done = was.lattice.dims[3];
  if (part.first != done || part.end != settings.dims[3] || part.end < done)
    fail(Code::invalid_argument, settings.path, ": it has ", done, " frames, and the series ",
         settings.dims[3], ": the part to be appended is ", done, " to ", settings.dims[3],
         " (excluded), not ", part.first, " to ", part.end);
  if (was.lattice.is_static()) refuse("a single frame is not continued");
  if (settings.abs_error > 0 || settings.psnr > 0 || settings.measure == Measure::all)
    refuse("a bound is checked on every frame");
  for (const ChannelInfo& channel : was.channels)
    if (channel.frames.size() != done)
      refuse("it was made of layers");
    else if (channel.residuals != ResidualInfo{})
      refuse("its frames are held to a bound by corrections");
  require_rising(part.times);
  require_equal_times(settings.path, was, part.times);
  options.lead = was.lattice.lead;
  lattice_ = Lattice4::fit(options.lattice, options.dims, options.scales, options.lead);
  rest_ = rest_of_series(lattice_, options, use, done);
  for (const ChannelInfo& channel : was.channels)
    if (was.coefficient_kernel.empty() && channel.clamped > 0 && !(was.tail && was.tail->slabs == slabs()))
      refuse("it does not tell where samples were clamped, as newer files do");
  if (!was.coefficient_kernel.empty() && slabs() > 0 && !(told_ = told_counts(was, slabs())))
    refuse("it does not tell of the samples that its coefficients were made of, as files of this version do");
  begin_earlier(part.early_frames, rest_.fit);
}

void Continuation::copy_slabs(Bcc4Writer& container, Progress& progress) const {
  struct Slab {
    uint64_t offset;
    int32_t slab;
    int channel;
  };
  std::vector<Slab> order;
  for (int32_t slab = 0; slab < slabs(); ++slab)
    for (int c = 0; c < static_cast<int>(info().channels.size()); ++c)
      if (const auto chunks = old_->chunks(c, slab); !chunks.empty())
        order.push_back({chunks.front().offset, slab, c});
  std::sort(order.begin(), order.end(), [](const Slab& a, const Slab& b) { return a.offset < b.offset; });
  for (const Slab& s : order) {
    container.copy_slab(s.slab, s.channel, *old_);
    progress.check();
  }
}

std::vector<LayerCounts> Continuation::old_counts(const Context& context) const {
  const VolumeInfo& was = info();
  if (told_) return *told_;
  std::vector<LayerCounts> counts;
  for (size_t c = 0; c < was.channels.size(); ++c) {
    counts.push_back(count_slabs(*old_, static_cast<int>(c), slabs(), context));
    if (slabs() > 0 && was.tail) counts.back().clamped = was.tail->clamped[c];
  }
  return counts;
}

void Continuation::add_to(FitReport& report, const Context& context) const {
  const VolumeInfo& was = info();
  PartReport all, rest;
  const std::vector<LayerCounts> counts = old_counts(context);
  for (size_t c = 0; c < was.channels.size(); ++c) {
    const ChannelInfo& channel = was.channels[c];
    FitChannelReport old;
    static_cast<LayerCounts&>(old) = old.lasting = counts[c];
    old.source_range = channel.source_range;
    const bool only_holes = channel.holes > 0 && channel.holes == channel.sites_kept;
    old.any_finite = !(only_holes && channel.source_range == Range{});
    old.frames = channel.frames;
    old.source_samples = was.cc_samples();
    old.cc_relevant = channel.cc_relevant;
    old.clamped_slabs.assign(static_cast<size_t>(slabs()), 0);
    if (slabs() > 0) old.clamped_slabs[0] = old.clamped;
    all.channels.push_back({old, 0, {}, {}});
    rest.channels.push_back({std::move(report.channels[c]), 0, {}, {}});
  }
  add_part_report(all, std::move(rest));
  for (size_t c = 0; c < was.channels.size(); ++c) report.channels[c] = std::move(all.channels[c].fit);
}

} // namespace bccsplat

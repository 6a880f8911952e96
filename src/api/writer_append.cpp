// A finished file whose series goes on. Either all frames come again and the slabs that more of them leave as
// they are need not be coded; or only the frames come that the other slabs hang on, and what is said about
// the series is put together from the old file and the new frames.
#include <algorithm>
#include <bit>
#include <cmath>

#include "api/writer.h"
#include "formats/bcc4/coding/codes.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

constexpr size_t batch_chunks = 64; // decoded together: at most 8 MiB of samples

// Samples of the slabs 0 .. end-1 as the fit counted them.
FitChannelReport count_slabs(const Bcc4Reader& file, int channel, int32_t end, const Context& context) {
  const ChannelInfo& info = file.info().channels[static_cast<size_t>(channel)];
  const Quantiser quantiser{info.type, info.scale, info.offset, info.air};
  // Single sites of air among others may be kept: no samples.
  const SampleCoder coder(info);
  const float air = coder.decode(coder.codes().air);
  const bool air_is_none = !(info.threshold > 0 && std::fabs(air) > info.threshold);
  FitChannelReport report;
  report.samples = SampleHistogram(quantiser);
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

} // namespace

// Throws wrong_state unless new frames can stand behind those of a file.
void bccsplat_writer::check_continues(const VolumeInfo& was) const {
  if (was.part) fail(Code::wrong_state, path, ": a part of a series; join all parts first");
  const Lattice4 &a = was.lattice, &b = initial.lattice;
  const auto differs = [&](const char* what) {
    fail(Code::wrong_state, path, ": ", what,
         " of its series and of the one to be appended differ; import all anew");
  };
  if (a.kind != b.kind || !(a.space == b.space) || a.time_step != b.time_step || a.lead != b.lead ||
      a.is_static() || !std::equal(a.dims.begin(), a.dims.begin() + 3, b.dims.begin()) ||
      was.slab_layers != initial.slab_layers)
    differs("the lattices");
  if (fit_options.dims[3] > 0 && a.dims[3] > b.dims[3]) differs("the numbers of frames");
  if (was.coefficient_kernel != initial.coefficient_kernel) differs("the kernels of coefficients");
  if (was.channels.size() != initial.channels.size()) differs("the channels");
  for (size_t c = 0; c < was.channels.size(); ++c) {
    const ChannelInfo &x = was.channels[c], &y = initial.channels[c];
    if (x.name != y.name || x.type != y.type || x.scale != y.scale || x.offset != y.offset ||
        x.air != y.air || x.threshold != y.threshold)
      differs("the channels");
  }
}

// The slabs of the old file that new frames behind its last one do not touch, when all frames come again.
Bcc4WriterOptions bccsplat_writer::appended() const {
  Bcc4WriterOptions o;
  o.earlier = Bcc4Reader::open(open_file_source(path));
  const VolumeInfo& was = o.earlier->info();
  check_continues(was);
  // Coefficients hang on samples beyond the reach of the filter.
  if (!coefficients) o.earlier_slabs = lasting_slabs(was.lattice, fit_options, was.lattice.dims[3]);
  return o;
}

// Frames o.first .. o.end-1 are added to a file of those before; nothing else but what their layers hang on
// is asked for.
void bccsplat_writer::begin_continued(const bccsplat_series_part& o) {
  Continued c;
  c.old = Bcc4Reader::open(open_file_source(path));
  const VolumeInfo& was = c.old->info();
  const auto refuse = [&](const auto&... why) {
    fail(Code::wrong_state, path, ": ", why..., "; give all frames, without a part");
  };
  const uint32_t done = was.lattice.dims[3];
  if (o.first != done || o.end != fit_options.dims[3])
    fail(Code::invalid_argument, path, ": it has ", done, " frames, and the series ", fit_options.dims[3],
         ": the part to be appended is ", done, " to ", fit_options.dims[3], " (excluded), not ", o.first,
         " to ", o.end);
  if (was.lattice.is_static()) refuse("a single frame is not continued");
  if (coefficients || !was.coefficient_kernel.empty()) refuse("coefficients hang on frames further back");
  if (abs_error > 0 || psnr > 0 || measure == BCCSPLAT_MEASURE_ALL)
    refuse("a bound is checked on every frame");
  for (const ChannelInfo& channel : was.channels)
    if (channel.frames.size() != done)
      refuse("it was made of layers");
    else if (channel.residuals != ResidualInfo{})
      refuse("its frames are held to a bound by corrections");
  read_times(o);
  const double step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  for (uint32_t f = 0; f < done; ++f)
    if (!(std::fabs(was.time.at(f) - times[f]) <= 1e-6 * step))
      fail(Code::wrong_state, path, ": its frame ", f, " is at time ", was.time.at(f),
           ", that of the series at ", times[f]);
  fit_options.lead = was.lattice.lead;
  initial.lattice = Lattice4::fit(fit_options.lattice, fit_options.dims, fit_options.scale,
                                  fit_options.time_scale, fit_options.lead);
  FitPart rest = rest_of_series(initial.lattice, fit_options, done);
  c.slabs = rest.first_layer / fit_options.slab_layers;
  for (const ChannelInfo& channel : was.channels)
    if (channel.clamped > 0 && !(was.tail && was.tail->slabs == c.slabs))
      refuse("it does not tell where samples were clamped, as newer files do");
  if (o.lead > rest.first_given)
    fail(Code::invalid_argument, "part.lead ", o.lead, ": only ", rest.first_given,
         " frames come before the first one needed");
  rest.first_given -= static_cast<uint32_t>(o.lead);
  fit_options.part = rest;
  added.assign(channels.size(), rest.first_given);
  continued = std::move(c);
}

// Puts the slabs that stay where a writer of all frames puts them: in the order of the old file.
void bccsplat_writer::copy_continued() {
  struct Slab {
    uint64_t offset;
    int32_t slab;
    int channel;
  };
  std::vector<Slab> order;
  for (int32_t slab = 0; slab < continued->slabs; ++slab)
    for (int c = 0; c < static_cast<int>(channels.size()); ++c)
      if (const auto chunks = continued->old->chunks(c, slab); !chunks.empty())
        order.push_back({chunks.front().offset, slab, c});
  std::sort(order.begin(), order.end(), [](const Slab& a, const Slab& b) { return a.offset < b.offset; });
  for (const Slab& s : order) {
    container->copy_slab(s.slab, s.channel, *continued->old);
    progress.check();
  }
}

// Adds what the old file tells of its frames and of the slabs that were copied.
void bccsplat_writer::add_continued(FitReport& result) {
  const VolumeInfo& was = continued->old->info();
  PartReport all, rest;
  for (size_t c = 0; c < was.channels.size(); ++c) {
    const ChannelInfo& info = was.channels[c];
    FitChannelReport old = count_slabs(*continued->old, static_cast<int>(c), continued->slabs, *context);
    old.source_range = info.source_range;
    const bool only_holes = info.holes > 0 && info.holes == info.sites_kept;
    old.any_finite = !(only_holes && info.source_range == Range{});
    old.frames = info.frames;
    old.source_samples = was.cc_samples();
    old.cc_relevant = info.cc_relevant;
    old.clamped_slabs.assign(static_cast<size_t>(continued->slabs), 0);
    if (continued->slabs > 0 && was.tail) old.clamped_slabs[0] = old.clamped = was.tail->clamped[c];
    all.channels.push_back({old, 0, {}, {}});
    rest.channels.push_back({std::move(result.channels[c]), 0, {}, {}});
  }
  add_part_report(all, std::move(rest));
  for (size_t c = 0; c < was.channels.size(); ++c) result.channels[c] = std::move(all.channels[c].fit);
}

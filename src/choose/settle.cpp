// SPDX-License-Identifier: Apache-2.0
// Decides what was left open: scans and samples the series, chooses its lattice and steps, or searches for a
// bound, and has labels kept whole.
#include "choose/settle.h"

#include <algorithm>
#include <cmath>

#include "choose/finer.h"
#include "choose/labels.h"
#include "choose/level_choice.h"
#include "choose/motion.h"
#include "choose/sample.h"
#include "choose/wavelet_memory.h"
#include "choose/wavelet_share.h"
#include "series/read_series.h"
#include "series/text.h"

namespace bccsplat::series {
namespace {

std::vector<double> air_of_channels(const SeriesDescription& s, const WriterSettings& settings) {
  std::vector<double> air;
  for (const Channel& c : s.channels) air.push_back(air_of(c, settings));
  return air;
}

bool need_ranges(const SeriesDescription& s, const WriterSettings& settings) {
  return std::any_of(s.channels.begin(), s.channels.end(),
                     [&](const Channel& c) { return needs_range(c, settings); });
}

bool any_labels(const std::vector<bool>& labels) {
  return std::find(labels.begin(), labels.end(), true) != labels.end();
}

// The peak of a PSNR, in root mean square errors.
double errors_in_peak(double psnr) { return std::pow(10.0, psnr / 20); }

std::vector<ChannelScan> scan_series(FrameReader& reader, const WriterSettings& settings, Watch* progress) {
  const SeriesDescription& s = reader.description();
  const std::vector<double> air = air_of_channels(s, settings);
  std::vector<ChannelScan> scans(s.channels.size());
  for (uint64_t f = 0; f < s.dims[3] && !reader.frames_fit(); ++f)
    for (uint32_t c = 0; c < scans.size(); ++c) {
      progress->go_on();
      progress->show(
          {"scan", f * scans.size() + c, s.dims[3] * scans.size(), concat("frame ", f + 1, "/", s.dims[3])});
      scan_large_frame(reader, f, c, air[c], settings.air_threshold, scans[c]);
    }
  if (!reader.frames_fit()) return scans;
  read_series(reader, {0, s.dims[3]}, "scan", *progress, [&](uint64_t f, uint32_t c, const Frame& values) {
    scan_frame(values, f, s.dims, air[c], settings.air_threshold, scans[c]);
  });
  return scans;
}

// Does the choice of steps make sense for these settings?
bool rounds(const Unsettled& unsettled, const WriterSettings& settings, const SeriesDescription& s) {
  return !unsettled.exact && s.dims[3] > 1 && settings.quantize == BCCSPLAT_TYPE_DEFAULT &&
         settings.steps.empty();
}

// What blends labels makes up others: who asks for nothing gets their grid.
bool keeps_grid(const Unsettled& unsettled, const WriterSettings& settings, const std::vector<bool>& labels) {
  const bool all_labels = std::find(labels.begin(), labels.end(), false) == labels.end();
  return all_labels && unsettled.auto_lattice && unsettled.density == 0 && !settings.lowpass &&
         has_cartesian(settings.kernel);
}

LatticeShape source_grid(const WriterSettings& settings) {
  return {BCCSPLAT_LATTICE_CC, {1, 1, 1, 1}, settings.faces, settings.ends, settings.periodic};
}

LatticeWish wish_of(const Unsettled& unsettled, const WriterSettings& settings, const SeriesDescription& s,
                    std::vector<bool> labels) {
  LatticeWish wish;
  wish.labels = std::move(labels), wish.faces = settings.faces, wish.ends = settings.ends;
  wish.periodic = settings.periodic;
  if (keeps_grid(unsettled, settings, wish.labels)) wish.fixed = source_grid(settings);
  if (!unsettled.auto_lattice) wish.fixed = shape_of(settings, s);
  if (unsettled.density > 0) wish.density = unsettled.density;
  if (settings.lattice != BCCSPLAT_LATTICE_DEFAULT) {
    wish.lattices = {shape_of(settings, s).lattice};
    if (settings.lattice == BCCSPLAT_LATTICE_CC && unsettled.density == 0) wish.density = 1;
  } else if (settings.lowpass || !has_cartesian(settings.kernel)) {
    wish.lattices = {BCCSPLAT_LATTICE_D4STAR};
  }
  return wish;
}

void choose_and_round(Trier& trier, const SeriesSample& sample, const LatticeWish& wish, bool rounded,
                      WriterSettings& settings, ImportPlan& plan) {
  const SeriesDescription& s = plan.series;
  LatticeChoice choice = choose_lattice(trier, *plan.spectra, wish, s);
  choice.sampled_frames = sample.frames();
  choice.rounded = choice.chosen().trial.value();
  Coding coding = choice.rounded.coding;
  if (rounded && !is_source_grid(coding.shape)) {
    coding.steps = worthwhile_steps(choice.rounded, s, settings, sample.ranges, wish.labels);
    choice.rounded = trier.tried()[trier.try_coding(coding)];
  }
  settings = apply_coding(settings, coding);
  plan.choice = std::move(choice);
}

// What an import promises that was asked for nothing: in the mean and at the worst sample.
constexpr ErrorBound kUsual{.psnr = 50, .share = .02, .outside_air = true};

double range_of(const ChannelScan& scan) { return scan.empty() ? 0 : scan.max - scan.min; }

double range_with_air(const ChannelScan& scan, double air) {
  return scan.empty() ? 0 : std::max(scan.max, air) - std::min(scan.min, air);
}

// The largest error that a bound allows a channel, 0 for any.
double largest_error(const ErrorBound& bound, const ChannelScan& scan) {
  return bound.abs > 0 ? bound.abs : bound.share * range_of(scan);
}

// The root mean square error that a PSNR leaves to wavelets, over all samples: codes are rounded, too, and
// the missing ones, or air where it is not to count, have none. For a constant any will do.
double wavelet_error(const ErrorBound& bound, const ChannelScan& scan) {
  constexpr double kRounding = .995;
  const double range = range_of(scan);
  const uint64_t counted = (bound.outside_air ? scan.relevant : scan.samples) - scan.nonfinite;
  const double part = counted > 0 ? static_cast<double>(counted) / static_cast<double>(scan.samples) : 1;
  return (range > 0 ? range : 1) * kRounding * std::sqrt(part) / errors_in_peak(bound.psnr);
}

// Does an import ask for nothing that only samples on a lattice have?
bool leaves_store(const Unsettled& unsettled, const WriterSettings& settings, const SeriesDescription& s) {
  return unsettled.open_store && settings.store == BCCSPLAT_STORE_DEFAULT && unsettled.auto_lattice &&
         unsettled.density == 0 && !unsettled.exact && !settings.lowpass && !settings.fixed_predictions &&
         settings.air_threshold == 0 && settings.quantize == BCCSPLAT_TYPE_DEFAULT &&
         has_cartesian(settings.kernel) && !is_scattered(s);
}

// A slab of wavelets is held as a whole while it is written: is there room for that?
bool holds_slab(const Device& device, const Unsettled& unsettled, const SeriesDescription& s,
                const WriterSettings& settings) {
  auto info = sized<bccsplat_device_info>();
  check(bccsplat_device_get_info(device.get(), &info), "");
  return memory_of_wavelets(s, settings, unsettled.bound.abs) <=
         std::min<uint64_t>(info.memory_budget, unsettled.memory);
}

// Are codes of 16 bits fine enough for a bound, and is it coarse enough that wavelets take fewer bytes than
// samples? Where nearly every integer has to come back, these do (tests/bench/notes/coder.md).
bool suits_wavelets(const ErrorBound& bound, const Channel& channel, const ChannelScan& scan, double air) {
  constexpr double kSteps = 1.5, kMeanSteps = .2; // of integers
  constexpr double kShare = 1.0 / (1 << 14), kMeanShare = 1e-4;
  const double step = source_step(channel), range = range_of(scan), codes = range_with_air(scan, air);
  if (range == 0) return false;
  if (bound.abs > 0) return bound.abs >= std::max(kSteps * step, kShare * codes);
  return range / errors_in_peak(bound.psnr) >= std::max(kMeanSteps * step, kMeanShare * codes);
}

bool suits_wavelets(const ErrorBound& bound, const SeriesDescription& s, const WriterSettings& settings,
                    const std::vector<ChannelScan>& scans) {
  for (size_t c = 0; c < scans.size(); ++c)
    if (!suits_wavelets(bound, s.channels[c], scans[c], air_of(s.channels[c], settings))) return false;
  return true;
}

// Codes for channels that u8 and u16 do not hold as they are, so fine that rounding adds next to nothing.
std::vector<StepCoding> steps_of_codes(const SeriesDescription& s, const WriterSettings& settings,
                                       const std::vector<ChannelScan>& scans) {
  constexpr double kPerError = 8, kCodes = 50000; // with room for values that come later
  std::vector<StepCoding> steps(s.channels.size());
  bool any = false;
  for (size_t c = 0; c < steps.size(); ++c) {
    const int32_t type = stored_type(s.channels[c], settings);
    if (type == BCCSPLAT_TYPE_U8 || type == BCCSPLAT_TYPE_U16) continue;
    const double air = air_of(s.channels[c], settings);
    const double step =
        std::max(settings.wavelet_errors[c] / kPerError, range_with_air(scans[c], air) / kCodes);
    steps[c] = step_coding(step, scans[c], air, settings.nonfinite);
    any = true;
  }
  return any ? steps : std::vector<StepCoding>{};
}

// Wavelets are of the source's own samples, on their grid unless another lattice is asked for, and need no
// search.
void settle_wavelets(FrameReader& reader, const Device& device, const Unsettled& unsettled,
                     const ErrorBound& bound, WriterSettings& settings, ImportPlan& plan) {
  constexpr double kTypical = .15; // of a bound; steps are right for others, too
  const SeriesDescription& s = reader.description();
  const bool goes_on = !settings.wavelet_errors.empty(); // as the file does
  if (plan.scans.empty() && (!goes_on || unsettled.everything || need_ranges(s, settings)))
    plan.scans = scan_series(reader, settings, unsettled.progress);
  if (goes_on) return;
  if (unsettled.auto_lattice) {
    settings.lattice = BCCSPLAT_LATTICE_CC;
    settings.scale = settings.time_scale = 1;
  }
  plan.wavelets = bound, plan.still = false;
  settings.store = BCCSPLAT_STORE_WAVELETS;
  settings.psnr = bound.psnr, settings.abs_error = bound.abs;
  for (const ChannelScan& scan : plan.scans) {
    settings.wavelet_errors.push_back(bound.psnr > 0 ? wavelet_error(bound, scan) : kTypical * bound.abs);
    settings.abs_errors.push_back(largest_error(bound, scan));
  }
  settings.steps = steps_of_codes(s, settings, plan.scans);
  if (bound.psnr > 0) return;
  const double share = choose_wavelet_share(reader, device, settings, plan.scans,
                                            air_of_channels(s, settings), *unsettled.progress);
  settings.wavelet_errors.assign(s.channels.size(), share * bound.abs);
}

Spectra spectra_of(const SeriesDescription& s, const SeriesSample& sample, const std::vector<double>& air,
                   const WriterSettings& settings, Watch& watch) {
  const int32_t periodic = settings.periodic;
  return {{s, sample, air, settings.faces, settings.ends, periodic, watch},
          {s, sample, air, BCCSPLAT_FACES_PREDICT, settings.ends, periodic, watch},
          {s, sample, air, BCCSPLAT_FACES_PREDICT, BCCSPLAT_ENDS_PREDICT, periodic, watch}};
}

// Labels have no means, of which coarser levels are made: they get none, and who asks for some hears it.
void refuse_levels(const SeriesDescription& s, const std::vector<bool>& labels, WriterSettings& settings,
                   ImportPlan& plan) {
  const auto found = std::find(labels.begin(), labels.end(), true);
  if (settings.levels == 0 || found == labels.end()) return;
  if (!plan.levels.automatic)
    fail(Code::invalid_argument, s.files.front().path, ": channel '", s.channels[found - labels.begin()].name,
         "' has labels, and coarser levels are means, which labels have none of: ask for no levels");
  plan.levels.labels = true, settings.levels = 0;
}

} // namespace

void settle_import(FrameReader& reader, const Device& device, const Unsettled& unsettled,
                   WriterSettings& settings, ImportPlan& plan) {
  const SeriesDescription& s = reader.description();
  const ErrorBound& bound = unsettled.bound;
  if (settings.store == BCCSPLAT_STORE_WAVELETS)
    return settle_wavelets(reader, device, unsettled, bound, settings, plan);
  const bool open = leaves_store(unsettled, settings, s) && holds_slab(device, unsettled, s, settings);
  if (unsettled.everything || need_ranges(s, settings) || bound.any() || open)
    plan.scans = scan_series(reader, settings, unsettled.progress);
  const bool rounded = !bound.any() && rounds(unsettled, settings, s);
  bool chosen =
      !bound.any() && ((unsettled.auto_lattice && s.dims[3] > 1) || unsettled.density > 0 || rounded);
  const bool still = !bound.any() && unsettled.auto_lattice && s.dims[3] == 1;
  plan.still = still && has_cartesian(settings.kernel);
  const bool levels = plan.levels.automatic && settings.levels > 0;
  const bool kept = !unsettled.auto_lattice && is_source_grid(shape_of(settings, s)); // labels whole, if any
  const auto nothing_to_try = [&] {
    return !unsettled.everything && !bound.any() && !chosen && !unsettled.auto_time_scale;
  };
  if (nothing_to_try() && !open && !levels && !still && !kept) return;

  const std::vector<double> air = air_of_channels(s, settings);
  Watch& watch = *unsettled.progress;
  SeriesSample sample =
      sample_series(reader, air, bound.any() && !open ? SampleSize{} : size_to_choose(s.dims), watch);
  if (settings.labels.empty()) settings.labels = find_labels(s, sample, air, watch); // else the file says it
  const std::vector<bool> labels = settings.labels;
  const auto look_closely = [&] {
    plan.spectra = spectra_of(s, sample, air, settings, watch), plan.motion = voxels_a_frame(sample);
  };
  bool exact = false; // the source's samples as they are, as these take less than wavelets
  if (plan.levels.automatic || kept || keeps_grid(unsettled, settings, labels))
    refuse_levels(s, labels, settings, plan);
  const ErrorBound promise = bound.any() ? bound : kUsual;
  if (open && !any_labels(labels) && suits_wavelets(promise, s, settings, plan.scans)) {
    if (unsettled.everything) look_closely();
    const WriterSettings samples = settings;
    settle_wavelets(reader, device, unsettled, promise, settings, plan);
    if (bound.any() || !takes_less_exactly(reader, device, settings, plan.scans, air, watch)) return;
    settings = samples, plan.wavelets.reset(), exact = true;
  }
  if (open && bound.any())
    sample = sample_series(reader, air, {}, watch); // of labels as of what is searched for
  chosen = chosen || exact || (still && keeps_grid(unsettled, settings, labels)); // others have BCC
  if (nothing_to_try()) return;
  look_closely();
  // What a dry run has scanned beyond it must not make other choices than an import at once.
  const std::vector<ChannelScan>& ranges = bound.any() ? plan.scans : sample.ranges;
  Trier trier(device, s, sample, settings, plan.scans.empty() ? sample.ranges : plan.scans, ranges, watch);
  if (unsettled.auto_time_scale)
    settings.time_scale = prove_time_scale(trier, plan.spectra->plain, s, settings);
  if (chosen) {
    LatticeWish wish = wish_of(unsettled, settings, s, labels);
    if (exact) wish.fixed = source_grid(settings);
    const bool on_grid = keeps_grid(unsettled, settings, labels);
    choose_and_round(trier, sample, wish, rounded, settings, plan);
    plan.choice->takes_less = exact, plan.still = plan.still && !exact;
    if (on_grid && std::any_of(s.channels.begin(), s.channels.end(), has_wide_integers))
      require_exact_labels(s, scan_series(reader, settings, unsettled.progress), air);
  }
  if (!bound.any()) return;
  plan.search = search_coding(trier, *plan.spectra, s, settings, bound, plan.scans);
  plan.search->sampled_frames = sample.frames();
  settings = apply_coding(settings, plan.search->chosen().coding);
  settings.psnr = bound.psnr;
  if (bound.abs > 0)
    settings.abs_error = bound.abs;
  else if (settings.abs_error > 0)
    correct_for_psnr(settings, plan.scans);
}

} // namespace bccsplat::series

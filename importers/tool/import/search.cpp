#include "tool/import/search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "tool/interrupt.h"

namespace bcc4 {
namespace {

// Of the lattice in source samples, from coarse to fine: the search stops at the first that does not pay.
constexpr double kScales[] = {4, 3.2, 2.5, 2, 1.6, 1.3, 1, 0.84};
// dB by which the sample must beat the series: more takes a finer coding than needed, less writes more series
// twice.
constexpr double kPsnrReserve = 0.3;
// The first step of values tried is the root of the mean square error that is allowed. For a largest error
// it is a third of that: errors of the codes and of the lattice add as squares.
constexpr double kPeakOverStep = 3;
constexpr double kTimeScales[] = {8, 6, 4, 3, 2.5, 2, 1.5, 1.25};
constexpr double kGoodPsnr = 45; // dB that any time scale may keep
constexpr double kLostPsnr = 3;  // or dB that it may lose against scale 1

bool same_coding(const CodingTrial& a, const CodingTrial& b) {
  return a.scale == b.scale && a.time_scale == b.time_scale && a.lattice == b.lattice && a.step == b.step &&
         a.abs_error == b.abs_error;
}

// A bound that cannot be kept rules a coding out; anything else is an error.
[[nodiscard]] bool keeps_bound(bccsplat_status status) {
  if (status == BCCSPLAT_ERROR_BOUND_NOT_MET) return false;
  check(status, "sample");
  return true;
}

// Gives all frames of a stretch to the writer and finishes it; nothing when it cannot keep a bound.
std::optional<bccsplat_writer_report> write_stretch(const Writer& writer, const SeriesDescription& part,
                                                    const SampleStretch& stretch) {
  for (uint64_t f = 0; f < stretch.frames; ++f)
    for (size_t c = 0; c < part.channels.size(); ++c) {
      stop_if_interrupted();
      auto box = sized<bccsplat_box>();
      box.type = BCCSPLAT_TYPE_F32;
      box.data = stretch.values[c].data() + f * stretch.box.samples();
      for (size_t a = 0; a < 3; ++a) box.dims[a] = static_cast<int64_t>(stretch.box.dims[a]);
      if (!keeps_bound(bccsplat_writer_add_frame(writer.get(), static_cast<uint32_t>(c), part.times.values[f],
                                                 &box, 1)))
        return std::nullopt;
    }
  auto report = sized<bccsplat_writer_report>();
  if (!keeps_bound(bccsplat_writer_finish(writer.get(), &report))) return std::nullopt;
  return report;
}

struct Trier {
  const Device& device;
  const SeriesDescription& series;
  const std::vector<SampleStretch>& sample;
  const WriterSettings& settings;
  const ErrorBound& bound;
  const std::vector<ChannelScan>& scans;
  CodingSearch& search;

  // Runs the sample through the writer, unless it was tried before; its place in the list.
  size_t try_coding(const CodingTrial& coding) const {
    for (size_t i = 0; i < search.tried.size(); ++i)
      if (same_coding(search.tried[i], coding)) return i;
    search.tried.push_back(measure(coding));
    return search.tried.size() - 1;
  }

 private:
  [[nodiscard]] CodingTrial measure(CodingTrial trial) const {
    WriterSettings s = apply_coding(settings, trial, {});
    s.abs_error = trial.abs_error;
    s.measure = BCCSPLAT_MEASURE_ALL;
    if (s.nonfinite == BCCSPLAT_NONFINITE_DEFAULT) s.nonfinite = BCCSPLAT_NONFINITE_HOLE;
    double squares = 0, samples = 0;
    trial.holds = true;
    for (const SampleStretch& stretch : sample) {
      const SeriesDescription part = describe_stretch(series, stretch);
      const Writer writer = create_writer(device, "", part, s, scans, stretch.frames);
      const auto report = write_stretch(writer, part, stretch);
      if (!report) {
        trial.holds = false;
        trial.bytes = std::numeric_limits<uint64_t>::max();
        break;
      }
      trial.bytes += report->bytes_file;
      for (uint32_t c = 0; c < part.channels.size(); ++c) {
        auto error = sized<bccsplat_error_report>();
        check(bccsplat_writer_get_error(writer.get(), c, -1, &error), "");
        trial.max_abs = std::max(trial.max_abs, error.max_abs);
        trial.corrected += error.corrected;
        squares += error.rmse * error.rmse * static_cast<double>(error.samples);
        samples += static_cast<double>(error.samples);
      }
    }
    const double rms = samples > 0 ? std::sqrt(squares / samples) : 0;
    trial.psnr = rms > 0 ? 20 * std::log10(peak_of(scans) / rms) : std::numeric_limits<double>::infinity();
    if (bound.psnr > 0) trial.holds = trial.holds && trial.psnr >= bound.psnr + kPsnrReserve;
    return trial;
  }
};

// The coding without what it gave.
CodingTrial forget_results(const CodingTrial& t) {
  CodingTrial out;
  out.scale = t.scale, out.time_scale = t.time_scale, out.lattice = t.lattice;
  out.step = t.step, out.abs_error = t.abs_error;
  return out;
}

// From one value of a channel to the next; 0: floats.
double source_step(const Channel& c) {
  return c.scaled() ? std::fabs(c.step) : is_float(c.precision) ? 0 : 1;
}

// Whole numbers of source steps for integers of one step; 0 where the source's own coding is as coarse.
double step_for(double wanted, const SeriesDescription& series, const WriterSettings& settings) {
  if (settings.quantize != BCCSPLAT_TYPE_DEFAULT || settings.store == BCCSPLAT_STORE_COEFFICIENTS) return 0;
  const double unit = source_step(series.channels.front());
  const bool one_step = std::all_of(series.channels.begin(), series.channels.end(),
                                    [&](const Channel& c) { return source_step(c) == unit; });
  if (!one_step || unit == 0) return wanted;
  return wanted < 2 * unit ? 0 : std::floor(wanted / unit) * unit;
}

} // namespace

double peak_of(const std::vector<ChannelScan>& scans) {
  double peak = 0;
  for (const ChannelScan& s : scans)
    if (!s.empty()) peak = std::max(peak, s.max - s.min);
  return peak;
}

WriterSettings apply_coding(WriterSettings s, const CodingTrial& trial, const ErrorBound& bound) {
  s.scale = trial.scale, s.time_scale = trial.time_scale;
  s.lattice = trial.lattice;
  s.value_step = trial.step;
  s.abs_error = bound.abs > 0 ? bound.abs : trial.abs_error;
  s.psnr = bound.psnr;
  return s;
}

CodingSearch search_coding(const Device& device, const SeriesDescription& series,
                           const std::vector<SampleStretch>& sample, const WriterSettings& settings,
                           const ErrorBound& bound, const std::vector<ChannelScan>& scans) {
  CodingSearch search;
  for (const SampleStretch& s : sample) search.sampled_frames += s.frames;
  const Trier trier{device, series, sample, settings, bound, scans, search};
  const double rms =
      bound.abs > 0 ? bound.abs / kPeakOverStep : peak_of(scans) * std::pow(10, -bound.psnr / 20);
  const auto coding = [&](double scale, double step) {
    CodingTrial t;
    t.scale = settings.scale > 0 ? settings.scale : scale;
    t.time_scale = settings.time_scale > 0 ? settings.time_scale : series.dims[3] > 1 ? scale : 1;
    t.lattice = settings.lattice != BCCSPLAT_LATTICE_DEFAULT ? settings.lattice
                : series.dims[3] > 1                         ? BCCSPLAT_LATTICE_D4STAR
                                                             : BCCSPLAT_LATTICE_BCC;
    t.step = step_for(step, series, settings);
    t.abs_error = bound.abs;
    return t;
  };
  const auto better = [&](size_t a, size_t b) {
    const CodingTrial &x = search.tried[a], &y = search.tried[b];
    return x.holds != y.holds ? x.holds : x.bytes < y.bytes;
  };
  const auto consider = [&](const CodingTrial& t) {
    const size_t i = trier.try_coding(t);
    if (better(i, search.best)) search.best = i;
    return i;
  };
  // From coarse to fine as long as it pays.
  size_t before = consider(coding(kScales[0], rms));
  for (const double scale : kScales) {
    const size_t now = consider(coding(scale, rms));
    if (now != before && search.tried[before].holds && better(before, now)) break;
    before = now;
  }
  const auto vary_step = [&](std::initializer_list<double> factors) {
    for (const double factor : factors) {
      const size_t best = search.best;
      CodingTrial t = search.chosen();
      t.step = step_for(rms * factor, series, settings);
      consider(forget_results(t));
      if (search.best == best) return;
    }
  };
  vary_step({2, 4});
  vary_step({0.5, 0.25});
  // All of the band, where the half that D4* leaves out is not empty.
  if (settings.lattice == BCCSPLAT_LATTICE_DEFAULT && settings.kernel.find("24") == std::string::npos &&
      settings.kernel != "fine" && settings.kernel != "gauss09") {
    CodingTrial t = coding(1, rms);
    t.lattice = BCCSPLAT_LATTICE_CC;
    t.step = search.chosen().step;
    consider(t);
  }
  // The last resort for a PSNR is to correct samples.
  if (!search.chosen().holds && bound.psnr > 0) {
    CodingTrial t = search.chosen();
    t.abs_error = kCorrectedPeak * rms;
    consider(forget_results(t));
  }
  return search;
}

double prove_time_scale(const Device& device, const SeriesDescription& series,
                        const std::vector<SampleStretch>& sample, const WriterSettings& settings, double most,
                        const std::vector<ChannelScan>& scans) {
  CodingSearch search;
  const ErrorBound none;
  const Trier trier{device, series, sample, settings, none, scans, search};
  const auto psnr = [&](double time_scale) {
    CodingTrial t;
    t.scale = settings.scale > 0 ? settings.scale : 1;
    t.time_scale = time_scale;
    t.lattice = settings.lattice;
    return search.tried[trier.try_coding(t)].psnr;
  };
  if (most <= 1) return 1;
  const double enough = std::min(kGoodPsnr, psnr(1) - kLostPsnr);
  for (const double x : kTimeScales)
    if (x <= most && psnr(x) >= enough) return x;
  return 1;
}

std::string coding_text(const CodingTrial& t) {
  return concat(lattice_name(t.lattice), ", scale ", short_number(t.scale, 4),
                t.time_scale != t.scale ? concat(", time scale ", short_number(t.time_scale, 4)) : "",
                t.step > 0 ? concat(", values in steps of ", short_number(t.step, 4)) : "",
                t.abs_error > 0 && t.corrected > 0 ? ", corrections" : "");
}

Json search_json(const CodingSearch& search) {
  const auto one = [](const CodingTrial& t) {
    return Json{{"lattice", lattice_name(t.lattice)},
                {"scale", t.scale},
                {"time_scale", t.time_scale},
                {"step", t.step},
                {"bytes", t.bytes},
                {"max_abs", t.max_abs},
                {"psnr", t.psnr},
                {"corrected", t.corrected},
                {"holds", t.holds}};
  };
  Json j{{"sampled_frames", search.sampled_frames}, {"chosen", one(search.chosen())}};
  j["tried"] = Json::array();
  for (const CodingTrial& t : search.tried) j["tried"].push_back(one(t));
  return j;
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// Writes the boxes of a sample into memory one by one, opens each as a volume and adds up the squared errors
// by what a box stands for. Boxes that lost most in the first trial come first, so that one with too low a
// PSNR ends early.
#include "choose/trial.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "choose/beyond.h"
#include "choose/frame_samples.h"
#include "series/library.h"
#include "series/text.h"

namespace bccsplat::series {
namespace {

// A file in memory, written and read as a stream.
struct MemoryFile {
  Bytes bytes;

  static int64_t write_at(void* user, uint64_t offset, const void* buffer, uint64_t size) {
    Bytes& bytes = static_cast<MemoryFile*>(user)->bytes;
    if (bytes.size() < offset + size) bytes.resize(offset + size);
    std::memcpy(bytes.data() + offset, buffer, size);
    return size;
  }
  static int64_t read_at(void* user, uint64_t offset, void* buffer, uint64_t size) {
    const Bytes& bytes = static_cast<MemoryFile*>(user)->bytes;
    if (offset > bytes.size()) return 0;
    size = std::min<uint64_t>(size, bytes.size() - offset);
    std::memcpy(buffer, bytes.data() + offset, size);
    return size;
  }
};

// A bound that cannot be kept rules a coding out; anything else is an error.
[[nodiscard]] bool keeps_bound(bccsplat_status status) {
  if (status == BCCSPLAT_ERROR_BOUND_NOT_MET) return false;
  check(status, "sample");
  return true;
}

} // namespace

bool write_stretch(const Writer& writer, const SeriesDescription& part, const SampleStretch& stretch,
                   Watch& watch, bccsplat_writer_report* report) {
  for (uint64_t f = 0; f < stretch.frames; ++f)
    for (size_t c = 0; c < part.channels.size(); ++c) {
      watch.go_on();
      auto box = sized<bccsplat_box>();
      box.type = BCCSPLAT_TYPE_F32;
      box.data = stretch.values[c].data() + f * stretch.box.samples();
      for (size_t a = 0; a < 3; ++a) box.dims[a] = stretch.box.dims[a];
      if (!keeps_bound(bccsplat_writer_add_frame(writer.get(), static_cast<uint32_t>(c), part.times.values[f],
                                                 &box, 1)))
        return false;
    }
  return keeps_bound(bccsplat_writer_finish(writer.get(), report));
}

namespace {

Volume open_memory(const Device& device, MemoryFile& file) {
  auto stream = sized<bccsplat_read_stream>();
  stream.size = file.bytes.size();
  stream.read_at = MemoryFile::read_at;
  stream.user = &file;
  bccsplat_volume* volume = nullptr;
  check(bccsplat_volume_open_stream(device.get(), &stream, nullptr, &volume), "sample");
  return Volume(volume);
}

struct Squares {
  double sum = 0, count = 0, largest = 0;
  double weight = 1; // of what is added next
  void add(double got, double expected) {
    if (!std::isfinite(expected) || !std::isfinite(got)) return;
    const double d = got - expected;
    sum += weight * d * d, count += weight;
    largest = std::max(largest, std::fabs(d));
  }
  [[nodiscard]] double mean() const { return count > 0 ? sum / count : 0; }
};

// The inner part of a stretch, in samples of its box.
SampleBox inner_part(const SampleStretch& s) {
  SampleBox part = s.inner;
  for (size_t a = 0; a < 3; ++a) part.begin[a] -= s.box.begin[a];
  return part;
}

// Calls body(place in the box's frame, place in the part) for every sample of a part.
template<class Body> void each_sample(const SampleStretch& s, const SampleBox& part, const Body& body) {
  uint64_t i = 0;
  for (uint64_t z = 0; z < part.dims[2]; ++z)
    for (uint64_t y = 0; y < part.dims[1]; ++y) {
      const uint64_t row =
          ((part.begin[2] + z) * s.box.dims[1] + part.begin[1] + y) * s.box.dims[0] + part.begin[0];
      for (uint64_t x = 0; x < part.dims[0]; ++x) body(row + x, i++);
    }
}

// Makes the layers of all frames that count at once, which costs a fraction of making them one by one.
void make_layers(const Volume& volume, const SampleStretch& s, uint32_t channel, Watch& watch) {
  const auto first = static_cast<double>(s.counts.first - s.first);
  const auto last = static_cast<double>(s.counts.end - 1 - s.first);
  auto hyperplane = sized<bccsplat_hyperplane>();
  hyperplane.d = 1, hyperplane.e = -first;
  auto options = sized<bccsplat_slice_options>();
  options.channel = channel, options.interval[1] = last - first;
  options.cancel_token = watch.token();
  check(bccsplat_volume_prefetch(volume.get(), &hyperplane, &options), "sample");
}

Squares compare_channel(const Volume& volume, const SampleStretch& s, uint32_t channel, Watch& watch) {
  make_layers(volume, s, channel, watch);
  Squares squares;
  const SampleBox part = inner_part(s);
  std::vector<float> got(part.samples());
  for (uint64_t f = s.counts.first; f < s.counts.end; ++f) {
    watch.go_on();
    const uint64_t frame = f - s.first;
    squares.weight = s.frame_weight(f);
    sample_frame(volume, frame, channel, part, watch.token(), got);
    const float* const expected = s.values[channel].data() + frame * s.box.samples();
    each_sample(s, part, [&](uint64_t from, uint64_t to) { squares.add(got[to], expected[from]); });
  }
  return squares;
}

} // namespace

WriterSettings apply_coding(WriterSettings s, const Coding& coding) {
  s.lattice = coding.shape.lattice;
  s.scales = coding.shape.scales;
  s.steps = coding.steps;
  s.abs_error = coding.abs_error;
  s.faces = coding.shape.faces, s.ends = coding.shape.ends;
  return s;
}

std::optional<size_t> Trier::find(const Coding& coding) const {
  for (size_t i = 0; i < tried_.size(); ++i)
    if (tried_[i].coding == coding) return i;
  return std::nullopt;
}

size_t Trier::try_coding(const Coding& coding) {
  if (const std::optional<size_t> known = find(coding)) return *known;
  CodingTrial trial = *measure(coding, -HUGE_VAL);
  if (!coding.steps.empty() && coding.abs_error == 0 && trial.holds)
    weigh_rounding(trial, tried_[try_coding({coding.shape, {}, 0})]);
  tried_.push_back(std::move(trial));
  return tried_.size() - 1;
}

std::optional<size_t> Trier::try_above(const Coding& coding, double least) {
  if (const std::optional<size_t> known = find(coding)) return known;
  std::optional<CodingTrial> trial = measure(coding, least);
  if (!trial) return std::nullopt;
  tried_.push_back(*std::move(trial));
  return tried_.size() - 1;
}

// The boxes are weighed by what the lattice loses; rounding adds to all that is not air.
void Trier::weigh_rounding(CodingTrial& trial, const CodingTrial& plain) const {
  for (size_t c = 0; c < trial.mean_squares.size(); ++c) {
    const double added = trial.mean_squares[c] - plain.mean_squares[c];
    if (added > 0) trial.mean_squares[c] = plain.mean_squares[c] + added / sample_.filled();
  }
  trial.psnr = psnr_of(trial.mean_squares);
}

// Returns what a writer of the series does at its ends; where a stretch is cut out of it, nothing counts.
int32_t Trier::ends_of(const SampleStretch& stretch, const LatticeShape& shape) const {
  const bool at_end = stretch.first == 0 || stretch.first + stretch.frames == series_.dims[3];
  if (shape.ends == BCCSPLAT_ENDS_PERIODIC) {
    // A stretch does not go round; one that predicts its ends comes closest to a series that does.
    if (stretch.frames == series_.dims[3] && stretch.frames > 1) return BCCSPLAT_ENDS_PERIODIC;
    return at_end ? BCCSPLAT_ENDS_PREDICT : BCCSPLAT_ENDS_MIRROR;
  }
  return at_end && predicts_ends(shape, series_.dims) ? BCCSPLAT_ENDS_PREDICT : BCCSPLAT_ENDS_MIRROR;
}

// Errors only add up: a PSNR that a part of the stretches spoils does not recover.
std::optional<CodingTrial> Trier::measure(const Coding& coding, double least) {
  CodingTrial trial;
  trial.coding = coding;
  watch_.show({"trial", tried_.size() + 1, 0, shape_text(coding.shape, series_.dims)});
  const size_t channels = series_.channels.size();
  std::vector<std::vector<double>> mean_squares(sample_.stretches.size(), std::vector<double>(channels));
  if (order_.empty())
    for (size_t i = 0; i < sample_.stretches.size(); ++i) order_.push_back(i);
  std::vector<double> so_far(channels);
  for (const size_t i : order_) {
    trial.holds = measure_stretch(sample_.stretches[i], trial, mean_squares[i]);
    if (!trial.holds) trial.bytes = std::numeric_limits<uint64_t>::max();
    for (size_t c = 0; c < channels; ++c) so_far[c] += mean_squares[i][c];
    if (psnr_of(so_far) < least) return std::nullopt;
    if (!trial.holds) break;
  }
  // Summed up in one order: to the last bit the same whichever was taken.
  trial.mean_squares.assign(channels, 0);
  for (const std::vector<double>& of_stretch : mean_squares)
    for (size_t c = 0; c < channels; ++c) trial.mean_squares[c] += of_stretch[c];
  trial.psnr = trial.holds ? psnr_of(trial.mean_squares) : 0;
  if (tried_.empty() && trial.holds)
    std::stable_sort(order_.begin(), order_.end(), [&](size_t a, size_t b) {
      return share_of_ranges(mean_squares[a]) > share_of_ranges(mean_squares[b]);
    });
  return trial;
}

bool Trier::measure_stretch(const SampleStretch& stretch, CodingTrial& trial,
                            std::vector<double>& mean_squares) const {
  const LatticeShape& whole = trial.coding.shape;
  WriterSettings s = apply_coding(settings_, trial.coding);
  s.psnr = 0; // a goal of the series
  s.measure = BCCSPLAT_MEASURE_DEFAULT;
  if (s.nonfinite == BCCSPLAT_NONFINITE_DEFAULT) s.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  const SeriesDescription part = describe_stretch(series_, stretch);
  const LatticeShape shape = shape_of_part(whole, series_.dims, part.dims, stretch.ends > 0);
  s.scales = shape.scales;
  s.ends = ends_of(stretch, whole);
  s.periodic = shape.periodic;
  s.faces = faces_of_part(whole, series_.dims);
  // What is cut out of an axis that goes round does not; predicted faces come closest to that.
  for (size_t a = 0; a < 3; ++a)
    if (shape.periodic != whole.periodic && is_periodic(whole.periodic & ~shape.periodic, a) &&
        part.dims[a] > 1 && !has_source_planes(whole))
      s.faces = s.faces == BCCSPLAT_FACES_MIRROR ? face_bit(a) : s.faces | face_bit(a);
  MemoryFile file;
  auto stream = sized<bccsplat_write_stream>();
  stream.write_at = MemoryFile::write_at;
  stream.user = &file;
  {
    const Writer writer = create_writer(device_, part, s, scans_, stretch.frames, &stream);
    if (!write_stretch(writer, part, stretch, watch_, nullptr)) return false;
  }
  // More of a box than of the series is outside the faces.
  trial.bytes += static_cast<uint64_t>(
      static_cast<double>(file.bytes.size()) * (1 + outside_share(whole, series_.dims)) /
      (1 + outside_share(shape, part.dims, s.faces, s.ends == BCCSPLAT_ENDS_PREDICT)));
  const Volume volume = open_memory(device_, file);
  for (uint32_t c = 0; c < part.channels.size(); ++c) {
    const Squares squares = compare_channel(volume, stretch, c, watch_);
    mean_squares[c] = stretch.weight * squares.mean();
    trial.max_abs = std::max(trial.max_abs, squares.largest);
  }
  return true;
}

// Over the squares of the ranges, all channels.
double Trier::share_of_ranges(const std::vector<double>& mean_squares) const {
  double sum = 0;
  for (size_t c = 0; c < mean_squares.size(); ++c)
    if (!ranges_[c].empty() && ranges_[c].max > ranges_[c].min)
      sum += mean_squares[c] / std::pow(ranges_[c].max - ranges_[c].min, 2);
  return sum;
}

double Trier::psnr_of(const std::vector<double>& mean_squares) const {
  double least = std::numeric_limits<double>::infinity();
  for (size_t c = 0; c < mean_squares.size(); ++c)
    if (mean_squares[c] > 0 && !ranges_[c].empty())
      least =
          std::min(least, 20 * std::log10((ranges_[c].max - ranges_[c].min) / std::sqrt(mean_squares[c])));
  return least;
}

double Trier::half_the_frames() const {
  std::vector<double> mean_squares(series_.channels.size());
  for (const SampleStretch& s : sample_.stretches)
    for (size_t c = 0; c < s.values.size(); ++c) {
      Squares squares;
      const uint64_t frame = s.box.samples();
      for (uint64_t f = s.counts.first - s.first; f < s.counts.end - s.first; ++f) {
        const float* const now = s.values[c].data() + f * frame;
        const bool kept = (s.first + f) % 2 == 0;
        squares.weight = s.frame_weight(s.first + f);
        const float* const before = kept ? now : now - frame;
        const float* const after = kept ? now : f + 1 < s.frames ? now + frame : before;
        each_sample(s, inner_part(s), [&](uint64_t i, uint64_t) {
          squares.add((static_cast<double>(before[i]) + after[i]) / 2, now[i]);
        });
      }
      mean_squares[c] += s.weight * squares.mean();
    }
  return psnr_of(mean_squares);
}

std::string decibels_text(double psnr) {
  return std::isinf(psnr) ? "exact" : concat(short_number(psnr, 3), " dB");
}

std::string steps_text(const Coding& coding, const SeriesDescription& series) {
  std::string text;
  for (size_t c = 0; c < coding.steps.size(); ++c)
    if (coding.steps[c].step > 0)
      text += concat(text.empty() ? "" : ", ", coding.steps.size() > 1 ? series.channels[c].name : "values",
                     " in steps of ", short_number(coding.steps[c].step, 3));
  return text;
}

std::string coding_text(const CodingTrial& t, const SeriesDescription& series) {
  const std::string steps = steps_text(t.coding, series);
  return concat(shape_text(t.coding.shape, series.dims), steps.empty() ? "" : ", ", steps,
                t.coding.abs_error > 0 ? ", corrections" : "");
}

} // namespace bccsplat::series

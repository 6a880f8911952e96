// SPDX-License-Identifier: Apache-2.0
// Divides frames into boxes by the memory that importing one takes, writes each as a part of the series, and
// joins them without coding anything again.
#include "tool/import/block.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <regex>
#include <utility>

#include <zlib.h>

#include "readers/system.h"
#include "tool/import/block_result.h"
#include "tool/import/part_frames.h"
#include "tool/import/plan_file.h"
#include "tool/interrupt.h"
#include "tool/options.h"

namespace bcc4 {
namespace {

// Samples that a block is given along an axis beyond its own (tests/bench/notes/blocks.md).
constexpr uint64_t kHalo = 48;
constexpr uint64_t kComparedHalo = 96; // where its samples are compared with the file
constexpr uint64_t kThinnest = 48;     // samples of a block along an axis, while another one can be divided

// What blocks are made of: settings, sources and how these are read.
std::string checksum_of(const SeriesDescription& series, const WriterSettings& settings,
                        const ImportScope& scope) {
  std::string text = settings_text(settings);
  for (const PlannedSource& s : scope.sources) text += concat('\n', s.name, ' ', s.bytes, ' ', s.crc32);
  for (const auto& [key, value] : scope.attributes) text += concat('\n', key, ' ', value);
  for (const uint64_t n : series.dims) text += concat('\n', n);
  for (const double t : series.times.values) text += concat('\n', t);
  const uLong sum = crc32_z(0, reinterpret_cast<const Bytef*>(text.data()), text.size());
  std::array<char, 16> digits{};
  std::snprintf(digits.data(), digits.size(), "%08lx", sum);
  return digits.data();
}

// By their number, too, so that a run with other memory takes none of this one's, and by what they are made
// of, so that blocks of other settings or other input do not stand for them.
std::string block_name(const std::string& output, size_t number, size_t count, const std::string& checksum) {
  return concat(output, ".block", number, "of", count, ".", checksum);
}

// One of `pieces` parts of nearly equal length of an axis.
void cut_axis(SampleBox& box, size_t axis, uint64_t n, uint64_t piece, uint64_t pieces) {
  box.begin[axis] = n * piece / pieces;
  box.dims[axis] = n * (piece + 1) / pieces - box.begin[axis];
}

// Returns the bytes that an import holds for each sample of a frame that it resamples: what waits for the
// filter in time takes 12 or 16 bits of integers, and floats else; beside it, where all is compared, frames
// and the field that readers get.
uint64_t bytes_of_sample(const SeriesDescription& series, bool compared) {
  struct Bytes {
    uint64_t resampled, compared;
  };
  constexpr Bytes of_bytes{16, 32}, of_words{32, 56}, of_floats{48, 64};
  uint64_t sum = 0;
  for (const Channel& c : series.channels) {
    const uint64_t size = type_size(c.precision);
    const Bytes& bytes = is_float(c.precision) || size > 2 ? of_floats : size == 1 ? of_bytes : of_words;
    sum += bytes.resampled + (compared ? bytes.compared : 0);
  }
  return sum;
}

// Are all samples compared with the file?
bool compares_all(const WriterSettings& settings) {
  const auto bounds = [](double error) { return error > 0; };
  return settings.measure == BCCSPLAT_MEASURE_ALL || settings.psnr > 0 || settings.abs_error > 0 ||
         std::any_of(settings.largest_errors.begin(), settings.largest_errors.end(), bounds);
}

// Are missing values filled?
bool fills(const SeriesDescription& series, const WriterSettings& settings) {
  const auto has_fill = [](const Channel& c) { return c.has_fill; };
  return settings.nonfinite == BCCSPLAT_NONFINITE_HOLE ||
         (settings.nonfinite == BCCSPLAT_NONFINITE_DEFAULT &&
          std::any_of(series.channels.begin(), series.channels.end(), has_fill));
}

// Returns the bytes of a sample that is read for coarser levels, or for the fill of missing ones, alone: read
// and read ahead, halved, filled. 0: there are none.
uint64_t bytes_of_given_sample(const SeriesDescription& series, const WriterSettings& settings) {
  constexpr uint64_t halved = 1, filled = 24;
  if (settings.levels == 0 && !fills(series, settings)) return 0;
  uint64_t most = 0;
  for (const Channel& c : series.channels) most = std::max<uint64_t>(most, type_size(c.type));
  return 2 * most + (settings.levels > 0 ? halved : 0) + (fills(series, settings) ? filled : 0);
}

// What importing the largest of the blocks takes, for divisions of the axes.
class BlockMemory {
 public:
  BlockMemory(const Device& device, const SeriesDescription& series, const WriterSettings& settings)
      : device_(device), series_(series), settings_(settings), compared_(compares_all(settings)) {}

  [[nodiscard]] uint64_t bytes(const std::array<uint64_t, 3>& pieces) {
    const uint64_t of_given = bytes_of_given_sample(series_, settings_);
    uint64_t own = 1, given = 1;
    for (size_t a = 0; a < 3; ++a) {
      const uint64_t n = series_.dims[a], length = (n + pieces[a] - 1) / pieces[a];
      own *= std::min(n, length + (pieces[a] > 1 ? compared_ ? kComparedHalo : kHalo : 0));
      if (of_given > 0) given *= longest_given(a, pieces[a]);
    }
    return own * bytes_of_sample(series_, compared_) + given * of_given;
  }

 private:
  // Samples that the first, the second, the middle or the last of the pieces of an axis is made of.
  uint64_t longest_given(size_t axis, uint64_t pieces) {
    if (pieces == 1) return series_.dims[axis];
    uint64_t& longest = given_[{axis, pieces}];
    for (const uint64_t piece : {uint64_t{0}, uint64_t{1}, pieces / 2, pieces - 1}) {
      if (longest > 0 && piece == 0) break; // asked before
      SampleBox box{{}, {series_.dims[0], series_.dims[1], series_.dims[2]}};
      cut_axis(box, axis, series_.dims[axis], piece, pieces);
      longest = std::max(longest, block_samples(device_, series_, settings_, box).dims[axis]);
    }
    return longest;
  }

  const Device& device_;
  const SeriesDescription& series_;
  const WriterSettings& settings_;
  bool compared_;
  std::map<std::pair<size_t, uint64_t>, uint64_t> given_;
};

void join_blocks(const Device& device, const std::vector<std::string>& names, const ImportScope& scope,
                 bool overwrite, bccsplat_writer_report& report) {
  auto options = sized<bccsplat_join_options>();
  options.overwrite = overwrite ? 1 : 0;
  options.compare_levels = 1;
  options.cancel_token = interrupt_token();
  std::vector<const char*> paths;
  for (const std::string& name : names) paths.push_back(name.c_str());
  check(
      bccsplat_join_parts(device.get(), paths.size(), paths.data(), scope.output.c_str(), &options, &report),
      "");
}

// Removes the blocks of an output, also those that runs with other settings have left.
void remove_all_blocks(const std::string& output) {
  const std::filesystem::path path = to_path(output);
  const std::string begin = to_text(path.filename());
  const std::regex of_block(R"(\.block[0-9]+of[0-9]+\.[0-9a-f]{8}(\.(result|partial|journal))?)");
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    const std::string name = to_text(entry.path().filename());
    if (name.starts_with(begin) && std::regex_match(name.substr(begin.size()), of_block))
      std::filesystem::remove(entry.path(), ignored);
  }
}

ImportResult write_block(FrameReader& reader, const Device& device, WriterSettings settings,
                         ImportScope scope, const CommonOptions& common, const std::string& name,
                         const SampleBox& block) {
  scope.output = name, scope.block = block;
  settings.overwrite = 1; // what an earlier run has left
  remove_block_result(name);
  ImportResult result = write_once(reader, device, settings, scope, common);
  keep_block_result(result, name);
  return result;
}

// Takes over what an earlier run told of a block that it has finished. False: it is to be written, also where
// its errors are to be told and are not known any more.
bool take_block(const std::string& name, const WriterSettings& settings, size_t channels,
                ImportResult& result) {
  std::error_code ignored;
  if (settings.partial != BCCSPLAT_PARTIAL_RESUME || !std::filesystem::exists(to_path(name), ignored))
    return false;
  return read_block_result(name, channels, result) || !compares_all(settings);
}

// Samples of halos are read by several blocks: the frames that lack some are told, with the largest count.
void add_nonfinite(const ImportResult& block, ImportResult& all) {
  for (size_t c = 0; c < block.nonfinite.size(); ++c)
    for (const auto& [frame, count] : block.nonfinite[c]) {
      uint64_t& most = all.nonfinite[c][frame];
      most = std::max<uint64_t>(most, count);
    }
}

// What blocks measured becomes that of the series: its values have the range that the file tells.
void set_peaks(const Device& device, const std::string& output, MeasuredErrors& errors) {
  if (errors.series.empty()) return;
  const Volume volume = open_volume(device, output, "");
  for (size_t c = 0; c < errors.series.size(); ++c) {
    const bccsplat_channel_info info = channel_info(volume, static_cast<uint32_t>(c));
    const double peak = info.range[1] - info.range[0];
    set_peak(errors.series[c], peak);
    for (bccsplat_error_report& frame : errors.frames[c]) set_peak(frame, peak);
  }
}

// Says what stays of an import whose blocks were not joined.
class UnjoinedBlocks {
 public:
  UnjoinedBlocks(const std::vector<std::string>& finished, bool quiet) : finished_(finished), quiet_(quiet) {}
  UnjoinedBlocks(const UnjoinedBlocks&) = delete;
  UnjoinedBlocks& operator=(const UnjoinedBlocks&) = delete;
  ~UnjoinedBlocks() {
    if (finished_.empty() || quiet_) return;
    std::fprintf(stderr,
                 "bcc4: finished blocks stay, the last one in %s; the same command with --resume "
                 "does not write them again\n",
                 finished_.back().c_str());
  }

 private:
  const std::vector<std::string>& finished_;
  bool quiet_;
};

} // namespace

SampleBox parse_block(const std::string& text, const std::array<uint64_t, 4>& dims) {
  SampleBox box;
  size_t begin = 0;
  for (size_t a = 0; a < 3; ++a) {
    const size_t end = a < 2 ? text.find(',', begin) : text.size();
    if (end == std::string::npos || text.find(',', begin) < end)
      fail_usage("--block ", text, ": X0:X1,Y0:Y1,Z0:Z1, samples from X0 to X1 - 1 and so on");
    const std::string part = text.substr(begin, end - begin);
    begin = end + 1;
    uint64_t first = 0, last = dims[a];
    if (const size_t colon = part.find(':'); !part.empty()) {
      if (colon == std::string::npos) fail_usage("--block ", text, ": ", part, " has no colon");
      if (colon > 0) first = option_number<uint64_t>("--block", part.substr(0, colon));
      if (colon + 1 < part.size()) last = option_number<uint64_t>("--block", part.substr(colon + 1));
    }
    if (first >= last || last > dims[a])
      fail_usage("--block ", text, ": samples along ", "xyz"[a], " run from 0 to ", dims[a],
                 ", the end excluded");
    box.begin[a] = first, box.dims[a] = last - first;
  }
  return box;
}

std::optional<SampleBox> parse_block_number(const std::string& text, const std::array<uint64_t, 4>& dims) {
  const size_t slash = text.find('/');
  if (slash == std::string::npos) return std::nullopt;
  const auto k = option_number<uint64_t>("--part", text.substr(0, slash));
  const auto n = option_number<uint64_t>("--part", text.substr(slash + 1));
  if (k < 1 || k > n) fail_usage("--part ", text, ": the first of ", n, " parts is 1/", n);
  std::array<uint64_t, 3> pieces{1, 1, 1};
  for (uint64_t rest = n, factor = 2; rest > 1; rest % factor == 0 ? rest /= factor : ++factor) {
    if (rest % factor != 0) continue;
    const auto length = [&](size_t a) { return dims[a] / pieces[a]; };
    const size_t longer = length(1) > length(0) ? 1 : 0;
    pieces[length(2) >= length(longer) ? 2 : longer] *= factor;
  }
  for (size_t a = 0; a < 3; ++a)
    if (pieces[a] > dims[a])
      fail_usage("--part ", text, ": ", pieces[a], " parts of ", dims[a], " samples along ", "xyz"[a]);
  SampleBox box;
  cut_axis(box, 0, dims[0], (k - 1) % pieces[0], pieces[0]);
  cut_axis(box, 1, dims[1], (k - 1) / pieces[0] % pieces[1], pieces[1]);
  cut_axis(box, 2, dims[2], (k - 1) / (pieces[0] * pieces[1]), pieces[2]);
  return box;
}

std::string needs_whole_frames(const WriterSettings& settings) {
  if (settings.store == BCCSPLAT_STORE_WAVELETS)
    return "the step of wavelets is chosen by whole frames: choose --store samples";
  if (settings.lowpass) return "--lowpass holds whole frames";
  if (settings.periodic_axes != 0) return "what follows the last sample of a --periodic axis is far away";
  return "";
}

void settle_for_blocks(WriterSettings& settings) {
  if (settings.store == BCCSPLAT_STORE_DEFAULT) settings.store = BCCSPLAT_STORE_SAMPLES;
  settings.fixed_predictions = true;
  if (settings.measure != BCCSPLAT_MEASURE_ALL) settings.measure = BCCSPLAT_MEASURE_DEFAULT;
}

uint64_t memory_of_frames(const SeriesDescription& series, const WriterSettings& settings) {
  return series.dims[0] * series.dims[1] * series.dims[2] *
         (bytes_of_sample(series, settings.store == BCCSPLAT_STORE_WAVELETS || compares_all(settings)) +
          bytes_of_given_sample(series, settings));
}

std::vector<SampleBox> blocks_that_fit(const Device& device, const SeriesDescription& series,
                                       const WriterSettings& settings, uint64_t memory) {
  const auto& n = series.dims;
  BlockMemory needed(device, series, settings);
  std::array<uint64_t, 3> pieces{1, 1, 1};
  while (needed.bytes(pieces) > memory) {
    std::array<uint64_t, 3> best{};
    uint64_t least = UINT64_MAX;
    for (size_t i = 3; i > 0; --i) { // planes first: files have them one after the other
      std::array<uint64_t, 3> more = pieces;
      if (n[i - 1] / ++more[i - 1] < kThinnest) continue;
      if (const uint64_t bytes = needed.bytes(more); bytes < least) least = bytes, best = more;
    }
    if (least == UINT64_MAX) break;
    pieces = best;
  }
  std::vector<SampleBox> blocks;
  for (uint64_t z = 0; z < pieces[2]; ++z)
    for (uint64_t y = 0; y < pieces[1]; ++y)
      for (uint64_t x = 0; x < pieces[0]; ++x) {
        SampleBox& box = blocks.emplace_back();
        cut_axis(box, 0, n[0], x, pieces[0]), cut_axis(box, 1, n[1], y, pieces[1]);
        cut_axis(box, 2, n[2], z, pieces[2]);
      }
  return blocks;
}

namespace {

ImportResult write_blocks_once(FrameReader& reader, const Device& device, const WriterSettings& settings,
                               const ImportScope& scope, const CommonOptions& common,
                               const std::vector<SampleBox>& blocks) {
  const size_t channels = reader.description().channels.size();
  ImportResult all;
  all.nonfinite.resize(channels);
  std::vector<std::string> names;
  const UnjoinedBlocks unjoined(names, common.quiet);
  const std::string checksum = checksum_of(reader.description(), settings, scope);
  for (const SampleBox& block : blocks) {
    const std::string name = block_name(scope.output, names.size() + 1, blocks.size(), checksum);
    ImportResult one;
    const bool there = take_block(name, settings, channels, one);
    if (common.prints_text() && blocks.size() > 1)
      std::printf("  block %zu of %zu%s\n", names.size() + 1, blocks.size(), there ? " is there" : "");
    if (!there) one = write_block(reader, device, settings, scope, common, name, block);
    add_nonfinite(one, all), add_errors(one.errors, all.errors);
    names.push_back(name);
  }
  all.given = {0, reader.description().dims[3]};
  try {
    join_blocks(device, names, scope, settings.overwrite != 0, all.report);
  } catch (const Error& e) {
    if (e.code() == Code::bound_not_met) names.clear(), remove_all_blocks(scope.output);
    throw;
  }
  names.clear();
  remove_all_blocks(scope.output);
  set_peaks(device, scope.output, all.errors);
  return all;
}

} // namespace

ImportResult write_blocks(FrameReader& reader, const Device& device, std::vector<WriterSettings>& attempts,
                          const ImportScope& scope, const CommonOptions& common,
                          const std::vector<SampleBox>& blocks) {
  return with_finer_steps(attempts, common, false, [&](const WriterSettings& settings) {
    return write_blocks_once(reader, device, settings, scope, common, blocks);
  });
}

} // namespace bcc4

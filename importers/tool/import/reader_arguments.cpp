// SPDX-License-Identifier: Apache-2.0
// Parses the options in one place, whether they are typed or recalled from a file. A file keeps all but the
// list of times, which may be long or a file: without a spacing or a step of time some sources cannot be
// read.
#include "tool/import/reader_arguments.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "readers/byte_stream.h"
#include "readers/system.h"
#include "tool/cli.h"

namespace bcc4 {
namespace {

const Choices<GapPolicy> kGaps{{"error", GapPolicy::error},
                               {"hold", GapPolicy::hold},
                               {"skip", GapPolicy::skip},
                               {"interpolate", GapPolicy::interpolate}};

std::array<uint64_t, 4> parse_dims(const std::string& text) {
  std::string commas = text;
  std::replace(commas.begin(), commas.end(), 'x', ',');
  const auto parts = split_commas(commas);
  if (parts.size() != 3 && parts.size() != 4)
    fail_usage("--dims ", text, ": NX,NY,NZ or NX,NY,NZ,NT is expected, such as 64,64,64,99");
  std::array<uint64_t, 4> dims{1, 1, 1, 0};
  for (size_t a = 0; a < parts.size(); ++a) {
    dims[a] = option_number<uint64_t>("--dims", parts[a]);
    if (dims[a] < 1 || dims[a] > INT32_MAX)
      fail_usage("--dims ", text, ": each size must be 1 to ", INT32_MAX);
  }
  return dims;
}

Type parse_type(const std::string& text) {
  static const std::vector<std::string> names{"u8", "i8", "u16", "i16", "u32", "i32", "f16", "f32", "f64"};
  const auto type = type_by_name(text);
  if (!type) fail_usage("--dtype ", text, ": must be ", join(names, " or "), did_you_mean(text, names));
  return *type;
}

std::vector<double> parse_times(const std::string& text) {
  std::error_code ignored;
  if (!std::filesystem::exists(to_path(text), ignored)) return option_numbers("--times", text, 0);
  std::vector<double> times;
  const std::string content = read_text_file(text, 256 << 20);
  for (const std::string_view line : split(content, "\r\n")) {
    const auto numbers = parse_numbers(split(line.substr(0, line.find('#')), " \t,;"));
    if (!numbers) fail_input(text, ": \"", line.substr(0, 60), "\" is not a list of times");
    times.insert(times.end(), numbers->begin(), numbers->end());
  }
  return times;
}

void set_option(ReaderOptions& o, const std::string& key, const std::string& text) {
  const std::string option = "--" + key;
  if (key == "dims") o.dims = parse_dims(text);
  if (key == "dtype") o.dtype = parse_type(text);
  if (key == "endian") o.big_endian = option_choice<bool>(option, text, {{"little", false}, {"big", true}});
  if (key == "skip") o.skip = option_number<uint64_t>(option, text);
  if (key == "count") {
    o.count = option_number<uint64_t>(option, text);
    if (*o.count < 1 || *o.count > 4096) fail_usage("--count ", text, ": 1 to 4096 arrays");
  }
  if (key == "axes") o.axes = lower(text);
  if (key == "grid") o.grids = option_names(option, text);
  if (key == "level-set")
    o.level_set_fog = option_choice<bool>(option, text, {{"distance", false}, {"fog", true}});
  if (key == "channel") o.channels = option_names(option, text);
  if (key == "frames") o.frames = parse_frame_selection(text);
  if (key == "gaps") o.gaps = option_choice(option, text, kGaps);
  if (key == "times") o.times = parse_times(text);
  if (key == "dt") {
    o.dt = option_number<double>(option, text);
    if (!(*o.dt > 0) || !std::isfinite(*o.dt)) fail_usage("--dt ", text, ": a time step must be positive");
  }
  if (key == "spacing") {
    const auto s = option_numbers(option, text, 3);
    for (const double v : s)
      if (!(v > 0)) fail_usage("--spacing ", text, ": must be positive");
    o.spacing = {s[0], s[1], s[2]};
  }
  if (key == "origin") {
    const auto s = option_numbers(option, text, 3);
    o.origin = {s[0], s[1], s[2]};
  }
}

// All but "times".
constexpr const char* kRecorded[] = {"dims",   "dtype", "endian", "skip",      "count",   "axes",   "spacing",
                                     "origin", "dt",    "grid",   "level-set", "channel", "frames", "gaps"};

} // namespace

void add_reader_options(const Command& command, ReaderArguments& arguments) {
  using Row = std::array<const char*, 3>;
  static constexpr Row common[] = {
      {"dims", "NX,NY,NZ[,NT]", "Raw: samples along x, y, z and time"},
      {"dtype", "TYPE", "Raw: u8, i8, u16, i16, u32, i32, f16, f32 or f64"},
      {"spacing", "SX,SY,SZ", "Distance between samples; replaces what the file says"},
      {"dt", "TIME", "Time between neighbouring frames of the source; replaces what the file says"},
      {"grid", "NAME[,NAME]", "OpenVDB: grids to read, one channel each"},
      {"channel", "NAME[,NAME]", "Other formats: arrays or components to read, one for each channel"},
      {"frames", "A-B[xS]",
       "Frames to take, by the numbers in the file names, else counted from 0; S: every S-th"},
  };
  static constexpr Row rare[] = {
      {"endian", "little|big", "Raw: byte order (default little)"},
      {"skip", "BYTES", "Raw: bytes before the data"},
      {"count", "N",
       "Raw: arrays in each frame, one for each channel. --axes says where they are (c), if not one after "
       "the other"},
      {"axes", "ORDER",
       "Raw, NRRD, MetaImage, NetCDF: axes as the file has them, fastest first, such as xyzt or zyxt; of raw "
       "files and NRRD also cxyzt (c: channels). TIFF: whether pages or files are planes (xyz) or moments "
       "(xyt)"},
      {"origin", "X,Y,Z", "Place of the first sample; replaces what the file says"},
      {"times", "LIST|FILE", "Times of all frames: numbers with commas, or a text file"},
      {"level-set", "distance|fog",
       "OpenVDB: read level sets as signed distances (default), or as fog: 1 inside, falling to 0 at the "
       "surface"},
      {"gaps", "error|hold|skip|interpolate",
       "What to do where a numbered sequence lacks frames: stop (default), repeat the frame before, close "
       "up, or blend the neighbours"},
  };
  const auto add = [&arguments](const Command& under, const Row& row) {
    under.add_text(concat("--", row[0]), row[1], row[2],
                   [&arguments, key = std::string(row[0])](const std::string& text) {
                     set_reader_option(arguments, key, text);
                   });
  };
  for (const Row& row : common) add(command.under("How the input is read"), row);
  for (const Row& row : rare) add(command.under("Input that is read otherwise", "input"), row);
}

void set_reader_option(ReaderArguments& arguments, const std::string& key, const std::string& text) {
  set_option(arguments.options, key, text);
  arguments.texts.emplace_back(key, text);
}

std::vector<std::pair<std::string, std::string>> reader_attributes(const ReaderArguments& arguments) {
  std::vector<std::pair<std::string, std::string>> out;
  for (const auto& [key, text] : arguments.texts)
    if (std::find(std::begin(kRecorded), std::end(kRecorded), key) != std::end(kRecorded))
      out.emplace_back("import." + key, text);
  return out;
}

void recall_reader_options(const Volume& volume, ReaderArguments& arguments) {
  for (const char* key : kRecorded) {
    const bool given = std::any_of(arguments.texts.begin(), arguments.texts.end(),
                                   [&](const auto& entry) { return entry.first == key; });
    const char* value = nullptr;
    if (given ||
        bccsplat_volume_find_attribute(volume.get(), concat("import.", key).c_str(), &value) != BCCSPLAT_OK)
      continue;
    set_option(arguments.options, key, value);
  }
}

} // namespace bcc4

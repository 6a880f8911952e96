// SPDX-License-Identifier: Apache-2.0
// Has frames read ahead (read_series.h), hands them to the library's writer and records in the file where
// they come from. Where a PSNR is missed it begins again, first with finer steps, in the end with
// corrections.
#include "tool/import/write_series.h"

#include <cstdio>
#include <exception>
#include <set>

#include "readers/text.h"
#include "series/read_series.h"
#include "series/scan.h"
#include "tool/import/air_in_file.h"
#include "tool/import/part_frames.h"
#include "tool/import/resume.h"
#include "tool/import/writer_choices.h"
#include "tool/run_watch.h"

namespace bcc4 {
namespace {

std::string counts_text(const std::vector<uint64_t>& counts) {
  std::string text;
  for (const uint64_t n : counts) text += concat(text.empty() ? "" : " ", n);
  return text;
}

void record_origin(const Writer& writer, const SeriesDescription& s, const WriterSettings& settings,
                   const ImportScope& scope) {
  std::set<std::string> told;
  const auto attribute = [&](const std::string& key, const std::string& value) {
    check(bccsplat_writer_set_attribute(writer.get(), utf8_of(key).c_str(), utf8_of(value).c_str()), key);
    told.insert(key);
  };
  attribute("import.format", s.format);
  attribute("import.times", s.times.origin);
  if (const std::string filtering = filtering_text(settings); !filtering.empty())
    attribute("import.filtering", filtering);
  if (settings.fixed_predictions) attribute(kPredictions, "fixed");
  for (const auto& [key, value] : s.attributes) attribute(key, value);
  for (const auto& [key, value] : scope.attributes) attribute(key, value);
  for (size_t c = 0; c < s.channels.size(); ++c) // what the file has the nearest float of
    if (const double air = settings.values[c].air; air != static_cast<float>(air))
      attribute(air_attribute(s.channels[c].name), concat(air));
  for (const Channel& c : s.channels)
    if (!c.active.empty()) attribute("openvdb.active." + c.name, counts_text(c.active));
  for (const auto& [key, value] : scope.kept)
    if (!told.contains(key)) attribute(key, value);
  for (const PlannedSource& f : scope.sources)
    check(bccsplat_writer_add_source(writer.get(), utf8_of(f.name).c_str(), f.bytes, f.crc32), f.name);
}

// A frame without any value would be the one before it once more, and filtered with its neighbours.
void refuse_missing_frame(const FrameReader& reader, uint64_t frame, uint64_t nonfinite,
                          const WriterSettings& settings) {
  const auto& n = reader.description().dims;
  if (!settings.lowpass || settings.nonfinite != BCCSPLAT_NONFINITE_HOLE || n[3] < 2) return;
  if (nonfinite < n[0] * n[1] * n[2]) return;
  fail_input(
      reader.frame_name(frame), ": frame ", frame,
      " has no value at all, and --lowpass would filter its neighbours with a frame that is not there: "
      "without --lowpass it becomes what lies between them");
}

ImportResult write_file(FrameReader& reader, const Device& device, const WriterSettings& settings,
                        const ImportScope& scope, const CommonOptions& common, UnfinishedImport& import) {
  const SeriesDescription& s = reader.description();
  auto part = sized<bccsplat_series_part>();
  const bool is_part = scope.part || scope.block;
  const FrameSpan frames = scope.part.value_or(FrameSpan{0, s.dims[3]});
  part.first = frames.first, part.end = frames.end;
  part.lead = scope.lead;
  part.times = s.times.values.data();
  for (size_t a = 0; a < 3 && scope.block; ++a) {
    part.box_begin[a] = scope.block->begin[a];
    part.box_end[a] = scope.block->begin[a] + scope.block->dims[a];
  }
  const bool anew = settings.partial != BCCSPLAT_PARTIAL_RESUME && !common.quiet;
  const std::string unfinished = anew ? unfinished_work(device, scope.output) : "";
  const Writer writer =
      create_writer(device, scope.output, s, settings, s.dims[3], is_part ? &part : nullptr);
  import.begun();
  if (!unfinished.empty())
    std::fprintf(stderr, "bcc4: %s is begun anew; --resume would have gone on with it\n", unfinished.c_str());
  record_origin(writer, s, settings, scope);

  ImportResult result;
  result.given = wanted_frames(writer);
  const SampleBox wanted = wanted_box(writer);
  result.nonfinite.resize(s.channels.size());
  RunWatch watch(common.prints_text());
  const auto take = [&](uint64_t f, uint32_t c, const Frame& values) {
    const uint64_t nonfinite = count_nonfinite(values);
    refuse_missing_frame(reader, f, nonfinite, settings);
    add_frame(writer, c, s.times.values[f], values, reader.frame_name(f));
    if (nonfinite > 0) result.nonfinite[c][f] = nonfinite;
  };
  read_series(reader, result.given, "import", watch, take, &wanted);
  check(bccsplat_writer_finish(writer.get(), &result.report), scope.output);
  result.errors = measured_errors(writer, s.channels.size(), result.report.frames_measured);
  return result;
}

} // namespace

void add_frame(const Writer& writer, uint32_t channel, double time, const Frame& frame,
               const std::string& name) {
  const std::vector<bccsplat_box> boxes = library_boxes(frame);
  check(bccsplat_writer_add_frame(writer.get(), channel, time, boxes.data(), boxes.size()), name);
}

ImportResult write_once(FrameReader& reader, const Device& device, const WriterSettings& settings,
                        const ImportScope& scope, const CommonOptions& common) {
  UnfinishedImport unfinished(scope.output, common.quiet);
  try {
    ImportResult result = write_file(reader, device, settings, scope, common, unfinished);
    unfinished.finished();
    return result;
  } catch (const Error& e) {
    if (e.code() == Code::bound_not_met) unfinished.missed_its_bound();
    if (e.code() == Code::wrong_state) unfinished.finished(); // what is there stays as it is
    throw;
  }
}

std::string filtering_text(const WriterSettings& settings) { return settings.lowpass ? "lowpass" : ""; }

ImportResult with_finer_steps(std::vector<WriterSettings>& attempts, const CommonOptions& common,
                              bool resumes, const std::function<ImportResult(const WriterSettings&)>& write) {
  std::exception_ptr first_refusal; // of what is resumed
  for (;;) try {
      return write(attempts.front());
    } catch (const Error& e) {
      const bool unlike = resumes && e.code() == Code::wrong_state;
      if (!unlike && e.code() != Code::bound_not_met) throw;
      if (unlike && !first_refusal) first_refusal = std::current_exception();
      if (attempts.size() == 1 && unlike) std::rethrow_exception(first_refusal);
      if (attempts.size() == 1) throw;
      attempts.erase(attempts.begin());
      if (common.prints_text() && !unlike)
        std::printf("  %s; again with %s\n", e.what(),
                    attempts.front().abs_error > 0 ? "corrections" : "finer steps");
    }
}

ImportResult write_series(FrameReader& reader, const Device& device, std::vector<WriterSettings>& attempts,
                          const ImportScope& scope, const CommonOptions& common) {
  return with_finer_steps(
      attempts, common, attempts.front().partial == BCCSPLAT_PARTIAL_RESUME,
      [&](const WriterSettings& settings) { return write_once(reader, device, settings, scope, common); });
}

ImportResult append_series(FrameReader& reader, const Device& device, const WriterSettings& settings,
                           const ImportScope& scope, const CommonOptions& common) {
  try {
    return write_once(reader, device, settings, scope, common);
  } catch (const Error& e) {
    if (e.code() != Code::wrong_state) throw;
    if (common.prints_text()) std::printf("  %s\n  reading all frames\n", e.what());
  }
  ImportScope whole = scope;
  whole.part.reset();
  whole.lead = 0;
  return write_once(reader, device, settings, whole, common);
}

} // namespace bcc4

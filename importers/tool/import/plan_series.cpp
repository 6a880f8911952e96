// SPDX-License-Identifier: Apache-2.0
// Describes a series to the library as any host does, hands it the frames of the reader, and takes over what
// it has chosen, with all that is to be tried where a PSNR is missed.
#include "tool/import/plan_series.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <set>

#include "tool/progress.h"

namespace bcc4 {
namespace {

using Plan = bccsplat::client::Plan;

// Gives a plan the frames of a reader, and holds what went wrong with one.
struct PlannedFrames {
  FrameReader& reader;
  bool asked = false;
  std::exception_ptr error{};

  static int32_t give(void* user, uint64_t frame, uint32_t channel, const uint64_t* begin,
                      const uint64_t* end, bccsplat_source_boxes* out) {
    struct Held {
      Frame frame;
      std::vector<bccsplat_box> boxes;
    };
    auto& own = *static_cast<PlannedFrames*>(user);
    own.asked = true;
    try {
      const auto& n = own.reader.description().dims;
      SampleBox wanted;
      for (size_t a = 0; a < 3; ++a) wanted.begin[a] = begin[a], wanted.dims[a] = end[a] - begin[a];
      const bool whole = own.reader.frames_fit() && wanted == SampleBox{{}, {n[0], n[1], n[2]}};
      auto held = std::make_unique<Held>();
      held->frame = whole ? own.reader.read(frame, channel) : own.reader.read_box(frame, channel, wanted);
      held->boxes = library_boxes(held->frame);
      out->boxes = held->boxes.data(), out->count = held->boxes.size();
      out->release = [](void* keeper) { delete static_cast<Held*>(keeper); };
      out->keeper = held.release();
      return 0;
    } catch (...) {
      own.error = std::current_exception();
      return 1;
    }
  }
};

std::vector<bccsplat_plan_channel> channels_of(const SeriesDescription& s, const PlanWish& wish) {
  std::vector<bccsplat_plan_channel> channels;
  for (size_t c = 0; c < s.channels.size(); ++c) {
    const Channel& channel = s.channels[c];
    auto& out = channels.emplace_back(sized<bccsplat_plan_channel>());
    out.type = library_type(channel.type), out.missing = channel.has_fill ? 1 : 0;
    out.kind = wish.kinds[c];
    out.step = channel.step, out.offset = channel.offset;
    out.active = channel.active.size() == s.dims[3] ? channel.active.data() : nullptr;
  }
  return channels;
}

WriterSettings settings_of(const Plan& plan, const WriterSettings& asked) {
  WriterSettings s;
  check(bccsplat_plan_get_writer_options(plan.get(), &s), "");
  s.values.assign(s.channels, s.channels + s.channel_count);
  if (s.wavelet_errors) s.mean_errors.assign(s.wavelet_errors, s.wavelet_errors + s.channel_count);
  if (s.abs_errors) s.largest_errors.assign(s.abs_errors, s.abs_errors + s.channel_count);
  if (s.recommended_kernel) s.kernel = s.recommended_kernel;
  s.progress = nullptr, s.progress_user = nullptr;
  s.nonfinite = asked.nonfinite, s.measure = asked.measure; // none among them
  return s;
}

} // namespace

void plan_series(FrameReader& reader, const Device& device, const WriterSettings& settings,
                 const PlanWish& wish, const std::string& output, bool shown, ImportPlan& plan) {
  const SeriesDescription& s = plan.series;
  SeriesOptions asked = series_options(s, settings);
  asked.options.nonfinite = settings.nonfinite;
  Progress line("plan", Progress::fraction_steps, false, !shown);
  asked.options.progress = Progress::show_fraction, asked.options.progress_user = &line;
  const std::vector<bccsplat_plan_channel> channels = channels_of(s, wish);
  PlannedFrames frames{reader};
  auto options = sized<bccsplat_plan_options>();
  const auto set = [&](bool wanted, uint32_t bit) { options.set_mask |= wanted ? bit : 0; };
  set(!wish.auto_levels, BCCSPLAT_PLAN_SET_LEVELS), set(wish.auto_time_scale, BCCSPLAT_PLAN_AUTO_TIME_SCALE);
  set(wish.everything, BCCSPLAT_PLAN_EVERYTHING), set(reader.any_thread(), BCCSPLAT_PLAN_ANY_THREAD);
  set(!reader.frames_fit(), BCCSPLAT_PLAN_LARGE_FRAMES);
  options.wish = &asked.options, options.channels = channels.data();
  options.times = s.times.values.data();
  options.boxes = PlannedFrames::give, options.frame_user = &frames;
  options.density = wish.density, options.exact = wish.exact ? 1 : 0;
  options.memory = wish.any_memory ? UINT64_MAX : 0;
  options.name = s.files.front().path.c_str();
  bccsplat_plan* made = nullptr;
  const bccsplat_status status = bccsplat_plan_create(device.get(), &options, &made);
  if (status == BCCSPLAT_CANCELLED && frames.error) std::rethrow_exception(frames.error);
  check(status, frames.asked ? "" : output);
  const Plan chosen(made);
  const char* json = nullptr;
  check(bccsplat_plan_get_json(chosen.get(), &json), "");
  plan.found = Json::parse(json), plan.auto_levels = wish.auto_levels;
  bccsplat_status finer = BCCSPLAT_OK;
  for (; finer == BCCSPLAT_OK; finer = bccsplat_plan_refine(made))
    plan.attempts.push_back(settings_of(chosen, settings));
  if (finer != BCCSPLAT_ERROR_NOT_FOUND) check(finer, "");
}

uint64_t lead_of(const Json& found, uint64_t first) {
  std::set<uint64_t> missing;
  for (const Json& channel : found.value("channels", Json::array()))
    for (const Json& frame : channel.at("missing_frames")) missing.insert(frame.get<uint64_t>());
  uint64_t lead = 0;
  while (lead < first && missing.contains(first - lead)) ++lead;
  return lead;
}

} // namespace bcc4

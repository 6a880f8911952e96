// SPDX-License-Identifier: Apache-2.0
#include "choose/series_plan.h"

#include "choose/air.h"
#include "choose/finer.h"
#include "choose/level_choice.h"
#include "choose/plan_json.h"
#include "series/text.h"

namespace bccsplat::series {
namespace {

std::string choice_text(const LatticeChoice& choice, const SeriesDescription& s) {
  const std::string steps = steps_text(choice.rounded.coding, s);
  std::string labels;
  for (size_t c = 0; c < choice.labels.size(); ++c)
    if (choice.labels[c]) labels += concat(labels.empty() ? "; labels: " : ", ", s.channels[c].name);
  return concat(shape_text(choice.chosen().shape, s.dims), steps.empty() ? "" : ", ", steps, ": ",
                decibels_text(choice.rounded.psnr), " on ", choice.sampled_frames,
                " sampled frames, the best of ", choice.candidates.size(), " lattices", labels);
}

std::string wavelets_text(const WriterSettings& settings) {
  const std::string bound = settings.psnr > 0 ? concat("at least ", settings.psnr, " dB")
                                              : concat("errors up to ", settings.abs_error);
  return concat("wavelets of ", settings.lattice == BCCSPLAT_LATTICE_CC ? "the source's samples" : "sites",
                ", rounded as far as ", bound, " allow");
}

std::string text_of(const ImportPlan& plan) {
  const SeriesDescription& s = plan.series;
  if (plan.search)
    return concat(coding_text(plan.search->chosen(), s), ": ", decibels_text(plan.search->chosen().psnr),
                  " on ", plan.search->sampled_frames, " sampled frames, the smallest of ",
                  plan.search->tried.size(), " codings tried");
  if (plan.choice) return choice_text(*plan.choice, s);
  if (plan.settings.store == BCCSPLAT_STORE_WAVELETS) return wavelets_text(plan.settings);
  return concat(shape_text(shape_of(plan.settings, s), s.dims),
                plan.still ? ", as of any single frame" : ", as given");
}

std::string levels_note(uint32_t levels) {
  return levels == 0 ? "" : concat("; ", levels, levels == 1 ? " coarser level" : " coarser levels");
}

} // namespace

SeriesPlan::SeriesPlan(FrameReader& reader, const Device& device, WriterSettings settings,
                       const SeriesWish& wish, Watch& watch)
    : series_(reader.description()), settings_(std::move(settings)), kinds_(wish.kinds) {
  settings_.own_air = dense_air(reader, settings_, wish.own_air, watch);
  settings_.levels = wish.levels.value_or(is_scattered(series_) ? 0 : levels_for(series_.dims));
  choose(reader, device, wish, watch);
  make_options();
}

void SeriesPlan::make_options() {
  options_.emplace(series_, settings_, scans_);
  for (size_t c = 0; c < kinds_.size(); ++c) // what the host says is kept, or refused by the writer
    options_->channels[c].set_mask |= kinds_[c];
  options_->options.dims[3] = static_cast<uint32_t>(series_.dims[3]);
  options_->options.partial = settings_.partial, options_->options.live = settings_.live;
}

void SeriesPlan::choose(FrameReader& reader, const Device& device, const SeriesWish& wish, Watch& watch) {
  Unsettled unsettled = static_cast<const Unsettled&>(wish); // what it shares with a wish
  unsettled.auto_lattice = wish.density > 0 || (!wish.auto_time_scale && !has_distances(settings_) &&
                                                settings_.lattice == BCCSPLAT_LATTICE_DEFAULT);
  unsettled.open_store = settings_.live == 0 && settings_.partial != BCCSPLAT_PARTIAL_APPEND;
  unsettled.progress = &watch;
  ImportPlan plan{series_, settings_};
  plan.levels.automatic = !wish.levels;
  plan.levels.scattered = !wish.levels && is_scattered(series_);
  settle_import(reader, device, unsettled, settings_, plan);
  text_ = text_of(plan) + levels_note(settings_.levels), json_ = json_of_plan(plan);
  scans_ = std::move(plan.scans);
}

bool SeriesPlan::refine() {
  const char* const remedy = make_finer(series_, scans_, missed_, settings_);
  if (!remedy) return false;
  ++missed_;
  make_options();
  text_ += concat("; again with ", remedy);
  return true;
}

} // namespace bccsplat::series

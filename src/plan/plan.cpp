// SPDX-License-Identifier: Apache-2.0
// The plan functions of the C API: src/choose behind a handle.
#include <cmath>
#include <cstring>

#include "api/handles.h"
#include "api/structs.h"
#include "plan/host_series.h"

using namespace bccsplat;
using namespace bccsplat::api;

struct bccsplat_plan : Object<Kind::plan> {
  bccsplat_plan(series::FrameReader& reader, const series::Device& device, const plan::Request& request,
                series::Watch& watch, const bccsplat_writer_options& wish)
      : chosen(reader, device, request.settings, request.wish, watch), progress(wish.progress),
        progress_user(wish.progress_user) {}

  mutable Users users;
  series::SeriesPlan chosen;
  bccsplat_progress_fn progress; // as the host gave it, for the writer
  void* progress_user;
};

namespace {

// Makes a fraction of what is told of a work whose length nobody knows: a pass over the frames, then trials.
class HostWatch : public series::Watch {
 public:
  HostWatch(Progress& progress, bccsplat_cancel_token* token) : progress_(progress), token_(token) {}
  [[nodiscard]] bool ends() override {
    progress_.check();
    return false;
  }
  [[nodiscard]] bccsplat_cancel_token* token() override { return token_; }
  void show(const series::WorkDone& work) override {
    constexpr double pass = 0.3, per_trial = 0.95;
    const auto done = static_cast<double>(work.done);
    progress_.report(work.total > 0 ? pass * std::min(1.0, done / static_cast<double>(work.total))
                                    : 1 - (1 - pass) * std::pow(per_trial, done));
  }

 private:
  Progress& progress_;
  bccsplat_cancel_token* token_;
};

series::Device reference_to(bccsplat_device* device) {
  bccsplat_device_retain(device);
  return series::Device(device);
}

} // namespace

extern "C" {

bccsplat_status bccsplat_plan_create(bccsplat_device* device, const bccsplat_plan_options* options,
                                     bccsplat_plan** made) {
  return guard([&] {
    require(made, "plan");
    *made = nullptr;
    require(device, "device"), require(options, "options");
    const auto o = read_struct(options, "bccsplat_plan_options");
    require(o.wish, "bccsplat_plan_options.wish");
    if (!o.frame && !o.boxes) fail(Code::invalid_argument, "bccsplat_plan_options.frame is NULL");
    const auto wish = read_struct(o.wish, "bccsplat_writer_options");
    const Token token = read_token(wish.cancel_token);
    Progress progress(progress_callback(wish.progress, wish.progress_user));
    watch(progress, token);
    progress.begin_call();
    HostWatch watching(progress, wish.cancel_token);
    plan::Request request = plan::read_request(o, wish);
    plan::HostFrames frames(request.series, o);
    auto plan =
        std::make_unique<bccsplat_plan>(frames, reference_to(device), std::move(request), watching, wish);
    progress.report(1);
    *made = plan.release();
  });
}

bccsplat_status bccsplat_plan_get_writer_options(const bccsplat_plan* plan,
                                                 bccsplat_writer_options* options) {
  return guard([&] {
    const Shared use(plan, "plan");
    bccsplat_writer_options complete = plan->chosen.options();
    complete.progress = plan->progress, complete.progress_user = plan->progress_user;
    write_struct(options, complete, "options");
  });
}

bccsplat_status bccsplat_plan_get_text(const bccsplat_plan* plan, const char** text) {
  return guard([&] {
    const Shared use(plan, "plan");
    require(text, "text");
    *text = plan->chosen.text().c_str();
  });
}

bccsplat_status bccsplat_plan_get_json(const bccsplat_plan* plan, const char** json) {
  return guard([&] {
    const Shared use(plan, "plan");
    require(json, "json");
    *json = plan->chosen.json().c_str();
  });
}

bccsplat_status bccsplat_plan_refine(bccsplat_plan* plan) {
  return guard([&] {
    const Alone use(plan, "plan");
    if (!plan->chosen.refine())
      fail(Code::not_found,
           "plan: nothing is left that would bring the file nearer to its psnr; ask for less");
  });
}

void bccsplat_plan_retain(bccsplat_plan* plan) { retain(plan); }
void bccsplat_plan_release(bccsplat_plan* plan) { release(plan); }

} // extern "C"

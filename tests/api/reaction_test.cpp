// SPDX-License-Identifier: Apache-2.0
// How soon a long call hears its host: with one thread, the processor time from one progress call to the next
// and from a cancelling answer to the return stays below 0.1 s, whatever the call is doing. Processor time,
// so that a busy machine does not matter.
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <iostream>
#include <vector>

#include "support.h"

using namespace host;

namespace {

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

// Progress that remembers the longest it was left alone and cancels at the call of that number.
struct Watch {
  int cancel_at = 0; // 0: never
  int calls = 0;
  double last = cpu_seconds(), longest = 0, cancelled = 0, fraction = 0;

  static int32_t report(void* user, double fraction) {
    auto& w = *static_cast<Watch*>(user);
    const double now = cpu_seconds();
    w.longest = std::max(w.longest, now - w.last);
    w.last = now;
    EXPECT_GE(fraction, w.fraction);
    w.fraction = fraction;
    if (++w.calls != w.cancel_at) return 0;
    w.cancelled = now;
    return 1;
  }
};

// Sanitizers and emulators slow some stages more than others: under them the calls are made and cancelled,
// and not timed.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(BCCSPLAT_EMULATED)
constexpr bool timed = false;
#else
constexpr bool timed = true;
#endif
constexpr double limit = timed ? 0.1 : 60; // seconds of one core, 60: none

// A run to the end, then runs cancelled early and in the middle.
template<class Call> void expect_prompt(const char* name, const Call& call) {
  Watch whole;
  const double begin = cpu_seconds();
  ASSERT_EQ(call(whole), BCCSPLAT_OK) << name << ": " << bccsplat_last_error();
  const double end = cpu_seconds();
  whole.longest = std::max(whole.longest, end - whole.last);
  std::cout << name << ": " << end - begin << " s, " << whole.calls << " reports, at most " << whole.longest
            << " s apart";
  EXPECT_GE(whole.calls, 2) << name;
  EXPECT_LT(whole.longest, limit) << name;
  for (const int at : {1, 1 + whole.calls / 2}) {
    Watch w;
    w.cancel_at = at;
    const bccsplat_status status = call(w);
    if (w.cancelled == 0 && at > 1) { // a shorter run than the first
      EXPECT_EQ(status, BCCSPLAT_OK);
      continue;
    }
    const double reaction = cpu_seconds() - w.cancelled;
    std::cout << "; cancelled in " << reaction << " s";
    EXPECT_EQ(status, BCCSPLAT_CANCELLED) << name << " at report " << at;
    EXPECT_LT(reaction, limit) << name;
  }
  std::cout << "\n";
}

Series large() {
  Series s;
  s.nx = s.ny = s.nz = 112, s.nt = 4;
  s.field = [](double x, double y, double z, double t) {
    const double dx = x - 50 - 2 * t, dy = y - 56, dz = z - 58;
    return std::exp(-(dx * dx + dy * dy + dz * dz) / 1200) * (2 + std::sin(0.8 * x) * std::sin(0.9 * y + t)) +
           0.2;
  };
  return s;
}

class Reaction : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    path = (std::filesystem::temp_directory_path() /
            ("bccsplat-reaction-" + std::to_string(::getpid()) + ".bcc4"))
               .string();
    (void)write_series(make_device(2), path, large());
  }
  static void TearDownTestSuite() { std::filesystem::remove(path); }
  static inline std::string path;
  Device device = make_device(1);
};

TEST_F(Reaction, Writer) {
  const Folder folder;
  const Series s = large();
  // The frames are made beforehand: only the library's time counts.
  std::vector<std::vector<float>> frames(s.nt);
  for (uint32_t t = 0; t < s.nt; ++t)
    for (uint32_t z = 0; z < s.nz; ++z)
      for (uint32_t y = 0; y < s.ny; ++y)
        for (uint32_t x = 0; x < s.nx; ++x) frames[t].push_back(static_cast<float>(s.field(x, y, z, t)));
  expect_prompt("import", [&](Watch& w) {
    auto o = options_of(s);
    o.overwrite = 1;
    o.progress = Watch::report, o.progress_user = &w;
    const Writer writer = make_writer(device, folder.file("s.bcc4"), o);
    for (uint32_t t = 0; t < s.nt; ++t) {
      auto box = sized<bccsplat_box>();
      box.type = BCCSPLAT_TYPE_F32, box.data = frames[t].data();
      box.dims[0] = s.nx, box.dims[1] = s.ny, box.dims[2] = s.nz;
      if (const auto status = bccsplat_writer_add_frame(writer.get(), 0, t, &box, 1)) return status;
    }
    return bccsplat_writer_finish(writer.get(), nullptr);
  });
}

TEST_F(Reaction, Verify) {
  const Volume volume = open(device, path);
  expect_prompt("verify", [&](Watch& w) {
    auto report = sized<bccsplat_verify_report>();
    return bccsplat_volume_verify(volume.get(), Watch::report, &w, &report);
  });
}

TEST_F(Reaction, Slices) {
  const auto cut_with = [&](double a, double d, double e, double begin) {
    return [=, this](Watch& w) {
      const Volume volume = open(device, path); // cold: the prefilter is part of it
      auto h = sized<bccsplat_hyperplane>();
      h.a = a, h.d = d, h.e = e;
      auto o = sized<bccsplat_slice_options>();
      o.interval[0] = begin;
      o.progress = Watch::report, o.progress_user = &w;
      bccsplat_slice* s = nullptr;
      const bccsplat_status status = bccsplat_slice_create(volume.get(), &h, &o, &s);
      bccsplat_slice_release(s);
      return status;
    };
  };
  expect_prompt("time slice", cut_with(0, 1, -1.5, 0));
  expect_prompt("mean over an interval", cut_with(0, 1, -2, -2));
  expect_prompt("axis slice", cut_with(1, 0, -50.3, 0));
  expect_prompt("oblique slice", cut_with(0.02, 1, -2.5, 0));
}

// What was reported while one slice was cut.
struct FractionTrace {
  double begin = cpu_seconds(), total = 0;
  std::vector<std::array<double, 2>> reports; // processor time, fraction

  static int32_t report(void* user, double fraction) {
    auto& t = *static_cast<FractionTrace*>(user);
    t.reports.push_back({cpu_seconds() - t.begin, fraction});
    return 0;
  }
  [[nodiscard]] size_t steps() const {
    double before = 0;
    size_t n = 0;
    for (const auto& r : reports) n += r[1] > before, before = r[1];
    return n;
  }
  // The most that a fraction is away from the share of the time that had passed.
  [[nodiscard]] double off() const {
    double most = 0;
    for (const auto& [at, fraction] : reports) most = larger(most, std::fabs(fraction - at / total));
    return most;
  }
};

struct TimedCut {
  const char* name;
  double a, d, e, thickness;
  int32_t slab;
};

FractionTrace trace_of(const std::string& path, const TimedCut& cut, int threads) {
  const Device device = make_device(threads);
  const Volume volume = open(device, path);
  auto h = sized<bccsplat_hyperplane>();
  h.a = cut.a, h.d = cut.d, h.e = cut.e;
  auto o = sized<bccsplat_slice_options>();
  o.thickness = cut.thickness, o.slab = cut.slab;
  FractionTrace trace;
  o.progress = FractionTrace::report, o.progress_user = &trace;
  bccsplat_slice* s = nullptr;
  EXPECT_OK(bccsplat_slice_create(volume.get(), &h, &o, &s));
  trace.total = cpu_seconds() - trace.begin;
  bccsplat_slice_release(s);
  return trace;
}

// Fractions of slices: they rise with the work that is done and end at 1, once the slice is there. A busy
// machine stretches some stages more than others, so that the nearest of three runs is judged.
TEST_F(Reaction, FractionsOfSlices) {
  constexpr TimedCut cuts[] = {
      {"time", 0, 1, -1.5, 0, BCCSPLAT_SLAB_MEAN},
      {"axis", 1, 0, -50.3, 0, BCCSPLAT_SLAB_MEAN},
      {"oblique", 0.02, 1, -2.5, 0, BCCSPLAT_SLAB_MEAN},
      {"mean over time", 0, 1, -1.5, 1, BCCSPLAT_SLAB_MEAN},
      {"maximum over time", 0, 1, -1.5, 0.1, BCCSPLAT_SLAB_MAXIMUM},
      {"oblique slab", 0.02, 1, -2.5, 0.1, BCCSPLAT_SLAB_SUM},
  };
  constexpr double furthest = 0.5;
  for (const int threads : {1, 2})
    for (const TimedCut& cut : cuts) {
      double off = 1;
      bool often =
          false; // whether half of the reports tell something new: the best of some runs, as of `off`
      for (int run = 0; run < 3 && (off >= furthest || !often); ++run) {
        const FractionTrace trace = trace_of(path, cut, threads);
        const auto& reports = trace.reports;
        ASSERT_GE(reports.size(), 2u) << cut.name;
        EXPECT_TRUE(std::is_sorted(reports.begin(), reports.end(), [](const auto& a, const auto& b) {
          return a[1] < b[1];
        })) << cut.name;
        EXPECT_EQ(reports.back()[1], 1) << cut.name;
        EXPECT_LT(reports.front()[1], 0.5) << cut.name;
        const bool tells = timed && reports.size() >= 6; // a short call tells less
        often = often || !tells || 2 * trace.steps() >= reports.size();
        off = tells ? std::min(off, trace.off()) : 0;
        std::cout << cut.name << ", " << threads << " threads: " << reports.size() << " reports, "
                  << trace.steps() << " steps, at most " << trace.off() << " from the share of time\n";
      }
      EXPECT_LT(off, furthest) << cut.name;
      EXPECT_TRUE(often) << cut.name;
    }
}

TEST_F(Reaction, Pictures) {
  const Volume volume = open(device, path);
  const auto render_with = [&](bool trail, bool reference, uint32_t size) {
    return [=, this, &volume](Watch& w) {
      const Slice slice = cut_time(volume, 2); // new: its points are made anew
      bccsplat_renderer* r = nullptr;
      EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
      const Renderer renderer(r);
      EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
      auto t = sized<bccsplat_trail>();
      t.interval[0] = -1;
      EXPECT_OK(bccsplat_renderer_set_trail(r, trail ? &t : nullptr));
      auto o = sized<bccsplat_render_options>();
      o.reference = reference;
      o.progress = Watch::report, o.progress_user = &w;
      EXPECT_OK(bccsplat_renderer_set_options(r, &o));
      bccsplat_frame* f = nullptr;
      EXPECT_OK(bccsplat_frame_create(device.get(), size, size, BCCSPLAT_FRAME_RGBA, &f));
      const Frame frame(f);
      w.last = cpu_seconds();
      return bccsplat_renderer_render(r, f);
    };
  };
  expect_prompt("picture", render_with(false, false, 512));
  expect_prompt("trail", render_with(true, false, 256));
  expect_prompt("reference", render_with(false, true, 32));
}

} // namespace

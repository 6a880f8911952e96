// SPDX-License-Identifier: Apache-2.0
// Hosts that trap on invalid numbers, round upwards or flush denormals: they get what all others get, and
// keep what they have.
#include <cfenv>
#include <fstream>
#include <iterator>
#include <thread>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

#include "support.h"

using namespace host;

namespace {

constexpr int trapped = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW | FE_UNDERFLOW;
[[maybe_unused]] constexpr unsigned flush_to_zero = 0x8040; // both bits of MXCSR

#if defined(_WIN32) // whose C library has no calls for traps: a flag's mask is seven bits above it
int fegetexcept() { return static_cast<int>(~_mm_getcsr() >> 7) & FE_ALL_EXCEPT; }
int feenableexcept(int flags) {
  const int before = fegetexcept();
  _mm_setcsr(_mm_getcsr() & ~(static_cast<unsigned>(flags) << 7));
  return before;
}
void fedisableexcept(int flags) { _mm_setcsr(_mm_getcsr() | static_cast<unsigned>(flags) << 7); }
#endif

// What this thread traps from now on: nothing where the machine has no traps, as most of 64-bit ARM.
int trap() { return feenableexcept(trapped) < 0 ? 0 : trapped; }

// Values down to denormal ones, worked out beforehand: nothing of it is a test's own arithmetic.
std::vector<std::vector<float>> frames_of(const Series& s) {
  std::vector<std::vector<float>> frames;
  for (uint32_t t = 0; t < s.nt; ++t) {
    auto& frame = frames.emplace_back();
    for (uint32_t z = 0; z < s.nz; ++z)
      for (uint32_t y = 0; y < s.ny; ++y)
        for (uint32_t x = 0; x < s.nx; ++x) frame.push_back(static_cast<float>(1e-36 * blob(x, y, z, t)));
  }
  return frames;
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// A file, a field and a picture, made through a device.
struct Work {
  std::vector<float> values, gradients, picture;
  std::string file;

  Work(const Folder& folder, const Device& device, const std::vector<std::vector<float>>& frames) {
    const Series series;
    auto o = options_of(series);
    o.overwrite = 1;
    const Writer writer = make_writer(device, folder.file("f.bcc4"), o);
    auto box = sized<bccsplat_box>();
    box.type = BCCSPLAT_TYPE_F32;
    box.dims[0] = series.nx, box.dims[1] = series.ny, box.dims[2] = series.nz;
    for (size_t t = 0; t < frames.size(); ++t) {
      box.data = frames[t].data();
      EXPECT_OK(bccsplat_writer_add_frame(writer.get(), 0, static_cast<double>(t), &box, 1));
    }
    EXPECT_OK(bccsplat_writer_finish(writer.get(), nullptr));
    const Volume volume = open(device, folder.file("f.bcc4"));
    const double at[8] = {8.2, 9.1, 8.7, 1.5, 3.3, 4.1, 15, 6};
    values.resize(2), gradients.resize(8);
    EXPECT_OK(bccsplat_volume_evaluate(volume.get(), 2, at, values.data(), gradients.data()));
    const Slice slice = cut(volume, 0, 0, 0, 1, -2.25);
    bccsplat_renderer* r = nullptr;
    EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
    const Renderer renderer(r);
    EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
    picture.resize(32 * 32 * 4);
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_wrap(device.get(), 32, 32, picture.data(), 0, &f));
    const Frame frame(f);
    EXPECT_OK(bccsplat_renderer_render(r, f));
    file = bytes_of(folder.file("f.bcc4"));
  }
  bool operator==(const Work&) const = default;
};

// Of this thread, until it ends.
struct Environment {
  std::fenv_t before;
  Environment() { std::fegetenv(&before); }
  ~Environment() { std::fesetenv(&before); }
};

class FloatEnvironment : public testing::Test {
 protected:
  Folder folder;
  std::vector<std::vector<float>> frames = frames_of({});
  Work usual{folder, make_device(2), frames};
};

TEST_F(FloatEnvironment, TrapsAreNotSprung) {
  const Environment own;
  std::feclearexcept(FE_ALL_EXCEPT);
  const int on = trap();
  const Work work(folder, make_device(2), frames); // whose threads start with the traps of this one
  EXPECT_EQ(fegetexcept(), on);
  fedisableexcept(FE_ALL_EXCEPT);
  EXPECT_TRUE(work == usual);
}

TEST_F(FloatEnvironment, FlagsStay) {
  const Device device = make_device(1);
  const Environment own;
  std::feclearexcept(FE_ALL_EXCEPT);
  std::feraiseexcept(FE_DIVBYZERO);
  (void)write_series(device, folder.file("g.bcc4"));
  const Volume volume = open(device, folder.file("g.bcc4"));
  (void)cut(volume, 0, 0, 0, 1, -2.25);
  EXPECT_EQ(std::fetestexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW | FE_UNDERFLOW), FE_DIVBYZERO);
}

TEST_F(FloatEnvironment, RoundingDoesNotMatter) {
  const Environment own;
  std::fesetround(FE_UPWARD);
  const Work work(folder, make_device(2), frames);
  EXPECT_EQ(std::fegetround(), FE_UPWARD);
  std::fesetround(FE_TONEAREST);
  EXPECT_TRUE(work == usual);
}

#if defined(__x86_64__)
TEST_F(FloatEnvironment, FlushingOfDenormalsDoesNotMatter) {
  const Environment own;
  _mm_setcsr(_mm_getcsr() | flush_to_zero);
  const Work work(folder, make_device(2), frames);
  EXPECT_EQ(_mm_getcsr() & flush_to_zero, flush_to_zero);
  _mm_setcsr(_mm_getcsr() & ~flush_to_zero);
  EXPECT_TRUE(work == usual);
}
#endif

// Threads of the host's, which trap as well.
TEST_F(FloatEnvironment, RunnersThreadsAreAsGood) {
  auto options = sized<bccsplat_device_options>();
  options.thread_count = 2;
  options.runner = [](void*, uint64_t count, bccsplat_task_fn task, void* context) {
    std::thread other([&] {
      const int on = trap();
      for (uint64_t i = 1; i < count; i += 2) task(context, i);
      EXPECT_EQ(fegetexcept(), on);
    });
    for (uint64_t i = 0; i < count; i += 2) task(context, i);
    other.join();
  };
  bccsplat_device* d = nullptr;
  ASSERT_OK(bccsplat_device_create(&options, &d));
  const Device device(d);
  EXPECT_TRUE(Work(folder, device, frames) == usual);
}

} // namespace

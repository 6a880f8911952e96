// SPDX-License-Identifier: Apache-2.0
// What a host can do wrong: every misuse has its code and text, and breaks nothing.
#include <atomic>
#include <thread>

#ifndef _WIN32
#include <sys/mman.h>
#include <sys/stat.h>
#endif

#include "support.h"

using namespace host;

namespace {

TEST(Misuse, NullEverywhere) {
  EXPECT_EQ(bccsplat_device_create(nullptr, nullptr), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(bccsplat_last_error()), "");
  const Device device = make_device();
  bccsplat_volume* v = reinterpret_cast<bccsplat_volume*>(1);
  EXPECT_EQ(bccsplat_volume_open_file(nullptr, "x", nullptr, &v), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(v, nullptr);
  EXPECT_EQ(bccsplat_volume_open_file(device.get(), nullptr, nullptr, &v), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(bccsplat_volume_get_info(nullptr, nullptr), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(bccsplat_slice_create(nullptr, nullptr, nullptr, nullptr), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(bccsplat_writer_create(device.get(), "x", nullptr, nullptr), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(bccsplat_writer_finish(nullptr, nullptr), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(bccsplat_renderer_render(nullptr, nullptr), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(bccsplat_frame_save_png(nullptr, "x", nullptr), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  bccsplat_device_release(nullptr), bccsplat_volume_release(nullptr), bccsplat_slice_release(nullptr);
  bccsplat_writer_release(nullptr), bccsplat_renderer_release(nullptr), bccsplat_frame_release(nullptr);
  bccsplat_device_retain(nullptr), bccsplat_volume_retain(nullptr);
}

template<class To, class From> To* as(const From& handle) { return reinterpret_cast<To*>(handle.get()); }

TEST(Misuse, HandlesOfAnotherKind) {
  const Folder folder;
  const Device device = make_device();
  (void)write_series(device, folder.file("s.bcc4"));
  const Volume volume = open(device, folder.file("s.bcc4"));
  const Slice slice = cut_time(volume, 2.5);
  const Writer writer = make_writer(device, folder.file("w.bcc4"), options_of({}));
  bccsplat_renderer* r = nullptr;
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  ASSERT_OK(bccsplat_frame_create(device.get(), 8, 8, BCCSPLAT_FRAME_RGBA, &f));
  const Frame frame(f);
  constexpr auto refused = BCCSPLAT_ERROR_INVALID_HANDLE;
  auto info = sized<bccsplat_volume_info>();
  auto of_slice = sized<bccsplat_slice_info>();
  EXPECT_EQ(bccsplat_volume_get_info(as<bccsplat_volume>(slice), &info), refused);
  EXPECT_EQ(bccsplat_volume_get_info(as<bccsplat_volume>(device), &info), refused);
  EXPECT_EQ(bccsplat_slice_get_info(as<bccsplat_slice>(volume), &of_slice), refused);
  EXPECT_EQ(bccsplat_renderer_set_slice(r, as<bccsplat_slice>(frame)), refused);
  EXPECT_EQ(bccsplat_renderer_render(r, as<bccsplat_frame>(renderer)), refused);
  EXPECT_EQ(bccsplat_renderer_render(as<bccsplat_renderer>(writer), f), refused);
  EXPECT_EQ(bccsplat_writer_finish(as<bccsplat_writer>(renderer), nullptr), refused);
  EXPECT_EQ(bccsplat_frame_save_png(as<bccsplat_frame>(volume), folder.file("x.png").c_str(), nullptr),
            refused);
  bccsplat_volume* v = nullptr;
  EXPECT_EQ(
      bccsplat_volume_open_file(as<bccsplat_device>(volume), folder.file("s.bcc4").c_str(), nullptr, &v),
      refused);
  EXPECT_NE(std::string(bccsplat_last_error()).find("another kind"), std::string::npos);
  bccsplat_slice_release(as<bccsplat_slice>(volume)), bccsplat_slice_retain(as<bccsplat_slice>(volume));
  EXPECT_OK(bccsplat_volume_get_info(volume.get(), &info)); // all are as they were
  EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  EXPECT_OK(bccsplat_renderer_render(r, f));
}

TEST(Misuse, ASliceOfAnotherDevice) {
  const Folder folder;
  const Device device = make_device(), other = make_device();
  (void)write_series(device, folder.file("s.bcc4"));
  const Slice slice = cut_time(open(device, folder.file("s.bcc4")), 2.5);
  bccsplat_renderer* r = nullptr;
  ASSERT_OK(bccsplat_renderer_create(other.get(), &r));
  const Renderer renderer(r);
  EXPECT_EQ(bccsplat_renderer_set_slice(r, slice.get()), BCCSPLAT_ERROR_INVALID_HANDLE);
}

// What a callback of a picture does to the renderer that draws it.
struct Meddler {
  bccsplat_renderer* renderer;
  bccsplat_frame* frame;
  std::atomic<int> calls{0}, refused{0};
  static int32_t meddle(void* self, double) {
    auto& m = *static_cast<Meddler*>(self);
    auto stats = sized<bccsplat_render_stats>();
    ++m.calls;
    m.refused += bccsplat_renderer_render(m.renderer, m.frame) == BCCSPLAT_ERROR_WRONG_STATE &&
                 bccsplat_renderer_set_slice(m.renderer, nullptr) == BCCSPLAT_ERROR_WRONG_STATE &&
                 bccsplat_renderer_set_options(m.renderer, nullptr) == BCCSPLAT_ERROR_WRONG_STATE &&
                 bccsplat_renderer_get_stats(m.renderer, &stats) == BCCSPLAT_ERROR_WRONG_STATE;
    return 0;
  }
};

TEST(Misuse, ARendererIsUsedByOneCallAtATime) {
  const Folder folder;
  const Device device = make_device();
  (void)write_series(device, folder.file("s.bcc4"));
  const Slice slice = cut_time(open(device, folder.file("s.bcc4")), 2.5);
  bccsplat_renderer* r = nullptr;
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  ASSERT_OK(bccsplat_frame_create(device.get(), 64, 64, BCCSPLAT_FRAME_RGBA, &f));
  const Frame frame(f);
  ASSERT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  Meddler meddler{r, f, {}, {}};
  auto o = sized<bccsplat_render_options>();
  o.progress = Meddler::meddle, o.progress_user = &meddler;
  ASSERT_OK(bccsplat_renderer_set_options(r, &o));
  ASSERT_OK(bccsplat_renderer_render(r, f));
  EXPECT_GT(meddler.calls, 0);
  EXPECT_EQ(meddler.refused, meddler.calls);
  ASSERT_OK(bccsplat_renderer_set_options(r, nullptr));
  // From three threads: each call draws the picture or is refused, and one at least draws it.
  std::atomic<int> drawn{0}, others{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&] {
      for (int k = 0; k < 20; ++k) {
        const bccsplat_status status = bccsplat_renderer_render(r, f);
        drawn += status == BCCSPLAT_OK;
        others += status != BCCSPLAT_OK && status != BCCSPLAT_ERROR_WRONG_STATE;
      }
    });
  for (std::thread& t : threads) t.join();
  EXPECT_GT(drawn, 0);
  EXPECT_EQ(others, 0);
}

TEST(Misuse, AWriterIsUsedByOneCallAtATime) {
  const Folder folder;
  const Device device = make_device();
  Series series;
  series.nx = series.ny = series.nz = 40;
  auto o = options_of(series);
  struct Meddling {
    bccsplat_writer* writer = nullptr;
    std::atomic<int> calls{0}, refused{0};
  } meddling;
  o.progress_user = &meddling;
  o.progress = [](void* self, double) {
    auto& m = *static_cast<Meddling*>(self);
    ++m.calls;
    m.refused += bccsplat_writer_finish(m.writer, nullptr) == BCCSPLAT_ERROR_WRONG_STATE;
    return 0;
  };
  const Writer writer = make_writer(device, folder.file("w.bcc4"), o);
  meddling.writer = writer.get();
  ASSERT_OK(add_frames(writer.get(), series));
  ASSERT_OK(bccsplat_writer_finish(writer.get(), nullptr));
  EXPECT_GT(meddling.calls, 0);
  EXPECT_EQ(meddling.refused, meddling.calls);
}

TEST(Misuse, StridesThatReachOutOfMemory) {
  const Folder folder;
  const Device device = make_device();
  const std::vector<float> values(20 * 19 * 18, 1);
  auto box = sized<bccsplat_box>();
  box.type = BCCSPLAT_TYPE_F32, box.data = values.data();
  box.dims[0] = 20, box.dims[1] = 19, box.dims[2] = 18;
  for (const int64_t stride : {INT64_MAX / 4, INT64_MIN / 17, INT64_MIN}) {
    box.stride_bytes[0] = 4, box.stride_bytes[1] = 80, box.stride_bytes[2] = stride;
    const Writer writer = make_writer(device, folder.file("w.bcc4"), options_of({}));
    EXPECT_EQ(bccsplat_writer_add_frame(writer.get(), 0, 0, &box, 1), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  }
  const Writer writer = make_writer(device, folder.file("w.bcc4"), options_of({}));
  box.stride_bytes[2] = 0; // the same plane again and again
  EXPECT_OK(bccsplat_writer_add_frame(writer.get(), 0, 0, &box, 1));
}

TEST(Misuse, ColoursThatComeToNoNumber) {
  const Device device = make_device();
  bccsplat_renderer* r = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  double colors[4] = {0, 1, 1e300, 1};
  const double opacities[2] = {0, 0.5};
  auto f = sized<bccsplat_transfer_function>();
  f.color_count = f.opacity_count = 1, f.colors = colors, f.opacities = opacities;
  EXPECT_EQ(bccsplat_renderer_set_transfer_function(r, &f), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  colors[2] = 1e9;
  EXPECT_OK(bccsplat_renderer_set_transfer_function(r, &f));
}

TEST(Misuse, AFrameThatIsNotAligned) {
  const Device device = make_device();
  std::vector<float> rgba(4 * 4 * 4 + 1);
  bccsplat_frame* f = nullptr;
  auto* crooked = reinterpret_cast<float*>(reinterpret_cast<char*>(rgba.data()) + 2);
  EXPECT_EQ(bccsplat_frame_wrap(device.get(), 4, 4, crooked, 0, &f), BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

TEST(Misuse, StructSizes) {
  bccsplat_device* d = nullptr;
  bccsplat_device_options o{};
  EXPECT_EQ(bccsplat_device_create(&o, &d), BCCSPLAT_ERROR_INVALID_STRUCT_SIZE); // size not set
  // A newer caller: a tail of zeros is fine, anything else is refused.
  struct {
    bccsplat_device_options known;
    uint64_t tail;
  } newer{};
  newer.known.struct_size = sizeof newer;
  EXPECT_EQ(bccsplat_device_create(&newer.known, &d), BCCSPLAT_OK);
  bccsplat_device_release(d);
  newer.tail = 1;
  EXPECT_EQ(bccsplat_device_create(&newer.known, &d), BCCSPLAT_ERROR_INVALID_STRUCT_SIZE);
  EXPECT_EQ(d, nullptr);
  // An older caller: fields beyond its struct are defaults on input and stay untouched on output.
  const Device device = make_device();
  bccsplat_device_info info{};
  info.struct_size = 8;
  info.memory_budget = 77;
  ASSERT_OK(bccsplat_device_get_info(device.get(), &info));
  EXPECT_EQ(info.thread_count, 2);
  EXPECT_EQ(info.memory_budget, 77u);
  EXPECT_EQ(info.struct_size, 8u);
}

#ifndef _WIN32 // whose pages are protected by other calls
// A size that was never set may be anything: nothing far behind the struct is read.
TEST(Misuse, AStructSizeOfGarbage) {
  const size_t page = ::sysconf(_SC_PAGESIZE);
  void* const memory = ::mmap(nullptr, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  ASSERT_EQ(::mprotect(static_cast<char*>(memory) + page, page, PROT_NONE), 0);
  auto* const options = static_cast<bccsplat_device_options*>(memory);
  options->struct_size = 0xdeadbeef;
  bccsplat_device* d = nullptr;
  EXPECT_EQ(bccsplat_device_create(options, &d), BCCSPLAT_ERROR_INVALID_STRUCT_SIZE);
  ::munmap(memory, 2 * page);
}
#endif

TEST(Misuse, FilesThatAreNotThere) {
  const Folder folder;
  const Device device = make_device();
  bccsplat_volume* v = nullptr;
  EXPECT_EQ(bccsplat_volume_open_file(device.get(), folder.file("none.bcc4").c_str(), nullptr, &v),
            BCCSPLAT_ERROR_FILE_NOT_FOUND);
  EXPECT_NE(std::string(bccsplat_last_error()).find("none.bcc4"), std::string::npos);
  EXPECT_EQ(bccsplat_volume_open_file(device.get(), folder.path().string().c_str(), nullptr, &v),
            BCCSPLAT_ERROR_IO);
  std::FILE* f = std::fopen(folder.file("text.bcc4").c_str(), "w");
  for (int i = 0; i < 1000; ++i) std::fputs("not a volume\n", f);
  std::fclose(f);
  EXPECT_EQ(bccsplat_volume_open_file(device.get(), folder.file("text.bcc4").c_str(), nullptr, &v),
            BCCSPLAT_ERROR_NOT_BCC4);
}

TEST(Misuse, WriterOptions) {
  const Folder folder;
  const Device device = make_device();
  bccsplat_writer* w = nullptr;
  const auto create = [&](const bccsplat_writer_options& o) {
    return bccsplat_writer_create(device.get(), folder.file("s.bcc4").c_str(), &o, &w);
  };
  auto o = options_of({});
  o.dims[1] = 0;
  EXPECT_EQ(create(o), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  o = options_of({});
  o.lattice = 9;
  EXPECT_EQ(create(o), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  o = options_of({});
  o.lattice = BCCSPLAT_LATTICE_CC;
  o.lowpass = 1;
  EXPECT_EQ(create(o), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  o = options_of({});
  o.levels = 16;
  EXPECT_EQ(create(o), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  o = options_of({});
  o.scale = -1;
  EXPECT_EQ(create(o), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  o = options_of({});
  o.recommended_kernel = "radail20";
  EXPECT_EQ(create(o), BCCSPLAT_ERROR_NOT_FOUND);
  EXPECT_NE(std::string(bccsplat_last_error()).find("radial20"), std::string::npos) << bccsplat_last_error();
  o = options_of({});
  o.affine[0] = 1; // singular
  o.affine[15] = 1;
  EXPECT_EQ(create(o), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  o = options_of({});
  auto c = sized<bccsplat_channel_options>();
  c.value_type = BCCSPLAT_TYPE_U8; // floats as bytes need a range
  o.channels = &c, o.channel_count = 1;
  ASSERT_OK(create(o));
  {
    const Writer writer(w);
    EXPECT_EQ(add_frames(w, {}), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  o = options_of({});
  EXPECT_EQ(bccsplat_writer_create(device.get(), folder.file("no/such/folder.bcc4").c_str(), &o, &w),
            BCCSPLAT_ERROR_FILE_NOT_FOUND);
}

TEST(Misuse, WriterOrder) {
  const Folder folder;
  const Device device = make_device();
  const auto o = options_of({});
  {
    const Writer w = make_writer(device, folder.file("s.bcc4"), o);
    EXPECT_EQ(bccsplat_writer_finish(w.get(), nullptr), BCCSPLAT_ERROR_WRONG_STATE); // nothing added
  }
  {
    const Writer w = make_writer(device, folder.file("s.bcc4"), o);
    EXPECT_EQ(bccsplat_writer_add_frame(w.get(), 1, 0, nullptr, 0), BCCSPLAT_ERROR_NOT_FOUND);
    ASSERT_OK(bccsplat_writer_add_frame(w.get(), 0, 0, nullptr, 0));
    EXPECT_EQ(bccsplat_writer_add_frame(w.get(), 0, 0, nullptr, 0),
              BCCSPLAT_ERROR_INVALID_ARGUMENT); // time stands still
  }
  {
    const Writer w = make_writer(device, folder.file("s.bcc4"), o);
    auto box = sized<bccsplat_box>();
    float value = 0;
    box.type = BCCSPLAT_TYPE_F32, box.data = &value, box.begin[0] = 20;
    box.dims[0] = box.dims[1] = box.dims[2] = 1;
    EXPECT_EQ(bccsplat_writer_add_frame(w.get(), 0, 0, &box, 1),
              BCCSPLAT_ERROR_INVALID_ARGUMENT); // beyond the end
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())); // nothing was finished, nothing is left
  (void)write_series(device, folder.file("s.bcc4"));
  bccsplat_writer* w = nullptr;
  EXPECT_EQ(bccsplat_writer_create(device.get(), folder.file("s.bcc4").c_str(), &o, &w),
            BCCSPLAT_ERROR_FILE_EXISTS);
  auto replace = o;
  replace.overwrite = 1;
  const Writer writer = make_writer(device, folder.file("s.bcc4"), replace);
  ASSERT_OK(add_frames(writer.get(), {}));
  ASSERT_OK(bccsplat_writer_finish(writer.get(), nullptr));
  EXPECT_EQ(bccsplat_writer_finish(writer.get(), nullptr), BCCSPLAT_ERROR_WRONG_STATE);
}

TEST(Misuse, AWriterThatCanOnlyBeReleasedTakesNothing) {
  const Folder folder;
  const Device device = make_device();
  const auto takes_nothing = [](const Writer& w) {
    EXPECT_EQ(bccsplat_writer_set_attribute(w.get(), "key", "value"), BCCSPLAT_ERROR_WRONG_STATE);
    EXPECT_EQ(bccsplat_writer_add_source(w.get(), "source", 1, 0), BCCSPLAT_ERROR_WRONG_STATE);
    EXPECT_EQ(bccsplat_writer_set_times(w.get(), 0, 1), BCCSPLAT_ERROR_WRONG_STATE);
  };
  const Writer finished = make_writer(device, folder.file("s.bcc4"), options_of({}));
  ASSERT_OK(add_frames(finished.get(), {}));
  ASSERT_OK(bccsplat_writer_finish(finished.get(), nullptr));
  takes_nothing(finished);
  auto cancels = options_of({});
  cancels.progress = [](void*, double) { return 1; };
  const Writer failed = make_writer(device, folder.file("t.bcc4"), cancels);
  EXPECT_EQ(add_frames(failed.get(), {}), BCCSPLAT_CANCELLED);
  takes_nothing(failed);
}

TEST(Misuse, PathsThatAreNoFiles) {
  const Folder folder;
  const Device device = make_device();
  auto o = options_of({});
  o.overwrite = 1;
  bccsplat_writer* w = nullptr;
  const auto create = [&](const std::string& path) {
    return bccsplat_writer_create(device.get(), path.c_str(), &o, &w);
  };
  EXPECT_EQ(create(""), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(create(folder.path().string()), BCCSPLAT_ERROR_IO);
#ifndef _WIN32 // whose pipes have no paths in folders
  const std::string pipe = folder.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(create(pipe), BCCSPLAT_ERROR_IO);
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
#endif
}

TEST(Misuse, TwoWritersOfOnePath) {
  const Folder folder;
  const Device device = make_device();
  const std::string path = folder.file("s.bcc4");
  auto o = options_of({});
  o.overwrite = 1;
  bccsplat_writer* second = nullptr;
  {
    const Writer first = make_writer(device, path, o);
    EXPECT_EQ(bccsplat_writer_create(device.get(), path.c_str(), &o, &second), BCCSPLAT_ERROR_WRONG_STATE);
    ASSERT_OK(add_frames(first.get(), {}));
    EXPECT_EQ(bccsplat_writer_create(device.get(), path.c_str(), &o, &second), BCCSPLAT_ERROR_WRONG_STATE);
    ASSERT_OK(bccsplat_writer_finish(first.get(), nullptr));
    auto report = sized<bccsplat_verify_report>();
    ASSERT_OK(bccsplat_volume_verify(open(device, path).get(), nullptr, nullptr, &report));
    EXPECT_EQ(report.damages, 0u);
    const Writer after = make_writer(device, path, o); // the first is done with it
    (void)open(device, path);                          // what it finished stays until this one is
  }
  EXPECT_TRUE(std::filesystem::exists(path));
  EXPECT_FALSE(std::filesystem::exists(path + ".partial"));
}

TEST(Misuse, ARefusedTrailLeavesTheOneBefore) {
  const Folder folder;
  const Device device = make_device();
  (void)write_series(device, folder.file("s.bcc4"));
  const Volume volume = open(device, folder.file("s.bcc4"));
  const Slice slice = cut_time(volume, 6);
  bccsplat_renderer* r = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_create(device.get(), 16, 16, BCCSPLAT_FRAME_RGBA, &f));
  const Frame frame(f);
  const auto picture = [&] {
    EXPECT_OK(bccsplat_renderer_render(r, f));
    auto plane = sized<bccsplat_plane>();
    EXPECT_OK(bccsplat_frame_get_channel(f, BCCSPLAT_FRAME_RGBA, &plane));
    return std::vector<float>(plane.pixels, plane.pixels + 4 * 16 * 16);
  };
  ASSERT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  const auto bare = picture();
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -4;
  ASSERT_OK(bccsplat_renderer_set_trail(r, &trail));
  const auto with_trail = picture();
  EXPECT_NE(with_trail, bare);
  trail.interval[0] = NAN;
  EXPECT_EQ(bccsplat_renderer_set_trail(r, &trail), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(picture(), with_trail);
}

TEST(Misuse, Hyperplanes) {
  const Folder folder;
  const Device device = make_device();
  (void)write_series(device, folder.file("s.bcc4"));
  const Volume volume = open(device, folder.file("s.bcc4"));
  auto h = sized<bccsplat_hyperplane>();
  bccsplat_slice* s = nullptr;
  EXPECT_EQ(bccsplat_slice_create(volume.get(), &h, nullptr, &s),
            BCCSPLAT_ERROR_INVALID_ARGUMENT); // no normal
  h.d = 1, h.e = -7.5;
  EXPECT_EQ(bccsplat_slice_create(volume.get(), &h, nullptr, &s),
            BCCSPLAT_ERROR_OUT_OF_DOMAIN); // after the last frame
  h.e = NAN;
  EXPECT_EQ(bccsplat_slice_create(volume.get(), &h, nullptr, &s), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  h.d = 1e-300, h.e = -3e-300; // tiny, but a normal: frame 3
  ASSERT_OK(bccsplat_slice_create(volume.get(), &h, nullptr, &s));
  const Slice tiny(s);
  auto info = sized<bccsplat_slice_info>();
  ASSERT_OK(bccsplat_slice_get_info(s, &info));
  EXPECT_DOUBLE_EQ(info.origin[3], 3);
  auto o = sized<bccsplat_slice_options>();
  o.kernel = "cubic";
  EXPECT_EQ(bccsplat_slice_create(volume.get(), &h, &o, &s), BCCSPLAT_ERROR_NOT_FOUND);
  EXPECT_EQ(s, nullptr);
}

TEST(Misuse, BudgetTooSmall) {
  const Folder folder;
  (void)write_series(make_device(), folder.file("s.bcc4"));
  const Device small = make_device(2, 50'000);
  auto h = sized<bccsplat_hyperplane>();
  h.d = 1, h.e = -3;
  bccsplat_volume* v = nullptr;
  bccsplat_status status = bccsplat_volume_open_file(small.get(), folder.file("s.bcc4").c_str(), nullptr, &v);
  const Volume volume(v);
  bccsplat_slice* s = nullptr;
  if (status == BCCSPLAT_OK) status = bccsplat_slice_create(v, &h, nullptr, &s);
  EXPECT_EQ(status, BCCSPLAT_ERROR_MEMORY_BUDGET);
  auto info = sized<bccsplat_device_info>();
  ASSERT_OK(bccsplat_device_get_info(small.get(), &info));
  EXPECT_LE(info.memory_peak, 50'000u);
}

TEST(Misuse, CancelledImportLeavesNothing) {
  const Folder folder;
  const Device device = make_device();
  auto o = options_of({});
  o.progress = [](void*, double fraction) { return fraction > 0.3 ? 1 : 0; };
  Writer w = make_writer(device, folder.file("s.bcc4"), o);
  // Reports come at most 30 times a second: with every frame one is due.
  Series s;
  s.field = [](double x, double y, double z, double) {
    if (x == 0 && y == 0 && z == 0) std::this_thread::sleep_for(std::chrono::milliseconds(40));
    return 1.0;
  };
  EXPECT_EQ(add_frames(w.get(), s), BCCSPLAT_CANCELLED);
  EXPECT_EQ(bccsplat_writer_finish(w.get(), nullptr), BCCSPLAT_ERROR_WRONG_STATE);
  w.reset();
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Threads, ConcurrentReadersAgree) {
  const Folder folder;
  const Device device = make_device(2);
  (void)write_series(device, folder.file("s.bcc4"));
  const Volume volume = open(device, folder.file("s.bcc4"));
  std::vector<std::vector<float>> results(4);
  std::vector<std::thread> threads;
  for (auto& r : results)
    threads.emplace_back([&] {
      r.resize(20 * 19 * 18);
      for (const double frame : {1.5, 4.25, 0.0}) {
        const Slice slice = cut_time(volume, frame);
        EXPECT_EQ(bccsplat_slice_sample_grid(slice.get(), nullptr, r.data()), BCCSPLAT_OK);
      }
    });
  for (auto& t : threads) t.join();
  for (const auto& r : results) EXPECT_EQ(r, results[0]);
}

TEST(Threads, HostRunnerDoesTheWork) {
  const Folder folder;
  (void)write_series(make_device(), folder.file("own.bcc4"));
  std::atomic<uint64_t> calls{0};
  auto o = sized<bccsplat_device_options>();
  o.thread_count = 3;
  o.runner_user = &calls;
  o.runner = [](void* user, uint64_t count, bccsplat_task_fn body, void* task) {
    static_cast<std::atomic<uint64_t>*>(user)->fetch_add(1);
    std::vector<std::thread> threads;
    std::atomic<uint64_t> next{0};
    for (int i = 0; i < 3; ++i)
      threads.emplace_back([&] {
        for (uint64_t k; (k = next.fetch_add(1)) < count;) body(task, k);
      });
    for (auto& t : threads) t.join();
  };
  bccsplat_device* d = nullptr;
  ASSERT_OK(bccsplat_device_create(&o, &d));
  const Device device(d);
  (void)write_series(device, folder.file("runner.bcc4"));
  EXPECT_GT(calls.load(), 0u);
  EXPECT_EQ(std::filesystem::file_size(folder.file("own.bcc4")),
            std::filesystem::file_size(folder.file("runner.bcc4")));
}

TEST(Lifetime, ChildrenKeepTheirParents) {
  const Folder folder;
  bccsplat_slice* s = nullptr;
  {
    Device device = make_device();
    (void)write_series(device, folder.file("s.bcc4"));
    Volume volume = open(device, folder.file("s.bcc4"));
    s = cut_time(volume, 2).release();
  }
  const Slice slice(s);
  std::vector<float> dense(20 * 19 * 18);
  EXPECT_OK(bccsplat_slice_sample_grid(s, nullptr, dense.data()));
  bccsplat_slice_retain(s);
  bccsplat_slice_release(s);
  const double at[3] = {1, 1, 1};
  float value = 0;
  EXPECT_OK(bccsplat_slice_evaluate(s, 1, at, &value, nullptr));
}

TEST(Library, NamesAndVersions) {
  EXPECT_EQ(bccsplat_version(),
            BCCSPLAT_VERSION_MAJOR * 10000 + BCCSPLAT_VERSION_MINOR * 100 + BCCSPLAT_VERSION_PATCH);
  EXPECT_EQ(bccsplat_abi_version(), BCCSPLAT_ABI_VERSION);
  EXPECT_STREQ(bccsplat_status_name(BCCSPLAT_CANCELLED), "BCCSPLAT_CANCELLED");
  EXPECT_STREQ(bccsplat_status_name(12345), "BCCSPLAT_UNKNOWN_STATUS");
  EXPECT_STREQ(bccsplat_kernel_name(0), "default");
  uint32_t count = 0;
  while (bccsplat_kernel_name(count)) ++count;
  EXPECT_EQ(count, 18u);
  EXPECT_NE(std::string(bccsplat_build_info()).find("version=" + std::to_string(BCCSPLAT_VERSION_MAJOR)),
            std::string::npos);
}

} // namespace

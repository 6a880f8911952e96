// SPDX-License-Identifier: Apache-2.0
// Input that would do harm later is refused when it is given, and reads keep to the number that is allowed.
#include <atomic>
#include <cstring>
#include <fstream>
#include <iterator>
#include <thread>

#include "support.h"

using namespace host;

namespace {

bccsplat_box box_at(const std::vector<float>& values, int64_t x, int64_t n) {
  auto box = sized<bccsplat_box>();
  box.type = BCCSPLAT_TYPE_F32, box.data = values.data();
  box.begin[0] = x;
  for (int64_t& d : box.dims) d = n;
  return box;
}

TEST(InputChecks, BoxesThatOverlapAreRefusedAndTheWriterGoesOn) {
  const Folder folder;
  const Device device = make_device(1);
  Series s;
  s.nt = 1;
  const Writer w = make_writer(device, folder.file("s.bcc4"), options_of(s));
  const std::vector<float> values(125, 1);
  const bccsplat_box apart[] = {box_at(values, 0, 5), box_at(values, 5, 5), box_at(values, 10, 5)};
  bccsplat_box over[] = {apart[0], apart[1], box_at(values, 9, 5)};
  EXPECT_EQ(bccsplat_writer_add_frame(w.get(), 0, 0, over, 3), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(bccsplat_last_error()).find("boxes 1 and 2 of frame 0 overlap"), std::string::npos)
      << bccsplat_last_error();
  EXPECT_OK(bccsplat_writer_add_frame(w.get(), 0, 0, apart, 3));
  EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
}

// A channel is asked for by its name.
TEST(InputChecks, NamesOfChannelsMustBeUtf8) {
  const Folder folder;
  const Device device = make_device(1);
  const std::string path = folder.file("n.bcc4");
  Series s;
  s.nt = 1;
  auto o = options_of(s);
  auto channel = sized<bccsplat_channel_options>();
  o.channels = &channel, o.channel_count = 1;
  channel.name = "density \xff";
  bccsplat_writer* w = nullptr;
  EXPECT_EQ(bccsplat_writer_create(device.get(), path.c_str(), &o, &w), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(bccsplat_last_error()).find("not UTF-8"), std::string::npos);
  channel.name = "density \xc3\xbc";
  const Writer writer = make_writer(device, path, o);
  EXPECT_OK(add_frames(writer.get(), s));
  EXPECT_OK(bccsplat_writer_finish(writer.get(), nullptr));
  const Volume volume = open(device, path);
  uint32_t number = 7;
  EXPECT_OK(bccsplat_volume_find_channel(volume.get(), channel.name, &number));
}

struct Counting {
  std::vector<char> bytes;
  std::atomic<int> now{0}, most{0};
};

int64_t read_counted(void* user, uint64_t offset, void* out, uint64_t size) {
  auto* const c = static_cast<Counting*>(user);
  const int now = ++c->now;
  for (int most = c->most; now > most && !c->most.compare_exchange_weak(most, now);) {
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(1)); // so that others come meanwhile
  std::memcpy(out, c->bytes.data() + offset, size);
  --c->now;
  return size;
}

TEST(InputChecks, NoMoreReadsAreInFlightThanAllowed) {
  const Folder folder;
  const std::string path = folder.file("s.bcc4");
  Series s;
  s.nx = s.ny = s.nz = 72;
  (void)write_series(make_device(2), path, s);
  for (const uint32_t most : {0u, 1u, 2u}) {
    auto o = sized<bccsplat_device_options>();
    o.thread_count = 4, o.max_reads = most;
    bccsplat_device* d = nullptr;
    ASSERT_OK(bccsplat_device_create(&o, &d));
    const Device device(d);
    Counting counting;
    std::ifstream file(path, std::ios::binary);
    counting.bytes.assign(std::istreambuf_iterator<char>(file), {});
    auto stream = sized<bccsplat_read_stream>();
    stream.size = counting.bytes.size(), stream.read_at = read_counted, stream.user = &counting;
    bccsplat_volume* v = nullptr;
    ASSERT_OK(bccsplat_volume_open_stream(d, &stream, nullptr, &v));
    {
      const Volume volume(v);
      std::vector<std::thread> hosts;
      for (const double frame : {1.5, 5.5}) hosts.emplace_back([&, frame] { (void)cut_time(volume, frame); });
      for (std::thread& t : hosts) t.join();
    }
    EXPECT_LE(counting.most, most > 0 ? static_cast<int>(most) : 8);
    EXPECT_GT(counting.most, most == 1 ? 0 : 1);
  }
}

} // namespace

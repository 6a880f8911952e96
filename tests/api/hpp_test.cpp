// SPDX-License-Identifier: Apache-2.0
// bccsplat.hpp: objects are made and released, failures are exceptions, and what is shared stays.
#include <bccsplat.hpp>

#include <utility>

#include "support.h"

namespace {
namespace client {

using namespace bccsplat::client;

TEST(Hpp, MakesAndReleases) {
  const ::host::Folder folder;
  const ::host::Series series;
  const Device device = make(bccsplat_device_create, nullptr);
  auto options = sized<bccsplat_writer_options>();
  options.dims[0] = series.nx, options.dims[1] = series.ny, options.dims[2] = series.nz,
  options.dims[3] = series.nt;
  Writer writer = make(bccsplat_writer_create, device.get(), folder.file("h.bcc4").c_str(), &options);
  check(::host::add_frames(writer.get(), series));
  check(bccsplat_writer_finish(writer.get(), nullptr));
  writer.reset();
  Volume volume = make(bccsplat_volume_open_file, device.get(), folder.file("h.bcc4").c_str(), nullptr);
  const Volume other = share(volume);
  EXPECT_EQ(other, volume);
  volume.reset();
  auto info = sized<bccsplat_volume_info>();
  check(bccsplat_volume_get_info(other.get(), &info)); // it is still there
  EXPECT_EQ(info.dims[3], series.nt);
  EXPECT_EQ(share(Volume()), nullptr);
}

TEST(Hpp, FailuresAreExceptions) {
  const Device device = make(bccsplat_device_create, nullptr);
  try {
    (void)make(bccsplat_volume_open_file, device.get(), "/nowhere/at.bcc4", nullptr);
    FAIL() << "there is no such file";
  } catch (const Error& e) {
    EXPECT_EQ(e.status(), BCCSPLAT_ERROR_FILE_NOT_FOUND);
    EXPECT_NE(std::string(e.what()).find("/nowhere/at.bcc4"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("(BCCSPLAT_ERROR_FILE_NOT_FOUND)"), std::string::npos) << e.what();
  }
  EXPECT_NO_THROW(check(BCCSPLAT_OK));
}

} // namespace client
} // namespace

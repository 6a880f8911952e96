// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>

#include "base/error.h"
#include "kernel/kernel.h"

namespace bccsplat {
namespace {

TEST(KernelNames, PresetsAreTheirKernels) {
  EXPECT_EQ(make_kernel("").name, "radial20+b3");
  EXPECT_EQ(make_kernel("default").name, "radial20+b3");
  EXPECT_EQ(make_kernel("fast").name, "radial16+b2");
  EXPECT_EQ(make_kernel("fine").name, "radial24+b4");
  EXPECT_EQ(make_kernel("radial18+b4").time.order, 4);
  EXPECT_EQ(make_kernel("radial18+b4").space.radius, 1.8);
}

TEST(KernelNames, EveryListedNameMakesAKernelAndTheNamesDiffer) {
  const std::vector<std::string> names = kernel_names();
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  EXPECT_EQ(names.size(), 3u + 3u + 12u);
  for (const std::string& name : names) {
    const Kernel kernel = make_kernel(name);
    EXPECT_EQ(make_kernel(kernel.name).name, kernel.name) << name; // canonical names are names
    EXPECT_EQ(kernel.normalised, name == "paper");
    EXPECT_EQ(kernel.prefilter4.empty(), name == "paper");
    EXPECT_EQ(kernel.prefilter3.empty(), name == "paper");
  }
}

TEST(KernelNames, AMisspeltNameIsRefusedWithTheNearest) {
  const auto message = [](const char* name) -> std::string {
    try {
      (void)make_kernel(name);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), Code::not_found);
      return e.message();
    }
    return "accepted";
  };
  EXPECT_NE(message("radail20+b3").find("did you mean 'radial20+b3'"), std::string::npos);
  EXPECT_NE(message("papr").find("did you mean 'paper'"), std::string::npos);
  EXPECT_NE(message("pap").find("did you mean 'paper'"), std::string::npos) << "two of five letters lack";
  EXPECT_NE(message("gauss9").find("did you mean 'gauss09'"), std::string::npos);
  EXPECT_NE(message("radial20+b5").find("did you mean 'radial20+b"), std::string::npos);
  EXPECT_NE(message("radial20").find("unknown kernel"), std::string::npos);
  EXPECT_NE(message("Default").find("unknown kernel"), std::string::npos);
  EXPECT_EQ(message("lanczos").find("did you mean"), std::string::npos) << "that is another one";
  EXPECT_NE(message("default ").find("did you mean 'default'"), std::string::npos);
}

TEST(KernelNames, ReachIsSupportAndPrefilter) {
  EXPECT_EQ(make_kernel("paper").reach_layers(), 3);    // 2 T = 2.83 layers
  EXPECT_EQ(make_kernel("fast").reach_layers(), 2 + 3); // hat, stages of 2 and 1 layers
  EXPECT_EQ(make_kernel("default").reach_layers(), 3 + 5);
  EXPECT_EQ(make_kernel("fine").reach_layers(), 4 + 8);
  EXPECT_EQ(make_kernel("gauss09").reach_layers(), 4 + 6);
}

} // namespace
} // namespace bccsplat

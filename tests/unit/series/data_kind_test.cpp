// SPDX-License-Identifier: Apache-2.0
// What files of many fields say of themselves, and the kind that it makes them.
#include "series/data_kind.h"

#include <gtest/gtest.h>

namespace bccsplat::series {
namespace {

struct Case {
  const char* what;
  DataFacts facts;
  DataKind kind;
};

const Case cases[] = {
    {"a heart, NIfTI in mm", {.sides = true, .sized = true, .whole = true}, DataKind::mr},
    {"perfusion of a brain in floats", {.sides = true, .sized = true}, DataKind::mr},
    {"PET", {.sides = true, .sized = true, .unit = "Bq/ml"}, DataKind::mr},
    {"NIfTI in Hounsfield units", {.sides = true, .sized = true, .whole = true, .low = -1024}, DataKind::ct},
    {"the same as floats", {.sides = true, .sized = true, .low = -1000.5}, DataKind::ct},
    {"the same outside a scanner's circle", {.sides = true, .sized = true, .low = -3024}, DataKind::ct},
    {"Hounsfield units that are told", {.unit = "HU", .low = -100}, DataKind::ct},
    {"a head without sides",
     {.sized = true, .whole = true, .low = -1024, .air = -1000, .tissue = 40},
     DataKind::ct},
    {"the same with 1024 added", {.sized = true, .whole = true, .air = 10, .tissue = 1050}, DataKind::ct},
    {"a relief", {.sized = true, .whole = true, .low = -1500}, DataKind::unknown},
    {"two materials far apart",
     {.sized = true, .whole = true, .air = 668, .tissue = 9000},
     DataKind::unknown},
    {"two materials 1000 apart, of something else",
     {.sized = true, .whole = true, .unit = "K", .air = 300, .tissue = 1300},
     DataKind::field},
    {"a tooth whose voxels have no size", {.sides = true, .whole = true}, DataKind::unknown},
    {"bytes", {.whole = true, .air = 10, .tissue = 150}, DataKind::unknown},
    {"wind speed in steps", {.sized = true, .whole = true}, DataKind::unknown},
    {"wind speed", {.unit = "m/s"}, DataKind::field},
    {"t values by a code", {.told = "statistic", .sides = true, .sized = true}, DataKind::statistic},
    {"t values", {.sides = true, .sized = true, .both_signs = true, .low = -8.7}, DataKind::statistic},
    {"a wave", {.both_signs = true, .low = -1}, DataKind::unknown},
    {"an atlas", {.labels = true, .sides = true, .sized = true, .whole = true}, DataKind::labels},
    {"a forecast", {.degrees = true, .sized = true, .unit = "K", .low = 191}, DataKind::map},
    {"land and sea", {.labels = true, .degrees = true}, DataKind::labels},
    {"a plume", {.fog = true, .sized = true}, DataKind::smoke},
    {"what burns in it", {.fog = true, .flame = true, .sized = true}, DataKind::fire},
    {"a scanner by a code", {.told = "ct", .sides = true, .sized = true}, DataKind::ct},
    {"a word that is no kind", {.told = "soup", .unit = "m/s"}, DataKind::field},
    {"nothing", {}, DataKind::unknown},
};

TEST(DataKind, IsThatOfTheFirstRule) {
  for (const Case& c : cases) EXPECT_EQ(name_of(data_kind(c.facts)), name_of(c.kind)) << c.what;
}

TEST(DataKind, NamesAreRead) {
  for (const std::string_view name : data_kind_names) EXPECT_EQ(name_of(data_kind_by_name(name)), name);
  EXPECT_EQ(data_kind_by_name("CT"), DataKind::unknown);
}

} // namespace
} // namespace bccsplat::series

// SPDX-License-Identifier: Apache-2.0
// What a channel is of, in the words of those who use such data: found by what its file says and by its
// values, never by the name of a file.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>

namespace bccsplat::series {

// ct, mr: a patient's scan, mr whatever it was made by. smoke, fire: fogs of effects.
enum class DataKind : uint8_t { unknown, ct, mr, statistic, labels, map, field, smoke, fire };

struct DataFacts {
  std::string told{};              // the name of a kind, where a header had a code for it
  bool labels = false;             // values are numbers of things
  bool fog = false, flame = false; // a fog volume of OpenVDB; one whose grid has the name of a flame
  bool degrees = false;            // the world is one of longitudes and latitudes
  bool sides = false;              // it is known where the left, back and upper side are
  bool sized = false;              // voxels have a size of their own: a unit, or not 1 x 1 x 1
  bool whole = false;              // values are whole numbers
  bool both_signs = false;         // most are near 0, and the others on both sides
  std::string unit{};              // of values
  double low = 0;                  // the lowest of them
  double air = 0, tissue = 0;      // where two peaks stand apart, the lower and the higher one; else the same
};

inline constexpr std::string_view data_kind_names[] = {"unknown", "ct",    "mr",    "statistic", "labels",
                                                       "map",     "field", "smoke", "fire"};

[[nodiscard]] constexpr std::string_view name_of(DataKind kind) {
  return data_kind_names[static_cast<size_t>(kind)];
}

// Returns unknown where it is the name of no kind.
[[nodiscard]] constexpr DataKind data_kind_by_name(std::string_view name) {
  const auto* const found = std::find(std::begin(data_kind_names), std::end(data_kind_names), name);
  return found == std::end(data_kind_names) ? DataKind::unknown
                                            : static_cast<DataKind>(found - std::begin(data_kind_names));
}

// Returns where a file says the kind of a channel.
[[nodiscard]] inline std::string kind_attribute(const std::string& channel) { return "kind." + channel; }

namespace data_kind_rules {

// Hounsfield units: air is at -1000, tissue near 0; some files have 1000 or 1024 added.
constexpr double least_apart = 850, most_apart = 1250;            // of tissue and air
constexpr double hounsfield_air = -900, least_hounsfield = -3100; // with what is outside the scanner's circle

[[nodiscard]] inline bool hounsfield(const DataFacts& f) {
  if (f.unit == "HU") return true;
  const double apart = f.tissue - f.air;
  const bool scaled = f.low <= hounsfield_air && f.low >= least_hounsfield;
  const bool tissues = apart >= least_apart && apart <= most_apart;
  return f.unit.empty() && f.sized && (f.sides ? scaled : f.whole && tissues);
}

struct Rule {
  DataKind kind;
  bool (*holds)(const DataFacts&);
};
inline constexpr Rule rules[] = {
    {DataKind::labels, [](const DataFacts& f) { return f.labels; }},
    {DataKind::map, [](const DataFacts& f) { return f.degrees; }},
    {DataKind::fire, [](const DataFacts& f) { return f.fog && f.flame; }},
    {DataKind::smoke, [](const DataFacts& f) { return f.fog; }},
    {DataKind::ct, hounsfield},
    {DataKind::statistic, [](const DataFacts& f) { return f.sides && f.sized && f.both_signs; }},
    {DataKind::mr, [](const DataFacts& f) { return f.sides && f.sized && f.low >= 0; }},
    {DataKind::field, [](const DataFacts& f) { return !f.unit.empty(); }},
};

} // namespace data_kind_rules

// Returns what the file's header said, else the kind of the first rule that holds.
[[nodiscard]] inline DataKind data_kind(const DataFacts& facts) {
  if (const DataKind told = data_kind_by_name(facts.told); told != DataKind::unknown) return told;
  for (const data_kind_rules::Rule& rule : data_kind_rules::rules)
    if (rule.holds(facts)) return rule.kind;
  return DataKind::unknown;
}

} // namespace bccsplat::series

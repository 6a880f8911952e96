// SPDX-License-Identifier: Apache-2.0
#include "readers/records.h"

#include <algorithm>

#include "readers/text.h"

namespace bcc4 {
namespace {

constexpr std::string_view of_time_alone[] = {"units", "calendar"};
constexpr std::string_view elsewhere[] = {
    "actual_range", "bcc4_error_bound", "_FillValue",    "missing_value",       "valid_range",  "valid_min",
    "valid_max",    "scale_factor",     "add_offset",    "_Unsigned",           "coordinates",  "bounds",
    "climatology",  "grid_mapping",     "cell_measures", "ancillary_variables", "formula_terms"};

template<class Names> bool holds(const Names& names, std::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

void add(SeriesDescription& d, const std::string& key, const Record& record) {
  d.attributes.emplace_back(key, record.dump(-1, ' ', false, Record::error_handler_t::replace));
}

} // namespace

std::string axis_record(size_t axis) { return concat("axis.", "xyzt"[axis]); }
std::string channel_record(const std::string& channel) { return "channel." + channel; }

bool in_record(std::string_view attribute, bool of_time) {
  return !holds(elsewhere, attribute) && !(of_time && holds(of_time_alone, attribute));
}

Record read_record(const std::string& text) {
  constexpr int deepest = 32; // what is deeper is left out: who copies or writes it goes down by calls
  Record record = Record::parse(
      text, [](int depth, Record::parse_event_t, const Record&) { return depth < deepest; }, false);
  return record.is_object() ? record : Record::object();
}

std::string text_in(const Record& record, const char* attribute) {
  const auto found = record.find(attribute);
  return found != record.end() && found->is_string() ? found->get<std::string>() : "";
}

void keep_axis(SeriesDescription& d, size_t axis, const std::string& name, Record attributes) {
  const std::string usual = axis == 3 ? "time" : std::string(1, "xyz"[axis]);
  if (attributes.empty() && (name.empty() || name == usual)) return;
  attributes["name"] = name.empty() ? usual : utf8_of(name);
  add(d, axis_record(axis), attributes);
}

void keep_channel(SeriesDescription& d, const std::string& channel, const Record& attributes) {
  if (attributes.size() > attributes.count("units")) add(d, channel_record(channel), attributes);
}

void keep_kind(SeriesDescription& d, const std::string& channel, bccsplat::series::DataKind kind) {
  d.attributes.emplace_back(bccsplat::series::kind_attribute(channel), bccsplat::series::name_of(kind));
}

} // namespace bcc4

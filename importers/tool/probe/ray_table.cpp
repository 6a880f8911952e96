// SPDX-License-Identifier: Apache-2.0
#include "tool/probe/ray_table.h"

#include <cstdio>

#include "tool/json.h"
#include "tool/view/time_slice.h"

namespace bcc4 {

RayTable::RayTable(std::string path, bool overwrite, bool dated, bool picks) : picks_(picks) {
  if (path.empty()) return;
  file_ = std::make_unique<OutputFile>(std::move(path), overwrite);
  std::vector<std::string> titles{"time"};
  if (dated) titles.emplace_back("date");
  titles.insert(titles.end(), {"ray", "distance", "x", "y", "z", "value"});
  if (picks) titles.insert(titles.end(), {"gradient_x", "gradient_y", "gradient_z"});
  write(titles);
}

void RayTable::add(double time, const std::string& date, std::span<const RayPlace> places) {
  for (const RayPlace& p : places) {
    std::vector<std::string> columns;
    if (file_ || date.empty()) columns.push_back(time_text(time));
    if (!date.empty()) columns.push_back(date);
    columns.push_back(concat(p.ray + 1));
    columns.push_back(concat(p.distance));
    for (const double w : p.world) columns.push_back(concat(w));
    columns.push_back(concat(static_cast<float>(p.value)));
    for (size_t a = 0; picks_ && a < 3; ++a) columns.push_back(concat(static_cast<float>(p.gradient[a])));
    write(columns);
  }
}

void RayTable::write(const std::vector<std::string>& columns) {
  std::string line;
  for (const std::string& column : columns) line += (line.empty() ? "" : file_ ? "," : "\t") + column;
  line += "\n";
  if (file_)
    file_->write(std::as_bytes(std::span(line)));
  else
    std::fputs(line.c_str(), stdout);
}

void RayTable::finish() {
  if (file_) file_->finish();
}

Json place_json(double time, const std::string& date, const RayPlace& p, bool picks) {
  Json j;
  j["time"] = time;
  if (!date.empty()) j["date"] = date;
  j["ray"] = p.ray + 1;
  j["distance"] = p.distance;
  j["world"] = p.world;
  j["value"] = static_cast<float>(p.value);
  if (picks) j["gradient"] = p.gradient;
  return j;
}

} // namespace bcc4

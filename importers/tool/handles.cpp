// SPDX-License-Identifier: Apache-2.0
// Adds to the library's texts what helps: the option to use, the nearest name of a kernel or channel. Opens
// devices and volumes, and fetches the structs that describe them.
#include "tool/handles.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "readers/lengths.h"
#include "readers/records.h"
#include "tool/interrupt.h"

namespace bcc4 {

const char* advice_on(Code code) {
  switch (code) {
  case Code::file_exists:
    return "; --overwrite replaces it";
  case Code::memory_budget:
    return "; raise --max-mem";
  case Code::nonfinite_value:
    return "; --on-nonfinite hole or clamp accepts such values";
  default:
    return "";
  }
}

void refuse_kernel(Code code, const std::string& kernel) {
  if (code != Code::not_found || kernel.empty()) return;
  std::vector<std::string> names;
  while (const char* name = bccsplat_kernel_name(static_cast<uint32_t>(names.size())))
    names.emplace_back(name);
  // "radail20" means one of radial20+b2, +b3, +b4: the spatial part decides.
  std::vector<std::string> spatial;
  for (const std::string& name : names) spatial.push_back(name.substr(0, name.find('+')));
  std::string nearest = nearest_name(kernel, names);
  if (nearest.empty())
    if (const std::string part = nearest_name(kernel.substr(0, kernel.find('+')), spatial); !part.empty())
      nearest = part + "+b3";
  fail_usage("unknown kernel \"", kernel, "\"",
             nearest.empty() ? "" : concat(" (did you mean ", nearest, "?)"), "; there are ", join(names));
}

void check_kernel(bccsplat_status status, const std::string& what, const std::string& kernel) {
  refuse_kernel(static_cast<Code>(status), kernel);
  check(status, what);
}

namespace {

void print_log(void*, int32_t level, const char* message) {
  if (level == BCCSPLAT_LOG_WARNING) std::fprintf(stderr, "bcc4: warning: %s\n", message);
}

} // namespace

Device create_device(int threads, uint64_t memory_budget) {
  auto options = sized<bccsplat_device_options>();
  options.thread_count = threads;
  options.memory_budget = memory_budget;
  options.log = print_log;
  bccsplat_device* device = nullptr;
  check(bccsplat_device_create(&options, &device), "");
  return Device(device);
}

Volume open_volume(const Device& device, const std::string& path, const std::string& kernel,
                   const std::array<double, 3>& shape) {
  auto options = sized<bccsplat_volume_options>();
  std::copy(shape.begin(), shape.end(), options.shape);
  options.kernel = kernel.empty() ? nullptr : kernel.c_str();
  options.cancel_token = interrupt_token(); // of all calls that take the volume, too
  bccsplat_volume* volume = nullptr;
  check_kernel(bccsplat_volume_open_file(device.get(), path.c_str(), &options, &volume), path, kernel);
  return Volume(volume);
}

bccsplat_volume_info volume_info(const Volume& volume) {
  auto info = sized<bccsplat_volume_info>();
  check(bccsplat_volume_get_info(volume.get(), &info), "");
  return info;
}

bccsplat_channel_info channel_info(const Volume& volume, uint32_t channel) {
  auto info = sized<bccsplat_channel_info>();
  check(bccsplat_volume_get_channel_info(volume.get(), channel, &info), "");
  return info;
}

bccsplat_axis axis_info(const Volume& volume, uint32_t axis) {
  auto info = sized<bccsplat_axis>();
  check(bccsplat_volume_get_axis(volume.get(), axis, &info), "");
  return info;
}

bool has_coordinates(const Volume& volume) {
  for (uint32_t a = 0; a < 3; ++a)
    if (axis_info(volume, a).count > 0) return true;
  return false;
}

std::array<std::string, 3> axis_units(const Volume& volume) {
  std::array<std::string, 3> units;
  units.fill(volume_info(volume).spatial_unit);
  const bool uneven = has_coordinates(volume);
  for (uint32_t a = 0; a < 3; ++a) {
    const Record said = read_record(told(volume, axis_record(a).c_str()));
    if (const std::string unit = length_unit(text_in(said, "units")); !unit.empty())
      units[a] = unit;
    else if (uneven)
      units[a] = axis_info(volume, a).unit;
  }
  return units;
}

std::string told(const Volume& volume, const char* key) {
  const char* value = nullptr;
  return bccsplat_volume_find_attribute(volume.get(), key, &value) == BCCSPLAT_OK ? value : "";
}

Clock clock_of(const Volume& volume) {
  return {volume_info(volume).time_unit, told(volume, "time_epoch"), told(volume, "time_calendar")};
}

bccsplat_level_info level_info(const Volume& volume, uint32_t level) {
  auto info = sized<bccsplat_level_info>();
  check(bccsplat_volume_get_level_info(volume.get(), level, &info), "");
  return info;
}

uint32_t find_channel(const Volume& volume, const std::string& name) {
  if (name.empty()) return 0;
  uint32_t channel = 0;
  if (bccsplat_volume_find_channel(volume.get(), name.c_str(), &channel) == BCCSPLAT_OK) return channel;
  const uint32_t count = volume_info(volume).channel_count;
  if (const auto number = parse_number<uint32_t>(name); number && *number < count) return *number;
  std::vector<std::string> names;
  for (uint32_t c = 0; c < count; ++c) names.emplace_back(channel_info(volume, c).name);
  fail_usage("no channel \"", name, "\"", did_you_mean(name, names), "; there are ", join(names));
}

const char* value_type_name(int32_t type) {
  static constexpr const char* names[] = {"default", "u8",  "u16", "f16", "f32",
                                          "i16",     "i32", "f64", "i8",  "u32"};
  return type >= 0 && type < 10 ? names[type] : "unknown";
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// ImageJ describes a stack in lines "key=value", OME in XML, tifffile in JSON; all in the words of the first
// page.
#include "readers/tiff/tiff_stack.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "readers/error.h"
#include "readers/lengths.h"
#include "readers/tiff/tiff_shape.h"
#include "readers/vti/xml.h"

namespace bcc4 {
namespace {

std::map<std::string, std::string, std::less<>> image_j_keys(const std::string& text) {
  std::map<std::string, std::string, std::less<>> keys;
  for (const std::string_view line : split(text, "\r\n"))
    if (const size_t at = line.find('='); at != std::string_view::npos)
      keys.emplace(line.substr(0, at), trim(line.substr(at + 1)));
  return keys;
}

// A product of such numbers can go beyond whole numbers of 64 bits; below 2^53 it is exact.
double pages_told(const TiffStack& stack) {
  return static_cast<double>(stack.c) * static_cast<double>(stack.z) * static_cast<double>(stack.t);
}

void check_pages(const TiffFile& file, const TiffStack& stack, const char* way_out) {
  const double told = pages_told(stack);
  if (told == static_cast<double>(file.pages())) return;
  fail_input(file.path(), ": ", stack.said_by, " tells of ", told, " pages, the file has ", file.pages(),
             ": ", way_out);
}

TiffStack image_j_stack(const TiffFile& file) {
  const auto keys = image_j_keys(file.description());
  const auto number = [&](const char* key) -> std::optional<double> {
    const auto found = keys.find(key);
    const auto value = found == keys.end() ? std::nullopt : parse_number<double>(found->second);
    return value && std::isfinite(*value) && *value > 0 ? value : std::nullopt;
  };
  const auto text = [&](const char* key) {
    const auto found = keys.find(key);
    return found == keys.end() ? std::string() : found->second;
  };
  const auto count = [&](const char* key) {
    constexpr double most = 0x1p32;
    return static_cast<uint64_t>(std::min(number(key).value_or(1), most));
  };
  TiffStack stack{.said_by = "ImageJ", .c = count("channels"), .z = count("slices"), .t = count("frames")};
  if (pages_told(stack) == 1) stack.z = count("images");
  check_pages(file, stack,
              "ImageJ writes one page where a file is larger than 4 GB; save it as OME-TIFF, or raw and read "
              "it with --dims");
  if (std::string order = text("order"), sorted = order; order.size() == stack.order.size()) {
    std::sort(sorted.begin(), sorted.end());
    if (sorted == "ctz") stack.order = order;
  }
  stack.unit = length_unit(text("unit"));
  for (size_t a = 0; a < 2; ++a)
    if (const auto r = file.resolution(a); r && keys.contains("unit")) stack.steps[a] = 1 / *r;
  if (const double z = parse_number<double>(text("spacing")).value_or(0); z != 0 && std::isfinite(z))
    stack.steps[2] = std::abs(z); // its sign says how the stage went
  stack.interval = number("finterval");
  if (const auto fps = number("fps"); !stack.interval && fps) stack.interval = 1 / *fps;
  const std::string unit = text("tunit");
  stack.time_unit = unit.empty() || unit == "sec" ? "s" : unit;
  return stack;
}

// Pages may be listed one by one; they have to be where the order of the axes puts them.
void check_listed_pages(const TiffFile& file, const TiffStack& stack, const pugi::xml_node& pixels) {
  for (const pugi::xml_node& data : pixels.children("TiffData")) {
    const auto number = [&](const char* name, uint64_t none) { return data.attribute(name).as_ullong(none); };
    const uint64_t place = stack.page(number("FirstC", 0), number("FirstZ", 0), number("FirstT", 0));
    if (data.attribute("IFD") && number("IFD", 0) != place)
      fail_input(file.path(), ": OME-XML puts page ", number("IFD", 0),
                 " elsewhere than its DimensionOrder "
                 "does: save it again, such as with bfconvert");
  }
}

// Takes when the first plane of each moment was recorded.
void take_moments(TiffStack& stack, const pugi::xml_node& pixels) {
  std::vector<unsigned long long> rank(stack.t, ULLONG_MAX);
  stack.moments.resize(stack.t);
  for (const pugi::xml_node& plane : pixels.children("Plane")) {
    const auto number = [&](const char* name) { return plane.attribute(name).as_ullong(0); };
    const unsigned long long t = number("TheT"), at = number("TheZ") * stack.c + number("TheC");
    const auto time = parse_number<double>(plane.attribute("DeltaT").value());
    if (!time || t >= stack.t || at >= rank[t]) continue;
    rank[t] = at;
    stack.moments[t] = {time, plane.attribute("DeltaTUnit").as_string("s")};
  }
}

// Returns the order of pages in one such as "XYZCT", whose planes are along x and y.
std::string page_order(const std::string& order) {
  const std::string axes = lower(order);
  return axes.starts_with("xy") && axes.size() == std::string_view("xyzct").size() ? axes.substr(2) : "zct";
}

// Takes the steps of x, y and z, each told in a unit of its own, in that of the first one told. Where they
// are not used, units that are not known together do not matter.
void take_steps(TiffStack& stack, const TiffFile& file, const pugi::xml_node& pixels, bool used) {
  bool told = false;
  for (size_t a = 0; a < 3; ++a) {
    const std::string name = concat("PhysicalSize", "XYZ"[a]);
    double step = pixels.attribute(name.c_str()).as_double(0);
    if (!(step > 0)) continue;
    const std::string unit = length_unit(pixels.attribute((name + "Unit").c_str()).as_string("\u00B5m"));
    if (!told) stack.unit = unit, told = true;
    if (const auto ratio = length_ratio(unit, stack.unit))
      step = *ratio < 1 ? step / length_ratio(stack.unit, unit).value() : step * *ratio; // right to the digit
    else if (used)
      fail_input(file.path(), ": OME-XML gives ", name, " in \"", unit, "\", another step in \"", stack.unit,
                 "\", which cannot be made one unit: give --spacing");
    stack.steps[a] = step;
  }
}

TiffStack ome_stack(const TiffFile& file, bool with_steps) {
  std::string text = file.description();
  pugi::xml_document document;
  parse_xml(text, file.path(), document);
  const pugi::xml_node ome = document.child("OME"), image = ome.child("Image"),
                       pixels = image.child("Pixels");
  if (!pixels) fail_input(file.path(), ": OME-XML without the sizes of an image: give its main file");
  if (image.next_sibling("Image"))
    fail_input(file.path(), ": holds several images: save the one that is wanted by itself");
  const auto count = [&](const char* name) { return pixels.attribute(name).as_ullong(1); };
  TiffStack stack{.said_by = "OME-XML",
                  .c = count("SizeC") / file.kind().samples,
                  .z = count("SizeZ"),
                  .t = count("SizeT")};
  stack.order = page_order(pixels.attribute("DimensionOrder").value());
  check_pages(file, stack, "the others are in files beside it; save all in one file, such as with bfconvert");
  check_listed_pages(file, stack, pixels);
  take_steps(stack, file, pixels, with_steps);
  if (const double step = pixels.attribute("TimeIncrement").as_double(0); step > 0) stack.interval = step;
  stack.time_unit = pixels.attribute("TimeIncrementUnit").as_string("s");
  take_moments(stack, pixels);
  for (const pugi::xml_node& channel : pixels.children("Channel"))
    if (const std::string name = channel.attribute("Name").value(); !name.empty())
      stack.names.push_back(name);
  if (stack.names.size() != stack.c) stack.names.clear();
  return stack;
}

TiffStack shaped_stack(const TiffFile& file, const TiffShape& shape) {
  // Who writes page after page tells of each alone.
  if (shape.sizes.empty() && file.pages() > 1) return TiffStack{.z = file.pages()};
  TiffStack stack{.said_by = "tifffile"};
  const size_t axes = shape.sizes.size();
  if (!shape.letters.empty())
    stack.set_axes(shape.letters, shape.sizes);
  else if (axes < 3)
    stack.set_axes(std::string("zt").substr(0, axes), shape.sizes);
  else
    stack.set_axes("z", {file.pages()});
  check_pages(file, stack, "write it anew, each array to a file of its own and without truncate");
  if (shape.letters.empty()) stack.said_by.clear(), stack.unnamed = shape.sizes;
  return stack;
}

} // namespace

void TiffStack::set_axes(const std::string& letters, const std::vector<uint64_t>& sizes) {
  c = z = t = 1;
  for (size_t a = 0; a < letters.size(); ++a) (letters[a] == 'c' ? c : letters[a] == 'z' ? z : t) = sizes[a];
  const std::string all = "czt";
  order = letters;
  for (const char axis : all)
    if (order.find(axis) == std::string::npos) order += axis;
}

uint64_t TiffStack::page(uint64_t channel, uint64_t plane, uint64_t moment) const {
  uint64_t at = 0, stride = 1;
  for (const char axis : order) {
    at += stride * (axis == 'c' ? channel : axis == 'z' ? plane : moment);
    stride *= axis == 'c' ? c : axis == 'z' ? z : t;
  }
  return at;
}

TiffStack tiff_stack(const TiffFile& file, bool with_steps) {
  if (file.description().starts_with("ImageJ=")) return image_j_stack(file);
  if (file.description().find("<OME") != std::string::npos) return ome_stack(file, with_steps);
  if (const auto shape = tiff_shape(file)) return shaped_stack(file, *shape);
  return TiffStack{.z = file.pages()};
}

} // namespace bcc4

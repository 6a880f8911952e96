// SPDX-License-Identifier: Apache-2.0
#include "tool/view/beside.h"

#include "bccsplat.h"
#include "tool/cli.h"
#include "tool/view/looks.h"
#include "tool/view/transfer_function.h"

namespace bcc4 {
namespace {

constexpr const char* with_form =
    "FILE.bcc4,KEY=VALUE,... is expected; keys are channel, look, tf, colormap, range, opacity, density, "
    "color-channel, move and trail";

// "A:B" or "X:Y:Z" as so many numbers.
std::vector<double> numbers_between_colons(const std::string& key, const std::string& text, size_t count) {
  std::vector<double> out;
  for (const std::string_view part : split(text, ":"))
    out.push_back(option_number<double>("--with: " + key, std::string(part)));
  if (out.size() != count)
    fail_usage("--with: ", key, "=", text, ": ", count, " numbers with : between them");
  return out;
}

void set_key(OtherVolume& other, const std::string& key, const std::string& value) {
  const Choices<std::string OtherVolume::*> texts{{"channel", &OtherVolume::channel},
                                                  {"tf", &OtherVolume::tf},
                                                  {"colormap", &OtherVolume::colormap},
                                                  {"color-channel", &OtherVolume::color_channel}};
  for (const auto& [name, member] : texts)
    if (name == key) {
      other.*member = value;
      return;
    }
  if (key == "look") {
    other.look = option_choice<int32_t>("--with: look", value, look_names());
  } else if (key == "range") {
    other.range = numbers_between_colons(key, value, 2);
  } else if (key == "move") {
    const std::vector<double> by = numbers_between_colons(key, value, 3);
    other.move = {by[0], by[1], by[2]};
  } else if (key == "trail") {
    other.trail = parse_trail_span("--with: trail", value);
  } else if (key == "opacity") {
    other.opacity = option_number<double>("--with: opacity", value);
    if (!(*other.opacity >= 0)) fail_usage("--with: opacity=", value, ": must not be negative");
  } else if (key == "density") {
    other.density = option_number<double>("--with: density", value);
    if (!(other.density > 0)) fail_usage("--with: density=", value, ": must be positive");
  } else {
    fail_usage("--with: there is no key ", key, "; ", with_form);
  }
}

OtherVolume parse_other(const std::string& text) {
  OtherVolume other;
  for (const std::string_view part : split(text, ",")) {
    const std::string piece(part);
    const size_t equals = piece.find('=');
    if (other.file.empty() || equals == std::string::npos) {
      other.file += (other.file.empty() ? "" : ",") + piece; // names may hold commas
      continue;
    }
    set_key(other, piece.substr(0, equals), piece.substr(equals + 1));
  }
  if (other.file.empty()) fail_usage("--with ", text, ": ", with_form);
  return other;
}

} // namespace

void add_beside(const Command& command, BesideArguments& a) {
  command.add_texts(
      "--with", "FILE[,KEY=VALUE...]",
      "Another volume in the same picture, right in depth; may be given several times. Keys: channel, "
      "look, tf, colormap, range=LO:HI, opacity, density (a factor), color-channel, move=X:Y:Z (in the "
      "world), trail=DT[f] or A:B[f] (as --trail)",
      [&a](const std::string& t) { a.others.push_back(parse_other(t)); });
  command
      .add_option("--color-channel", a.color_channel,
                  "Colours by the values of this channel, opacity or surface by --channel")
      .type_name("NAME");
  command.add_option("--color-tf", a.color_tf, "ParaView colour map (JSON) of --color-channel")
      .type_name("FILE.json");
  command.add_option("--color-colormap", a.color_colormap, "Built-in colours of --color-channel")
      .type_name("NAME");
  command.add_text("--color-range", "LO,HI", "Values that the colours of --color-channel span",
                   [&a](const std::string& t) { a.color_range = option_numbers("--color-range", t, 2); });
  command.add_option("--mask-channel", a.mask_channel, "Draw only what is of certain labels of this channel")
      .type_name("NAME");
  command.add_text("--mask-labels", "L[,...]", "The labels of --mask-channel that are drawn",
                   [&a](const std::string& t) { a.mask_labels = option_numbers("--mask-labels", t, 0); });
  command.add_flag("--shadow", a.shadow, "The volume throws shadow on itself, by each of its lights");
  command.add_flag("--ao", a.occlusion, "Ambient light is less where the volume is around");
  command.add_texts(
      "--light", "X,Y,Z",
      "Towards a white light, in the world; may be given several times (default: from the camera; "
      "with --shadow from above its left)",
      [&a](const std::string& t) {
        const std::vector<double> d = option_numbers("--light", t, 3);
        if (d[0] == 0 && d[1] == 0 && d[2] == 0) fail_usage("--light ", t, ": a direction is expected");
        a.lights.push_back({d[0], d[1], d[2]});
      });
}

void check_beside(const BesideArguments& a) {
  if (a.color_channel.empty() && (!a.color_tf.empty() || !a.color_colormap.empty() || a.color_range))
    fail_usage("--color-tf, --color-colormap and --color-range go with --color-channel NAME");
  if (!a.color_tf.empty() && !a.color_colormap.empty())
    fail_usage("--color-tf and --color-colormap exclude each other");
  if (a.mask_channel.empty() != a.mask_labels.empty())
    fail_usage(
        "--mask-channel and --mask-labels go together: which channel, and which of its labels are drawn");
  constexpr size_t most_lights = 8;
  if (a.lights.size() > most_lights) fail_usage("--light: at most ", most_lights, " lights");
}

} // namespace bcc4

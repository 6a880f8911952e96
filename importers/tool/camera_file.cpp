#include "tool/camera_file.h"

#include <cmath>

#include "readers/byte_stream.h"
#include "readers/error.h"
#include "tool/json.h"

namespace bcc4 {
namespace {

void read_vector(const Json& json, const std::string& key, double (&out)[3], const std::string& path) {
  const Json& list = json[key];
  bool good = list.is_array() && list.size() == 3;
  for (size_t i = 0; good && i < 3; ++i) {
    good = list[i].is_number();
    if (good) out[i] = list[i].get<double>();
  }
  if (!good) fail_input(path, ": ", key, " must be a list of three numbers");
}

double read_positive(const Json& json, const std::string& key, const std::string& path) {
  if (!json[key].is_number() || !(json[key].get<double>() > 0))
    fail_input(path, ": ", key, " must be a positive number");
  return json[key].get<double>();
}

} // namespace

CameraFile read_camera_file(const std::string& path) {
  const Json json = Json::parse(read_text_file(path, 1 << 20), nullptr, false);
  if (!json.is_object()) fail_input(path, ": a camera is a JSON object");
  static const std::vector<std::string> keys{"position", "target",       "up",
                                             "fovy_deg", "ortho_height", "resolution"};
  for (const auto& [key, value] : json.items())
    if (std::find(keys.begin(), keys.end(), key) == keys.end())
      fail_input(path, ": unknown key \"", key, "\"", did_you_mean(key, keys), "; a camera has ", join(keys));
  for (const char* key : {"position", "target"})
    if (!json.contains(key)) fail_input(path, ": \"", key, "\" is missing");
  CameraFile out;
  bccsplat_camera& c = out.camera;
  c.struct_size = sizeof c;
  read_vector(json, "position", c.position, path);
  read_vector(json, "target", c.target, path);
  c.up[1] = 1;
  if (json.contains("up")) read_vector(json, "up", c.up, path);
  const bool perspective = json.contains("fovy_deg"), orthographic = json.contains("ortho_height");
  if (perspective == orthographic)
    fail_input(path, ": give either fovy_deg (perspective) or ortho_height (orthographic)");
  c.projection = perspective ? BCCSPLAT_PROJECTION_PERSPECTIVE : BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
  if (perspective)
    c.fovy_degrees = read_positive(json, "fovy_deg", path);
  else
    c.ortho_height = read_positive(json, "ortho_height", path);
  if (json.contains("resolution")) {
    const Json& r = json["resolution"];
    if (!r.is_array() || r.size() != 2 || !r[0].is_number_unsigned() || !r[1].is_number_unsigned())
      fail_input(path, ": resolution must be two whole numbers");
    out.resolution = {r[0].get<uint32_t>(), r[1].get<uint32_t>()};
  }
  return out;
}

} // namespace bcc4

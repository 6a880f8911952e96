// SPDX-License-Identifier: Apache-2.0
// A little smoke simulation that makes a 4D data set: two puffing jets collide, billow and rise.
// Writes smoke.0000.raw ... (float32, x fastest) and smoke.0000.vdb ... (fog volume "density"), and with
// --heat heat.0000.raw ... (how much of its heat the smoke still has, 0 to 1). y is up.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>
#include <system_error>
#include <thread>

#include <unistd.h>

#include "smoke/expose.h"
#include "smoke/output.h"
#include "smoke/solver.h"

namespace {

struct Settings {
  int size = 96;  // cells per edge of the cube
  int steps = 48; // frames written
  std::filesystem::path folder = "out";
  bool raw = false, vdb = false, half = false, heat = false;
  int threads = 0; // 0: one per core
  bool progress = isatty(2) != 0;
};

constexpr float frames_per_second = 48; // of simulated time; one solver step per frame
constexpr int lead = 34;                // steps before the first frame: the jets are about to meet

void usage(std::FILE* to) {
  std::fprintf(
      to,
      "usage: simulate_smoke [--size N] [--steps S] [-o FOLDER] [--raw] [--vdb] [--half] [--heat] [--threads "
      "N]\n"
      "  --size N     cells per edge of the cube, even, 16 to 512 (96)\n"
      "  --steps S    frames, 1 to 9999, %g per second (48)\n"
      "  -o FOLDER    made when missing (out)\n"
      "  --raw        write smoke.%%04d.raw, float32, x fastest\n"
      "  --vdb        write smoke.%%04d.vdb, fog volume \"density\"%s\n"
      "               neither: raw, and vdb where it is built in\n"
      "  --half       store 16-bit floats in the .vdb\n"
      "  --heat       write heat.%%04d.raw, too: 1 where smoke comes in, less the longer it has been there\n"
      "  --threads N  0: one per core; the result does not depend on it (0)\n",
      static_cast<double>(frames_per_second), smoke::has_vdb ? "" : " (not built in)");
}

// Reads a whole number; returns false when the text is none in [least, most].
bool read_number(const char* text, int least, int most, int& number) {
  const char* end = text + std::strlen(text);
  const auto [stop, error] = std::from_chars(text, end, number);
  return error == std::errc() && stop == end && number >= least && number <= most;
}

// Reads the command line; returns false after a message when it makes no sense.
bool read_settings(int argc, char** argv, Settings& s) {
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const char* value = i + 1 < argc ? argv[i + 1] : "";
    bool good = true;
    if (option == "--size")
      good = read_number(value, 16, 512, s.size) && s.size % 2 == 0, ++i;
    else if (option == "--steps")
      good = read_number(value, 1, 9999, s.steps), ++i;
    else if (option == "--threads")
      good = read_number(value, 0, 1024, s.threads), ++i;
    else if (option == "-o")
      good = *value != 0, s.folder = value, ++i;
    else if (option == "--raw")
      s.raw = true;
    else if (option == "--vdb")
      s.vdb = true;
    else if (option == "--half")
      s.half = true;
    else if (option == "--heat")
      s.heat = true;
    else {
      std::fprintf(stderr, "simulate_smoke: unknown option %s\n", option.c_str());
      return false;
    }
    if (!good) {
      std::fprintf(stderr, "simulate_smoke: %s cannot be '%s'\n", option.c_str(), value);
      return false;
    }
  }
  if (s.vdb && !smoke::has_vdb) {
    std::fprintf(stderr, "simulate_smoke: --vdb: built without OpenVDB\n");
    return false;
  }
  if (!s.raw && !s.vdb) s.raw = true, s.vdb = smoke::has_vdb;
  if (s.threads == 0) s.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return true;
}

// Returns two jets that lean towards each other and blow in turn, so that each breath rolls up into a ring of
// its own. Their nozzles swing in a circle, against each other, which breaks the symmetry.
std::array<smoke::Source, 2> sources(float seconds) {
  constexpr float turn = 6.2831853f, breaths_per_second = 2.2f, swings_per_second = 3;
  const auto breath = [seconds](float shift) {
    return std::max(0.0f, std::sin(turn * (seconds * breaths_per_second + shift)));
  };
  const float left = breath(0), right = breath(0.45f);
  const float swing_x = 0.5f * std::cos(turn * swings_per_second * seconds);
  const float swing_z = 0.5f * std::sin(turn * swings_per_second * seconds);
  return {smoke::Source{{0.22f, 0.12f, 0.47f},
                        0.065f,
                        {(1.6f + swing_x) * left, 1.3f * left, swing_z * left + 0.06f},
                        std::min(1.0f, 1.5f * left)},
          smoke::Source{{0.78f, 0.12f, 0.53f},
                        0.065f,
                        {(swing_x - 1.6f) * right, 1.3f * right, -swing_z * right - 0.06f},
                        std::min(1.0f, 1.5f * right)}};
}

void simulate(const Settings& s) {
  std::filesystem::create_directories(s.folder);
  smoke::Solver solver(s.size, s.threads, s.heat);
  for (int step = 0; step < lead + s.steps; ++step) {
    const float seconds = static_cast<float>(step) / frames_per_second;
    solver.step(1 / frames_per_second, sources(seconds), smoke::Physics{});
    if (step < lead) continue;
    const int number = step - lead;
    const smoke::Grid frame = smoke::expose(solver.density());
    if (s.raw) smoke::write_raw(smoke::frame_path(s.folder, "smoke", number, "raw"), frame);
    if (s.heat) smoke::write_raw(smoke::frame_path(s.folder, "heat", number, "raw"), solver.heat());
    if (s.vdb)
      smoke::write_vdb(smoke::frame_path(s.folder, "smoke", number, "vdb"), frame, 1.0 / s.size, s.half);
    if (s.progress) std::fprintf(stderr, "\rsmoke: frame %d of %d", number + 1, s.steps);
  }
  if (s.progress) std::fprintf(stderr, "\n");
}

} // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--help") == 0) {
    usage(stdout);
    return 0;
  }
  Settings settings;
  if (!read_settings(argc, argv, settings)) {
    usage(stderr);
    return 2;
  }
  try {
    simulate(settings);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "simulate_smoke: %s\n", e.what());
    return 1;
  }
  return 0;
}

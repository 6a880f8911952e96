// SPDX-License-Identifier: Apache-2.0
// The depth at which the truth's opacity passes 1/2 tells where between two sheets a pixel's surface is, and
// so the phase of the wave that its error is compared with.
#include "tests/bench/sheet_residue.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace bccsplat::bench {
namespace {

constexpr int edge = 16;           // of a block, pixels
constexpr double beside = 1.37;    // periods per sheet
constexpr double least_run = 0.75; // of a surface through a block, sheets

// Adds the squares of the amplitudes in one block, of the part of the colour in which they are largest.
void add_block(SheetResidue& r, const Image& picture, const Image& truth, double step, int x0, int y0) {
  SheetResidue most;
  for (int c = 0; c < 3; ++c) {
    const auto error = [&](int x, int y) {
      return 255 * (static_cast<double>(picture.rgba.at(x, y)[c]) - truth.rgba.at(x, y)[c]);
    };
    double mean = 0;
    for (int y = y0; y < y0 + edge; ++y)
      for (int x = x0; x < x0 + edge; ++x) mean += error(x, y) / (edge * edge);
    std::complex<double> along, other;
    for (int y = y0; y < y0 + edge; ++y)
      for (int x = x0; x < x0 + edge; ++x) {
        const double turn = 2 * std::numbers::pi * *truth.depth.at(x, y) / step;
        const double of_wave = (error(x, y) - mean) * 2 / (edge * edge);
        along += std::polar(1.0, turn) * of_wave, other += std::polar(1.0, beside * turn) * of_wave;
      }
    most.sheets = std::max(most.sheets, std::norm(along)),
    most.beside = std::max(most.beside, std::norm(other));
  }
  r.sheets += most.sheets, r.beside += most.beside;
}

} // namespace

SheetResidue sheet_residue(const Image& picture, const Image& truth, double step) {
  SheetResidue r;
  int blocks = 0;
  for (int y0 = 0; y0 + edge <= picture.height; y0 += edge)
    for (int x0 = 0; x0 + edge <= picture.width; x0 += edge) {
      double low = INFINITY, high = -INFINITY;
      for (int y = y0; y < y0 + edge; ++y)
        for (int x = x0; x < x0 + edge; ++x) {
          const double at = *truth.depth.at(x, y) / step;
          low = std::min(low, at), high = std::max(high, at);
        }
      if (!std::isfinite(high) || high - low < least_run) continue;
      add_block(r, picture, truth, step, x0, y0);
      ++blocks;
    }
  if (blocks > 0) r.sheets = std::sqrt(r.sheets / blocks), r.beside = std::sqrt(r.beside / blocks);
  return r;
}

} // namespace bccsplat::bench

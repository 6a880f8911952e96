// SPDX-License-Identifier: Apache-2.0
#include "choose/wave_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

namespace bccsplat::series {
namespace {

constexpr double kPerUnit = 20; // entries of the tables

// Means over directions at 0, 1/20 .. of the gauge, kernel and prefilter alone (the parts of Blu & Unser's
// error kernel; tests/bench/notes/lattice-fit.md).
constexpr WaveResponse kLattice[] = {
    {1, 9e-7},        {.9999, 9.4e-07}, {.9999, 8.8e-07}, {.9998, 8.8e-07}, {.9998, 9.7e-07},
    {.9998, 1.3e-06}, {.9995, 1.8e-06}, {.9992, 2.7e-06}, {.9985, 4.5e-06}, {.9969, 1.1e-05},
    {.9948, 3.7e-05}, {.9918, 0.00013}, {.9861, 0.0004},  {.9737, 0.0012},  {.946, 0.0032},
    {.8929, 0.0079},  {.8091, 0.017},   {.7015, 0.035},   {.5811, 0.063},   {.4603, 0.1},
    {.3619, 0.19},    {.2684, 0.27},    {.1874, 0.35},    {.1226, 0.42},    {.0784, 0.49},
    {.0481, 0.54},    {.0266, 0.57},    {.0137, 0.61},    {.007, 0.64},     {.0025, 0.65},
    {.0006, 0.67},    {.0001, 0.69},    {0, 0.69}};
constexpr WaveResponse kCartesian[] = {
    {1, 8e-127},     {1, 3.1e-13},     {1, 8.6e-11},     {.9999, 2.4e-09}, {.9998, 2.8e-08}, {.9994, 2e-07},
    {.9987, 1e-06},  {.9973, 4.3e-06}, {.9951, 1.6e-05}, {.9914, 5.1e-05}, {.9855, 0.00015}, {.9766, 0.00041},
    {.9632, 0.0011}, {.9437, 0.0026},  {.916, 0.0059},   {.8776, 0.013},   {.8264, 0.027},   {.761, 0.052},
    {.6814, 0.093},  {.5903, 0.16},    {.4928, 0.24},    {.3956, 0.35},    {.3054, 0.46},    {.2271, 0.58},
    {.1632, 0.68},   {.1137, 0.77},    {.077, 0.84},     {.0507, 0.89},    {.0325, 0.93},    {.0202, 0.95},
    {.0122, 0.97},   {.007, 0.98},     {.0039, 0.99}};

// Between entries straight; the last one goes on.
WaveResponse look_up(std::span<const WaveResponse> table, double at) {
  const auto i = static_cast<size_t>(at);
  if (i + 1 >= table.size()) return table.back();
  const double part = at - static_cast<double>(i);
  return {table[i].pass + part * (table[i + 1].pass - table[i].pass),
          table[i].folded + part * (table[i + 1].folded - table[i].folded)};
}

// Modified Bessel function of order 0, by its power series.
double bessel_i0(double x) {
  double term = 1, sum = 1;
  for (int k = 1; term > 1e-12 * sum; ++k) {
    term *= (x / 2 / k) * (x / 2 / k);
    sum += term;
  }
  return sum;
}

constexpr size_t kPerBand = 50; // entries of the response between frequencies 0 and 1

// Samples the response of the Kaiser-windowed sinc of 8 taps up to frequency 2; the integral by midpoints.
std::array<double, 2 * kPerBand + 1> make_response() {
  constexpr double half = 4, beta = 5.5;
  constexpr int steps = 400;
  std::array<double, 2 * kPerBand + 1> response{};
  for (int i = 0; i < steps; ++i) {
    const double u = (i + 0.5) / steps, p = std::numbers::pi * half * u;
    const double tap = std::sin(p) / p * bessel_i0(beta * std::sqrt(1 - u * u));
    for (size_t f = 0; f < response.size(); ++f)
      response[f] += tap * std::cos(p * static_cast<double>(f) / kPerBand);
  }
  const double sum = response[0];
  for (double& r : response) r /= sum;
  return response;
}

} // namespace

WaveResponse lattice_response(double gauge) { return look_up(kLattice, gauge * kPerUnit); }

WaveResponse cartesian_response(double frequency) { return look_up(kCartesian, frequency * kPerUnit); }

double filter_response(double frequency) {
  static const auto table = make_response();
  const double at = frequency * kPerBand;
  const auto i = static_cast<size_t>(at);
  if (i + 1 >= table.size()) return 0;
  return table[i] + (at - static_cast<double>(i)) * (table[i + 1] - table[i]);
}

} // namespace bccsplat::series

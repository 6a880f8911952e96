// SPDX-License-Identifier: Apache-2.0
// Each call is first let run to its end, for its length; then it is made again and again, cancelled at random
// moments of that length, and what is told is the time from the cancel to its return.
#include "tests/bench/cancel/cancel.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <optional>
#include <random>
#include <thread>

#include <time.h>
#include <unistd.h>

#include "base/error.h"
#include "tests/bench/cancel/cancel_calls.h"
#include "tests/bench/scale/scale_host.h"

namespace bccsplat::bench {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

// CPU time of the process: other programs on the machine do not count.
double cpu_milliseconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

struct Latency {
  double whole_ms = 0; // of the call when nobody cancels it
  std::vector<double> wall, cpu;
};

// Cancels the call at a moment; returns the wall and CPU time until it returned, none where it had ended by
// itself.
std::optional<std::array<double, 2>> cancel_at(const LongCall& call, bccsplat_cancel_token* token,
                                               double after_ms) {
  api(bccsplat_cancel_token_reset(token));
  if (call.prepare) call.prepare();
  Clock::time_point returned;
  double cpu_returned = 0;
  bccsplat_status status = BCCSPLAT_OK;
  std::thread host([&] {
    status = call.run(token);
    returned = Clock::now();
    cpu_returned = cpu_milliseconds();
  });
  std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(after_ms));
  const Clock::time_point asked = Clock::now();
  const double cpu_asked = cpu_milliseconds();
  api(bccsplat_cancel_token_cancel(token));
  host.join();
  if (status != BCCSPLAT_CANCELLED) api(status);
  if (status != BCCSPLAT_CANCELLED) return std::nullopt;
  return {{milliseconds(asked, returned), cpu_returned - cpu_asked}};
}

Latency measure(const LongCall& call, bccsplat_cancel_token* token, int trials) {
  Latency out;
  api(bccsplat_cancel_token_reset(token));
  if (call.prepare) call.prepare();
  const Clock::time_point start = Clock::now();
  api(call.run(token));
  out.whole_ms = milliseconds(start, Clock::now());
  std::mt19937 random(11);
  std::uniform_real_distribution<double> moment(0, 0.95 * out.whole_ms);
  for (int n = 0; n < trials; ++n)
    if (const auto ms = cancel_at(call, token, moment(random)))
      out.wall.push_back((*ms)[0]), out.cpu.push_back((*ms)[1]);
  std::sort(out.wall.begin(), out.wall.end()), std::sort(out.cpu.begin(), out.cpu.end());
  return out;
}

Row row_of(const std::string& name, const Latency& l) {
  const auto at = [](const std::vector<double>& ms, double share) {
    return ms.empty() ? 0 : ms[static_cast<size_t>(share * static_cast<double>(ms.size() - 1))];
  };
  return {word("call", name),
          figure("uncancelled, ms", l.whole_ms, 0),
          figure("cancelled", static_cast<double>(l.wall.size()), 0),
          figure("median ms", at(l.wall, 0.5), 1),
          figure("95 % ms", at(l.wall, 0.95), 1),
          figure("largest ms", at(l.wall, 1), 1),
          figure("95 % CPU ms", at(l.cpu, 0.95), 1),
          figure("largest CPU ms", at(l.cpu, 1), 1)};
}

} // namespace

int run_cancel_suite(std::span<const std::string> args, const Report& report) {
  uint32_t size = report.quick ? 32 : 256;
  int trials = report.quick ? 3 : 20;
  std::string only;
  for (size_t i = 0; i < args.size(); i += 2) {
    if (i + 1 == args.size()) fail(Code::invalid_argument, "cancel: ", args[i], " needs a value");
    if (args[i] == "--size")
      size = static_cast<uint32_t>(std::stoul(args[i + 1]));
    else if (args[i] == "--trials")
      trials = std::stoi(args[i + 1]);
    else if (args[i] == "--only")
      only = args[i + 1];
    else
      fail(Code::invalid_argument, "cancel: unknown option ", args[i]);
  }
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("bccsplat-cancel-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::vector<Row> rows;
  {
    const LongCalls calls(size, folder.string(), 2);
    bccsplat_cancel_token* made = nullptr;
    api(bccsplat_cancel_token_create(&made));
    const host::Handle<bccsplat_cancel_token> token(made);
    for (const LongCall& call : calls.calls())
      if (call.name.find(only) != std::string::npos)
        rows.push_back(row_of(call.name, measure(call, made, trials)));
  }
  std::filesystem::remove_all(folder);
  report.table("Time from the cancel to the end of the call, 2 threads", rows);
  return 0;
}

} // namespace bccsplat::bench

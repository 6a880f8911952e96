// SPDX-License-Identifier: Apache-2.0
// Covering arrays: few cases that hold every pair (or triple) of choices of different options, but those that
// exclude each other. Greedy and seeded: the same cases each time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace bccsplat::test {

// The number of a choice for each option; 0: what is there unless somebody asks.
using ChosenOf = std::vector<size_t>;

class Covering {
 public:
  using Excludes = std::function<bool(size_t option, size_t choice, size_t other, size_t other_choice)>;

  // choices: of each option. excludes: whether two choices cannot be in one case; symmetric.
  Covering(std::vector<size_t> choices, Excludes excludes, size_t strength)
      : choices_(std::move(choices)), excludes_(std::move(excludes)), strength_(strength) {}

  // Those that found no case are in left().
  [[nodiscard]] std::vector<ChosenOf> cases() {
    find_all({});
    std::vector<ChosenOf> all;
    while (!missing_.empty()) {
      ChosenOf best;
      size_t most = 0;
      for (int n = 0; n < candidates; ++n) {
        ChosenOf one = candidate();
        const size_t covers = one.empty() ? 0 : tuples_in(one, false);
        if (covers > most) best = std::move(one), most = covers;
      }
      if (most > 0) {
        (void)tuples_in(best, true);
        all.push_back(std::move(best));
        continue;
      }
      left_.push_back(*missing_.begin());
      missing_.erase(missing_.begin());
    }
    return all;
  }
  using Tuple = std::vector<std::pair<size_t, size_t>>; // option and choice, by rising option
  [[nodiscard]] const std::vector<Tuple>& left() const { return left_; }

 private:
  static constexpr int candidates = 20;

  [[nodiscard]] bool fits(const Tuple& chosen, size_t option, size_t choice) const {
    return std::none_of(chosen.begin(), chosen.end(),
                        [&](const auto& c) { return excludes_(c.first, c.second, option, choice); });
  }
  void find_all(const Tuple& begun) {
    if (begun.size() == strength_) {
      missing_.insert(begun);
      return;
    }
    for (size_t option = begun.empty() ? 0 : begun.back().first + 1; option < choices_.size(); ++option)
      for (size_t choice = 0; choice < choices_[option]; ++choice) {
        if (!fits(begun, option, choice)) continue;
        Tuple more = begun;
        more.emplace_back(option, choice);
        find_all(more);
      }
  }
  // Tuples of a new choice with those before that no case holds yet.
  [[nodiscard]] size_t new_tuples(const Tuple& chosen, size_t option, size_t choice) const {
    size_t count = 0;
    for (size_t a = 0; a < chosen.size(); ++a) {
      if (strength_ == 2) count += missing_.count(sorted({chosen[a], {option, choice}}));
      for (size_t b = 0; strength_ == 3 && b < a; ++b)
        count += missing_.count(sorted({chosen[a], chosen[b], {option, choice}}));
    }
    return count;
  }
  static Tuple sorted(Tuple t) {
    std::sort(t.begin(), t.end());
    return t;
  }
  // A case around a tuple that is missing, the rest chosen one after the other by what they add; empty: none.
  ChosenOf candidate() {
    auto at = missing_.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(random_() % missing_.size()));
    Tuple chosen = *at;
    std::vector<size_t> order(choices_.size());
    std::iota(order.begin(), order.end(), size_t{0});
    for (size_t n = order.size(); n > 1; --n) std::swap(order[n - 1], order[random_() % n]);
    for (const size_t option : order) {
      if (std::any_of(chosen.begin(), chosen.end(), [&](const auto& c) { return c.first == option; }))
        continue;
      size_t best = choices_[option], most = 0;
      const size_t first = random_() % choices_[option];
      for (size_t n = 0; n < choices_[option]; ++n) {
        const size_t choice = (first + n) % choices_[option];
        if (!fits(chosen, option, choice)) continue;
        const size_t adds = new_tuples(chosen, option, choice) + 1;
        if (adds > most) best = choice, most = adds;
      }
      if (best == choices_[option]) return {};
      chosen.emplace_back(option, best);
    }
    ChosenOf one(choices_.size());
    for (const auto& [option, choice] : chosen) one[option] = choice;
    return one;
  }
  // How many of those missing a case holds, which may be taken off.
  size_t tuples_in(const ChosenOf& one, bool take) {
    size_t count = 0;
    for (size_t a = 0; a < one.size(); ++a)
      for (size_t b = a + 1; b < one.size(); ++b) {
        if (strength_ == 2) count += found({{a, one[a]}, {b, one[b]}}, take);
        for (size_t c = b + 1; strength_ == 3 && c < one.size(); ++c)
          count += found({{a, one[a]}, {b, one[b]}, {c, one[c]}}, take);
      }
    return count;
  }
  size_t found(const Tuple& t, bool take) { return take ? missing_.erase(t) : missing_.count(t); }

  std::vector<size_t> choices_;
  Excludes excludes_;
  size_t strength_;
  std::set<Tuple> missing_;
  std::vector<Tuple> left_;
  std::mt19937 random_{20};
};

// Drops choices of a case that fails, one after the other, as long as it does: mostly two are left.
inline ChosenOf reduced(ChosenOf one, const std::function<bool(const ChosenOf&)>& fails) {
  for (bool again = true; again;) {
    again = false;
    for (size_t option = 0; option < one.size(); ++option) {
      if (one[option] == 0) continue;
      ChosenOf less = one;
      less[option] = 0;
      if (fails(less)) one = std::move(less), again = true;
    }
  }
  return one;
}

} // namespace bccsplat::test

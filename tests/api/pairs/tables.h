// SPDX-License-Identifier: Apache-2.0
// Tables of options, and of pairs of their choices that do not go together.
#pragma once

#include <functional>

#include "../../support/covering.h"
#include "asked.h"

namespace host::pairs {

using bccsplat::test::ChosenOf;
using bccsplat::test::Covering;

struct Choice {
  const char* name;
  std::function<void(Asked&)> ask;
};
struct Option {
  const char* name;
  std::vector<Choice> choices; // the first is what nobody asks for
};
// Choices as "option=choice", "option=choice|choice", or "option" for all of its choices but the first: two
// that are never in one case, or more, which may be, and then the case may end in this.
using Together = std::vector<const char*>;
struct Refused {
  Together together;
  bccsplat_status status;
  const char* text; // a part of the sentence
};
struct Known {
  Together together;
  const char* text; // a part of what is wrong
  const char* fault;
};

class Tables {
 public:
  Tables(const std::vector<Option>& options, const std::vector<Refused>& refused,
         const std::vector<Together>& no_sense, const std::vector<Known>& known)
      : options_(options) {
    for (const Refused& r : refused) take(r.together, r.text);
    for (const Together& n : no_sense) take(n, "");
    for (const Known& k : known) take(k.together, k.text);
  }
  [[nodiscard]] std::vector<size_t> counts() const {
    std::vector<size_t> all;
    for (const Option& o : options_) all.push_back(o.choices.size());
    return all;
  }
  [[nodiscard]] bool excludes(size_t option, size_t choice, size_t other, size_t other_choice) const {
    return excluded_.count({{option, choice}, {other, other_choice}}) > 0;
  }
  [[nodiscard]] bool allowed(const ChosenOf& chosen) const {
    for (size_t a = 0; a < chosen.size(); ++a)
      for (size_t b = 0; b < a; ++b)
        if (excludes(a, chosen[a], b, chosen[b])) return false;
    return true;
  }
  [[nodiscard]] Asked asked(const ChosenOf& chosen) const {
    Asked a;
    for (size_t n = 0; n < chosen.size(); ++n) options_[n].choices[chosen[n]].ask(a);
    return a;
  }
  // Whether a case with more than two that are in one row may end so.
  [[nodiscard]] bool may_end_in(const ChosenOf& chosen, const std::string& text) const {
    return std::any_of(of_more_.begin(), of_more_.end(), [&](const auto& row) {
      return text.find(row.second) != std::string::npos &&
             std::all_of(row.first.begin(), row.first.end(),
                         [&](const Covering::Tuple::value_type& c) { return chosen[c.first] == c.second; });
    });
  }
  // A case for each of the groups of choices that a row stands for, of these alone.
  [[nodiscard]] std::vector<ChosenOf> cases_of(const Together& together) const {
    std::vector<ChosenOf> all;
    for (const Covering::Tuple& tuple : tuples_of(together)) {
      all.emplace_back(options_.size());
      for (const auto& [option, choice] : tuple) all.back()[option] = choice;
    }
    return all;
  }
  [[nodiscard]] std::string names(const ChosenOf& chosen) const {
    Covering::Tuple asked;
    for (size_t n = 0; n < chosen.size(); ++n)
      if (chosen[n] > 0) asked.emplace_back(n, chosen[n]);
    return names(asked);
  }
  [[nodiscard]] std::string names(const Covering::Tuple& tuple) const {
    std::string text;
    for (const auto& [option, choice] : tuple)
      text += (text.empty() ? "" : ", ") + std::string(options_[option].name) + "=" +
              options_[option].choices[choice].name;
    return text.empty() ? "nothing" : text;
  }

 private:
  using Chosen = std::pair<size_t, size_t>;
  [[nodiscard]] std::vector<Chosen> chosen_by(const std::string& text) const {
    const size_t end = text.find('=');
    std::vector<Chosen> all;
    for (size_t o = 0; o < options_.size(); ++o) {
      if (text.substr(0, end) != options_[o].name) continue;
      for (size_t c = 0; c < options_[o].choices.size(); ++c) {
        const std::string listed = "|" + (end == std::string::npos ? "" : text.substr(end + 1)) + "|";
        const std::string name = "|" + std::string(options_[o].choices[c].name) + "|";
        if (end == std::string::npos ? c > 0 : listed.find(name) != std::string::npos) all.emplace_back(o, c);
      }
    }
    if (all.empty()) throw std::invalid_argument(text + " is no choice of any option");
    return all;
  }
  [[nodiscard]] std::vector<Covering::Tuple> tuples_of(const Together& together) const {
    std::vector<Covering::Tuple> all{{}};
    for (const char* one : together) {
      std::vector<Covering::Tuple> more;
      for (const Covering::Tuple& before : all)
        for (const Chosen& chosen : chosen_by(one)) {
          more.push_back(before);
          more.back().push_back(chosen);
        }
      all = std::move(more);
    }
    return all;
  }
  void take(const Together& together, const char* text) {
    for (const Covering::Tuple& t : tuples_of(together)) {
      if (t.size() == 2) excluded_.insert({t[0], t[1]}), excluded_.insert({t[1], t[0]});
      if (t.size() > 2) of_more_.emplace_back(t, text);
    }
  }

  const std::vector<Option>& options_;
  std::set<std::pair<Chosen, Chosen>> excluded_;
  std::vector<std::pair<Covering::Tuple, std::string>> of_more_;
};

} // namespace host::pairs

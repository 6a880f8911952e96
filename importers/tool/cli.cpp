// SPDX-License-Identifier: Apache-2.0
// The command line by CLI11, which no other file includes.
#include "tool/cli.h"

#include <CLI/CLI.hpp>

#include <algorithm>

namespace bcc4 {

Option Option::type_name(const std::string& name) const { return Option(option_->type_name(name)); }
Option Option::expected(int least, int most) const { return Option(option_->expected(least, most)); }

Command Command::under(const std::string& heading) const {
  Command same = *this;
  same.heading_ = heading;
  return same;
}

Command Command::under(const std::string& heading, const std::string& topic) const {
  return under(concat(heading, " (", topic, ")"));
}

Option Command::added(CLI::Option* option) const {
  return Option(heading_.empty() ? option : option->group(heading_));
}

std::string Command::name() const { return app_->get_name(); }
std::string Command::help() const { return app_->get_description(); }

std::vector<Command> Command::commands() const {
  std::vector<Command> commands;
  for (CLI::App* command : app_->get_subcommands([](const CLI::App*) { return true; }))
    commands.emplace_back(command);
  return commands;
}

std::vector<OptionText> Command::options() const {
  std::vector<OptionText> texts;
  for (const CLI::Option* option : std::as_const(*app_).get_options()) {
    OptionText& text = texts.emplace_back();
    for (const std::string& name : option->get_snames()) text.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) text.names.push_back("--" + name);
    if (text.names.empty()) text.names = {option->get_name(true)};
    if (option->get_type_size() != 0) text.value = option->get_type_name();
    text.heading = option->get_group();
    text.help = option->get_description();
    text.given = option->count() > 0;
  }
  return texts;
}

std::string Command::examples() const { return app_->get_footer(); }
void Command::set_examples(const std::vector<std::string>& command_lines) const {
  std::string text;
  for (const std::string& line : command_lines) text += concat(text.empty() ? "" : "\n", "  ", line);
  app_->footer(text);
}

Command Command::add_command(const std::string& name, const std::string& help) const {
  return Command(app_->add_subcommand(name, help));
}

Option Command::add_flag(const std::string& names, bool& target, const std::string& help) const {
  return added(app_->add_flag(names, target, help));
}

template<class Value>
Option Command::add_option(const std::string& names, Value& target, const std::string& help) const {
  return added(app_->add_option(names, target, help));
}
template Option Command::add_option(const std::string&, std::string&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;
template Option Command::add_option(const std::string&, int32_t&, const std::string&) const;
template Option Command::add_option(const std::string&, uint32_t&, const std::string&) const;
template Option Command::add_option(const std::string&, std::optional<uint32_t>&, const std::string&) const;
template Option Command::add_option(const std::string&, double&, const std::string&) const;

Option Command::add_text(const std::string& names, const std::string& type, const std::string& help,
                         const Read& read) const {
  return added(app_->add_option_function<std::string>(names, read, help)->type_name(type));
}

Option Command::add_texts(const std::string& names, const std::string& type, const std::string& help,
                          const Read& read) const {
  const auto read_all = [read](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) read(text);
  };
  return added(app_->add_option_function<std::vector<std::string>>(names, read_all, help)
                   ->type_name(type)
                   ->allow_extra_args(false));
}

namespace {

// Returns the text in lines of at most `width` characters, cut between words.
std::string wrapped(const std::string& text, size_t width) {
  std::string out;
  size_t used = 0;
  for (const std::string_view word : split(text, " ")) {
    const bool fits = used + 1 + word.size() <= width;
    if (!out.empty()) out += fits ? ' ' : '\n';
    used = out.empty() || !fits ? word.size() : used + 1 + word.size();
    out += word;
  }
  return out;
}

// Returns the topic of a heading, "lattice" of "What is stored (lattice)"; "" where it has none.
std::string topic_of(const std::string& heading) {
  const size_t open = heading.rfind('(');
  return heading.ends_with(')') && open != std::string::npos
             ? heading.substr(open + 1, heading.size() - open - 2)
             : "";
}

// Help as it is printed: lines that fit, examples before the options, and of topics what they are about.
class HelpPage : public CLI::Formatter {
 public:
  std::string make_description(const CLI::App* app) const override {
    return wrapped(app->get_description(), kWidth) + "\n";
  }
  std::string make_usage(const CLI::App* app, std::string name) const override {
    const std::string examples = app->get_footer();
    return CLI::Formatter::make_usage(app, std::move(name)) +
           (examples.empty() ? "" : "\nExamples:\n" + examples + "\n");
  }
  std::string make_footer(const CLI::App* /*app*/) const override { return ""; }
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    if (mode != CLI::AppFormatMode::Normal) return CLI::Formatter::make_help(app, std::move(name), mode);
    return concat(make_description(app), make_usage(app, std::move(name)), make_positionals(app),
                  sections(app), make_subcommands(app, mode), "\n");
  }
  // What stands under a heading; "" where nothing does.
  std::string section(const CLI::App* app, const std::string& heading) const {
    const auto options = options_under(app, heading);
    return heading.empty() || options.empty() ? "" : make_group(heading, false, options);
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(option->get_description(), kWidth - get_column_width());
  }
  std::string make_subcommand(const CLI::App* command) const override {
    std::stringstream out;
    CLI::detail::format_help(out, command->get_name(), first_sentence(command->get_description()),
                             get_column_width());
    return out.str();
  }

 private:
  static std::vector<const CLI::Option*> options_under(const CLI::App* app, const std::string& heading) {
    return app->get_options([&heading](const CLI::Option* option) {
      return option->get_group() == heading && option->nonpositional();
    });
  }
  // All options but those of topics, and which topics there are.
  std::string sections(const CLI::App* app) const {
    std::string out, topics;
    for (const std::string& heading : app->get_groups()) {
      const std::string topic = topic_of(heading);
      if (topic.empty())
        out += section(app, heading);
      else
        topics += topic_line(app, heading, topic);
    }
    if (topics.empty()) return out;
    return concat(out, "\nMore, by bcc4 help ", app->get_name(), " TOPIC, or all:\n", topics);
  }
  std::string topic_line(const CLI::App* app, const std::string& heading, const std::string& topic) const {
    std::string text = heading.substr(0, heading.rfind(" (")) + ":";
    for (const CLI::Option* option : options_under(app, heading)) text += " " + option->get_name();
    std::stringstream out;
    CLI::detail::format_help(out, "  " + topic, wrapped(text, kWidth - get_column_width()),
                             get_column_width());
    return out.str();
  }
  static constexpr size_t kWidth = 100;
};

// What other programs call things, and how they are done here.
constexpr std::pair<const char*, const char*> kOtherNames[] = {
    {"convert", "bcc4 import makes .bcc4 files, bcc4 export writes other formats"},
    {"crop", "bcc4 export --roi writes a part"},
    {"cut", "bcc4 export --roi writes a part, bcc4 slice --plane a plane over time"},
    {"append", "bcc4 import --append adds frames"},
    {"resume", "bcc4 import --resume goes on with an import"},
    {"diff", "bcc4 compare tells the difference"},
    {"film", "bcc4 render -o FILE.mp4 makes films"},
    {"movie", "bcc4 render -o FILE.mp4 makes films"},
    {"view", "bcc4 render draws pictures"},
    {"show", "bcc4 info tells what is in a file, bcc4 render draws it"},
    {"join", "bcc4 concat joins parts"},
    {"merge", "bcc4 concat joins parts"}};

std::string unknown_command(const Command& tool, const std::string& name) {
  for (const auto& [other, way] : kOtherNames)
    if (name == other) return concat("unknown command \"", name, "\": ", way);
  std::vector<std::string> names;
  for (const Command& command : tool.commands()) names.push_back(command.name());
  return concat("unknown command \"", name, "\"", did_you_mean(name, names), "; there are ", join(names));
}

// Returns what the user may have meant by an argument that nothing takes.
std::string unknown_argument(const Command& tool, const Command* chosen, const std::string& argument) {
  std::vector<std::string> names;
  if (argument.starts_with("-")) {
    for (const OptionText& option : (chosen ? *chosen : tool).options())
      std::copy_if(option.names.begin(), option.names.end(), std::back_inserter(names),
                   [](const std::string& name) { return name.starts_with("--"); });
    return concat("unknown option ", argument, did_you_mean(argument.substr(0, argument.find('=')), names));
  }
  if (chosen) return concat("unexpected argument \"", argument, "\"");
  return unknown_command(tool, argument);
}

} // namespace

std::string Command::help_page(const std::string& topic) const {
  const CLI::App* parent = app_->get_parent();
  const std::string name = concat(parent ? parent->get_name() + " " : "", app_->get_name());
  const HelpPage page;
  if (topic.empty()) return page.make_help(app_, name, CLI::AppFormatMode::Normal);
  if (topic == "all") return page.make_help(app_, name, CLI::AppFormatMode::All);
  std::vector<std::string> topics{"all"};
  for (const std::string& heading : app_->get_groups()) {
    const std::string of_heading = topic_of(heading);
    if (topic == of_heading) return page.section(app_, heading).substr(1);
    if (!of_heading.empty()) topics.push_back(of_heading);
  }
  fail_usage("help ", app_->get_name(), " ", topic, ": no such topic", did_you_mean(topic, topics),
             "; there are ", join(topics));
}

std::string first_sentence(const std::string& text) {
  const std::string first = text.substr(0, text.find(". "));
  return first.ends_with('.') ? first.substr(0, first.size() - 1) : first;
}

void fail_unknown_command(const Command& tool, const std::string& name) {
  fail_usage(unknown_command(tool, name), "; see bcc4 help");
}

CommandLine::CommandLine(const std::string& name, const std::string& help, const std::string& version)
    : app_(std::make_unique<CLI::App>(help, name)) {
  app_->formatter(std::make_shared<HelpPage>());
  app_->set_version_flag("--version", version);
  app_->require_subcommand(0, 1); // a second command's name is an argument, as in "bcc4 help import"
  app_->set_help_all_flag("--help-all", "Help for all commands");
  app_->option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::Throw);
}

CommandLine::~CommandLine() = default;

Command CommandLine::tool() const { return Command(app_.get()); }

std::optional<std::string> CommandLine::parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::Success& e) {
    app_->exit(e);
    return std::nullopt;
  } catch (const CLI::ExtrasError&) {
    const std::vector<CLI::App*> chosen = app_->get_subcommands();
    const std::vector<std::string> extras = app_->remaining(true);
    if (chosen.empty() && !extras.front().starts_with("-")) fail_unknown_command(tool(), extras.front());
    const auto option =
        std::find_if(extras.begin(), extras.end(), [](const std::string& s) { return s.starts_with("-"); });
    const std::optional<Command> command =
        chosen.empty() ? std::nullopt : std::optional(Command(chosen.front()));
    fail_usage(unknown_argument(tool(), command ? &*command : nullptr,
                                option != extras.end() ? *option : extras.front()),
               "; see bcc4 ", command ? command->name() + " " : "", "--help");
  } catch (const CLI::ParseError& e) {
    const std::vector<CLI::App*> chosen = app_->get_subcommands();
    fail_usage(e.what(), "; see bcc4 help", chosen.empty() ? "" : " " + chosen.front()->get_name());
  }
  const std::vector<CLI::App*> chosen = app_->get_subcommands();
  return chosen.empty() ? "" : chosen.front()->get_name();
}

void add_threads(const Command& command, CommonOptions& options) {
  command.add_text("--threads", "N", "Threads to use (default: as many as the machine has)",
                   [&options](const std::string& text) {
                     options.threads = option_number<int>("--threads", text);
                     if (options.threads < 1) fail_usage("--threads ", text, ": at least 1");
                   });
}

void add_max_memory(const Command& command, CommonOptions& options) {
  command.add_text(
      "--max-mem", "BYTES", "Memory for data, such as 500M or 4G (default: no limit)",
      [&options](const std::string& text) { options.max_memory = option_bytes("--max-mem", text); });
}

} // namespace bcc4

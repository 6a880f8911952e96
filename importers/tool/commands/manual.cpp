// SPDX-License-Identifier: Apache-2.0
// bcc4 help, manual and completion: written from the options themselves, so that neither can fall behind
// them.
#include <algorithm>
#include <cstdio>

#include "tool/cli.h"
#include "tool/commands/commands.h"

namespace bcc4 {
namespace {

// An option as the texts need it.
struct Named : OptionText {
  std::vector<std::string> choices; // of "a|b|c"
};

struct CommandText {
  std::string name, help, examples;
  std::vector<Named> options, arguments;
};

std::vector<std::string> choices_of(const std::string& value) {
  const bool choice =
      value.find('|') != std::string::npos && std::all_of(value.begin(), value.end(), [](char c) {
        return c == '|' || c == '-' || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
      });
  std::vector<std::string> choices;
  if (choice)
    for (const std::string_view word : split(value, "|")) choices.emplace_back(word);
  return choices;
}

std::vector<CommandText> commands_of(const Command& tool) {
  std::vector<CommandText> commands;
  for (const Command& command : tool.commands()) {
    CommandText text{command.name(), command.help(), command.examples(), {}, {}};
    for (const OptionText& option : command.options())
      (option.is_argument() ? text.arguments : text.options).push_back({option, choices_of(option.value)});
    commands.push_back(std::move(text));
  }
  return commands;
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : between) + word;
  return out;
}

std::string replaced(std::string_view text, char from, const char* to) {
  std::string out;
  for (const char c : text) c == from ? out += to : out += c;
  return out;
}

// Text for roff: no line may begin with a dot or a quote, and a hyphen is a minus.
std::string roff(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) out += "\\&";
    out += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
  }
  return out;
}

std::string manual(const Command& tool, const std::string& version) {
  std::string out = ".TH BCC4 1 \"\" \"" + roff(version) + "\" \"User Commands\"\n.SH NAME\nbcc4 \\- " +
                    roff(tool.help()) + "\n.SH SYNOPSIS\n";
  const std::vector<CommandText> commands = commands_of(tool);
  for (const CommandText& c : commands) {
    out += ".B bcc4 " + roff(c.name) + "\n[options]";
    for (const Named& argument : c.arguments) out += " \\fI" + roff(argument.names[0]) + "\\fR";
    out += "\n.br\n";
  }
  out += ".SH DESCRIPTION\nStores time\\-varying volumes as the relevant points of a D4* lattice, cuts "
         "slices at any time "
         "and orientation out of the four\\-dimensional field, and draws them.\n.SH COMMANDS\n";
  for (const CommandText& c : commands) {
    out += ".SS " + roff(c.name) + "\n" + roff(c.help) + "\n";
    if (!c.examples.empty()) out += ".PP\n.nf\n" + roff(c.examples) + "\n.fi\n";
    const std::string* heading = nullptr;
    for (const Named& o : c.options) {
      if (heading && *heading != o.heading) out += ".PP\n" + roff(o.heading) + ":\n";
      heading = &o.heading;
      out += ".TP\n\\fB" + roff(joined(o.names, ", ")) + "\\fR" +
             (o.value.empty() ? "" : " \\fI" + roff(o.value) + "\\fR") + "\n" + roff(o.help) + "\n";
    }
  }
  return out + ".SH EXIT STATUS\n.TP\n0\nsuccess\n.TP\n1\na check found damage or a "
               "difference\n.TP\n2\nwrong use\n.TP\n3\n"
               "bad input\n.TP\n4\ntoo little memory or disk\n.TP\n130\ninterrupted\n";
}

std::string bash_completion(const std::vector<CommandText>& commands) {
  std::string names, cases;
  for (const CommandText& c : commands) {
    names += (names.empty() ? "" : " ") + c.name;
    std::string options, values;
    for (const Named& o : c.options) {
      options += (options.empty() ? "" : " ") + joined(o.names, " ");
      if (!o.choices.empty())
        values += "      " + joined(o.names, "|") + ") words='" + joined(o.choices, " ") + "' ;;\n";
      else if (!o.value.empty())
        values += "      " + joined(o.names, "|") + ") words= ;;\n";
    }
    cases +=
        "  " + c.name + ")\n    words='" + options + "'\n    case $before in\n" + values + "    esac ;;\n";
  }
  return "# bash completion of bcc4; `bcc4 completion bash` prints it\n"
         "_bcc4() {\n"
         "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words=\n"
         "  if ((COMP_CWORD == 1)); then words='" +
         names + " --help --version'; fi\n  case ${COMP_WORDS[1]} in\n" + cases +
         "  esac\n"
         "  case $word in\n"
         "  -*) mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\") ;;\n"
         "  *) if [[ $words == -* || -z $words ]]; then mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
         "     else mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\"); fi ;;\n"
         "  esac\n"
         "}\n"
         "complete -o filenames -F _bcc4 bcc4\n";
}

std::string zsh_completion(const std::vector<CommandText>& commands) {
  const auto text = [](std::string_view s) { // inside [ ] within '' quotes
    return replaced(replaced(replaced(s, '\'', "'\\''"), '[', "("), ']', ")");
  };
  std::string list, cases;
  for (const CommandText& c : commands) {
    list += "    '" + c.name + ":" + text(replaced(first_sentence(c.help), ':', "\\:")) + "'\n";
    cases += "  " + c.name + ")\n    _arguments";
    for (const Named& o : c.options)
      for (const std::string& name : o.names) {
        cases += " \\\n      '" + name + "[" + text(replaced(o.help, ':', "\\:")) + "]";
        if (!o.choices.empty())
          cases += ":value:(" + joined(o.choices, " ") + ")";
        else if (!o.value.empty())
          cases += ":value:_files";
        cases += "'";
      }
    cases += " \\\n      '*:file:_files' ;;\n";
  }
  return "#compdef bcc4\n# `bcc4 completion zsh` prints it\n_bcc4() {\n  local -a commands=(\n" + list +
         "  )\n  if ((CURRENT == 2)); then\n    _describe command commands\n    return\n  fi\n"
         "  local command=$words[2]\n  shift words\n  ((CURRENT--))\n  case $command in\n" +
         cases + "  esac\n}\n_bcc4 \"$@\"\n";
}

std::string fish_completion(const std::vector<CommandText>& commands) {
  const auto text = [](std::string_view s) { return replaced(replaced(s, '\\', "\\\\"), '\'', "\\'"); };
  std::string out = "# `bcc4 completion fish` prints it\n";
  for (const CommandText& c : commands)
    out += "complete -c bcc4 -n __fish_use_subcommand -f -a " + c.name + " -d '" +
           text(first_sentence(c.help)) + "'\n";
  for (const CommandText& c : commands)
    for (const Named& o : c.options) {
      out += "complete -c bcc4 -n '__fish_seen_subcommand_from " + c.name + "'";
      for (const std::string& name : o.names)
        out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (!o.choices.empty())
        out += " -x -a '" + joined(o.choices, " ") + "'";
      else if (!o.value.empty())
        out += " -r";
      out += " -d '" + text(o.help) + "'\n";
    }
  return out;
}

} // namespace

Run add_help(const Command& tool) {
  const Command help = tool.add_command("help", "Print what a command does and its options");
  const auto name = std::make_shared<std::string>();
  const auto topic = std::make_shared<std::string>();
  help.add_option("COMMAND", *name, "A command of bcc4 (default: all of them in short)");
  help.add_option("TOPIC", *topic, "A topic that the command's page names, or all (default: that page)");
  help.set_examples({"bcc4 help import", "bcc4 help import lattice", "bcc4 help import all"});
  return [tool, name, topic] {
    const std::vector<Command> commands = tool.commands();
    const auto found = std::find_if(commands.begin(), commands.end(),
                                    [&](const Command& command) { return command.name() == *name; });
    if (found == commands.end() && !name->empty()) fail_unknown_command(tool, *name);
    std::fputs((name->empty() ? tool : *found).help_page(*topic).c_str(), stdout);
    return Exit::ok;
  };
}

Run add_manual(const Command& tool, std::string version) {
  tool.add_command("manual", "Print the manual page (roff, section 1)");
  return [tool, version = std::move(version)] {
    std::fputs(manual(tool, version).c_str(), stdout);
    return Exit::ok;
  };
}

Run add_completion(const Command& tool) {
  const Command command = tool.add_command("completion", "Print the completion script of a shell");
  const auto shell = std::make_shared<std::string>();
  command.add_option("SHELL", *shell, "bash, zsh or fish");
  return [tool, shell] {
    const std::vector<CommandText> commands = commands_of(tool);
    if (*shell == "bash")
      std::fputs(bash_completion(commands).c_str(), stdout);
    else if (*shell == "zsh")
      std::fputs(zsh_completion(commands).c_str(), stdout);
    else if (*shell == "fish")
      std::fputs(fish_completion(commands).c_str(), stdout);
    else
      fail_usage("completion", shell->empty() ? "" : " " + *shell, ": of bash, zsh or fish?");
    return Exit::ok;
  };
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
#include "server/help/option_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>

namespace fanlight {

namespace {

std::string first_name(const CLI::Option& option) {
  return option.get_lnames().empty() ? option.get_name() : "--" + option.get_lnames().front();
}

std::string names_of(const std::set<CLI::Option*>& options) {
  // CLI11 orders them by their addresses.
  std::vector<std::string> names;
  names.reserve(options.size());
  for (const CLI::Option* const option : options) names.push_back(first_name(*option));
  std::ranges::sort(names);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string text_of(const CLI::Option& option) {
  std::string text = option.get_description();
  if (option.get_required() && option.nonpositional()) text += "; required";
  if (!option.get_needs().empty()) text += "; needs " + names_of(option.get_needs());
  if (!option.get_excludes().empty()) text += "; not with " + names_of(option.get_excludes());
  return text;
}

/// CLI11 appends the descriptions of the checks after a colon, and has names of types for programmers.
std::string value_of(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return "";
  const std::string type = option.get_type_name();
  const std::string name = type.substr(0, type.find(':'));
  if (name == "INT" || name == "UINT") return "N";
  return name == "FLOAT" ? "NUMBER" : name;
}

std::vector<std::string> split(std::string_view text, char at) {
  std::vector<std::string> parts;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(at), text.size());
    parts.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return parts;
}

OptionRow row_of(const CLI::Option& option) {
  OptionRow row{.option = &option,
                .value = value_of(option),
                .text = text_of(option),
                .usual = option.get_default_str()};
  for (const std::string& name : option.get_snames()) row.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) row.names.push_back("--" + name);
  if (row.value.find('|') != std::string::npos) row.choices = split(row.value, '|');
  return row;
}

}  // namespace

std::string OptionRow::key() const {
  return option->get_lnames().empty() ? "" : option->get_lnames().front();
}

std::vector<OptionGroup> option_table(const CLI::App& command) {
  std::vector<OptionGroup> groups;
  for (const CLI::Option* const option : command.get_options()) {
    if (option->get_group().empty()) continue;  // hidden
    auto group = std::ranges::find(groups, option->get_group(), &OptionGroup::name);
    if (group == groups.end()) group = groups.insert(groups.end(), {option->get_group(), {}});
    group->rows.push_back(row_of(*option));
  }
  // Help comes first in CLI11, where it is not expected. (Not std::ranges: clang 14, whose tidy checks
  // this, cannot read its subrange in the library of gcc 12.)
  std::stable_partition(groups.begin(), groups.end(),
                        [](const OptionGroup& group) { return group.name != "Help"; });
  std::stable_partition(groups.begin(), groups.end(),
                        [](const OptionGroup& group) { return !is_rare(group.name); });
  return groups;
}

std::vector<const CLI::App*> subcommands(const CLI::App& command) {
  return command.get_subcommands([](const CLI::App* sub) { return !sub->get_name().empty(); });
}

const CLI::App* find_subcommand(const CLI::App& command, std::string_view name) {
  const auto all = subcommands(command);
  const auto found = std::ranges::find(all, name, &CLI::App::get_name);
  return found == all.end() ? nullptr : *found;
}

bool is_rare(std::string_view group) {
  return group.starts_with("Scene: ");
}

const CLI::App& program_of(const CLI::App& command) {
  return command.get_parent() == nullptr ? command : program_of(*command.get_parent());
}

std::string command_path(const CLI::App& command) {
  if (command.get_parent() == nullptr) return "";
  const std::string before = command_path(*command.get_parent());
  return before.empty() ? command.get_name() : before + " " + command.get_name();
}

bool takes_source(const CLI::App& command) {
  constexpr std::string_view kCommands[] = {"serve", "render", "export", "record"};
  return std::ranges::find(kCommands, command_path(command)) != std::end(kCommands);
}

std::vector<ExitCode> exit_codes() {
  return {{0, "done"},
          {1, "the command failed; one sentence on standard error says why, and what was expected"},
          {2,
           "the command line, the environment, the configuration, or (serve) a file named there is wrong: "
           "a retry would fail too"}};
}

std::vector<Example> examples_of(std::string_view command) {
  struct Row {
    std::string_view command;
    Example example;
  };
  static constexpr Row kRows[] = {
      {"", {"fanlight serve", "the simulated probe on http://127.0.0.1:8080/"}},
      {"", {"fanlight serve liver.igs.mha", "a recording, in a loop"}},
      {"", {"fanlight render liver.igs.mha --out liver.png", "a recording to a picture"}},
      {"serve", {"fanlight serve", "the simulated probe on http://127.0.0.1:8080/"}},
      {"serve", {"fanlight serve phantom:scene=sphere,lost=5", "another body, and lost frames"}},
      {"serve", {"fanlight serve liver.igs.mha --speed 0.5", "a recording at half its speed"}},
      {"serve", {"fanlight serve usb:1d50:6190 --title \"Theatre 3\"", "a probe on USB"}},
      {"serve", {"fanlight serve igtl:scanner.local", "a PlusServer or a scanner, by OpenIGTLink"}},
      {"serve", {"fanlight serve --listen 9000 --look clinical", "another port, another light"}},
      {"serve", {"fanlight serve --config fanlight.toml", "options from a file"}},
      {"serve", {"fanlight serve --print-config > fanlight.toml", "such a file, with all options"}},
      {"render", {"fanlight render phantom: --out face.png", "the simulated probe"}},
      {"render", {"fanlight render liver.igs.mha --out liver.png --depth z.exr", "with depths in mm"}},
      {"render", {"fanlight render liver.igs.mha --all --out liver.mp4", "every volume, as a video"}},
      {"render", {"fanlight render phantom: --out - > face.png", "to standard output, as PNG"}},
      {"export", {"fanlight export phantom: --out face.html", "the simulated probe"}},
      {"export", {"fanlight export liver.igs.mha --all --out liver.html", "every volume, as a film"}},
      {"batch", {"fanlight batch sweeps.toml", "all sweeps, one after the other"}},
      {"batch", {"fanlight batch sweeps.toml --shard 2/16", "one of 16 shards"}},
      {"batch", {"seq 4 | xargs -P 4 -I{} fanlight batch sweeps.csv --shard {}/4", "in four processes"}},
      {"batch", {"fanlight batch sweeps.toml --report", "results of all shards"}},
      {"watch", {"fanlight watch", "statistics of the local server, each second"}},
      {"watch", {"fanlight watch 127.0.0.1:9000 --save shot --pictures 1", "one picture to a file"}},
      {"watch", {"fanlight watch --set light.up_mm=20 --seconds 1", "move the light"}},
      {"token", {"fanlight token add --tokens tokens.toml --name ward-3", "a token for a display"}},
      {"token", {"fanlight token list --tokens tokens.toml", "the tokens in the file"}},
      {"token add", {"fanlight token add --tokens tokens.toml --name ward-3", "a viewer"}},
      {"token add",
       {"fanlight token add --tokens tokens.toml --name ward-3 --role operator --expires 2027-01-31",
        "an operator, until a day"}},
      {"token revoke", {"fanlight token revoke --tokens tokens.toml 3f9a01bc", "a token, by its id"}},
      {"audit", {"fanlight audit audit.jsonl", "verify a log"}},
      {"bench", {"fanlight bench --only r1/paper", "the times of each pass for one row"}},
      {"bench", {"fanlight bench --input liver.igs.mha", "the times for a recording"}},
      {"info", {"fanlight info", "the GPUs of this machine"}},
      {"info", {"fanlight info liver.igs.mha", "a recording"}},
      {"info", {"fanlight info sweep.mha --write-geometry", "write a geometry to edit"}},
      {"record", {"fanlight record usb:1d50:6190 --out sweep.igs.mha --seconds 20", "20 seconds"}},
      {"recover", {"fanlight recover sweep.igs.mha", "after a crash or a full disk"}},
      {"convert", {"fanlight convert liver.igs.mha --out liver.nrrd --volume 3", "a volume on a grid"}},
      {"convert", {"fanlight convert liver.igs.mha --out liver.seq.nrrd", "all frames, with their fields"}},
      {"send", {"fanlight send --to ARCHIVE@10.0.0.5:11112", "whether the archive answers"}},
      {"send",
       {"fanlight send face.png volume.dcm --to ARCHIVE@10.0.0.5:11112 --patient order.json",
        "a picture and a volume"}},
      {"send",
       {"fanlight send --queue /var/lib/fanlight/outbox --follow --to ARCHIVE@10.0.0.5:11112",
        "what comes into a queue, until Ctrl-C"}},
      {"worklist", {"fanlight worklist RIS@10.0.0.6:104 --date 20261128", "the examinations of a day"}},
      {"worklist",
       {"fanlight worklist RIS@10.0.0.6:104 --accession A1234 --save order.json", "one, to a file"}},
      {"view", {"fanlight view", "the server on this machine, in a window"}},
      {"view", {"fanlight view --full-screen", "on a scanner's own screen"}},
      {"view", {"fanlight view https://theatre3.example:8443 --server-ca ca.pem", "another machine"}},
  };
  std::vector<Example> examples;
  for (const Row& row : kRows) {
    if (row.command == command) examples.push_back(row.example);
  }
  return examples;
}

}  // namespace fanlight

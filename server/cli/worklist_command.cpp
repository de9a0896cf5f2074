// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "proto/base/file_replacement.hpp"
#include "proto/base/printable.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/json_text.hpp"
#include "server/cli/pacs_options.hpp"
#include "server/pacs/identity_json.hpp"
#include "server/pacs/worklist.hpp"

namespace fanlight {

namespace {

struct WorklistOptions {
  PacsOptions pacs;
  WorklistQuery query;
  std::string save;
  bool json = false;
};

nlohmann::ordered_json entry_json(const WorklistEntry& entry) {
  return {{"date", entry.date},
          {"time", entry.time},
          {"step", entry.step_description},
          {"station", entry.station_title},
          {"patient", identity_json(entry.identity)}};
}

void print_entries(const std::vector<WorklistEntry>& entries) {
  for (const WorklistEntry& entry : entries) {
    fmt::print("{} {}  {}  {}  {}  {}\n", entry.date, entry.time.substr(0, 4),
               entry.identity.accession_number, entry.identity.patient_id, entry.identity.patient_name,
               entry.step_description);
  }
}

/// For fanlight send --patient. The owner alone may read it.
Result<void> save_entry(const std::string& path, const std::vector<WorklistEntry>& entries) {
  if (entries.size() != 1) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{} entries match, expected exactly one to save: narrow the query, such as with "
                             "--accession",
                             entries.size())};
  }
  constexpr mode_t kOwnerOnly = 0600;
  const std::string text = identity_json(entries.front().identity).dump(2) + "\n";
  return replace_file(path, text, {.mode = kOwnerOnly});
}

Result<void> check_date(const std::string& date) {
  static const std::regex dates("([0-9]{8})?(-)?([0-9]{8})?");
  if (std::regex_match(date, dates)) return {};
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("--date {} is no day, expected YYYYMMDD, or YYYYMMDD-YYYYMMDD", printable(date))};
}

Result<void> list(const WorklistOptions& options) {
  if (auto date = check_date(options.query.date); !date) return date;
  const auto peer = options.pacs.dicom_peer();
  if (!peer) return peer.error();
  const auto entries = find_worklist(*peer, options.query);
  if (!entries) return entries.error();
  if (options.json) {
    nlohmann::ordered_json report = nlohmann::ordered_json::array();
    for (const WorklistEntry& entry : *entries) report.push_back(entry_json(entry));
    fmt::print("{}\n", json_text(report, 2));
  } else if (options.save.empty()) {
    print_entries(*entries);
  }
  return options.save.empty() ? Result<void>() : save_entry(options.save, *entries);
}

}  // namespace

Command add_worklist_command(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("worklist", "List the examinations that a worklist server has scheduled");
  const auto options = std::make_shared<WorklistOptions>();
  command->add_option("PEER", options->pacs.peer, "Worklist server, TITLE@HOST:PORT")
      ->required()
      ->type_name("PEER");
  command
      ->add_option("--date", options->query.date,
                   "Only this day, YYYYMMDD, or from one to another, with a hyphen")
      ->type_name("DATE");
  command->add_option("--station", options->query.station_title, "Only what is scheduled for this title")
      ->type_name("TITLE");
  command->add_option("--modality", options->query.modality, "Only this modality; empty: any")
      ->capture_default_str()
      ->type_name("CODE");
  command
      ->add_option("--patient-id", options->query.patient_id, "Only this patient; * and ? match characters")
      ->type_name("ID");
  command
      ->add_option("--accession", options->query.accession_number,
                   "Only this order; * and ? match characters")
      ->type_name("NUMBER");
  command
      ->add_option("--save", options->save,
                   "Write the only entry to a JSON file, for --patient of send and convert")
      ->type_name("FILE");
  command->add_flag("--json", options->json, "Print the entries as JSON");
  options->pacs.add_to(*command);
  return [options] { return list(*options); };
}

}  // namespace fanlight

// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <utility>

#include "proto/base/file_replacement.hpp"
#include "proto/base/printable.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/json_text.hpp"
#include "server/cli/pacs_options.hpp"
#include "server/pacs/identity_json.hpp"
#include "server/pacs/private_file.hpp"
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
  nlohmann::json patient = identity_json(entry.identity);
  for (auto& [name, value] : patient.items()) value = printable(value.get<std::string>());
  return {{"date", printable(entry.date)},
          {"time", printable(entry.time)},
          {"step", printable(entry.step_description)},
          {"station", printable(entry.station_title)},
          {"patient", std::move(patient)}};
}

void print_entries(const std::vector<WorklistEntry>& entries) {
  for (const WorklistEntry& entry : entries) {
    const DicomIdentity& of = entry.identity;
    fmt::print("{} {}  {}  {}  {}  {}\n", printable(entry.date), printable(entry.time.substr(0, 4)),
               printable(of.accession_number), printable(of.patient_id), printable(of.patient_name),
               printable(entry.step_description));
  }
}

/// The identity for objects, exactly as the worklist has it, or not at all. A sex that DICOM does not have,
/// such as U for unknown, is left out as not known.
Result<DicomIdentity> exact_identity(const WorklistEntry& entry) {
  if (entry.has_unknown_characters) {
    return Error{ErrorCode::kBadInput,
                 "the entry is in a character set that cannot be read, expected one of DICOM's"};
  }
  DicomIdentity identity = entry.identity;
  if (!check_identity({.sex = identity.sex})) {
    fmt::print(stderr, "fanlight worklist: the sex is left out, expected M, F or O in the worklist\n");
    identity.sex.clear();
  }
  if (auto fits = check_identity(identity); !fits) return fits.error();
  return identity;
}

/// For fanlight send --patient. The owner alone may read it.
Result<void> save_entry(const std::string& path, const std::vector<WorklistEntry>& entries) {
  if (entries.empty()) {
    return Error{
        ErrorCode::kNotFound,
        "no entry matches, expected one to save: see --date, --accession and --modality, which is US"};
  }
  if (entries.size() != 1) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{} entries match, expected exactly one to save: narrow the query, such as with "
                             "--accession",
                             entries.size())};
  }
  const auto identity = exact_identity(entries.front());
  if (!identity) return identity.error();
  std::error_code unknown;
  const auto status = std::filesystem::status(path, unknown);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} is no regular file, expected one or a new name", printable(path))};
  }
  const std::string text = identity_json(*identity).dump(2) + "\n";
  const int failure = write_private_file(path, ExistingFile::kReplace, text);
  if (failure == 0) return {};
  return Error{ErrorCode::kUnavailable,
               fmt::format("{} cannot be written ({}), expected a folder with free space", printable(path),
                           write_failure(failure))};
}

Result<void> check_date(const std::string& date) {
  static const std::regex dates("|[0-9]{8}|[0-9]{8}-|-[0-9]{8}|[0-9]{8}-[0-9]{8}");
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
      ->add_option(
          "--patient-id", options->query.patient_id,
          "Only this patient; * and ? match characters. Other users of this machine see it in the list of "
          "processes")
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

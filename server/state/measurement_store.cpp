// SPDX-License-Identifier: Apache-2.0
#include "server/state/measurement_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>

#include "proto/base/printable.hpp"
#include "server/state/measurement_check.hpp"
#include "server/state/measurement_file.hpp"

namespace fanlight {

namespace {

// Of a message: what a session has room for among its answers.
constexpr std::size_t kMostPartBytes = 100'000;

int points_of(const v1::Measurement& measurement) {
  return measurement.points_size() + measurement.path_size();
}

bool is_within(const v1::Measurement& measurement, std::uint64_t first, std::uint64_t last) {
  return measurement.first_frame_number() >= first && measurement.last_frame_number() <= last;
}

Error not_found() {
  return {ErrorCode::kNotFound, "there is no measurement of this id, expected one of the list"};
}

}  // namespace

std::uint64_t MeasurementStore::random_id() {
  std::random_device device;
  return static_cast<std::uint64_t>(device()) << 32 | device() | 1;
}

std::vector<MeasurementStore::Kept>::iterator MeasurementStore::find(std::uint64_t id) {
  return std::ranges::find(kept_, id, [](const Kept& each) { return each.measurement.id(); });
}

Result<void> MeasurementStore::request(const v1::MeasurementRequest& request) {
  thread_owner_.check();
  switch (request.wish_case()) {
    case v1::MeasurementRequest::kAdd: {
      if (auto added = add(request.add()); !added) return added;
      break;
    }
    case v1::MeasurementRequest::kRename: {
      if (auto renamed = rename(request.rename()); !renamed) return renamed;
      break;
    }
    case v1::MeasurementRequest::kRemove: {
      if (auto removed = remove(request.remove()); !removed) return removed;
      break;
    }
    case v1::MeasurementRequest::kRemoveAll:
      if (!request.remove_all()) return Error{ErrorCode::kInvalidArgument, "remove_all: expected true"};
      kept_.clear();
      ++clearings_;
      bytes_ = 0;
      ++revision_;
      break;
    case v1::MeasurementRequest::WISH_NOT_SET:
      return Error{ErrorCode::kInvalidArgument,
                   "the wish is not known, expected add, rename, remove or remove_all"};
  }
  overview_.clear();
  changed_();
  return {};
}

Result<void> MeasurementStore::add(v1::Measurement measurement) {
  if (measurement.id() == 0) measurement.set_id(random_id());
  if (auto checked = check_measurement(measurement); !checked) return checked;
  if (find(measurement.id()) != kept_.end())
    return Error{ErrorCode::kInvalidArgument, "id: there is a measurement of this id, expected another"};
  const std::size_t bytes = measurement.ByteSizeLong();
  int points = points_of(measurement);
  for (const Kept& each : kept_) points += points_of(each.measurement);
  if (kept_.size() >= kMost || bytes_ + bytes > kMostBytes || points > kMostPointsInAll) {
    return Error{
        ErrorCode::kUnavailable,
        fmt::format("{} measurements are kept already, expected some to be removed first", kept_.size())};
  }
  kept_.push_back({.measurement = std::move(measurement), .revision = ++revision_});
  bytes_ += bytes;
  return {};
}

Result<void> MeasurementStore::rename(const v1::MeasurementRequest::Name& wish) {
  const auto found = find(wish.id());
  if (found == kept_.end()) return not_found();
  if (auto named = check_measurement_name(wish.name()); !named) return named;
  bytes_ -= found->measurement.ByteSizeLong();
  found->measurement.set_name(wish.name());
  bytes_ += found->measurement.ByteSizeLong();
  found->revision = ++revision_;
  return {};
}

Result<void> MeasurementStore::remove(std::uint64_t id) {
  const auto found = find(id);
  if (found == kept_.end()) return not_found();
  bytes_ -= found->measurement.ByteSizeLong();
  kept_.erase(found);
  ++revision_;
  return {};
}

MeasurementStore::Part MeasurementStore::part_after(std::uint64_t known_revision) const {
  Part part{.list = {}, .revision = known_revision};
  std::vector<const Kept*> changed;
  for (const Kept& each : kept_) {
    part.list.add_ids(each.measurement.id());
    if (each.revision > known_revision) changed.push_back(&each);
  }
  std::ranges::sort(changed, {}, &Kept::revision);
  std::size_t bytes = 0;
  for (const Kept* each : changed) {
    bytes += each->measurement.ByteSizeLong();
    part.more = part.list.changed_size() > 0 && bytes > kMostPartBytes;
    if (part.more) break;
    *part.list.add_changed() = each->measurement;
    part.revision = each->revision;
  }
  part.list.set_with_recording(with_recording_);
  part.list.set_trouble(trouble_);
  return part;
}

void MeasurementStore::keep_with_recording(std::string trouble) {
  with_recording_ = true;
  trouble_ = std::move(trouble);
  overview_.clear();
}

std::vector<std::string> MeasurementStore::load(v1::MeasurementFile file) {
  std::vector<std::string> troubles;
  for (v1::Measurement& each : *file.mutable_measurements()) {
    const std::string name = printable(each.name().substr(0, kLongestName));
    if (auto added = add(std::move(each)); !added)
      troubles.push_back(fmt::format("the measurement {}: {}", name, added.error().message));
  }
  overview_.clear();
  return troubles;
}

v1::MeasurementFile MeasurementStore::file(std::uint64_t first_number, std::uint64_t last_number) const {
  v1::MeasurementFile file;
  for (const auto& [measurement, revision] : kept_)
    if (is_within(measurement, first_number, last_number)) *file.add_measurements() = measurement;
  return file;
}

std::uint64_t MeasurementStore::signature(std::uint64_t first_number, std::uint64_t last_number) const {
  constexpr std::uint64_t kPrime = 1'099'511'628'211;  // of FNV-1a
  std::uint64_t hash = 0;
  for (const auto& [measurement, revision] : kept_)
    if (is_within(measurement, first_number, last_number)) hash = (hash ^ revision) * kPrime;
  return hash;
}

const std::string& MeasurementStore::overview() const {
  if (!overview_.empty()) return overview_;
  v1::MeasurementFile file;
  for (const auto& [measurement, revision] : kept_) {
    v1::Measurement& one = *file.add_measurements();
    one = measurement;
    one.clear_path();
    if (one.has_region()) one.mutable_region()->clear_depths();
  }
  auto json = nlohmann::ordered_json::parse(measurement_file_text(file));
  json.erase("recording_bytes");
  json["with_recording"] = with_recording_;
  json["trouble"] = trouble_;
  overview_ = json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  return overview_;
}

}  // namespace fanlight

// SPDX-License-Identifier: Apache-2.0
#include "server/state/measurement_store.hpp"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <random>

#include "proto/base/printable.hpp"
#include "server/state/measurement_check.hpp"

namespace fanlight {

namespace {

// Of a message: what a session has room for among its answers.
constexpr std::size_t kMostPartBytes = 100'000;

std::uint64_t random_id() {
  std::random_device device;
  return static_cast<std::uint64_t>(device()) << 32 | device() | 1;
}

std::string json_of(const v1::MeasurementFile& file) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string text;
  (void)google::protobuf::util::MessageToJsonString(file, &text, options);
  return text;
}

bool is_within(const v1::Measurement& measurement, std::uint64_t first, std::uint64_t last) {
  return measurement.first_frame_number() >= first && measurement.last_frame_number() <= last;
}

Error not_found() {
  return {ErrorCode::kNotFound, "there is no measurement of this id, expected one of the list"};
}

}  // namespace

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
      kept_.clear();
      bytes_ = 0;
      ++revision_;
      break;
    case v1::MeasurementRequest::WISH_NOT_SET:
      return Error{ErrorCode::kInvalidArgument,
                   "the wish is not known, expected add, rename, remove or remove_all"};
  }
  changed_();
  return {};
}

Result<void> MeasurementStore::add(v1::Measurement measurement) {
  if (measurement.id() == 0) measurement.set_id(random_id());
  if (auto checked = check_measurement(measurement); !checked) return checked;
  if (find(measurement.id()) != kept_.end())
    return Error{ErrorCode::kInvalidArgument, "id: there is a measurement of this id, expected another"};
  const std::size_t bytes = measurement.ByteSizeLong();
  if (kept_.size() >= kMost || bytes_ + bytes > kMostBytes) {
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
}

std::vector<std::string> MeasurementStore::load(std::string_view text) {
  thread_owner_.check();
  v1::MeasurementFile file;
  const auto read = google::protobuf::util::JsonStringToMessage({text.data(), text.size()}, &file);
  if (!read.ok()) {
    return {fmt::format("{}, expected measurements as this server writes them",
                        printable(std::string(read.message()).substr(0, kLongestName)))};
  }
  std::vector<std::string> troubles;
  for (v1::Measurement& each : *file.mutable_measurements()) {
    const std::string name = printable(each.name().substr(0, kLongestName));
    if (auto added = add(std::move(each)); !added)
      troubles.push_back(fmt::format("the measurement {}: {}", name, added.error().message));
  }
  return troubles;
}

std::string MeasurementStore::file_text(std::uint64_t first_number, std::uint64_t last_number) const {
  v1::MeasurementFile file;
  for (const auto& [measurement, revision] : kept_)
    if (is_within(measurement, first_number, last_number)) *file.add_measurements() = measurement;
  return json_of(file);
}

std::uint64_t MeasurementStore::signature(std::uint64_t first_number, std::uint64_t last_number) const {
  constexpr std::uint64_t kPrime = 1'099'511'628'211;  // of FNV-1a
  std::uint64_t hash = 0;
  for (const auto& [measurement, revision] : kept_)
    if (is_within(measurement, first_number, last_number)) hash = (hash ^ revision) * kPrime;
  return hash;
}

std::string MeasurementStore::overview() const {
  v1::MeasurementFile file;
  for (const auto& [measurement, revision] : kept_) {
    *file.add_measurements() = measurement;
    if (measurement.has_region()) file.mutable_measurements()->rbegin()->mutable_region()->clear_depths();
  }
  return json_of(file);
}

}  // namespace fanlight

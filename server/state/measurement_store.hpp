// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/base/thread_owner.hpp"
#include "proto/fanlight.pb.h"

namespace fanlight {

/// The measurements that displays keep on the server: of a replay those of its recording, else those of this
/// start. Checks what comes; computes nothing. No input or output. Server thread only.
class MeasurementStore {
 public:
  static constexpr std::size_t kMost = 200;
  /// Of all together, as messages: a region of fluid takes up to 110 KB.
  static constexpr std::size_t kMostBytes = 4'000'000;
  static constexpr int kMostPoints = 1024;          ///< of one
  static constexpr int kMostPointsInAll = 20'000;   ///< of all together: JSON has a line for each number
  static constexpr std::size_t kLongestName = 100;  ///< bytes

  struct Kept {
    v1::Measurement measurement;
    std::uint64_t revision = 0;  ///< of its last change; later changes have greater ones
  };
  /// A message for a session.
  struct Part {
    v1::MeasurementList list;
    std::uint64_t revision = 0;  ///< the session then knows all up to this
    bool more = false;           ///< others follow
  };

  /// `changed`: called after each change of a measurement.
  explicit MeasurementStore(std::function<void()> changed = [] {}) : changed_(std::move(changed)) {}

  static std::uint64_t random_id();  ///< never 0; any thread

  /// Adds, renames or removes. Errors: kInvalidArgument for a value; kUnavailable where there is no room;
  /// kNotFound: there is none of that id.
  Result<void> request(const v1::MeasurementRequest& request);

  /// In the order in which they were made.
  const std::vector<Kept>& all() const { return kept_; }

  /// What a session has not got that knows all up to a revision; 0: it knows none.
  Part part_after(std::uint64_t known_revision) const;

  /// Measurements are kept in a file beside the recording that is played. `trouble`: why it could not be read
  /// or written; empty: no trouble.
  void keep_with_recording(std::string trouble);

  /// Takes the measurements of a file, before other threads know of this object. Leaves out those that may
  /// not be kept, and returns a sentence for each.
  std::vector<std::string> load(v1::MeasurementFile file);

  /// The file for a recording of the frames with these numbers, both inclusive: measurements on volumes that
  /// are whole in it.
  v1::MeasurementFile file(std::uint64_t first_number, std::uint64_t last_number) const;

  /// Differs wherever file() does; 0 where that has no measurement.
  std::uint64_t signature(std::uint64_t first_number, std::uint64_t last_number) const;

  /// How often all were removed.
  std::uint64_t clearings() const { return clearings_; }

  /// All as JSON, without paths and the grids of regions, and where they are kept. Made once for each change.
  const std::string& overview() const;

 private:
  Result<void> add(v1::Measurement measurement);
  Result<void> rename(const v1::MeasurementRequest::Name& wish);
  Result<void> remove(std::uint64_t id);
  std::vector<Kept>::iterator find(std::uint64_t id);

  std::function<void()> changed_;
  std::vector<Kept> kept_;
  std::size_t bytes_ = 0;       // of all measurements, as messages
  std::uint64_t revision_ = 0;  // of the last change
  std::uint64_t clearings_ = 0;
  mutable std::string overview_;  // empty: to be made
  bool with_recording_ = false;
  std::string trouble_;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight

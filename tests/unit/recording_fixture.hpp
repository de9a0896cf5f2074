// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

#include "acquisition/replay/recording.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {

/// Opens recordings made by a test, in a folder of its own.
class RecordingTest : public testing::Test {
 protected:
  Result<Recording> open(std::string_view bytes) {
    write_file(path_, bytes);
    return Recording::open({.path = path_, .geometry_path = {}});
  }

  Recording open_whole(const NamedFile& file) {
    auto recording = open(file.bytes());
    if (!recording) {
      ADD_FAILURE() << recording.error().message;
      std::abort();
    }
    return *std::move(recording);
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "sweep.igs.mha";
};

}  // namespace fanlight::test

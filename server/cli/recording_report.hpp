// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "acquisition/replay/file_facts.hpp"
#include "acquisition/replay/recording.hpp"

namespace fanlight {

/// What `fanlight info` says of a recording that can be played: lines for people.
std::string recording_text(const Recording& recording);

/// The same for programs: numbers with their units in their names.
nlohmann::ordered_json recording_json(const Recording& recording);

/// What it says of a file that cannot be played: what is there. `why`: the reason, a sentence.
std::string facts_text(const FileFacts& facts, const std::string& name);
nlohmann::ordered_json facts_json(const FileFacts& facts, const std::string& name, const std::string& why);

/// The angles over time as text, `columns` wide and `rows` high, with the range at its left.
std::string angle_plot(const Recording& recording, int columns, int rows);

}  // namespace fanlight

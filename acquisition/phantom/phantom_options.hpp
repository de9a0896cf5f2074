// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "acquisition/phantom/phantom_source.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// An option of the text of parse_phantom(), for help.
struct PhantomOption {
  std::string_view name;
  std::string_view text;      ///< what it is
  std::string_view expected;  ///< its values
};
std::vector<PhantomOption> phantom_option_texts();

/// What `phantom:` means: the fetal face with a hand and the cord, seen by the usual 4D probe r2.
PhantomSource::Config usual_phantom();

/// `base` with the options of a text such as "rate=20,frames=35,seed=7,speckle=off,moving=off" applied.
/// phantom_option_texts() lists them; an empty text changes nothing. Errors: kInvalidArgument with the
/// accepted values, and those of check_phantom().
Result<PhantomSource::Config> parse_phantom(std::string_view options, PhantomSource::Config base);

/// kInvalidArgument where a value is out of its range.
Result<void> check_phantom(const PhantomSource::Config& config);

}  // namespace fanlight

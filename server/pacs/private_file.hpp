// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace fanlight {

/// Whether a file of that name may be replaced.
enum class ExistingFile : bool { kKeep, kReplace };

/// Writes a file whole or not at all, synced to the disk, that its owner alone may read. What is there under
/// the name is kept (EEXIST) or replaced, also a symbolic link. `write` gets a descriptor. Any thread.
/// Returns 0 or an errno, of `write` too.
int write_private_file(const std::filesystem::path& path, ExistingFile existing,
                       const std::function<int(int)>& write);

/// The same with a text.
int write_private_file(const std::filesystem::path& path, ExistingFile existing, std::string_view text);

}  // namespace fanlight

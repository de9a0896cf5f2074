// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glib-object.h>

#include <memory>

namespace fanlight::test {

struct Unref {
  void operator()(gpointer object) const { g_object_unref(object); }
};
/// Owning reference to a GObject.
template <typename T>
using GRef = std::unique_ptr<T, Unref>;

/// Adds a reference.
template <typename T>
GRef<T> new_ref(T* object) {
  return GRef<T>(static_cast<T*>(g_object_ref(object)));
}

}  // namespace fanlight::test

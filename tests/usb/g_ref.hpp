#pragma once

#include <glib-object.h>

#include <memory>

namespace fanlight::test {

struct Unref {
  void operator()(gpointer object) const { g_object_unref(object); }
};
/// A reference to a GObject, given back at its end.
template <typename T>
using GRef = std::unique_ptr<T, Unref>;

/// One more reference.
template <typename T>
GRef<T> new_ref(T* object) {
  return GRef<T>(static_cast<T*>(g_object_ref(object)));
}

}  // namespace fanlight::test

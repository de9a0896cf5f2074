// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

namespace fanlight {

/// An activity of the event loop that is a chain of operations: the end of each begins the next. Each handler
/// holds a link. Where an exception ends a handler before it begins the next operation, the chain is broken,
/// and its owner begins it again. Server thread only.
class LoopChain {
 public:
  using Link = std::shared_ptr<const void>;

  /// To be kept by the handler of an operation.
  Link link() const { return links_; }

  /// Whether no operation is pending. Call it outside of the chain's handlers.
  bool broken() const { return links_.use_count() == 1; }

 private:
  std::shared_ptr<const void> links_ = std::make_shared<char>();
};

}  // namespace fanlight

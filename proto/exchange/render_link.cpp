// SPDX-License-Identifier: Apache-2.0
#include "proto/exchange/render_link.hpp"

#include <utility>

namespace fanlight {

bool RenderLink::send(RenderOrder order) {
  const bool put = orders.put(std::move(order));
  to_renderer.ring();
  return put;
}

bool RenderLink::answer(RenderAnswer answer) {
  if (!has_room_for_answer() && !std::holds_alternative<Error>(answer)) return false;
  const bool put = answers.put(std::move(answer));
  to_server.ring();
  return put;
}

}  // namespace fanlight

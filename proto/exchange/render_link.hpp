// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <variant>

#include "proto/base/result.hpp"
#include "proto/exchange/audience.hpp"
#include "proto/exchange/cine.hpp"
#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/private_view.hpp"
#include "proto/exchange/pulse.hpp"
#include "proto/exchange/render_health.hpp"
#include "proto/exchange/small_queue.hpp"
#include "proto/exchange/volume_order.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/picture_size.hpp"
#include "proto/model/scene.hpp"

namespace fanlight {

/// What the server thread asks of the render thread. A new order is an alternative here, a case in
/// RenderThread::obey(), and its sender.
using RenderOrder = std::variant<CineOrder, VolumeOrder>;

/// What the render thread reports. Error: it cannot continue, and has ended.
using RenderAnswer = std::variant<CineStatus, VolumeAnswer, RenderHealth, PrivateViewEnds, Error>;

/// All that the server thread and the render thread exchange. What is replaced by its newest value is in
/// mailboxes; orders and answers keep their order.
struct RenderLink {
  /// Both must outlive the link. The renderer's bell rings with all that the server sends, the server's with
  /// all that the renderer sends. `blank`: fills the picture's mailbox, so that its memory is allocated here;
  /// that of pictures up to `largest` is reserved.
  RenderLink(Doorbell& renderer_bell, Doorbell& server_bell, const Picture& blank = {},
             PictureSize largest = {.width = 0, .height = 0})
      : to_renderer(renderer_bell),
        to_server(server_bell),
        scenes(renderer_bell),
        private_views(renderer_bell),
        wanted_sizes(renderer_bell),
        audience(renderer_bell),
        pictures(server_bell, blank, [largest](Picture& each) { reserve_picture(each, largest); }) {}

  /// Server thread. False where too many orders wait.
  bool send(RenderOrder order);
  /// Render thread. False where too many answers wait: try again later. There is always room for one Error,
  /// which is the last answer.
  bool answer(RenderAnswer answer);
  /// Render thread.
  bool has_room_for_answer() const { return answers.room() > 1; }

  Doorbell& to_renderer;
  Doorbell& to_server;
  // Written by the server thread.
  Mailbox<NumberedScene> scenes;
  Mailbox<PrivateViews> private_views;
  Mailbox<WantedSizes> wanted_sizes;
  Audience audience;
  SmallQueue<RenderOrder, 32> orders;
  // Written by the render thread.
  Mailbox<Picture> pictures;
  SmallQueue<RenderAnswer, 32> answers;
  Pulse pulse;  ///< beats while the render thread's loop comes round
};

}  // namespace fanlight

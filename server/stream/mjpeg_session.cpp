// SPDX-License-Identifier: Apache-2.0
#include "server/stream/mjpeg_session.hpp"

#include <fmt/format.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>
#include <new>
#include <sstream>
#include <utility>

#include "server/stream/picture_mark_of.hpp"

namespace fanlight {

namespace beast = boost::beast;

namespace {

constexpr std::string_view kBoundary = "--fanlight-picture\r\n";
// Behind a picture and not before the next one: browsers show a picture once it has ended.
constexpr std::string_view kPictureEnd = "\r\n--fanlight-picture\r\n";

}  // namespace

MjpegSession::MjpegSession(Connection connection, ConnectionPermit permit,
                           const StreamSession::Dependencies& dependencies, std::string address)
    : dependencies_(dependencies),
      shared_(dependencies.shared),
      permit_(std::move(permit)),
      connection_(std::move(connection)),
      identity_{.id = shared_.sessions.next_id(),
                .address = std::move(address),
                .principal = std::nullopt,
                .name = ""},
      audit_(dependencies.audit, identity_),
      queue_(shared_.state.counters) {}

void MjpegSession::start(Response head, const Principal& principal, const StreamSettings& settings,
                         bool head_only) {
  beast::get_lowest_layer(connection_).expires_never();
  permit_.on_eviction([this] { beast::get_lowest_layer(connection_).close(); });
  identity_.principal = principal;
  identity_.name = principal.name;
  settings_ = settings;
  settings_.mark = mark_of(shared_.state.liveness.report());
  head.set(beast::http::field::content_type, kMediaType);
  head.keep_alive(false);
  std::ostringstream text;
  text << head.base();
  if (head_only) {
    must_leave_ = true;  // once it is written
    return write(text.str(), "");
  }
  is_open_ = true;
  shared_.sessions.add(shared_from_this());
  shared_.state.counters.sessions_opened.add();
  audit_.note("session_opened", "done");
  write(text.str() + std::string(kBoundary), "");
  watch_for_end();
  shared_.hub.add(*this);
  shared_.sessions.opened();
}

void MjpegSession::offer(const PictureOffer& picture) {
  try {
    queue_.offer(picture);
    pump();
  } catch (const std::bad_alloc&) {
    must_leave_ = true;
  }
}

void MjpegSession::notify(Notice notice) {
  if (notice != Notice::kLiveness) return;
  const PictureMark mark = mark_of(shared_.state.liveness.report());
  if (std::exchange(settings_.mark, mark) == mark) return;
  try {
    shared_.hub.resync(*this);  // the same picture with other words
  } catch (const std::bad_alloc&) {
    must_leave_ = true;
  }
}

void MjpegSession::pump() {
  if (writing_ || !is_open_) return;
  const OutgoingQueue::Item item = queue_.next();
  if (item.kind != OutgoingQueue::Item::Kind::kPicture) return;
  v1::ServerMessage message;
  message.ParseFromString(*item.message);
  const v1::Picture& picture = message.picture();
  const PictureLiveness::Report& liveness = shared_.state.liveness.report();
  std::string text = fmt::format(
      "Content-Type: image/jpeg\r\nContent-Length: {}\r\nX-Fanlight-Picture-Id: {}\r\n"
      "X-Fanlight-Volume-Id: {}\r\nX-Fanlight-Scene-Revision: {}\r\nX-Fanlight-Liveness: {}\r\n"
      "X-Fanlight-Origin: {}\r\n\r\n",
      picture.jpeg().size(), picture.picture_id(), picture.volume_id(), picture.scene_revision(),
      PictureLiveness::name(liveness.state), origin_name(liveness.origin));
  write(std::move(text), std::move(*message.mutable_picture()->mutable_jpeg()));
}

void MjpegSession::write(std::string text, std::string picture) {
  text_ = std::move(text);
  picture_ = std::move(picture);
  writing_ = true;
  const std::string_view end = picture_.empty() ? std::string_view() : kPictureEnd;
  const std::array<boost::asio::const_buffer, 3> parts = {
      boost::asio::buffer(text_), boost::asio::buffer(picture_), boost::asio::buffer(end)};
  boost::asio::async_write(connection_, parts,
                           [self = shared_from_this()](beast::error_code failure, std::size_t /*bytes*/) {
                             self->written(failure);
                           });
}

void MjpegSession::written(beast::error_code failure) {
  writing_ = false;
  if (failure || must_leave_) return leave("the client left");
  queue_.sent();
  pump();
}

void MjpegSession::watch_for_end() {
  connection_.async_read_some(
      boost::asio::buffer(ignored_),
      [self = shared_from_this()](beast::error_code failure, std::size_t /*bytes*/) {
        self->leave(failure ? "the client left" : "the client sent more than its request");
      });
}

void MjpegSession::second_passed() {
  const SessionLimits& limits = dependencies_.limits;
  const int stalled =
      progress_.seconds_stalled(beast::get_lowest_layer(connection_).socket().native_handle(), writing_);
  if (stalled >= limits.stalled_s) {
    shared_.state.counters.sessions_stalled.add();
    return leave(fmt::format("it took nothing for {} s", limits.stalled_s));
  }
  if (must_leave_) {
    shared_.state.counters.encodings_failed.add();
    return leave("the picture could not be encoded");
  }
  if (!shared_.access.may_stay(*identity_.principal)) leave("the token or certificate is not valid any more");
}

void MjpegSession::end(const std::string& reason) {
  leave(reason);
}

void MjpegSession::leave(const std::string& why) {
  beast::get_lowest_layer(connection_).close();
  if (!std::exchange(is_open_, false)) return;
  const auto self = shared_from_this();  // the registry may hold the last reference
  shared_.sessions.remove(id());
  shared_.hub.remove(*this);
  shared_.state.counters.sessions_closed.add();
  queue_.end();
  audit_.note("session_closed", why);
}

}  // namespace fanlight

// SPDX-License-Identifier: Apache-2.0
#include "server/stream/outgoing_queue.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace fanlight {

void OutgoingQueue::add_shown_request(const ShownRequest& request) {
  if (shown_requests_.size() >= kMostShownRequests) {
    given_up_.push_back(shown_requests_.front());
    shown_requests_.pop_front();
  }
  shown_requests_.push_back(request);
}

void OutgoingQueue::count_skip() {
  ++counts_.skipped;
  counters_.pictures_skipped.add();
}

void OutgoingQueue::skip_waiting() {
  if (std::exchange(waiting_.message, nullptr) != nullptr) count_skip();
}

void OutgoingQueue::offer(const PictureOffer& picture) {
  ++counts_.offered;
  counters_.pictures_offered.add();
  needs_key_ |= waiting_.message != nullptr;
  skip_waiting();
  waiting_ = picture;
  if (needs_key_ && !picture.key) {
    skip_waiting();  // the client could not decode it
  } else {
    needs_key_ = false;
  }
}

void OutgoingQueue::begin_stream(bool needs_key) {
  skip_waiting();
  client_surface_ = 0;
  needs_key_ = needs_key;
}

std::optional<Notice> OutgoingQueue::take_notice() {
  if (notices_due_ == 0) return std::nullopt;
  const auto first = static_cast<Notice>(std::countr_zero(notices_due_));
  notices_due_ &= notices_due_ - 1;
  return first;
}

OutgoingQueue::Item OutgoingQueue::next() {
  if (close_sent_) return {};
  if (!answers_.empty()) {
    Item item{.kind = Item::Kind::kAnswer, .message = answers_.front()};
    answers_.pop_front();
    return item;
  }
  if (closing_) {
    close_sent_ = true;
    return {.kind = Item::Kind::kClose};
  }
  if (const auto notice = take_notice()) return {.kind = Item::Kind::kNotice, .notice = *notice};
  if (!given_up_.empty()) {
    Item item{.kind = Item::Kind::kShown, .shown = given_up_.front(), .picture_id = 0};
    given_up_.pop_front();
    return item;
  }
  if (waiting_.message != nullptr) return next_of_picture();
  // The client lacks a picture, and the next one may be far away.
  if (needs_key_) return {.kind = Item::Kind::kNeedsKey};
  return {};
}

OutgoingQueue::Item OutgoingQueue::next_of_picture() {
  // Before the picture, the client learns which of its changes the picture shows.
  const auto shown = std::ranges::find_if(shown_requests_, [this](const ShownRequest& request) {
    return request.view_id == waiting_.view_id && request.revision <= waiting_.scene_revision;
  });
  if (shown != shown_requests_.end()) {
    Item item{.kind = Item::Kind::kShown, .shown = *shown, .picture_id = waiting_.picture_id};
    shown_requests_.erase(shown);
    return item;
  }
  picture_under_way_ = true;
  // Messages arrive in the order of their sending, or the session ends.
  const bool has_surface = waiting_.surface_id != 0 && waiting_.surface_id == client_surface_;
  if (waiting_.surface_id != 0) client_surface_ = waiting_.surface_id;
  SharedMessage whole = std::exchange(waiting_.message, nullptr);
  Item item{.kind = Item::Kind::kPicture,
            .message = has_surface ? std::exchange(waiting_.without_surface, nullptr) : std::move(whole)};
  bytes_under_way_ = item.message->size();
  return item;
}

void OutgoingQueue::sent() {
  if (!std::exchange(picture_under_way_, false)) return;
  ++counts_.sent;
  counters_.pictures_sent.add();
  counters_.picture_bytes_sent.add(bytes_under_way_);
}

void OutgoingQueue::end() {
  skip_waiting();
  if (std::exchange(picture_under_way_, false)) count_skip();
}

}  // namespace fanlight

// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/igtl_session.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>
#include <new>
#include <utility>

#include "proto/base/clock.hpp"
#include "proto/base/printable.hpp"
#include "proto/igtl/timestamp.hpp"

namespace fanlight {

namespace asio = boost::asio;

namespace {

constexpr std::uint64_t kMostBodyBytes = 64 << 10;  // a command
// Programs that send images to everybody are read, and their images skipped.
constexpr std::uint64_t kMostSkippedBytes = std::uint64_t{1} << 30;
constexpr int kStalledSeconds = 5;
constexpr std::string_view kCommandDevice = "CMD_";

/// STT_VIDEO begins with the code of a codec. Without content, ours is meant.
bool wants_another_codec(std::span<const std::uint8_t> content) {
  constexpr std::string_view kOurs = "H264";
  return !content.empty() &&
         !std::ranges::equal(content.first(std::min(content.size(), kOurs.size())), kOurs);
}

}  // namespace

IgtlSession::IgtlSession(asio::ip::tcp::socket socket, ConnectionPermit permit, Principal principal,
                         const Config& config, const Dependencies& dependencies)
    : socket_(std::move(socket)),
      permit_(std::move(permit)),
      principal_(std::move(principal)),
      dependencies_(dependencies),
      reader_(kMostBodyBytes, kMostSkippedBytes),
      started_(config.usual),
      wanted_(config.usual),
      most_messages_(config.most_messages),
      patience_(config.patience),
      outbox_(dependencies.counters, dependencies.bytes_waiting) {}

void IgtlSession::start() {
  dependencies_.counters.igtl_clients_opened.add();
  permit_->on_eviction([this] {
    close_for(dependencies_.counters.igtl_clients_evicted,
              "has sent no message, and another client needed its place");
  });
  send_status();
  read();
}

// ---- reading

void IgtlSession::read() {
  if (!may_read()) return;
  reading_ = true;
  const auto room = reader_.room();
  socket_.async_read_some(asio::buffer(room.data(), room.size()),
                          [self = shared_from_this()](boost::system::error_code failure, std::size_t bytes) {
                            self->reading_ = false;
                            if (failure) return self->leave();
                            try {
                              self->received(bytes);
                            } catch (const std::bad_alloc&) {
                              self->dependencies_.counters.sessions_out_of_memory.add();
                              self->leave();
                            }
                          });
}

void IgtlSession::received(std::size_t bytes) {
  using Event = igtl::MessageReader::Event;
  if (gone_) return;
  switch (reader_.filled(bytes)) {
    case Event::kMore:
      break;
    case Event::kMessage:
      ++messages_;
      take_message();
      break;
    case Event::kSkipped:
      ++messages_;
      dependencies_.counters.igtl_messages_ignored.add();
      if (reader_.head().type.view() == "COMMAND")
        refuse_command(0,
                       fmt::format("the COMMAND is longer than {} KiB, expected less", kMostBodyBytes >> 10));
      break;
    case Event::kLost:
    case Event::kUnwanted:
      dependencies_.counters.igtl_messages_refused.add();
      spdlog::info("the client {} does not speak OpenIGTLink: disconnecting", principal_.address);
      return leave();
  }
  read();
}

void IgtlSession::take_message() {
  const igtl::MessageHead& head = reader_.head();
  const igtl::OpenedMessage opened = igtl::open_message(head, reader_.body());
  if (opened.state != igtl::OpenedMessage::State::kGood) {
    dependencies_.counters.igtl_messages_refused.add();
    return;
  }
  if (!std::exchange(is_heard_, true)) permit_->authenticated();
  // A picture of the video that is being written comes in the other version.
  if (head.version >= 2 && std::exchange(version_, igtl::HeadVersion::kTwo) == igtl::HeadVersion::kOne) {
    outbox_.video_lost();
    dependencies_.asked();  // and so do all others
  }
  const igtl::QueryType query = igtl::query_of(head.type.view());
  if (query.query != igtl::Query::kNone && query.query != igtl::Query::kReply)
    return take_query(query, opened);
  if (query.type == "COMMAND" && query.query == igtl::Query::kNone) return take_command(opened);
  if (query.type == "STRING" && head.device.view().starts_with(kCommandDevice)) return take_string(opened);
  // A STATUS is a sign of life.
  if (query.type != "STATUS") dependencies_.counters.igtl_messages_ignored.add();
}

void IgtlSession::take_query(const igtl::QueryType& query, const igtl::OpenedMessage& opened) {
  const std::string_view device = reader_.head().device.view();
  if (query.query == igtl::Query::kStart) return start_stream(query, opened);
  if (query.query == igtl::Query::kStop) return stop_streams(query);
  if (query.type == "STATUS") return send_status();
  if (query.type == "CAPABIL") {
    return answer({.type = "CAPABILITY", .device = kIgtlDevice}, [](std::vector<std::uint8_t>& bytes) {
      const igtl::TypeName types[] = {
          "IMAGE",     "POLYDATA",     "TRANSFORM", "VIDEO",       "STATUS",     "CAPABILITY",
          "GET_IMAGE", "GET_POLYDATA", "GET_TRANS", "GET_VIDEO",   "GET_STATUS", "GET_CAPABIL",
          "STT_IMAGE", "STT_POLYDATA", "STT_TRANS", "STT_VIDEO",   "STP_IMAGE",  "STP_POLYDATA",
          "STP_TRANS", "STP_VIDEO",    "COMMAND",   "RTS_COMMAND", "STRING"};
      igtl::put_capability(bytes, types);
    });
  }
  const auto stream = stream_of(query.type, device);
  if (!stream) {
    // What is not available is a message without a body.
    dependencies_.counters.igtl_messages_ignored.add();
    const std::string_view type = query.type == "TRANS" ? "TRANSFORM" : query.type;
    return answer({.type = igtl::TypeName(type), .device = igtl::DeviceName(device)}, {});
  }
  want(*stream, once_);
}

/// Begins a stream, or asks for one message of it.
void IgtlSession::want(IgtlStream stream, IgtlStreams& whether) {
  if (stream == IgtlStream::kVideo)
    outbox_.video_lost();                          // it was not sent what is before, or has dropped it
  sent_of_[static_cast<std::size_t>(stream)] = 0;  // who asks again gets it again
  if (stream == IgtlStream::kVolume) volume_ordered_ = 0;
  whether.set(stream, true);
  wants_changed();
  dependencies_.asked();
}

void IgtlSession::wants_changed() {
  wanted_ = started_;
  wanted_.add(once_);
  dependencies_.wants_changed();
}

IgtlStreams IgtlSession::wanted_of(std::uint64_t picture_id, std::uint64_t volume_id) const {
  IgtlStreams left = wanted_;
  left.set(IgtlStream::kFrames, false);
  for (std::size_t i = 0; i < kIgtlStreams; ++i) {
    const auto stream = static_cast<IgtlStream>(i);
    const std::uint64_t id = stream == IgtlStream::kVolume ? volume_id : picture_id;
    if (has_of(stream, id) && !once_.has(stream)) left.set(stream, false);
  }
  return left;
}

bool IgtlSession::has_of(IgtlStream stream, std::uint64_t id) const {
  return sent_of_[static_cast<std::size_t>(stream)] == id ||
         (stream == IgtlStream::kVolume && volume_ordered_ == id);
}

void IgtlSession::start_stream(const igtl::QueryType& query, const igtl::OpenedMessage& opened) {
  auto stream = stream_of(query.type, reader_.head().device.view());
  if (stream == IgtlStream::kVideo && wants_another_codec(opened.content)) stream = {};
  if (stream) {
    // Who asks gets what was asked for, and no more what is usual.
    if (!std::exchange(has_asked_, true)) started_ = {};
    want(*stream, started_);
  } else {
    dependencies_.counters.igtl_messages_ignored.add();
  }
  answer_query(query.type, stream.has_value());
}

void IgtlSession::stop_streams(const igtl::QueryType& query) {
  const std::string_view device = reader_.head().device.view();
  has_asked_ = true;
  bool any = false;
  for (std::size_t i = 0; i < kIgtlStreams; ++i) {
    const auto stream = static_cast<IgtlStream>(i);
    const bool meant = device.empty() ? stream_of(query.type, name_of(stream).device) == stream
                                      : stream_of(query.type, device) == stream;
    if (!meant) continue;
    any = true;
    started_.set(stream, false);
  }
  wants_changed();
  answer_query(query.type, any);
}

/// RTS_TDATA has a byte that says whether it was done; the document leaves those of other types open.
void IgtlSession::answer_query(std::string_view type, bool good) {
  answer({.type = igtl::TypeName(fmt::format("RTS_{}", type)), .device = reader_.head().device},
         [good](std::vector<std::uint8_t>& bytes) { bytes.push_back(good ? 0 : 1); });
}

// ---- commands

void IgtlSession::take_command(const igtl::OpenedMessage& opened) {
  const auto command = igtl::parse_command(opened.content);
  if (!command) {
    dependencies_.counters.igtl_messages_refused.add();
    return refuse_command(
        0,
        "this is no COMMAND, expected an id (4 bytes), a name (128), an encoding (2), a length (4), and as "
        "many bytes of XML");
  }
  const auto reply = dependencies_.commands.carry_out(command->name.view(), command->text, principal_);
  answer({.type = "RTS_COMMAND", .device = reader_.head().device}, [&](std::vector<std::uint8_t>& bytes) {
    igtl::put_command(bytes, {.id = command->id, .name = command->name, .text = reply.xml});
  });
}

/// Where the id is not known, it is 0.
void IgtlSession::refuse_command(std::uint32_t id, const std::string& why) {
  answer({.type = "RTS_COMMAND", .device = reader_.head().device}, [&](std::vector<std::uint8_t>& bytes) {
    igtl::put_command(bytes, {.id = id, .name = {}, .text = IgtlCommands::refusal(why)});
  });
}

/// As PLUS took commands before there was COMMAND: CMD_ and an id in the device's name, and ACK_ in that of
/// the answer. A client that got no answer sends it again; it is carried out once.
void IgtlSession::take_string(const igtl::OpenedMessage& opened) {
  const auto text = igtl::parse_string(opened.content);
  const std::string_view id = reader_.head().device.view().substr(kCommandDevice.size());
  if (!text) {
    dependencies_.counters.igtl_messages_refused.add();
    return;
  }
  if (is_repeated(id)) return;
  const auto reply = dependencies_.commands.carry_out("", *text, principal_);
  answer({.type = "STRING", .device = igtl::DeviceName(fmt::format("ACK_{}", id))},
         [&](std::vector<std::uint8_t>& bytes) { igtl::put_string(bytes, reply.xml); });
}

bool IgtlSession::is_repeated(std::string_view id) {
  if (std::ranges::find(repeats_, id) != repeats_.end()) return true;
  repeats_[repeat_at_++ % kRepeats] = id;
  return false;
}

// ---- writing

void IgtlSession::send_status() {
  const IgtlState state = dependencies_.state();
  answer({.type = "STATUS", .device = kIgtlDevice}, [&state](std::vector<std::uint8_t>& bytes) {
    igtl::put_status(bytes, {.code = state.code, .name = std::string_view(state.name), .text = state.text});
  });
}

void IgtlSession::answer(const igtl::Envelope& envelope,
                         const std::function<void(std::vector<std::uint8_t>&)>& put) {
  // A client that reads nothing is sent nothing more; its requests are not read either.
  if (gone_ || !has_room()) return;
  igtl::Envelope in_its_version = envelope;
  in_its_version.version = version_;
  in_its_version.timestamp = igtl::timestamp_of(utc_now_ns());
  auto& bytes = writer_.begin(in_its_version);
  if (put) put(bytes);
  const auto message = writer_.finish();
  answers_.push_back(std::make_shared<const std::vector<std::uint8_t>>(message.begin(), message.end()));
  pump();
}

void IgtlSession::offer(IgtlStream stream, const IgtlMessage& message, std::uint64_t id, bool key) {
  if (gone_ || ending_ || message == nullptr || !wanted_.has(stream)) return;
  // A frame has no id. A picture of the video is needed by the next one, also where it shows the same.
  const bool each_counts = stream == IgtlStream::kFrames || stream == IgtlStream::kVideo;
  if (!each_counts && has_of(stream, id) && !once_.has(stream)) return;
  if (!outbox_.offer(stream, message, key)) return;
  sent_of_[static_cast<std::size_t>(stream)] = id;
  once_.set(stream, false);
  wanted_ = started_;
  wanted_.add(once_);
  pump();
}

void IgtlSession::offer_volume(const IgtlMessage& message, std::uint64_t ordered_id, std::uint64_t shown_id) {
  if (!wanted_of(0, ordered_id).has(IgtlStream::kVolume)) return;
  offer(IgtlStream::kVolume, message, shown_id);
  if (message != nullptr) volume_ordered_ = ordered_id;
}

void IgtlSession::not_available(IgtlStream stream, const std::string& why) {
  if (started_.has(stream) && !why.empty()) {
    answer({.type = "STATUS", .device = kIgtlDevice}, [&](std::vector<std::uint8_t>& bytes) {
      igtl::put_status(bytes,
                       {.code = igtl::StatusCode::kNoResources, .name = name_of(stream).word, .text = why});
    });
  }
  if (!once_.has(stream)) return;
  once_.set(stream, false);
  wanted_ = started_;
  wanted_.add(once_);
  answer({.type = igtl::TypeName(name_of(stream).type), .device = igtl::DeviceName(name_of(stream).device)},
         {});
}

IgtlMessage IgtlSession::next() {
  under_way_counts_ = answers_.empty();
  if (under_way_counts_) return outbox_.next();
  IgtlMessage answer = answers_.front();
  answers_.pop_front();
  return answer;
}

void IgtlSession::pump() {
  if (gone_ || under_way_ != nullptr) return;
  under_way_ = next();
  if (under_way_ == nullptr) {
    if (ending_) leave();
    return;
  }
  asio::async_write(socket_, asio::buffer(*under_way_),
                    [self = shared_from_this()](boost::system::error_code failure, std::size_t bytes) {
                      if (self->gone_) return;
                      if (failure) return self->leave();
                      self->written(bytes);
                    });
}

void IgtlSession::written(std::size_t bytes) {
  if (under_way_counts_) {
    seconds_idle_ = 0;
    dependencies_.counters.igtl_messages_sent.add();
    dependencies_.counters.igtl_bytes_sent.add(bytes);
  }
  outbox_.sent();
  under_way_ = nullptr;
  pump();
  read();  // there may be room for answers again
}

void IgtlSession::second_passed() {
  if (gone_) return;
  messages_ = 0;
  read();
  if (progress_.seconds_stalled(socket_.native_handle(), under_way_ != nullptr) >= kStalledSeconds) {
    return close_for(dependencies_.counters.igtl_clients_stalled,
                     fmt::format("took nothing for {} s", kStalledSeconds));
  }
  seconds_in_head_ = reader_.is_in_head() ? seconds_in_head_ + 1 : 0;
  if (seconds_in_head_ > patience_.head_s) {
    return close_for(dependencies_.counters.igtl_clients_timed_out,
                     fmt::format("sent no whole head of a message in {} s", patience_.head_s));
  }
  if (is_heard_ || ++seconds_idle_ <= patience_.idle_s) return;
  close_for(dependencies_.counters.igtl_clients_timed_out,
            fmt::format("has sent no message, and was sent none for {} s", patience_.idle_s));
}

void IgtlSession::close_for(Counter& counter, const std::string& why) {
  if (gone_) return;
  counter.add();
  spdlog::info("disconnected the OpenIGTLink client {}: it {}", principal_.address, why);
  leave();
}

void IgtlSession::end() {
  if (gone_ || ending_) return;
  outbox_.clear();  // the end does not wait for what is large
  answer({.type = "STATUS", .device = kIgtlDevice}, [](std::vector<std::uint8_t>& bytes) {
    igtl::put_status(
        bytes, {.code = igtl::StatusCode::kShuttingDown, .name = "end", .text = "the server is stopping"});
  });
  ending_ = true;
  pump();
}

void IgtlSession::leave() {
  if (std::exchange(gone_, true)) return;
  outbox_.clear();
  outbox_.sent();
  if (under_way_ != nullptr && under_way_counts_) dependencies_.counters.igtl_messages_skipped.add();
  boost::system::error_code ignored;
  socket_.close(ignored);
  // Pending operations may keep this object longer than the server.
  permit_.reset();
  dependencies_.counters.igtl_clients_closed.add();
  dependencies_.left(*this);
}

}  // namespace fanlight

// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/igtl_server.hpp"

#include <fmt/format.h>
#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <new>
#include <string>
#include <utility>

#include "proto/base/clock.hpp"
#include "server/codec/reduced_picture.hpp"
#include "server/igtl/igtl_video.hpp"
#include "server/igtl/picture_messages.hpp"

namespace fanlight {

namespace asio = boost::asio;
using asio::ip::tcp;

namespace {

// PLUS and 3D Slicer take a connection without messages for dead.
constexpr int kStatusSeconds = 2;
constexpr std::int64_t kLeastBetweenKeysNs = 500'000'000;
constexpr std::int64_t kBetweenRefusalLogsNs = 60'000'000'000;

/// A time of this host's steady clock as one since 1970.
std::uint64_t utc_ns(std::int64_t steady_ns) {
  const auto now = static_cast<std::int64_t>(utc_now_ns());
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, now - (now_ns() - steady_ns)));
}

}  // namespace

/// The writing of one picture's messages. The server and the thread that writes share it.
struct IgtlServer::Job {
  Picture picture;
  PictureSize usual_size;
  IgtlWanted wanted;
  bool key_wanted = false;  // of the video
  std::uint64_t utc_ns = 0;
  IgtlVideo video;
  IgtlPictureMessages messages;
  bool key = false;           // the video's picture is one
  std::string video_trouble;  // empty: none
  bool no_memory = false;

  void write() {
    try {
      // Programs expect pictures of one size.
      if (picture.height != usual_size.height) picture = reduced(picture, usual_size);
      messages = picture_messages(picture, wanted, utc_ns);
      if (wanted.has(IgtlStream::kVideo)) write_video();
    } catch (const std::bad_alloc&) {
      no_memory = true;
    }
  }

 private:
  void write_video() {
    const auto content = video.write(picture, key_wanted);
    if (!content) {
      video_trouble = content.error().message;
      return;
    }
    key = content->key;
    const PictureMetadata metadata(picture.stamp);
    messages.at(IgtlStream::kVideo) =
        stream_messages(IgtlStream::kVideo,
                        {.utc_ns = utc_ns,
                         .id = static_cast<std::uint32_t>(picture.stamp.picture_id),
                         .metadata = metadata.items()},
                        content->bytes, wanted);
  }
};

IgtlServer::IgtlServer(asio::io_context& loop, const Config& config, Dependencies dependencies)
    : config_(config),
      dependencies_(std::move(dependencies)),
      commands_(
          {.state = dependencies_.state, .commands = dependencies_.commands, .audit = dependencies_.audit}),
      session_dependencies_{.counters = dependencies_.state.counters,
                            .commands = commands_,
                            .state = [this] { return igtl_state(dependencies_.state.liveness.report()); },
                            .asked = [this] { show_newest(); },
                            .wants_changed = [this] { wants_changed(); },
                            .bytes_waiting = bytes_waiting_,
                            .left =
                                [this](IgtlSession& session) {
                                  std::erase_if(sessions_,
                                                [&](const auto& each) { return each.get() == &session; });
                                  wants_changed();
                                }},
      limit_(config.most_clients, config.most_clients_a_host),
      acceptor_(loop),
      pause_(loop),
      frames_(dependencies_.ports.frames),
      job_(std::make_shared<Job>()),
      volumes_(config.spacing_mm, {.copier = dependencies_.state.volumes,
                                   .executor = dependencies_.executor,
                                   .utc_ns = utc_ns,
                                   .made = [this](const IgtlVolumes::Made& made) { offer_volume(made); }}) {}

IgtlServer::~IgtlServer() {
  dependencies_.wants_changed = [] {};  // there is no one left to notify
  frames_ = nullptr;
  for (const auto& session : std::vector(sessions_)) session->leave();
}

Result<void> IgtlServer::open() {
  boost::system::error_code failure;
  acceptor_.open(config_.endpoint.protocol(), failure);
  if (!failure) acceptor_.set_option(tcp::acceptor::reuse_address(true), failure);
  if (!failure) acceptor_.bind(config_.endpoint, failure);
  if (!failure) acceptor_.listen(tcp::socket::max_listen_connections, failure);
  if (!failure) return {};
  return Error{
      ErrorCode::kUnavailable,
      fmt::format("OpenIGTLink cannot listen on {}:{}: {}, expected an address of this machine and a port "
                  "that is free",
                  config_.endpoint.address().to_string(), config_.endpoint.port(), failure.message())};
}

void IgtlServer::start() {
  if (chain_.broken() && acceptor_.is_open()) accept();
}

void IgtlServer::accept() {
  acceptor_.async_accept([this, link = chain_.link()](boost::system::error_code failure, tcp::socket socket) {
    if (failure == asio::error::operation_aborted) return;
    if (failure) {
      dependencies_.state.counters.connections_refused.add();
      pause_.expires_after(std::chrono::milliseconds(100));
      return pause_.async_wait([this, link](boost::system::error_code stopped) {
        if (!stopped) accept();
      });
    }
    try {
      begin(std::move(socket));
    } catch (const std::bad_alloc&) {
      dependencies_.state.counters.connections_refused.add();
    }
    accept();
  });
}

void IgtlServer::begin(tcp::socket socket) {
  boost::system::error_code ignored;
  const auto remote = socket.remote_endpoint(ignored);
  auto permit = limit_.take(remote.address());
  if (!permit) return refuse(remote.address());  // the destructor closes the socket
  socket.set_option(tcp::no_delay(true), ignored);
  // What waits in the kernel cannot be replaced by something newer.
  const int most_unsent_bytes = 64 << 10;
  setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &most_unsent_bytes,
             sizeof(most_unsent_bytes));
  Principal principal{.role = config_.role,
                      .name = "OpenIGTLink",
                      .proof = {},
                      .address = fmt::format("{}:{}", remote.address().to_string(), remote.port())};
  const auto session = std::make_shared<IgtlSession>(
      std::move(socket), *std::move(permit), std::move(principal),
      IgtlSession::Config{
          .usual = config_.usual, .most_messages = config_.most_messages, .patience = config_.patience},
      session_dependencies_);
  sessions_.push_back(session);
  session->start();
  wants_changed();
  show_newest();
}

/// Logged once a minute at most: a flood of clients must not flood the log.
void IgtlServer::refuse(const asio::ip::address& address) {
  dependencies_.state.counters.igtl_clients_refused.add();
  const std::int64_t now = now_ns();
  if (refusal_logged_ns_ != 0 && now - refusal_logged_ns_ < kBetweenRefusalLogsNs) return;
  refusal_logged_ns_ = now;
  spdlog::warn(
      "refused the OpenIGTLink client {}: {} clients are connected, at most {} and {} of one address",
      address.to_string(), sessions_.size(), config_.most_clients, config_.most_clients_a_host);
}

bool IgtlServer::wants_pictures() const {
  const IgtlWanted all = wanted();
  return all.version_1.any_of_pictures() || all.version_2.any_of_pictures();
}

void IgtlServer::wants_changed() {
  if (!wanted().has(IgtlStream::kVolume)) volumes_.stop();
  if (frames_ != nullptr) frames_->open(wanted().has(IgtlStream::kFrames));
  dependencies_.wants_changed();
}

IgtlWanted IgtlServer::wanted() const {
  IgtlWanted all;
  for (const auto& session : sessions_) all.in(session->version()).add(session->wanted());
  return all;
}

IgtlWanted IgtlServer::wanted_of(const PictureStamp& stamp) const {
  IgtlWanted all;
  for (const auto& session : sessions_)
    all.in(session->version()).add(session->wanted_of(stamp.picture_id, stamp.volume.volume_id));
  return all;
}

void IgtlServer::show_newest() {
  if (const Picture* const picture = dependencies_.hub.newest_picture()) show(*picture);
}

void IgtlServer::show(const Picture& picture) {
  thread_owner_.check();
  IgtlWanted now = wanted_of(picture.stamp);
  if (now.has(IgtlStream::kVolume)) volumes_.order(now, picture.stamp.volume.volume_id);
  now.remove(IgtlStream::kVolume);
  plan_video(now, picture.stamp);
  if (!now.any()) return;
  if (busy_) {
    newer_waits_ = true;
    return;
  }
  write_messages(picture, now);
}

/// The video has this picture if a client that lacks it can decode it. Then all clients of the video get it,
/// also those that have it already: the next picture may need this one.
void IgtlServer::plan_video(IgtlWanted& now, const PictureStamp& stamp) const {
  now.remove(IgtlStream::kVideo);
  const bool key_comes = key_is_due();
  const auto gains = [&](const auto& session) {
    return session->wanted_of(stamp.picture_id, stamp.volume.volume_id).has(IgtlStream::kVideo) &&
           (key_comes || !session->needs_key_picture());
  };
  if (std::ranges::none_of(sessions_, gains)) return;
  for (const auto& session : sessions_)
    if (session->wanted().has(IgtlStream::kVideo)) now.in(session->version()).set(IgtlStream::kVideo, true);
}

/// Whether the video needs a key picture: it has lost one itself, or a client has, and the last key picture
/// is old enough: slow clients shall not make the video of the others coarse.
bool IgtlServer::key_is_due() const {
  if (video_failed_) return true;
  return now_ns() - key_coded_ns_ >= kLeastBetweenKeysNs &&
         std::ranges::any_of(sessions_, &IgtlSession::needs_key_picture);
}

void IgtlServer::write_messages(const Picture& picture, const IgtlWanted& now) {
  newer_waits_ = false;
  job_->picture = picture;
  job_->usual_size = dependencies_.state.description.picture_size;
  job_->wanted = now;
  job_->key_wanted = key_is_due();
  job_->utc_ns = utc_ns(picture.stamp.volume.last_capture_time_ns);
  job_->video_trouble.clear();
  job_->no_memory = false;
  busy_ = true;
  const std::shared_ptr<Job> job = job_;
  const bool is_heavy = now.has(IgtlStream::kSurface) || now.has(IgtlStream::kDepth);
  try {
    dependencies_.executor(
        is_heavy ? EncoderLane::kHeavy : EncoderLane::kQuick, [job] { job->write(); },
        [this, job] { written(*job); });
  } catch (const std::bad_alloc&) {
    busy_ = false;  // it was not handed over
    throw;
  }
}

void IgtlServer::written(Job& job) {
  busy_ = false;
  if (job.no_memory) dependencies_.state.counters.handlers_out_of_memory.add();
  if (!job.video_trouble.empty() && !video_failed_)
    spdlog::warn("OpenIGTLink clients get no video: {}", job.video_trouble);
  const bool has_video = job.messages.at(IgtlStream::kVideo).any();
  if (has_video && job.key) key_coded_ns_ = now_ns();
  // Until all have it: a lack of memory below leaves some without this picture.
  if (job.wanted.has(IgtlStream::kVideo)) video_failed_ = true;
  for (const auto& session : std::vector(sessions_)) {
    for (std::size_t i = 0; i < kIgtlStreams; ++i) {
      const auto stream = static_cast<IgtlStream>(i);
      session->offer(stream, job.messages.at(stream).in(session->version()), job.picture.stamp.picture_id,
                     job.key);
    }
  }
  if (has_video) video_failed_ = false;
  job.messages = {};
  if (newer_waits_) show_newest();
}

void IgtlServer::offer_volume(const IgtlVolumes::Made& made) {
  for (const auto& session : std::vector(sessions_)) {
    session->offer_volume(made.messages.in(session->version()), made.ordered_id, made.shown_id);
    if (!made.messages.any()) session->not_available(IgtlStream::kVolume, made.trouble);
  }
  show_newest();  // there may be a newer one
}

void IgtlServer::bell_rang() {
  thread_owner_.check();
  if (frames_ != nullptr) send_frames();
}

void IgtlServer::send_frames() {
  FrameQueue& queue = frames_->queue();
  const IgtlWanted all = wanted();
  while (const QueuedFrame* const frame = queue.front()) {
    for (const auto version : {igtl::HeadVersion::kOne, igtl::HeadVersion::kTwo}) {
      if (frame->fault != FrameFault::kNone || !all.in(version).has(IgtlStream::kFrames)) continue;
      const auto bytes = dependencies_.write_frame(*frame, utc_ns(frame->stamp.capture_time_ns),
                                                   dependencies_.state.frame_origin(), version);
      const auto message = std::make_shared<const std::vector<std::uint8_t>>(bytes.begin(), bytes.end());
      for (const auto& session : std::vector(sessions_))
        if (session->version() == version) session->offer(IgtlStream::kFrames, message);
    }
    queue.pop();
  }
}

void IgtlServer::state_changed() {
  thread_owner_.check();
  seconds_to_state_ = kStatusSeconds;
  for (const auto& session : std::vector(sessions_)) session->send_status();
}

void IgtlServer::second_passed() {
  thread_owner_.check();
  if (frames_ != nullptr) dependencies_.state.counters.igtl_frames_missed.set(frames_->frames_missed());
  for (const auto& session : std::vector(sessions_)) session->second_passed();
  if (--seconds_to_state_ <= 0) state_changed();
  show_newest();  // what was put off: a key picture of the video, a volume
}

void IgtlServer::end() {
  boost::system::error_code ignored;
  acceptor_.close(ignored);
  volumes_.end();
  for (const auto& session : std::vector(sessions_)) session->end();
}

}  // namespace fanlight

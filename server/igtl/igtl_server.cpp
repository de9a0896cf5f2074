// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/igtl_server.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <new>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace asio = boost::asio;
using asio::ip::tcp;

namespace {

// PLUS and 3D Slicer take a connection without messages for dead.
constexpr int kStatusSeconds = 2;

/// A time of this host's steady clock as one since 1970.
std::uint64_t utc_ns(std::int64_t steady_ns) {
  timespec wall{};
  clock_gettime(CLOCK_REALTIME, &wall);
  const std::int64_t now = wall.tv_sec * std::int64_t{1'000'000'000} + wall.tv_nsec;
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, now - (now_ns() - steady_ns)));
}

}  // namespace

/// The writing of one picture's messages. The server and the thread that writes share it.
struct IgtlServer::Job {
  Picture picture;
  IgtlWanted wanted;
  std::uint64_t utc_ns = 0;
  IgtlPictureMessages messages;
  bool no_memory = false;
};

IgtlServer::IgtlServer(asio::io_context& loop, const Config& config, Dependencies dependencies)
    : config_(config),
      dependencies_(std::move(dependencies)),
      commands_(dependencies_.commands),
      session_dependencies_{.counters = dependencies_.counters,
                            .commands = commands_,
                            .state = dependencies_.state,
                            .asked =
                                [this] {
                                  if (const Picture* const picture = dependencies_.newest_picture())
                                    show(*picture);
                                },
                            .wants_changed = [this] { wants_changed(); },
                            .left =
                                [this](IgtlSession& session) {
                                  std::erase_if(sessions_,
                                                [&](const auto& each) { return each.get() == &session; });
                                  wants_changed();
                                }},
      limit_(config.most_clients, config.most_clients_a_host),
      acceptor_(loop),
      pause_(loop),
      job_(std::make_shared<Job>()) {}

IgtlServer::~IgtlServer() {
  dependencies_.wants_changed = [] {};  // nobody is left to be told
  dependencies_.frames = nullptr;
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
      dependencies_.counters.connections_refused.add();
      pause_.expires_after(std::chrono::milliseconds(100));
      return pause_.async_wait([this, link](boost::system::error_code stopped) {
        if (!stopped) accept();
      });
    }
    try {
      begin(std::move(socket));
    } catch (const std::bad_alloc&) {
      dependencies_.counters.connections_refused.add();
    }
    accept();
  });
}

void IgtlServer::begin(tcp::socket socket) {
  boost::system::error_code ignored;
  const auto remote = socket.remote_endpoint(ignored);
  auto permit = limit_.take(remote.address());
  if (!permit) {
    dependencies_.counters.connections_refused.add();  // the destructor closes the socket
    return;
  }
  socket.set_option(tcp::no_delay(true), ignored);
  Principal principal{.role = config_.role,
                      .name = "OpenIGTLink",
                      .proof = {},
                      .address = fmt::format("{}:{}", remote.address().to_string(), remote.port())};
  const auto session =
      std::make_shared<IgtlSession>(std::move(socket), *std::move(permit), config_.usual,
                                    std::move(principal), config_.most_messages, session_dependencies_);
  sessions_.push_back(session);
  session->start();
  wants_changed();
  if (const Picture* const picture = dependencies_.newest_picture()) show(*picture);
}

bool IgtlServer::wants_pictures() const {
  const IgtlWanted all = wanted();
  return all.version_1.any_of_pictures() || all.version_2.any_of_pictures();
}

void IgtlServer::wants_changed() {
  const IgtlWanted all = wanted();
  if (dependencies_.frames != nullptr)
    dependencies_.frames->open(all.version_1.has(IgtlStream::kFrames) ||
                               all.version_2.has(IgtlStream::kFrames));
  dependencies_.wants_changed();
}

IgtlWanted IgtlServer::wanted() const {
  IgtlWanted all;
  for (const auto& session : sessions_)
    (session->version() == igtl::HeadVersion::kOne ? all.version_1 : all.version_2).add(session->wanted());
  return all;
}

IgtlWanted IgtlServer::wanted_of(std::uint64_t picture_id) const {
  IgtlWanted all;
  for (const auto& session : sessions_)
    (session->version() == igtl::HeadVersion::kOne ? all.version_1 : all.version_2)
        .add(session->wanted_of(picture_id));
  return all;
}

void IgtlServer::show(const Picture& picture) {
  const IgtlWanted now = wanted_of(picture.stamp.picture_id);
  if (!now.version_1.any_of_pictures() && !now.version_2.any_of_pictures()) return;
  if (busy_) {
    newer_waits_ = true;
    return;
  }
  write_messages(picture, now);
}

void IgtlServer::write_messages(const Picture& picture, const IgtlWanted& now) {
  newer_waits_ = false;
  job_->picture = picture;
  job_->wanted = now;
  job_->utc_ns = utc_ns(picture.stamp.volume.last_capture_time_ns);
  job_->no_memory = false;
  busy_ = true;
  const std::shared_ptr<Job> job = job_;
  const auto write = [job] {
    try {
      job->messages = picture_messages(job->picture, job->wanted, job->utc_ns);
    } catch (const std::bad_alloc&) {
      job->no_memory = true;
    }
  };
  try {
    dependencies_.executor(EncoderLane::kHeavy, write, [this, job] { written(*job); });
  } catch (const std::bad_alloc&) {
    busy_ = false;  // it was not handed over
    throw;
  }
}

void IgtlServer::written(Job& job) {
  busy_ = false;
  if (job.no_memory) dependencies_.counters.handlers_out_of_memory.add();
  for (const auto& session : std::vector(sessions_)) {
    for (std::size_t i = 0; i < kIgtlStreams; ++i) {
      const auto stream = static_cast<IgtlStream>(i);
      if (stream != IgtlStream::kFrames)
        session->offer(stream, job.messages.at(stream, session->version()), job.picture.stamp.picture_id);
    }
  }
  job.messages = {};
  if (!newer_waits_) return;
  if (const Picture* const picture = dependencies_.newest_picture()) show(*picture);
}

void IgtlServer::frames_came() {
  if (dependencies_.frames == nullptr) return;
  FrameQueue& queue = dependencies_.frames->queue();
  const IgtlWanted all = wanted();
  while (const QueuedFrame* const frame = queue.front()) {
    for (const auto version : {igtl::HeadVersion::kOne, igtl::HeadVersion::kTwo}) {
      const bool is_1 = version == igtl::HeadVersion::kOne;
      if (frame->fault != FrameFault::kNone ||
          !(is_1 ? all.version_1 : all.version_2).has(IgtlStream::kFrames))
        continue;
      const auto bytes = dependencies_.write_frame(*frame, utc_ns(frame->stamp.capture_time_ns), version);
      const auto message = std::make_shared<const std::vector<std::uint8_t>>(bytes.begin(), bytes.end());
      for (const auto& session : std::vector(sessions_))
        if (session->version() == version) session->offer(IgtlStream::kFrames, message);
    }
    queue.pop();
  }
}

void IgtlServer::state_changed() {
  seconds_to_state_ = kStatusSeconds;
  for (const auto& session : std::vector(sessions_)) session->tell_status();
}

void IgtlServer::second_passed() {
  if (dependencies_.frames != nullptr)
    dependencies_.counters.igtl_frames_missed.set(dependencies_.frames->frames_missed());
  for (const auto& session : std::vector(sessions_)) session->second_passed();
  if (--seconds_to_state_ <= 0) state_changed();
}

void IgtlServer::end() {
  boost::system::error_code ignored;
  acceptor_.close(ignored);
  for (const auto& session : std::vector(sessions_)) session->end();
}

}  // namespace fanlight

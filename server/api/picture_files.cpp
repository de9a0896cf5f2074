// SPDX-License-Identifier: Apache-2.0
#include "server/api/picture_files.hpp"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "server/api/problem.hpp"
#include "server/stream/page_files.hpp"
#include "server/stream/picture_mark_of.hpp"
#include "server/stream/shared_page.hpp"

namespace fanlight {

namespace http = boost::beast::http;

namespace {

ApiResponse no_picture() {
  return refusal(Problem::kUnavailable, "there is no such picture yet, expected a later request");
}

}  // namespace

void PictureFiles::png(const ApiQuery& query, const Principal& principal, const Answer& answer,
                       std::int64_t now_ns) {
  const auto revision = wanted_revision(query);
  if (!revision) return answer(refusal(Problem::kMalformed, revision.error().message));
  once_rendered(*revision, answer, now_ns, [this, principal, answer] {
    encode({.codec = StreamSettings::Codec::kPng}, "image/png", principal, answer);
  });
}

void PictureFiles::jpeg(const ApiQuery& query, const Principal& principal, const Answer& answer,
                        std::int64_t now_ns) {
  const auto settings = jpeg_settings(query, state_.description.jpeg_quality);
  if (!settings) return answer(refusal(Problem::kMalformed, settings.error().message));
  const auto revision = wanted_revision(query);
  if (!revision) return answer(refusal(Problem::kMalformed, revision.error().message));
  once_rendered(*revision, answer, now_ns, [this, principal, answer, settings = *settings]() mutable {
    settings.mark = mark_of(state_.liveness.report());
    encode(settings, "image/jpeg", principal, answer);
  });
}

bool PictureFiles::shows(std::uint64_t revision) const {
  const Picture* const newest = hub_.newest_picture();
  return newest != nullptr && newest->stamp.scene_revision >= revision;
}

void PictureFiles::once_rendered(std::uint64_t revision, const Answer& answer, std::int64_t now_ns,
                                 const std::function<void()>& then) {
  state_.demand.asked(now_ns);
  if (shows(revision)) return then();
  if (waiting_.size() >= PictureHub::kMostFileRequests) return answer(no_picture());
  waiting_.push_back({then, answer, now_ns + kMostWaitNs, revision});
}

void PictureFiles::shared_surface(const Principal& principal, const Answer& answer, std::int64_t now_ns) {
  if (!has_role(principal.role, kShares)) {
    constexpr auto kReason = "the role may not share surfaces, expected an operator";
    audit_.note(principal, {.what = "share", .result = std::string("refused: ") + kReason}, nullptr);
    return answer(refusal(Problem::kNotPermitted, kReason));
  }
  once_rendered(0, answer, now_ns, [this, principal, answer] { make_shared_page(principal, answer); });
}

void PictureFiles::make_shared_page(const Principal& principal, const Answer& answer) {
  const auto refused = [&](http::status status, const std::string& reason) {
    audit_.note(principal, {.what = "share", .result = "refused: " + reason}, nullptr);
    answer(refusal(status, reason));
  };
  const Picture* const newest = hub_.newest_picture();
  if (newest == nullptr) return answer(no_picture());
  // Its camera would be another one.
  if (newest->stamp.scene_revision < state_.scene_store.in_force().revision)
    return refused(http::status::service_unavailable,
                   "the newest picture does not show the scene in force yet, expected a later request");
  struct Made {
    Result<std::string> html = Error{ErrorCode::kUnavailable, "there is no memory to make the page"};
    std::uint64_t picture_id = 0;
  };
  const auto made = std::make_shared<Made>();
  const auto begun = hub_.work_on_newest(
      [made, scene = state_.scene_store.in_force().scene,
       usual = state_.description.picture_size](const Picture& picture) {
        made->picture_id = picture.stamp.picture_id;
        SharedPage page(shared_page_template(), "", scene);
        if (const auto added = page.add_within(picture, usual); added) {
          made->html = page.html();
        } else {
          made->html = added.error();
        }
      },
      [made, answer, principal, this] {
        const std::string result = made->html ? "done" : "refused: " + made->html.error().message;
        audit_.note(principal, {.what = "share", .result = result}, {{"picture", made->picture_id}});
        if (!made->html) return answer(refusal(http::status::conflict, made->html.error().message));
        ApiResponse response(http::status::ok, 11);
        response.set(http::field::content_type, "text/html; charset=utf-8");
        response.set(http::field::content_disposition, "attachment; filename=surface.html");
        response.body() = *std::move(made->html);
        answer(std::move(response));
      });
  if (!begun) refused(http::status::service_unavailable, begun.error().message);
}

void PictureFiles::answer_waiting(std::int64_t now_ns) {
  if (waiting_.empty()) return;
  const auto is_due = [&](const Waiting& each) { return now_ns >= each.until_ns || shows(each.revision); };
  std::vector<Waiting> due;
  for (Waiting& each : waiting_) {
    if (is_due(each)) due.push_back(each);
  }
  std::erase_if(waiting_, is_due);
  for (const Waiting& each : due) {
    if (shows(each.revision)) {
      each.then();
    } else {
      each.answer(no_picture());
    }
  }
}

void PictureFiles::encode(const StreamSettings& settings, const char* media_type, const Principal& principal,
                          const Answer& answer) {
  hub_.file(settings, [answer, principal, media_type, this](const Result<PictureHub::PictureFile>& file) {
    if (!file) {
      const bool busy = file.error().code == ErrorCode::kUnavailable;
      return answer(refusal(busy ? Problem::kUnavailable : Problem::kFailed, file.error().message));
    }
    audit_.note(principal, {.what = "picture_read", .result = "done"}, {{"picture", file->stamp.picture_id}});
    ApiResponse response(http::status::ok, 11);
    response.set(http::field::content_type, media_type);
    response.set("X-Fanlight-Picture-Id", std::to_string(file->stamp.picture_id));
    response.set("X-Fanlight-Volume-Id", std::to_string(file->stamp.volume.volume_id));
    response.set("X-Fanlight-Scene-Revision", std::to_string(file->stamp.scene_revision));
    const PictureLiveness::Report& liveness = state_.liveness.report();
    response.set("X-Fanlight-Liveness", PictureLiveness::name(liveness.state));
    response.set("X-Fanlight-Origin", origin_name(liveness.origin));
    response.body() = *file->bytes;
    answer(std::move(response));
  });
}

}  // namespace fanlight

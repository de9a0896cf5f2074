// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/outbox.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include "tests/support/file_text.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight {
namespace {

using State = StoreOutcome::State;
using Which = Outbox::Which;

/// A queue, and an archive that does with each object what its one byte says.
class OutboxTest : public testing::Test {
 protected:
  Outbox open(const std::string& name = "ARCHIVE@host:104") {
    auto opened = Outbox::open(folder_ / "queue",
                               {.name = name,
                                .store = [this](auto files, const auto& /*stop*/) { return store(files); },
                                .check = [] { return Result<void>(); }});
    if (!opened) {
      ADD_FAILURE() << opened.error().message;
      std::abort();
    }
    return *std::move(opened);
  }

  Result<std::vector<StoreOutcome>> store(std::span<const std::filesystem::path> files) {
    if (absent_) return Error{ErrorCode::kUnavailable, "absent"};
    std::vector<StoreOutcome> outcomes(files.size());
    for (std::size_t at = 0; at < files.size(); ++at) {
      const std::string object = test::text_of(files[at]);
      asked_.push_back(object);
      outcomes[at] = StoreOutcome::of_peer(State::kStored, "");
      if (refused_.contains(object)) outcomes[at] = StoreOutcome::of_peer(State::kRefused, "refused");
      if (failing_.contains(object)) {
        outcomes[at] = StoreOutcome::of_peer(State::kNotSent, "broke");
        break;  // as a connection does
      }
    }
    return outcomes;
  }

  static void add(Outbox& outbox, std::string_view objects) {
    std::vector<std::filesystem::path> staged;
    for (const char object : objects) {
      const auto byte = static_cast<std::uint8_t>(object);
      const auto path = outbox.stage({&byte, 1}, "object");
      ASSERT_TRUE(path) << path.error().message;
      staged.push_back(*path);
    }
    ASSERT_TRUE(outbox.publish(staged));
  }

  Outbox::Report send(Outbox& outbox, Which which = Which::kAll) {
    asked_.clear();
    auto report = outbox.send(which, never_);
    EXPECT_TRUE(report);
    return report ? *report : Outbox::Report{};
  }

  std::string asked() const {
    std::string all;
    for (const std::string& each : asked_) all += each;
    return all;
  }

  test::TemporaryFolder folder_;
  std::set<std::string> refused_;
  std::set<std::string> failing_;
  bool absent_ = false;
  std::vector<std::string> asked_;
  const std::atomic<bool> never_ = false;
};

TEST_F(OutboxTest, SendsInOrderWhatIsPublished) {
  Outbox outbox = open();
  add(outbox, "abc");
  const std::uint8_t byte = 'x';
  const auto staged = outbox.stage({&byte, 1}, "object");
  EXPECT_EQ(outbox.waiting(), 3U) << "what is staged does not wait yet";
  EXPECT_EQ(send(outbox).stored, 3U);
  EXPECT_EQ(asked(), "abc");
  EXPECT_EQ(outbox.waiting(), 0U);
  Outbox::discard({&*staged, 1});
  EXPECT_FALSE(std::filesystem::exists(*staged));
}

TEST_F(OutboxTest, AnObjectThatFailsHoldsUpNoOther) {
  failing_ = {"a"};
  Outbox outbox = open();
  add(outbox, "abc");
  EXPECT_EQ(send(outbox).stored, 2U);
  EXPECT_EQ(asked(), "abc");
  add(outbox, "d");
  send(outbox, Which::kUntried);
  EXPECT_EQ(asked(), "d");
  add(outbox, "e");
  send(outbox);
  EXPECT_EQ(asked(), "ea") << "what failed comes last";
  EXPECT_EQ(outbox.waiting(), 1U);
}

TEST_F(OutboxTest, ThreeFailuresEndAnAttemptAndTheNextProgramBeginsBehindThem) {
  failing_ = {"a", "b", "c", "d"};
  {
    Outbox outbox = open();
    add(outbox, "abcdef");
    EXPECT_EQ(send(outbox).stored, 0U);
    EXPECT_EQ(asked(), "abc");
  }
  Outbox next = open();
  EXPECT_EQ(send(next).stored, 2U);
  EXPECT_EQ(asked(), "defabc");
  EXPECT_EQ(next.waiting(), 4U);
}

TEST_F(OutboxTest, PutsAsideWhatIsRefusedAndReplacesNothingThere) {
  refused_ = {"a"};
  Outbox outbox = open();
  for (int times = 0; times < 2; ++times) {
    std::ofstream(folder_ / "queue" / "same.dcm") << "a";
    EXPECT_EQ(send(outbox).refused, 1U);
  }
  std::size_t kept = 0;
  for ([[maybe_unused]] const auto& entry :
       std::filesystem::directory_iterator(folder_ / "queue" / "refused"))
    ++kept;
  EXPECT_EQ(kept, 2U);
}

TEST_F(OutboxTest, IsForOneArchive) {
  Outbox outbox = open();
  add(outbox, "a");
  const auto other = Outbox::open(folder_ / "queue", {.name = "OTHER@host:104", .store = {}, .check = {}});
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::kInvalidArgument);
  std::ofstream(folder_ / "queue" / "archive") << "OTHER@host:104\n";
  const auto sent = outbox.send(Which::kAll, never_);
  ASSERT_FALSE(sent) << "a sender that runs notices it";
  EXPECT_TRUE(asked_.empty());
}

TEST_F(OutboxTest, KeepsAllForAnArchiveThatIsAbsent) {
  absent_ = true;
  Outbox outbox = open();
  add(outbox, "ab");
  EXPECT_FALSE(outbox.send(Which::kAll, never_));
  absent_ = false;
  EXPECT_EQ(send(outbox).stored, 2U);
}

TEST_F(OutboxTest, HasOneSender) {
  Outbox first = open();
  Outbox second = open();
  const auto is_first = first.become_sender();
  const auto is_second = second.become_sender();
  EXPECT_TRUE(is_first && *is_first);
  EXPECT_TRUE(is_second && !*is_second);
}

TEST(StoreOutcome, FollowsFromTheStatusesOfDicom) {
  for (const unsigned status : {0x0000U, 0x0001U, 0x0107U, 0x0116U, 0xB000U, 0xB007U})
    EXPECT_EQ(outcome_of_status(static_cast<std::uint16_t>(status)).state, State::kStored) << status;
  for (const unsigned status : {0xA700U, 0xA7FFU, 0x0110U, 0x0124U, 0x0213U})
    EXPECT_EQ(outcome_of_status(static_cast<std::uint16_t>(status)).state, State::kNotSent) << status;
  for (const unsigned status : {0x0111U, 0x0117U, 0x0122U, 0xA900U, 0xC000U})
    EXPECT_EQ(outcome_of_status(static_cast<std::uint16_t>(status)).state, State::kRefused) << status;
}

TEST(DicomWeb, AnswersFollowTheirStatusAndTheirFailedObjects) {
  const auto failed = [](unsigned reason) {
    return R"({"00081198":{"vr":"SQ","Value":[{"00081197":{"vr":"US","Value":[)" + std::to_string(reason) +
           "]}}]}}";
  };
  const auto state = [](long status, const std::string& body) {
    const auto outcome = outcome_of_answer(status, body);
    return outcome ? outcome->state : State::kNotTried;
  };
  EXPECT_EQ(state(200, "{}"), State::kStored);
  EXPECT_EQ(state(200, failed(0xA700)), State::kNotSent) << "said in the body alone";
  EXPECT_EQ(state(202, failed(0xC000)), State::kRefused);
  EXPECT_EQ(state(202, R"({"00081198":{"Value":[{}]}})"), State::kNotSent) << "no reason is given";
  EXPECT_EQ(state(409, failed(0x0110)), State::kNotSent);
  EXPECT_EQ(state(409, "<xml/>"), State::kRefused);
  EXPECT_EQ(state(413, ""), State::kRefused);
  EXPECT_EQ(state(503, ""), State::kNotSent);
  EXPECT_EQ(state(0, "reset by peer"), State::kNotSent);
  for (const long status : {301L, 401L, 403L, 404L, 405L}) {
    const auto outcome = outcome_of_answer(status, "");
    ASSERT_FALSE(outcome) << status;
    EXPECT_EQ(outcome.error().code, ErrorCode::kUnavailable);
  }
}

TEST(DicomWeb, IsAUrlWithoutALogin) {
  const auto peer = parse_dicom_web("https://pacs.example:8443/dicom-web/", "user:password");
  ASSERT_TRUE(peer);
  EXPECT_EQ(peer->url, "https://pacs.example:8443/dicom-web");
  EXPECT_TRUE(parse_dicom_web("http://localhost:8042/dicom-web", "user:password"));
  EXPECT_FALSE(parse_dicom_web("http://pacs.example/dicom-web", "user:password")) << "unencrypted";
  EXPECT_TRUE(parse_dicom_web("http://pacs.example/dicom-web"));
  EXPECT_TRUE(parse_dicom_web("https://pacs.example/studies-2/dicom-web"));
  EXPECT_FALSE(parse_dicom_web("https://pacs.example/dicom-web/studies/"));
  for (const char* url : {"https://user:secret@pacs.example/", "https://", "ftp://pacs.example/",
                          "https://pacs.example/?a=b", "pacs.example"}) {
    const auto refused = parse_dicom_web(url);
    ASSERT_FALSE(refused) << url;
    EXPECT_EQ(refused.error().message.find("secret"), std::string::npos);
  }
}

}  // namespace
}  // namespace fanlight

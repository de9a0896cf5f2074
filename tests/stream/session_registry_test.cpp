// SPDX-License-Identifier: Apache-2.0
// SessionRegistry without sockets: which session receives what.
#include "server/stream/session_registry.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace fanlight::test {
namespace {

using Told = std::vector<std::string>;

std::string name_of(Notice notice) {
  return notice == Notice::kScene     ? "scene"
         : notice == Notice::kView    ? "view"
         : notice == Notice::kControl ? "control"
         : notice == Notice::kProbe   ? "probe"
                                      : "liveness";
}

/// A session that keeps what it receives.
class Spy : public RegisteredSession {
 public:
  Spy(std::uint64_t id, bool open) : id_(id), open_(open) {}

  std::uint64_t id() const override { return id_; }
  bool is_open() const override { return open_; }
  void notify(Notice notice) override { told.push_back(name_of(notice)); }
  void view_ended(const std::string& reason) override { told.push_back("view ended: " + reason); }
  void scene_withdrawn(const std::string& reason) override { told.push_back("withdrawn: " + reason); }
  void second_passed() override { told.emplace_back("second"); }
  void end(const std::string& reason) override { told.push_back("end: " + reason); }
  void abandon() override { told.emplace_back("abandon"); }

  Told told;

 private:
  std::uint64_t id_;
  bool open_;
};

class SessionRegistryTest : public testing::Test {
 protected:
  SessionRegistryTest() {
    for (const auto& spy : {first_, second_, closed_}) registry_.add(spy);
  }

  Doorbell bell_;
  RenderLink link_{bell_, bell_};
  SceneStore scene_store_{{.revision = 1, .scene = {}}, {}, link_.scenes};
  RenderCounters render_;
  ServerCounters counters_;
  ViewAdmission views_{{.link = link_, .scene_store = scene_store_, .render = render_, .counters = counters_},
                       kMostPrivateViews,
                       {4, 4}};
  SessionRegistry registry_{views_};
  std::shared_ptr<Spy> first_ = std::make_shared<Spy>(registry_.next_id(), true);
  std::shared_ptr<Spy> second_ = std::make_shared<Spy>(registry_.next_id(), true);
  std::shared_ptr<Spy> closed_ = std::make_shared<Spy>(registry_.next_id(), false);
};

TEST_F(SessionRegistryTest, NumbersSessionsFromOneAndNeverTwice) {
  EXPECT_EQ(first_->id(), 1U);
  EXPECT_EQ(closed_->id(), 3U);
  registry_.remove(3);
  EXPECT_EQ(registry_.next_id(), 4U);
}

TEST_F(SessionRegistryTest, TellsOpenSessionsOnly) {
  registry_.notify(Notice::kControl);
  registry_.notify(Notice::kProbe);
  registry_.notify(Notice::kLiveness);
  EXPECT_EQ(first_->told, (Told{"control", "probe", "liveness"}));
  EXPECT_EQ(second_->told, first_->told);
  EXPECT_EQ(closed_->told, Told());
}

TEST_F(SessionRegistryTest, TellsASceneToAllButWhoChangedIt) {
  registry_.notify(Notice::kScene, 1);
  EXPECT_EQ(first_->told, Told());
  EXPECT_EQ(second_->told, (Told{"scene"}));
  registry_.notify(Notice::kScene, 0);
  EXPECT_EQ(first_->told, (Told{"scene"}));
}

TEST_F(SessionRegistryTest, TellsAChangedPrivateViewToItsSessionAlone) {
  v1::Scene own;
  own.mutable_light()->set_right_mm(20);
  const SceneField* refused = nullptr;
  ASSERT_TRUE(views_.change(2, own, &refused, 0));
  v1::Scene main;
  main.mutable_detector()->set_threshold(77);
  ASSERT_TRUE(scene_store_.apply(main));
  registry_.notify(Notice::kScene, 1);
  EXPECT_EQ(first_->told, Told());
  EXPECT_EQ(second_->told, (Told{"scene", "view"}));
}

TEST_F(SessionRegistryTest, TellsTheEndOfAViewToItsSession) {
  registry_.view_ended(2, "because");
  registry_.view_ended(3, "it is not open");
  registry_.view_ended(9, "there is none");
  EXPECT_EQ(first_->told, Told());
  EXPECT_EQ(second_->told, (Told{"view ended: because"}));
  EXPECT_EQ(closed_->told, Told());
}

TEST_F(SessionRegistryTest, ListsAllSessionsInOrderUntilTheyAreRemoved) {
  EXPECT_EQ(registry_.all().size(), 3U);
  EXPECT_EQ(registry_.all().back()->id(), 3U);
  registry_.remove(1);
  ASSERT_EQ(registry_.all().size(), 2U);
  EXPECT_EQ(registry_.all().front()->id(), 2U);
  registry_.notify(Notice::kControl);
  EXPECT_EQ(first_->told, Told());
}

TEST_F(SessionRegistryTest, AWithdrawnSceneIsExplainedToEveryOpenSession) {
  registry_.scene_withdrawn("no memory");
  const Told expected = {"withdrawn: no memory", "scene"};
  EXPECT_EQ(first_->told, expected);
  EXPECT_EQ(second_->told, expected);
  EXPECT_TRUE(closed_->told.empty());
}

}  // namespace
}  // namespace fanlight::test

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "server/pacs/dicom_peer.hpp"
#include "server/pacs/identity_json.hpp"

namespace fanlight {
namespace {

TEST(DicomPeer, IsATitleAHostAndAPort) {
  const auto peer = parse_dicom_peer("MAIN ARCHIVE@pacs.example:11112");
  ASSERT_TRUE(peer);
  EXPECT_EQ(peer->called_title, "MAIN ARCHIVE");
  EXPECT_EQ(peer->host, "pacs.example");
  EXPECT_EQ(peer->port, 11112);
}

TEST(DicomPeer, RefusesWhatIsNoPeer) {
  for (const char* text :
       {"", "ARCHIVE", "ARCHIVE@host", "@host:104", "ARCHIVE@:104", "ARCHIVE@host:0", "ARCHIVE@host:70000",
        "ARCHIVE@host:104x", "A\\B@host:104", "SEVENTEEN LETTERS@host:104", "  @host:104", "host:104@ARCHIVE",
        "ARCHIVE@[::1]:104"}) {
    const auto peer = parse_dicom_peer(text);
    ASSERT_FALSE(peer) << text;
    EXPECT_EQ(peer.error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(Identity, ComesBackFromItsJson) {
  const nlohmann::json json = {{"patient_name", "Müller^Änne"}, {"patient_id", "P1"},
                               {"birth_date", "19900203"},      {"sex", "F"},
                               {"study_uid", "1.2.3.40"},       {"scheduled_step_id", "S1"}};
  const auto identity = parse_identity(json);
  ASSERT_TRUE(identity);
  EXPECT_EQ(identity->patient_name, "Müller^Änne");
  EXPECT_EQ(identity_json(*identity), json);
  EXPECT_EQ(identity_json(*parse_identity(nlohmann::json::object())), nlohmann::json::object());
}

TEST(Identity, RefusesWhatDicomCannotHoldAndDoesNotRepeatIt) {
  const std::string secret = "Secret";
  for (const nlohmann::json& json :
       {nlohmann::json{{"patient_name", secret + "\\Other"}},
        nlohmann::json{{"patient_name", secret + "\x1b[31m"}}, nlohmann::json{{"birth_date", secret}},
        nlohmann::json{{"birth_date", "1990-02-03"}}, nlohmann::json{{"sex", secret}},
        nlohmann::json{{"study_uid", secret}},
        nlohmann::json{{"accession_number", secret + std::string(20, 'x')}},
        nlohmann::json{{"patient_id", 4711}}, nlohmann::json{{"name", secret}},
        nlohmann::json::array({secret})}) {
    const auto identity = parse_identity(json);
    ASSERT_FALSE(identity) << json;
    EXPECT_EQ(identity.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(identity.error().message.find(secret), std::string::npos) << identity.error().message;
  }
}

TEST(Identity, CountsCharactersAndNotBytes) {
  std::string name;
  for (int count = 0; count < 64; ++count) name += "ä";
  EXPECT_TRUE(parse_identity({{"patient_name", name}}));
  EXPECT_FALSE(parse_identity({{"patient_name", name + "ä"}}));
  EXPECT_TRUE(parse_identity({{"patient_name", name + "=" + name + "=" + name}})) << "of each group";
  EXPECT_FALSE(parse_identity({{"patient_name", "a=b=c=d"}}));
  EXPECT_FALSE(check_identity({.patient_name = name + "ä"}));
  EXPECT_FALSE(check_identity({.sex = "U"}));
  EXPECT_TRUE(check_identity({}));
}

}  // namespace
}  // namespace fanlight

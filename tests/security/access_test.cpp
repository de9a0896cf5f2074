// SPDX-License-Identifier: Apache-2.0
// Tokens: creation, file, authentication, revocation, and the back-off after a wrong one.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "server/access/authenticator.hpp"
#include "tests/support/file_text.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

constexpr std::int64_t kNow = 1'800'000'000;  // 2027-01-15

TEST(Credentials, KnowATokenByItsHashAlone) {
  const TemporaryFolder folder;
  const auto file = folder / "tokens.toml";
  const NewToken made = make_token("theatre \"3\"\n", Role::kOperator, std::nullopt);
  ASSERT_TRUE(append_token(file, made.entry));
  std::ifstream text(file);
  const std::string all((std::istreambuf_iterator<char>(text)), {});
  EXPECT_EQ(all.find(made.text), std::string::npos);
  EXPECT_EQ(all.find(made.text.substr(12)), std::string::npos) << "the secret part is in the file";
  struct stat status {};
  ASSERT_EQ(stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600U);

  const auto known = Credentials::load(file);
  ASSERT_TRUE(known) << known.error().message;
  const auto entry = known->token(made.text, kNow);
  ASSERT_TRUE(entry) << entry.error().message;
  EXPECT_EQ(entry->name, "theatre \"3\"\n");
  EXPECT_EQ(entry->role, Role::kOperator);
  EXPECT_TRUE(known->holds(entry->id, Role::kOperator, kNow));
  EXPECT_FALSE(known->holds(entry->id, Role::kAdmin, kNow));
}

TEST(Credentials, RefuseWhatIsNearlyRight) {
  const TemporaryFolder folder;
  const NewToken made = make_token("a", Role::kAdmin, std::nullopt);
  ASSERT_TRUE(append_token(folder / "t", made.entry));
  const Credentials known = Credentials::load(folder / "t").value();
  for (std::size_t at = 0; at < made.text.size(); ++at) {
    std::string other = made.text;
    other[at] = other[at] == '0' ? '1' : '0';
    EXPECT_FALSE(known.token(other, kNow)) << at;
  }
  for (const std::string& other : {std::string(), made.text + "0", made.text.substr(1),
                                   std::string(5000, 'f'), made.text.substr(0, made.text.size() - 1)}) {
    EXPECT_FALSE(known.token(other, kNow));
  }
}

TEST(Credentials, ExpireAtTheBeginningOfTheDay) {
  const TemporaryFolder folder;
  const std::int64_t day_s = parse_day("2027-01-15").value();
  const NewToken made = make_token("a", Role::kViewer, day_s);
  ASSERT_TRUE(append_token(folder / "t", made.entry));
  const Credentials known = Credentials::load(folder / "t").value();
  EXPECT_TRUE(known.token(made.text, day_s - 1));
  EXPECT_FALSE(known.token(made.text, day_s));
  EXPECT_FALSE(known.holds(made.entry.id, Role::kViewer, day_s));
  EXPECT_EQ(day_text(day_s), "2027-01-15");
  for (const char* text :
       {"", "2027-02-30", "2027-13-01", "27-01-01", "2027-1-1", "2027-01-01T", "abcd-ef-gh"}) {
    EXPECT_FALSE(parse_day(text)) << text;
  }
}

TEST(Credentials, CertificatesExpireToo) {
  const TemporaryFolder folder;
  std::ofstream(folder / "t") << "[[certificate]]\nname = \"c\"\nrole = \"admin\"\nsha256 = \""
                              << hex(sha256("x")) << "\"\nexpires = \"2027-01-15\"\n";
  const Credentials known = Credentials::load(folder / "t").value();
  const std::int64_t day_s = parse_day("2027-01-15").value();
  EXPECT_TRUE(known.certificate(sha256("x"), day_s - 1));
  EXPECT_FALSE(known.certificate(sha256("x"), day_s));
}

TEST(Credentials, AreTakenBackOneByOne) {
  const TemporaryFolder folder;
  const auto file = folder / "t";
  const NewToken first = make_token("first", Role::kViewer, std::nullopt);
  const NewToken second = make_token("second", Role::kViewer, std::nullopt);
  ASSERT_TRUE(append_token(file, first.entry));
  std::ofstream(file, std::ios::app)
      << "# a remark\n[[certificate]]\nname = \"c\"\nrole = \"admin\"\nsha256 = \"" << hex(sha256("x"))
      << "\"\n\n";
  ASSERT_TRUE(append_token(file, second.entry));
  ASSERT_TRUE(remove_token(file, first.entry.id));
  const Credentials known = Credentials::load(file).value();
  EXPECT_FALSE(known.token(first.text, kNow));
  EXPECT_TRUE(known.token(second.text, kNow));
  EXPECT_TRUE(known.certificate(sha256("x"), kNow));
  EXPECT_EQ(remove_token(file, first.entry.id).error().code, ErrorCode::kNotFound);
}

/// A [[token]] table as a person may write it.
std::string handwritten_token(const std::string& id) {
  return "[[ token ]]  # of the ward\n  id=\"" + id +
         "\"\n  name = \"\"\"\\\n    a\"\"\"\n  role='viewer'\nsha256=\"" + hex(sha256("x")) + "\"\n";
}

TEST(Credentials, AreTakenBackWhereAPersonWroteThem) {
  const TemporaryFolder folder;
  std::ofstream(folder / "t") << handwritten_token("11112222") << handwritten_token("33334444")
                              << handwritten_token("11112222");
  ASSERT_EQ(Credentials::load(folder / "t").value().tokens().size(), 3U);
  const auto removed = remove_token(folder / "t", "11112222");
  ASSERT_TRUE(removed) << removed.error().message;
  EXPECT_EQ(text_of(folder / "t"), handwritten_token("33334444"));
}

TEST(Credentials, LeaveEverythingElseInTheFileWhenOneIsTakenBack) {
  const TemporaryFolder folder;
  const NewToken made = make_token("a", Role::kViewer, std::nullopt);
  const std::string before =
      "# tokens of the ward\n\n" + handwritten_token("11112222") + "\n# the next one\n\n";
  const std::string after =
      "  # the last one\r\n[[certificate]]\nname = \"c\"\nrole = \"admin\"\nsha256 = \"" + hex(sha256("x")) +
      "\"  # no line end";
  std::ofstream(folder / "t") << before;
  ASSERT_TRUE(append_token(folder / "t", made.entry));
  std::ofstream(folder / "t", std::ios::app) << after;
  const auto removed = remove_token(folder / "t", made.entry.id);
  ASSERT_TRUE(removed) << removed.error().message;
  EXPECT_EQ(text_of(folder / "t"), before + after);
}

TEST(Credentials, AreNotTakenBackWhereSomethingElseWouldBeLost) {
  const TemporaryFolder folder;
  const auto entry = [](const std::string& id) {
    return "{id='" + id + "', name='a', role='viewer', sha256='" + hex(sha256("x")) + "'}";
  };
  const std::string one_line = "token = [" + entry("11112222") + ", " + entry("33334444") + "]\n";
  std::ofstream(folder / "t") << one_line;
  ASSERT_EQ(Credentials::load(folder / "t").value().tokens().size(), 2U);
  EXPECT_EQ(remove_token(folder / "t", "11112222").error().code, ErrorCode::kBadInput);
  EXPECT_EQ(text_of(folder / "t"), one_line);
}

TEST(Credentials, SayWhatIsWrongWithTheirFile) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text) {
    std::ofstream(folder / "t") << text;
    const auto known = Credentials::load(folder / "t");
    return known ? "" : known.error().message;
  };
  const std::string hash = hex(sha256("x"));
  EXPECT_NE(refused("nonsense").find("TOML"), std::string::npos);
  EXPECT_NE(refused("[token]\nid = 1\n").find("[[token]]"), std::string::npos);
  EXPECT_NE(refused("[[token]]\nid=\"12345678\"\nname=\"a\"\nrole=\"king\"\nsha256=\"" + hash + "\"\n")
                .find("role"),
            std::string::npos);
  EXPECT_NE(refused("[[token]]\nid=\"12345678\"\nname=\"a\"\nrole=\"admin\"\nsha256=\"12\"\n").find("sha256"),
            std::string::npos);
  EXPECT_NE(refused("[[token]]\nid=\"1\"\nname=\"a\"\nrole=\"admin\"\nsha256=\"" + hash + "\"\n").find("id"),
            std::string::npos);
  EXPECT_NE(refused("[[token]]\nid=\"12345678\"\nname=\"a\"\nrole=\"admin\"\nsha256=\"" + hash +
                    "\"\nexpires=\"soon\"\n")
                .find("expires"),
            std::string::npos);
  chmod((folder / "t").c_str(), 0666);
  EXPECT_NE(refused("").find("others"), std::string::npos);
  EXPECT_EQ(Credentials::load(folder / "none").error().code, ErrorCode::kNotFound);
  // A folder opens and cannot be read, also by root.
  std::filesystem::create_directory(folder / "directory");
  const auto unreadable = Credentials::load(folder / "directory");
  ASSERT_FALSE(unreadable) << "a file that cannot be read is no empty one";
  EXPECT_NE(unreadable.error().message.find("cannot be read"), std::string::npos);
  EXPECT_FALSE(remove_token(folder / "directory", "12345678"));
}

TEST(LoginBackoff, MakesGuessingSlow) {
  LoginBackoff guard;
  std::int64_t now_ms = 5'000'000;
  EXPECT_EQ(guard.wait_ms("a", now_ms), 0);
  std::int64_t waited_ms = 0;
  for (int wrong = 0; wrong < 20; ++wrong) {
    guard.failed("a", now_ms);
    const std::int64_t wait_ms = guard.wait_ms("a", now_ms);
    EXPECT_GE(wait_ms, 1000);
    EXPECT_LE(wait_ms, 60'000);
    waited_ms += wait_ms;
    now_ms += wait_ms;
  }
  EXPECT_GT(waited_ms, 14 * 60'000);
  EXPECT_EQ(guard.wait_ms("b", now_ms), 0) << "one address, not all";
}

TEST(LoginBackoff, ForgetsAndStaysSmall) {
  LoginBackoff guard;
  guard.failed("a", 0);
  guard.failed("a", 1000);
  guard.failed("a", 1'000'000);
  EXPECT_EQ(guard.wait_ms("a", 1'000'000), 1000);
  for (int address = 0; address < 100'000; ++address)
    guard.failed(std::to_string(address), 2'000'000 + address);
  EXPECT_EQ(guard.wait_ms("0", 2'000'000), 0) << "the stalest made room";
  EXPECT_GT(guard.wait_ms("99999", 2'099'999), 0);
}

TEST(Authenticator, ReadsItsFileAgain) {
  const TemporaryFolder folder;
  const auto file = folder / "t";
  const NewToken made = make_token("a", Role::kViewer, std::nullopt);
  ASSERT_TRUE(append_token(file, made.entry));
  AuditLog none;
  Authenticator authenticator = Authenticator::create(file).value();
  authenticator.audit_to(none);
  const auto principal = authenticator.by_token(made.text, "10.0.0.1:5");
  ASSERT_TRUE(principal);
  std::string trouble;
  EXPECT_FALSE(authenticator.reload(trouble));
  int age = 0;
  const auto touch = [&] {
    std::filesystem::last_write_time(
        file, std::filesystem::file_time_type::clock::now() + std::chrono::seconds(++age));
  };
  std::ofstream(file, std::ios::app) << "[[token]]\n";
  touch();
  EXPECT_TRUE(authenticator.reload(trouble));
  EXPECT_NE(trouble, "");
  EXPECT_TRUE(authenticator.may_stay(*principal)) << "what cannot be read changes nothing";
  std::ofstream(file) << "";
  touch();
  EXPECT_TRUE(authenticator.reload(trouble));
  EXPECT_EQ(trouble, "");
  EXPECT_FALSE(authenticator.may_stay(*principal));
  EXPECT_FALSE(authenticator.by_token(made.text, "10.0.0.1:5"));
  EXPECT_EQ(authenticator.by_token(made.text, "10.0.0.1:6").error().code, ErrorCode::kUnavailable)
      << "too soon, from any port";
}

}  // namespace
}  // namespace fanlight::test

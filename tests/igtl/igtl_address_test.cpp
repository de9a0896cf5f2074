// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/igtl_address.hpp"

#include <gtest/gtest.h>

#include <string>

namespace fanlight::test {
namespace igtl_address_tests {

std::string refusal(std::string_view text) {
  const auto parsed = IgtlAddress::parse(text);
  return parsed ? "" : parsed.error().message;
}

TEST(IgtlAddress, HasAUsualPort) {
  const auto address = IgtlAddress::parse("scanner.local");
  ASSERT_TRUE(address);
  EXPECT_EQ(address->host, "scanner.local");
  EXPECT_EQ(address->port, "18944");
  EXPECT_EQ(address->text(), "igtl:scanner.local:18944");
}

TEST(IgtlAddress, TakesPortsIpv6AndOptions) {
  const auto address =
      IgtlAddress::parse("[::1]:2000,image=Image_Reference,transform=ProbeToTracker,orientation=UF");
  ASSERT_TRUE(address) << address.error().message;
  EXPECT_EQ(address->host, "::1");
  EXPECT_EQ(address->text(), "igtl:[::1]:2000");
  EXPECT_EQ(address->image, "Image_Reference");
  EXPECT_EQ(address->transform, "ProbeToTracker");
  EXPECT_TRUE(address->orientation.towards_unmarked);
}

TEST(IgtlAddress, SaysWhatIsWrong) {
  EXPECT_NE(refusal("").find("host"), std::string::npos);
  EXPECT_NE(refusal("a b").find("host"), std::string::npos);
  EXPECT_NE(refusal("::1").find("[ADDRESS]"), std::string::npos);
  EXPECT_NE(refusal("host:0").find("1 to 65535"), std::string::npos);
  EXPECT_NE(refusal("host:65536").find("1 to 65535"), std::string::npos);
  EXPECT_NE(refusal("host:").find("1 to 65535"), std::string::npos);
  EXPECT_NE(refusal("host,imgae=x").find("did you mean image"), std::string::npos);
  EXPECT_NE(refusal("host,image=").find("no value"), std::string::npos);
  EXPECT_NE(refusal("host,image=aNameOfMoreThan20Letters").find("20 characters"), std::string::npos);
  EXPECT_NE(refusal("host,orientation=XY").find("MF, MN"), std::string::npos);
}

}  // namespace igtl_address_tests
}  // namespace fanlight::test

// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/usb_address.hpp"

#include <gtest/gtest.h>

namespace fanlight {
namespace {

TEST(UsbAddress, ReadsWhatLsusbPrints) {
  const auto plain = UsbAddress::parse("1209:0001");
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->vendor, 0x1209);
  EXPECT_EQ(plain->product, 1);
  EXPECT_EQ(plain->serial, "");
  EXPECT_EQ(plain->text(), "usb:1209:0001");
  const auto named = UsbAddress::parse("1d6b:FACE:A:7");
  ASSERT_TRUE(named);
  EXPECT_EQ(named->product, 0xFACE);
  EXPECT_EQ(named->serial, "A:7");
  EXPECT_EQ(named->text(), "usb:1d6b:face:A:7");
}

TEST(UsbAddress, RefusesInOneSentence) {
  for (const char* text :
       {"", ":", "1209", "1209:", "1209:00001", "120g:0001", "-1:1", "1209:0001:", "0x12:0x34"}) {
    EXPECT_FALSE(UsbAddress::parse(text)) << text;
  }
  EXPECT_EQ(UsbAddress::parse("probe").error().message,
            "the USB device is \"probe\", expected VENDOR:PRODUCT[:SERIAL] in hexadecimal, such as "
            "usb:1209:0001 or "
            "usb:1209:0001:A7");
}

}  // namespace
}  // namespace fanlight

// SPDX-License-Identifier: BSD-3-Clause
#include "core/stream/pacing.h"

#include <gmock/gmock.h>

#include <stdexcept>

namespace plslam::stream {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(ResumePoint, IsReadAsItIsWritten) {
  const ResumePoint point{12, 1403636579763555584};
  EXPECT_EQ(ParseResumePoint(ToText(point)), point);
  EXPECT_EQ(ParseResumePoint("0@-5"), (ResumePoint{0, -5}));
  for (const char* text : {"", "7", "7@", "@7", "-1@7", "7@8x", "x@8", "7 @8"}) {
    EXPECT_THAT([&] { ParseResumePoint(text); }, ThrowsMessage<std::runtime_error>(HasSubstr("is not ID@T_NS")))
        << text;
  }
}

TEST(ParsePace, KnownAndUnknown) {
  EXPECT_TRUE(ParsePace("lockstep").lockstep);
  EXPECT_FALSE(ParsePace("realtime").lockstep);
  EXPECT_EQ(ParsePace("realtimex2").speed, 2.0);
  EXPECT_EQ(ParsePace("realtimex0.5").speed, 0.5);
  for (const char* bad :
       {"", "realtimex", "realtimex0", "realtimexnan", "realtimex2x", "realtimex-1", "realtime2", "fast"}) {
    EXPECT_THAT([&] { ParsePace(bad); }, ThrowsMessage<std::runtime_error>(HasSubstr("not one of lockstep"))) << bad;
  }
}

TEST(RealtimeClock, LateBeyondHalfAPeriod) {
  RealtimeClock clock(2.0, 100);
  EXPECT_EQ(clock.Due_ns(1000, 7), 7);
  EXPECT_EQ(clock.Due_ns(1100, 9), 57);
  EXPECT_FALSE(clock.IsLate(57, 82));
  EXPECT_TRUE(clock.IsLate(57, 83));
}

}  // namespace
}  // namespace plslam::stream

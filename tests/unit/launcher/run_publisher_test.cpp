// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/node/run_publisher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "plslam/run_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::launcher {
namespace {

using bus::test::Eventually;

bus::BusOptions On(const std::string& url) {
  bus::BusOptions options;
  options.url = url;
  return options;
}

/// A viewer that starts when the run is over, as one that was killed.
class LateReader {
 public:
  explicit LateReader(const std::string& url) : bus_(On(url)) {
    bus_->Subscribe<run_t>(bus::kRun, [this](const run_t& m) {
      const std::scoped_lock lock(mutex_);
      messages_.push_back(m);
    });
    bus_.Start();
  }
  ~LateReader() { bus_.Join(); }
  LateReader(const LateReader&) = delete;
  LateReader& operator=(const LateReader&) = delete;

  std::vector<run_t> messages() {
    const std::scoped_lock lock(mutex_);
    return messages_;
  }

 private:
  std::mutex mutex_;
  std::vector<run_t> messages_;
  bus::test::RunningBus bus_;
};

TEST(RunPublisher, EveryLateReaderGetsBeginAndEnd) {
  const std::string url = bus::test::PrivateUrl();
  bus::Bus launcher(On(url), "plslam");
  PublishRunBegin(launcher);
  PublishRunEnd(launcher, {40, 38, {SessionId(7), 11}});
  for (int restart = 0; restart < 3; ++restart) {
    LateReader reader(url);
    ASSERT_TRUE(Eventually([&] { return reader.messages().size() == 2; })) << restart;
    const std::vector<run_t> messages = reader.messages();
    EXPECT_EQ(messages[0].event, "begin");
    EXPECT_EQ(messages[0].n_poses, -1);
    EXPECT_EQ(messages[0].session_keyframe_id, -1);
    EXPECT_EQ(messages[1].event, "end");
    EXPECT_EQ(messages[1].n_frames, 40);
    EXPECT_EQ(messages[1].n_poses, 38);
    EXPECT_EQ(messages[1].session, 7);
    EXPECT_EQ(messages[1].session_keyframe_id, 11);
  }
}

}  // namespace
}  // namespace plslam::launcher

// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/node/arrival_queue.h"

#include <gtest/gtest.h>

#include <thread>

namespace plslam::loop {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kNow{0};
constexpr milliseconds kLong{100000};

class ArrivalQueueTest : public testing::Test {
 protected:
  static bus::BusOptions Memory() {
    bus::BusOptions options;
    options.url = "memq://";
    return options;
  }
  static SourceId SourceOf(const std::optional<Arrival>& arrival) {
    return std::get<SignOfLife>(arrival.value()).source;
  }

  bus::Process process_{"loop", Memory()};
  ArrivalQueue queue_{process_};
};

TEST_F(ArrivalQueueTest, NothingIsTakenBeforeAMap) {
  queue_.Add(SignOfLife{SourceId(7)});
  EXPECT_FALSE(queue_.is_open());
  EXPECT_FALSE(queue_.Take(kNow));
  StereoCamera camera;
  camera.width_px = 376;
  queue_.Open(camera);
  EXPECT_EQ(SourceOf(queue_.Take(kNow)), SourceId(7));
  EXPECT_FALSE(queue_.Take(kNow));
}

TEST_F(ArrivalQueueTest, CameraIsThatOfTheFirstMap) {
  StereoCamera first, second;
  first.width_px = 376;
  second.width_px = 752;
  queue_.Open(first);
  queue_.Open(second);
  EXPECT_EQ(queue_.camera().width_px, 376);
}

TEST_F(ArrivalQueueTest, OrderIsThatOfArrival) {
  queue_.Open(StereoCamera());
  std::thread adder([this] {
    for (int i = 0; i < 100; ++i) queue_.Add(SignOfLife{SourceId(i)});
  });
  for (int i = 0; i < 100; ++i) EXPECT_EQ(SourceOf(queue_.Take(kLong)), SourceId(i));
  adder.join();
}

TEST_F(ArrivalQueueTest, StopEndsTheWait) {
  queue_.Open(StereoCamera());
  std::thread stopper([this] { queue_.Stop(); });
  EXPECT_FALSE(queue_.Take(kLong));
  stopper.join();
  EXPECT_TRUE(queue_.stopped());
  queue_.Add(SignOfLife{SourceId(7)});
  EXPECT_FALSE(queue_.Take(kLong)) << "what has arrived is not handled any more";
  queue_.Open(StereoCamera());
  EXPECT_TRUE(queue_.stopped());
}

}  // namespace
}  // namespace plslam::loop

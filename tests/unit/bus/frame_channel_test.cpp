// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <span>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/frame_channel.h"
#include "plslam/camera_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using test::Eventually;
using test::PrivateUrl;
using test::RunningBus;
using test::Waiter;

BusOptions OptionsFor(const std::string& url) {
  BusOptions options;
  options.url = url;
  return options;
}

/// Sets the kernel's default receive buffer, whatever this machine allows: LCM requests half of it, and the kernel
/// doubles that.
std::string WithDefaultBuffer(const std::string& url) { return url + "&recv_buf_size=106496"; }

StereoImages FrameOf(int64_t id, int width, int height, int right_type = CV_8UC1) {
  StereoImages frame;
  frame.frame_id = FrameId(id);
  frame.t_ns = 50'000'000 * id;
  cv::RNG random(static_cast<uint64_t>(id + 1));
  frame.left.create(height, width, CV_8UC1);
  frame.right.create(height, width, right_type);
  random.fill(frame.left, cv::RNG::UNIFORM, 0, 256);
  random.fill(frame.right, cv::RNG::UNIFORM, 0, right_type == CV_8UC1 ? 256 : 65536);
  return frame;
}

bool Equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

/// Keeps both cores busy during its lifetime.
class BusyCores {
 public:
  BusyCores() {
    for (unsigned i = 0; i < std::thread::hardware_concurrency(); ++i) {
      threads_.emplace_back([this] {
        volatile double x = 1.0;
        while (!stop_) x = x * 1.0000001;
      });
    }
  }
  ~BusyCores() {
    stop_ = true;
    for (auto& thread : threads_) thread.join();
  }

 private:
  std::atomic<bool> stop_ = false;
  std::vector<std::thread> threads_;
};

struct LockstepResult {
  int64_t frames = 0;
  int64_t wrong = 0;
  double seconds = 0.0;
  BusCounters reader;
  BusCounters publisher;
};

/// Runs a lockstep stream: frame n+1 is sent at its time, and not before frame n has been handled.
LockstepResult RunLockstep(const std::string& url, int width, int height, double rate_hz, int n_frames, double drop) {
  BusOptions options = OptionsFor(url);
  options.drop_fraction = drop;
  LockstepResult result;
  Waiter handled;
  std::vector<StereoImages> frames;
  for (int i = 0; i < 4; ++i) frames.push_back(FrameOf(i, width, height));
  RunningBus reader(options, "reader");
  FrameSubscriber subscriber(*reader, FrameSubscriber::Mode::kReliable, [&](const FrameSubscriber::Frame& frame) {
    const auto n = handled.value();
    const StereoImages& sent = frames[static_cast<size_t>(n % 4)];
    const bool right = frame.images.frame_id.value == n && Equal(frame.images.left, sent.left) &&
                       Equal(frame.images.right, sent.right) && frame.lockstep && frame.skipped == 0;
    result.wrong += right ? 0 : 1;
    handled.Add();
  });
  reader.Start();
  RunningBus publisher(OptionsFor(url), "publisher");
  EXPECT_TRUE(test::WaitForReaders(*publisher, kStereoFrame, 1));
  FramePublisher frame_publisher(*publisher, true);
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < n_frames; ++i) {
    std::this_thread::sleep_until(start + std::chrono::duration<double>(i / rate_hz));
    StereoImages frame = frames[static_cast<size_t>(i % 4)];
    frame.frame_id = i;
    frame_publisher.Publish(frame);
    if (!handled.Reaches(i + 1)) break;
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.frames = handled.value();
  reader.Join();
  result.reader = reader->counters();
  result.publisher = publisher->counters();
  return result;
}

struct StressCase {
  const char* name;
  int width;
  int height;
  double rate_hz;
  double drop;
};

class LockstepStress : public testing::TestWithParam<StressCase> {};

TEST_P(LockstepStress, DefaultBufferAndBusyCores) {
  const StressCase& c = GetParam();
  const int n = static_cast<int>(3 * c.rate_hz);
  LockstepResult result;
  {
    const BusyCores busy;
    result = RunLockstep(WithDefaultBuffer(PrivateUrl()), c.width, c.height, c.rate_hz, n, c.drop);
  }
  const double rate_hz = static_cast<double>(n) / result.seconds;
  std::printf("  %s: %.1f Hz of %.0f, missed %ld repaired %ld resent %ld duplicates %ld\n", c.name, rate_hz,
              c.rate_hz, result.reader.lost, result.reader.repaired, result.publisher.resent,
              result.reader.duplicates);
  EXPECT_EQ(result.frames, n);
  EXPECT_EQ(result.wrong, 0);
  EXPECT_EQ(result.reader.lost, result.reader.repaired);
  EXPECT_EQ(result.reader.rejected, 0);
#ifndef PLSLAM_SANITIZED
  EXPECT_GT(rate_hz, 0.95 * c.rate_hz);
#endif
}

INSTANTIATE_TEST_SUITE_P(Rates, LockstepStress,
                         testing::Values(StressCase{"Kitti20Hz", 1241, 376, 20.0, 0.0},
                                         StressCase{"Euroc40Hz", 752, 480, 40.0, 0.0},
                                         StressCase{"Kitti20HzDrop5", 1241, 376, 20.0, 0.05},
                                         StressCase{"Euroc40HzDrop5", 752, 480, 40.0, 0.05}),
                         [](const auto& test) { return test.param.name; });

/// A player that has waited long for a pose resends its frame: it is delivered once, and no frame counts as skipped.
TEST(FramePublisher, RefusesImagesLargerThanReadersAccept) {
  Bus bus(OptionsFor("memq://"), "player");
  FramePublisher publisher(bus, true);
  const auto error_of = [&](const cv::Size& left, const cv::Size& right, int right_type) -> std::string {
    StereoImages frame;
    frame.frame_id = 3;
    frame.left = cv::Mat(left, CV_8UC1);
    frame.right = cv::Mat(right, right_type);
    try {
      publisher.Publish(frame);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  const cv::Size small(8, 8), large(8001, 8000);  // fewer pixels than a file may have
  EXPECT_EQ(error_of(small, large, CV_8UC1),
            "frame 3: an image of 8001 x 8000 pixels, 1 bytes each, is larger than readers accept (64000000 bytes, "
            "32768 pixels a side)");
  EXPECT_NE(error_of(large, small, CV_8UC1), "");
  EXPECT_NE(error_of(small, {8000, 4001}, CV_16UC1), "");
  EXPECT_NE(error_of(small, {32'769, 1}, CV_8UC1), "");
  EXPECT_EQ(bus.counters().sent, 0);
  EXPECT_EQ(error_of(small, {8000, 100}, CV_16UC1), "");
}

TEST(FrameChannel, ResentFramesAreDeliveredInLockstep) {
  const std::string url = PrivateUrl();
  Waiter handled;
  int64_t skipped = 0;
  std::vector<int64_t> ids;
  RunningBus reader(OptionsFor(url), "reader");
  FrameSubscriber subscriber(*reader, FrameSubscriber::Mode::kReliable, [&](const FrameSubscriber::Frame& frame) {
    ids.push_back(frame.images.frame_id.value);
    skipped += frame.skipped;
    handled.Add();
  });
  reader.Start();
  RunningBus publisher(OptionsFor(url), "publisher");
  ASSERT_TRUE(test::WaitForReaders(*publisher, kStereoFrame, 1));
  FramePublisher frame_publisher(*publisher, true);
  const std::vector<int64_t> sent{0, 1, 1, 1, 2, 3, 1, 2, 3, 4};
  for (const int64_t id : sent) frame_publisher.Publish(FrameOf(id, 320, 240));
  ASSERT_TRUE(handled.Reaches(static_cast<int64_t>(sent.size())));
  reader.Join();
  EXPECT_EQ(ids, sent);
  EXPECT_EQ(skipped, 0);
}

/// In real time: a slow handler sees the newest frames, and how many it missed.
TEST(FrameChannel, LiveFramesThatAreLateAreSkippedAndCounted) {
  const std::string url = PrivateUrl();
  std::mutex gate;
  Waiter entered;
  std::vector<int64_t> ids;
  int64_t skipped = 0;
  Waiter handled;
  Waiter strips;
  RunningBus reader(OptionsFor(url), "reader");
  FrameSubscriber subscriber(
      *reader, FrameSubscriber::Mode::kReliable,
      [&](const FrameSubscriber::Frame& frame) {
        entered.Add();
        const std::lock_guard lock(gate);
        EXPECT_FALSE(frame.lockstep);
        ids.push_back(frame.images.frame_id.value);
        skipped += frame.skipped;
        handled.Add();
      },
      [](FrameId) { return true; });
  // Called after the subscriber's handler for each strip, which has then been processed.
  reader->SubscribeBytes(
      kStereoFrameLive, Bus::Reading::kAsItComes, [] { return true; },
      [&](std::span<const uint8_t>) { strips.Add(); });
  reader.Start();
  Bus publisher(OptionsFor(url), "publisher");
  ASSERT_TRUE(test::WaitForReaders(publisher, kStereoFrameLive, 1));
  FramePublisher frames(publisher, false);
  {
    const std::lock_guard closed(gate);
    frames.Publish(FrameOf(0, 320, 240));
    ASSERT_TRUE(entered.Reaches(1));
    for (int i = 1; i <= 10; ++i) frames.Publish(FrameOf(3 * i, 320, 240));  // ids with a stride
    ASSERT_TRUE(strips.Reaches(11 * 4));
  }
  ASSERT_TRUE(handled.Reaches(2));
  reader.Join();
  EXPECT_EQ(ids, (std::vector<int64_t>{0, 30}));
  EXPECT_EQ(skipped, 9);
  EXPECT_EQ(reader->counters().skipped, 9);
}

TEST(FrameChannel, LiveFramesAreSeldomLostWithTheDefaultBuffer) {
#ifdef PLSLAM_SANITIZED
  GTEST_SKIP() << "real time means nothing under a sanitizer";
#endif
  const std::string url = WithDefaultBuffer(PrivateUrl());
  Waiter handled;
  RunningBus reader(OptionsFor(url), "reader");
  FrameSubscriber subscriber(*reader, FrameSubscriber::Mode::kReliable,
                             [&](const FrameSubscriber::Frame&) { handled.Add(); });
  reader.Start();
  Bus publisher(OptionsFor(url), "publisher");
  ASSERT_TRUE(test::WaitForReaders(publisher, kStereoFrameLive, 1));
  FramePublisher frames(publisher, false);
  const auto start = std::chrono::steady_clock::now();
  static constexpr int kFrames = 40;
  const StereoImages image = FrameOf(0, 1241, 376);
  for (int i = 0; i < kFrames; ++i) {
    std::this_thread::sleep_until(start + std::chrono::milliseconds(50) * i);
    StereoImages frame = image;
    frame.frame_id = i;
    frames.Publish(frame);
  }
  EXPECT_TRUE(handled.Reaches(kFrames / 2, std::chrono::seconds(2))) << handled.value() << " of " << kFrames;
}

class FrameSizes : public testing::TestWithParam<std::tuple<int, int, int, int>> {};

TEST_P(FrameSizes, ArriveAsTheyWere) {
  const auto [width, height, right_type, max_message_bytes] = GetParam();
  BusOptions options = OptionsFor(PrivateUrl());
  options.max_message_bytes = max_message_bytes;
  Waiter handled;
  RunningBus reader(options, "reader");
  const StereoImages sent = FrameOf(5, width, height, right_type);
  FrameSubscriber subscriber(*reader, FrameSubscriber::Mode::kReliable, [&](const FrameSubscriber::Frame& frame) {
    EXPECT_TRUE(Equal(frame.images.left, sent.left));
    EXPECT_TRUE(Equal(frame.images.right, sent.right));
    EXPECT_EQ(frame.images.t_ns, sent.t_ns);
    handled.Add();
  });
  reader.Start();
  RunningBus publisher(options, "publisher");
  ASSERT_TRUE(test::WaitForReaders(*publisher, kStereoFrame, 1));
  FramePublisher(*publisher, true).Publish(sent);
  EXPECT_TRUE(handled.Reaches(1));
  EXPECT_EQ(reader->counters().rejected, 0);
}

INSTANTIATE_TEST_SUITE_P(Sizes, FrameSizes,
                         testing::Values(std::tuple{1242, 375, CV_8UC1, 60'000}, std::tuple{1242, 375, CV_8UC1, 1200},
                                         std::tuple{640, 480, CV_16UC1, 60'000}, std::tuple{1, 1, CV_8UC1, 60'000},
                                         std::tuple{64, 48, CV_16UC1, 1000}));

TEST(FrameChannel, PicturesAreReceivedOnlyIfRequested) {
  const std::string url = PrivateUrl();
  Waiter handled;
  RunningBus reader(OptionsFor(url), "viewer");
  FrameSubscriber subscriber(
      *reader, FrameSubscriber::Mode::kPictures,
      [&](const FrameSubscriber::Frame& frame) {
        EXPECT_EQ(frame.images.frame_id.value % 5, 0);
        handled.Add();
      },
      [](FrameId id) { return id.value % 5 == 0; });
  reader.Start();
  Bus publisher(OptionsFor(url), "publisher");
  FramePublisher frames(publisher, true);
  for (int i = 0; i <= 20; ++i) {
    frames.Publish(FrameOf(i, 320, 240));
    if (i % 5 == 0) {
      ASSERT_TRUE(handled.Reaches(i / 5 + 1));
    }
  }
}

TEST(FrameChannel, SlowReaderOfPicturesGetsEveryFrameInLockstep) {
  constexpr int kFrames = 24;
  BusOptions options = OptionsFor(PrivateUrl());
  // Unread frames do not fit into the history, and a reader takes longer for each than a publisher waits.
  options.history_bytes = 200'000;
  options.max_wait_ms = 10;
  Waiter handled;
  RunningBus reader(options, "viewer");
  FrameSubscriber subscriber(*reader, FrameSubscriber::Mode::kPictures, [&](const FrameSubscriber::Frame& frame) {
    EXPECT_EQ(frame.images.frame_id.value, handled.value());
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    handled.Add();
  });
  reader.Start();
  RunningBus publisher(options, "publisher");
  ASSERT_TRUE(test::WaitForReaders(*publisher, kStereoFrame, 1));
  FramePublisher frames(*publisher, true);
  for (int i = 0; i < kFrames; ++i) frames.Publish(FrameOf(i, 640, 480));
  EXPECT_TRUE(handled.Reaches(kFrames)) << handled.value();
}

TEST(FrameChannel, PictureReaderDoesNotThrottleInRealTime) {
  const std::string url = PrivateUrl();
  RunningBus reader(OptionsFor(url), "viewer");
  FrameSubscriber subscriber(*reader, FrameSubscriber::Mode::kPictures, [](const FrameSubscriber::Frame&) {});
  reader.Start();
  Bus publisher(OptionsFor(url), "publisher");
  ASSERT_TRUE(test::WaitForReaders(publisher, kStereoFrame, 1));
  FramePublisher(publisher, false).Publish(FrameOf(0, 320, 240));
  EXPECT_EQ(publisher.ReaderCount(kStereoFrameLive), 0);
}

TEST(FramePublisher, RefusesColourAndEmptyImages) {
  Bus bus(OptionsFor("memq://"), "test");
  FramePublisher frames(bus, true);
  StereoImages frame = FrameOf(0, 32, 24);
  frame.right = cv::Mat(24, 32, CV_8UC3);
  EXPECT_THROW(frames.Publish(frame), std::invalid_argument);
  frame.right = cv::Mat();
  EXPECT_THROW(frames.Publish(frame), std::invalid_argument);
  frame.left = cv::Mat(24, 32, CV_16UC1);
  EXPECT_THROW(frames.Publish(frame), std::invalid_argument);
}

}  // namespace

namespace {

RigCalibration RigOf(double focal_px) {
  RigCalibration rig;
  rig.name = "rig";
  rig.left.width_px = rig.right.width_px = 640;
  rig.left.height_px = rig.right.height_px = 480;
  for (CameraCalibration* camera : {&rig.left, &rig.right}) {
    camera->fx_px = camera->fy_px = focal_px;
    camera->cx_px = 320.0;
    camera->cy_px = 240.0;
  }
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0});
  rig.baseline_m = 0.1;
  rig.rate_hz = 20.0;
  return rig;
}

TEST(CameraChannel, RepeatedAndInvalidCameras) {
  BusOptions options;
  options.url = test::PrivateUrl();
  test::Waiter heard, rejected, last;
  test::RunningBus reader(options, "vo");
  std::vector<double> focal_px;
  CameraSubscriber subscriber(
      *reader,
      [&](const RigCalibration& rig) {
        focal_px.push_back(rig.left.fx_px);
        heard.Add();
      },
      [&] { rejected.Add(); });
  reader.Start();
  Bus player(options, "player");
  const auto say = [&](const RigCalibration& rig) { player.Publish(kCamera, ToMessage(rig)); };
  // The newest message of a latest channel replaces earlier ones, so each is repeated until it is received.
  while (heard.value() < 1) say(RigOf(400.0));
  for (int i = 0; i < 20; ++i) say(RigOf(400.0));
  while (rejected.value() < 1) say(RigOf(-1.0));
  while (heard.value() < 2) say(RigOf(500.0));
  reader.Join();
  EXPECT_EQ(focal_px, (std::vector<double>{400.0, 500.0}));
}

TEST(CameraChannel, RestoresStoredCameraBytes) {
  BusOptions options;
  options.url = test::PrivateUrl();
  Bus bus(options, "vo");
  double focal_px = 0.0;
  CameraSubscriber subscriber(bus, [&](const RigCalibration& rig) { focal_px = rig.left.fx_px; });
  EXPECT_TRUE(subscriber.bytes().empty());
  const std::vector<uint8_t> kept = RigBytes(ToMessage(RigOf(400.0)));
  subscriber.Restore(kept, 7);
  EXPECT_EQ(focal_px, 400.0);
  EXPECT_EQ(subscriber.bytes(), kept);
  EXPECT_THROW(subscriber.Restore({kept.begin(), kept.end() - 9}, 7), std::runtime_error);
}

TEST(CameraChannel, RigIsThatOfTheFramesPublisher) {
  BusOptions options;
  options.url = "memq://";
  Bus bus(options, "vo");
  std::vector<double> focal_px;
  CameraSubscriber subscriber(bus, [&](const RigCalibration& rig) { focal_px.push_back(rig.left.fx_px); });
  const SourceId idle(1), camera(2), silent(3);
  const auto hear = [&](SourceId publisher, double f_px) {
    subscriber.Restore(RigBytes(ToMessage(RigOf(f_px))), publisher);
  };
  hear(idle, 400.0);
  EXPECT_FALSE(subscriber.awaits_rig()) << "no frames yet";
  subscriber.Follow(camera);
  EXPECT_TRUE(subscriber.awaits_rig());
  hear(camera, 500.0);
  EXPECT_FALSE(subscriber.awaits_rig());
  hear(idle, 400.0);
  hear(camera, 500.0);
  EXPECT_EQ(focal_px, (std::vector<double>{400.0, 500.0}));
  hear(idle, 410.0);
  subscriber.Follow(idle);
  EXPECT_FALSE(subscriber.awaits_rig());
  EXPECT_EQ(focal_px, (std::vector<double>{400.0, 500.0, 410.0}));
  // The rig of a publisher that sends none is that of another.
  subscriber.Follow(silent);
  hear(camera, 510.0);
  EXPECT_EQ(focal_px, (std::vector<double>{400.0, 500.0, 410.0, 510.0}));
}

}  // namespace
}  // namespace plslam::bus

#include "core/bus/frame_channel.h"

#include <atomic>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

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

/// The kernel's default receive buffer, whatever this machine allows: LCM asks for half, the kernel doubles it.
std::string WithDefaultBuffer(const std::string& url) { return url + "&recv_buf_size=106496"; }

StereoImages FrameOf(int64_t id, int width, int height, int right_type = CV_8UC1) {
  StereoImages frame;
  frame.frame_id = id;
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

/// Keeps both cores busy while it lives.
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

/// A lockstep stream: frame n+1 goes out at its time, and not before frame n has been handled.
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
    const bool right = frame.images.frame_id == n && Equal(frame.images.left, sent.left) &&
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

TEST_P(LockstepStress, NothingLostAndRateKeptWithDefaultBufferAndBusyCores) {
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

}  // namespace
}  // namespace plslam::bus

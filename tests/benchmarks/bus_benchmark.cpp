// SPDX-License-Identifier: BSD-3-Clause
// Cost of messages on loopback: time from publishing to the handler of another bus, and CPU of both ends together.
#include <atomic>
#include <random>
#include <semaphore>
#include <thread>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>

#include "core/bus/messages/frame_channel.h"
#include "core/bus/transport/authenticator.h"
#include "core/bus/transport/wire.h"
#include "plslam/image_strip_t.hpp"
#include "plslam/pose_t.hpp"

namespace plslam::bus {
namespace {

BusOptions Options(bool default_buffer) {
  std::random_device device;
  BusOptions options;
  options.url = "udpm://239.255." + std::to_string(200 + device() % 50) + "." + std::to_string(1 + device() % 250) +
                ":" + std::to_string(20'000 + device() % 20'000) + "?ttl=0";
  if (default_buffer) options.url += "&recv_buf_size=106496";
  return options;
}

class Reader {
 public:
  explicit Reader(const BusOptions& options) : bus_(options, "reader") {}
  ~Reader() {
    bus_.Stop();
    thread_.join();
  }
  Bus& bus() { return bus_; }
  void Start() {
    thread_ = std::thread([this] { bus_.Run(); });
  }

 private:
  Bus bus_;
  std::thread thread_;
};

void WaitForReader(Bus& publisher, const Channel& channel) {
  while (publisher.ReaderCount(channel) == 0) std::this_thread::yield();
}

/// A pose to the handler of another bus, one at a time.
void BM_SmallMessage(benchmark::State& state) {
  const BusOptions options = Options(true);
  Reader reader(options);
  std::binary_semaphore handled(0);
  reader.bus().Subscribe<pose_t>(kPose, [&](const pose_t&) { handled.release(); });
  reader.Start();
  Bus publisher(options, "publisher");
  WaitForReader(publisher, kPose);
  for (auto _ : state) {
    publisher.Publish(kPose, pose_t{});
    handled.acquire();
  }
}
BENCHMARK(BM_SmallMessage)->Unit(benchmark::kMicrosecond)->UseRealTime()->MeasureProcessCPUTime();

/// A stereo frame in lockstep, with flow control and all. Arguments: width, height, default receive buffer.
void BM_StereoFrame(benchmark::State& state) {
  const BusOptions options = Options(state.range(2) != 0);
  Reader reader(options);
  std::binary_semaphore handled(0);
  FrameSubscriber subscriber(reader.bus(), FrameSubscriber::Mode::kReliable,
                             [&](const FrameSubscriber::Frame&) { handled.release(); });
  reader.Start();
  Bus publisher(options, "publisher");
  WaitForReader(publisher, kStereoFrame);
  FramePublisher frames(publisher, true);
  StereoImages images;
  images.left = cv::Mat(static_cast<int>(state.range(1)), static_cast<int>(state.range(0)), CV_8UC1, cv::Scalar(7));
  images.right = images.left.clone();
  for (auto _ : state) {
    frames.Publish(images);
    handled.acquire();
    ++images.frame_id;
    ++images.t_ns;
  }
  const BusCounters counters = reader.bus().counters();
  state.counters["lost"] = static_cast<double>(counters.lost);
}
BENCHMARK(BM_StereoFrame)
    ->Args({1241, 376, 1})
    ->Args({1241, 376, 0})
    ->Args({752, 480, 1})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

/// The check of the bytes of a strip of 60 kB, and of a page of features.
void BM_CheckStrip(benchmark::State& state) {
  image_strip_t strip{};
  strip.n_bytes = 59'000;
  strip.data.resize(59'000);
  std::vector<uint8_t> bytes(static_cast<size_t>(strip.getEncodedSize()));
  strip.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  const MessageLayout* layout = FindMessageLayout("image_strip_t");
  for (auto _ : state) benchmark::DoNotOptimize(MessageLength(*layout, bytes));
}
BENCHMARK(BM_CheckStrip);

}  // namespace
}  // namespace plslam::bus

BENCHMARK_MAIN();

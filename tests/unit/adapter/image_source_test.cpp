// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/image_source.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "bot_core/images_t.hpp"
#include "core/bus/run_loop.h"
#include "plslam/warning_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::adapter {
namespace {

using bus::test::Eventually;

bot_core::image_t GreyImage() {
  constexpr int kWidth = 64, kHeight = 48, kGrey = 1497715271;
  bot_core::image_t image{};
  image.width = image.row_stride = kWidth;
  image.height = kHeight;
  image.pixelformat = kGrey;
  image.data.assign(size_t{kWidth} * kHeight, 90);
  image.size = kWidth * kHeight;
  return image;
}

/// The adapter of a robot that publishes pairs on "CAMERA".
class ImageSourceTest : public testing::Test {
 protected:
  ImageSourceTest() : robot_(url_, "robot"), foreign_(url_, "foreign") {
    bus_options_.url = bus::test::PrivateUrl();
    listener_ = std::make_unique<bus::test::RunningBus>(bus_options_, "listener");
    (*listener_)->Subscribe<warning_t>(bus::kWarning, [this](const warning_t& message) {
      const std::scoped_lock lock(mutex_);
      warnings_ += message.code + ": " + message.sentence + "\n";
    });
    listener_->Start();
    process_ = std::make_unique<bus::Process>("adapter", bus_options_);
    runs_ = std::thread([this] { process_->bus().Run(); });
    const std::string camera = folder_ / "camera.yaml";
    std::ofstream(camera) << "baseline_m: 0.1\nleft: {resolution_px: [64, 48], focal_length_px: [40, 40], "
                             "principal_point_px: [32, 24]}\n";
    AdapterOptions options;
    options.foreign_url = url_;
    options.images = "CAMERA";
    options.camera = camera;
    source_ = std::make_unique<ImageSource>(
        *process_, foreign_, options, robot::FrameSource::Listener{[](const RigCalibration&) {}, [](int64_t) {}});
    listens_ = std::thread([this] {
      while (!stopped_) foreign_.Handle(50);
    });
    works_ = std::thread([this] { source_->Work(); });
  }
  ~ImageSourceTest() override {
    stopped_ = true;
    source_->Stop();
    listens_.join();
    works_.join();
    process_->bus().Stop();
    runs_.join();
    listener_->Join();
  }

  /// Publishes pairs until one more is a frame.
  void SendOne() {
    const int64_t before = source_->n_sent();
    EXPECT_TRUE(Eventually([&] {
      bot_core::images_t pair{};
      pair.utime = ++utime_ * 50'000;
      pair.image_types = {0, 1};
      pair.images = {GreyImage(), GreyImage()};
      pair.n_images = 2;
      robot_.Publish("CAMERA", bus::Encoded(pair));
      return source_->n_sent() > before;
    }));
  }
  std::string Warnings() const {
    const std::scoped_lock lock(mutex_);
    return warnings_;
  }

  const std::string url_ = bus::test::PrivateUrl();
  bus::test::TemporaryFolder folder_;
  bus::BusOptions bus_options_;
  mutable std::mutex mutex_;
  std::string warnings_;
  int64_t utime_ = 1000;
  std::unique_ptr<bus::test::RunningBus> listener_;
  std::unique_ptr<bus::Process> process_;
  bus::StockLcm robot_, foreign_;
  std::unique_ptr<ImageSource> source_;
  std::atomic<bool> stopped_ = false;
  std::thread runs_, listens_, works_;
};

TEST_F(ImageSourceTest, OutageIsReportedOnce) {
  SendOne();
  EXPECT_TRUE(Eventually([&] { return !Warnings().empty(); }));
  SendOne();
  EXPECT_EQ(Warnings(), "adapter_no_frames: no frames: waiting for images on CAMERA\n");
}

}  // namespace
}  // namespace plslam::adapter

// SPDX-License-Identifier: BSD-3-Clause
// Images of a robot of ROS 2 in each form that it may send, on the bus.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "tests/integration/bus_frames.h"
#include "tests/integration/rgbd_wall.h"
#include "tests/integration/ros2_robot.h"

namespace plslam::test {
namespace {

/// A robot in a namespace, plslam_ros2 on its own bus, and what arrives there.
struct Sender {
  std::string name;  ///< of the namespace and the files
  std::string dataset;
  std::vector<std::string> options;  ///< of the robot
  std::string left, right;           ///< topics
  double most_difference;            ///< of pixels in the mean

  std::unique_ptr<BusFrames> frames = nullptr;
  std::unique_ptr<launcher::ChildProcess> process = nullptr, robot = nullptr;
};

double MeanDifference(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return 1e9;
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

constexpr int kFrames = 8;

TEST_F(Ros2, EveryEncodingArrivesAsItWasSent) {
  const std::string wall = WallOfAnRgbdCamera(folder_, kFrames);
  const std::string left = "/stereo/left/image_raw", right = "/stereo/right/image_raw";
  std::vector<Sender> senders;
  senders.push_back({"jpeg", kWorld, {"jpeg"}, left + "/compressed", right + "/compressed", 2.0});
  senders.push_back({"png", kWorld, {"png"}, left + "/compressed", right + "/compressed", 0.0});
  senders.push_back({"big_endian", kWorld, {"big_endian"}, left, right, 0.0});
  senders.push_back({"depth",
                     wall,
                     {"compressed_depth"},
                     "/camera/color/image_raw",
                     "/camera/aligned_depth_to_color/image_raw/compressedDepth",
                     0.0});
  int port = 7710;
  for (Sender& sender : senders) {
    const std::string url = fmt::format("udpm://239.255.76.67:{}?ttl=0", ++port), space = "/" + sender.name;
    host_->Do([&] { sender.frames = std::make_unique<BusFrames>(url, true); });
    sender.process =
        Start(BinaryFolder() / "plslam_ros2",
              {"--left", space + sender.left, "--right", space + sender.right, "--url", url}, sender.name + ".log");
    sender.options.insert(sender.options.begin(),
                          {sender.dataset, "5", std::to_string(kFrames), "space=" + space, "listen_s=0.3"});
    sender.robot =
        Start(BinaryFolder().parent_path() / "tests/fast_dds_robot", sender.options, sender.name + ".json");
  }
  std::vector<launcher::ChildProcess*> processes;
  for (const Sender& sender : senders) {
    Wait(*sender.robot);
    processes.push_back(sender.process.get());
  }
  StopAll(processes);
  for (const Sender& sender : senders) {
    SCOPED_TRACE(sender.name);
    const auto dataset = OpenDataset(sender.dataset, "");
    const auto images = sender.frames->images();
    // A machine that is busy otherwise may lose one.
    EXPECT_GE(images.size(), size_t{kFrames - 1}) << Log(sender.name + ".log");
    for (const auto& [t_ns, frame] : images) {
      const int64_t dt_ns = dataset->t_ns(1) - dataset->t_ns(0);
      const auto i = static_cast<int>((t_ns - dataset->t_ns(0) - 1'000'000'000) / dt_ns);
      const StereoImages sent = dataset->Read(i);
      EXPECT_LE(MeanDifference(frame.left, sent.left), sender.most_difference) << i;
      EXPECT_LE(MeanDifference(frame.right, sent.right), sender.most_difference) << i;
    }
  }
}

}  // namespace
}  // namespace plslam::test

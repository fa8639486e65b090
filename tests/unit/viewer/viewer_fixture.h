// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/frame_channel.h"
#include "core/process/process.h"
#include "plslam/camera_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/run_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "plslam/tracks_t.hpp"
#include "tests/support/text_file.h"
#include "tests/unit/viewer/some_rig.h"
#include "viewer_headless/node/viewer_node.h"

namespace plslam::viewer {

inline constexpr int64_t kFrames = 12;

inline SE3 TruePose(int64_t frame) {
  return SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, 0.5 * static_cast<double>(frame)));
}

inline int64_t Time(int64_t frame) { return 1'000'000'000 + frame * 50'000'000; }

// One bus for the viewer and for its publishers: messages of a memq return to their sender.
class ViewerFixture : public testing::Test {
 protected:
  ViewerFixture() {
    bus::BusOptions options;
    options.url = "memq://";
    process_ = std::make_unique<bus::Process>("viewer", options);
    bus().Subscribe<status_t>(bus::kStatus, [this](const status_t& status) {
      if (status.process != "viewer") return;
      states_.push_back(status.state);
      if (status.state == stop_at_) bus().Stop();
    });
    // A test that fails must not hang.
    bus().Every(std::chrono::seconds(60), [this] { bus().Stop(); });
  }

  bus::Bus& bus() { return process_->bus(); }

  ViewerOptions Options(int64_t overlay_every = 0) const {
    return {.out = folder_.Path("out"), .overlay_every = overlay_every, .quiet = true, .video = ""};
  }

  void PublishPose(int64_t frame, int8_t state = 1) {
    pose_t m{};
    m.header.t_ns = Time(frame);
    m.frame_id = frame;
    m.state = state;
    m.T_odom_c = bus::ToMessage(TruePose(frame));
    m.T_w_odom = m.T_prev_c = bus::ToMessage(SE3());
    bus::ToArray(1e-4 * Matrix6d::Identity(), m.covariance);
    bus::ToArray(1e-4 * Matrix6d::Identity(), m.motion_covariance);
    m.keyframe_id = frame % 4 == 0 ? frame / 4 : -1;
    m.n_tracked_points = 100;
    bus().Publish(bus::kPose, m);
  }

  void PublishTruth(int64_t frame) {
    ground_truth_t m{};
    m.header.t_ns = Time(frame);
    m.frame_id = frame;
    m.T_w_l = bus::ToMessage(TruePose(frame));
    bus().Publish(bus::kGroundTruth, m);
  }

  void PublishCamera() { bus().Publish(bus::kCamera, bus::ToMessage(SomeRig())); }

  void PublishStream(const std::string& event, int64_t n_frames, const std::string& pace = "realtime",
                     int64_t session = 0) {
    stream_t m{};
    m.header.session = session;
    m.event = event;
    m.pace = pace;
    m.n_frames = n_frames;
    bus().Publish(bus::kStream, m);
  }

  void PublishRun(const std::string& event, int64_t n_poses = -1, int64_t keyframe = -1) {
    run_t m{};
    m.event = event;
    m.n_frames = m.n_poses = n_poses;
    m.session_keyframe_id = keyframe;
    bus().Publish(bus::kRun, m);
  }

  void PublishTracks(int64_t frame) {
    tracks_t tracks{};
    tracks.frame_id = frame;
    tracks.points.push_back({50.0F, 60.0F, 5.0F, 3, -1});
    tracks.n_points = 1;
    bus().Publish(bus::kTracks, std::move(tracks));
  }

  void PublishMappingStatus() {
    status_t m{};
    m.process = "mapping";
    m.state = "running";
    bus().Publish(bus::kStatus, m);
  }

  /// A map of the keyframes 0 .. `last` of session 0, each moved by `x_m`.
  static MapUpdate MapOf(int64_t last, double x_m) {
    Map map;
    for (int id = 0; id <= last; ++id) {
      MapKeyframe keyframe;
      keyframe.id = id;
      keyframe.name.number = id;
      keyframe.frame_id = 4 * id;
      keyframe.t_ns = Time(4 * id);
      keyframe.T_odom_kf = TruePose(4 * id);
      keyframe.T_w_kf = SE3(Eigen::Quaterniond::Identity(), {x_m, 0, 0}) * keyframe.T_odom_kf;
      map.Put(keyframe);
    }
    MapUpdate update = WholeMap(map);
    update.version = last + 1;
    update.newest.number = last;
    update.committed = true;
    return update;
  }

  void PublishImages(int64_t frame) {
    const cv::Mat image(240, 320, CV_8UC1, cv::Scalar(90));
    bus::FramePublisher(bus(), true).Publish({FrameId(frame), Time(frame), image, image});
  }

  std::string Out(const std::string& name) const { return folder_.Path("out/" + name); }

  ScratchFolder folder_;
  std::string stop_at_ = "finished";
  std::vector<std::string> states_;
  std::unique_ptr<bus::Process> process_;
};

}  // namespace plslam::viewer

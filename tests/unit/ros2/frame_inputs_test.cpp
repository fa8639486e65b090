// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/frame_inputs.h"

#include <gtest/gtest.h>

#include <map>

namespace plslam::ros2 {
namespace {

using robot::Side;

constexpr double kStart_s = 100.0;

/// Two image topics and one of CameraInfo, whose readers have the numbers 0, 1 and 2.
class FrameInputsTest : public testing::Test {
 protected:
  FrameInputsTest() {
    inputs_.SetImages(Side::kLeft, "/left", "sensor_msgs/msg/Image", 0);
    inputs_.SetImages(Side::kRight, "/right", "sensor_msgs/msg/Image", 1);
    inputs_.AddInfo("/left_info", 2);
  }
  void Receive(size_t reader, int64_t n) {
    n_messages_[reader] += n;
    inputs_.ReadStates([this](size_t of) { return ReaderState{1, "", n_messages_[of]}; });
  }

  FrameInputs inputs_{kStart_s};
  std::map<size_t, int64_t> n_messages_;
};

TEST_F(FrameInputsTest, FramesAreLateAfterAWhile) {
  const double late_s = kStart_s + robot::FrameProgress::kPatience_s;
  EXPECT_FALSE(inputs_.HasProgress(0, kStart_s + 1.0));
  EXPECT_FALSE(inputs_.AreLate(late_s - 0.1));
  EXPECT_TRUE(inputs_.AreLate(late_s));
  EXPECT_TRUE(inputs_.HasProgress(1, late_s));
  EXPECT_FALSE(inputs_.AreLate(late_s + 1.0));
  EXPECT_FALSE(inputs_.HasProgress(1, late_s + 1.0)) << "no other frame was sent";
}

TEST_F(FrameInputsTest, SymptomsBeginWithTheLastProgress) {
  Receive(0, 5);
  Receive(1, 6);
  Receive(2, 7);
  EXPECT_EQ(inputs_.OnRejected(), 1);
  Symptoms symptoms = inputs_.SinceProgress();
  EXPECT_EQ(symptoms.left.topic, "/left");
  EXPECT_EQ(symptoms.right.topic, "/right");
  EXPECT_EQ(symptoms.left.state.n_messages, 5);
  EXPECT_EQ(symptoms.right.state.n_messages, 6);
  EXPECT_EQ(symptoms.n_rejected, 1);
  ASSERT_TRUE(inputs_.HasProgress(3, kStart_s));
  Receive(1, 2);
  EXPECT_EQ(inputs_.OnRejected(), 2);
  EXPECT_EQ(inputs_.OnRejected(), 3);
  symptoms = inputs_.SinceProgress();
  EXPECT_EQ(symptoms.left.state.n_messages, 0);
  EXPECT_EQ(symptoms.right.state.n_messages, 2);
  EXPECT_EQ(symptoms.n_rejected, 2);
  ASSERT_EQ(symptoms.infos.size(), 1U);
  EXPECT_EQ(symptoms.infos[0].state.n_messages, 7) << "a robot may send CameraInfo once";
}

TEST_F(FrameInputsTest, LastTwoStampsAreKept) {
  for (const int64_t t_ns : {10, 20, 30}) inputs_.OnImage(Side::kRight, t_ns);
  const Symptoms symptoms = inputs_.SinceProgress();
  EXPECT_FALSE(symptoms.left.stamp_ns);
  EXPECT_EQ(symptoms.right.stamp_ns, 30);
  EXPECT_EQ(symptoms.right.previous_stamp_ns, 20);
}

TEST_F(FrameInputsTest, ProgressEndsTheReason) {
  EXPECT_EQ(inputs_.SetReason("no topic"), "");
  EXPECT_EQ(inputs_.SetReason("no stamps"), "no topic");
  ASSERT_TRUE(inputs_.HasProgress(1, kStart_s));
  EXPECT_EQ(inputs_.SetReason("no stamps"), "");
}

}  // namespace
}  // namespace plslam::ros2

// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/frame_assembler.h"

#include <cstdint>

#include <gtest/gtest.h>

#include "plslam/image_strip_t.hpp"

namespace plslam::bus {
namespace {

/// Strips of one image of 100 x 40 in four runs.
image_strip_t StripOf(int64_t frame, int8_t camera, int32_t strip) {
  image_strip_t message{};
  message.header.source = 9;
  message.header.seq = 4 * camera + strip;
  message.frame_id = frame;
  message.camera = camera;
  message.strip = strip;
  message.n_strips = 4;
  message.width_px = 100;
  message.height_px = 40;
  message.encoding = "mono8";
  message.offset_bytes = 1000 * strip;
  message.n_bytes = 1000;
  message.data.assign(1000, static_cast<uint8_t>(strip));
  return message;
}

TEST(FrameAssembler, TakesStripsInAnyOrderAndMoreThanOnce) {
  using Outcome = FrameAssembler::Outcome;
  FrameAssembler assembler;
  for (int32_t s : {3, 1, 0, 2}) EXPECT_EQ(assembler.Add(StripOf(1, 1, s)), Outcome::kTaken);
  EXPECT_EQ(assembler.Add(StripOf(1, 1, 2)), Outcome::kRepeated);
  for (int32_t s : {2, 3, 0}) EXPECT_EQ(assembler.Add(StripOf(1, 0, s)), Outcome::kTaken);
  EXPECT_EQ(assembler.Add(StripOf(1, 0, 1)), Outcome::kComplete);
  EXPECT_EQ(assembler.TakeFrame().images.left.at<uint8_t>(39, 99), 3);
  EXPECT_EQ(assembler.partial(), 0U);
}

TEST(FrameAssembler, RefusesInconsistentStrips) {
  const std::vector<std::function<void(image_strip_t&)>> faults = {
      [](image_strip_t& s) { s.camera = 2; },
      [](image_strip_t& s) { s.camera = -1; },
      [](image_strip_t& s) { s.strip = 4; },
      [](image_strip_t& s) { s.strip = -1; },
      [](image_strip_t& s) { s.n_strips = 5; },
      [](image_strip_t& s) { s.n_strips = 2'000'000'000; },
      [](image_strip_t& s) { s.width_px = 0; },
      [](image_strip_t& s) { s.width_px = 101; },
      [](image_strip_t& s) { s.height_px = -40; },
      [](image_strip_t& s) { s.width_px = s.height_px = 30'000; },
      [](image_strip_t& s) { s.encoding = "bgr8"; },
      [](image_strip_t& s) { s.encoding = "depth16"; },
      [](image_strip_t& s) { s.offset_bytes = -1; },
      [](image_strip_t& s) { s.offset_bytes = 3001; },
      [](image_strip_t& s) { s.offset_bytes = INT32_MAX; },
      [](image_strip_t& s) { s.n_bytes = 0; },
      [](image_strip_t& s) { s.n_bytes = 999; },
      [](image_strip_t& s) { s.header.t_ns = 1; },
  };
  for (size_t i = 0; i < faults.size(); ++i) {
    FrameAssembler assembler;
    ASSERT_EQ(assembler.Add(StripOf(1, 0, 0)), FrameAssembler::Outcome::kTaken);
    image_strip_t hostile = StripOf(1, 0, 1);
    faults[i](hostile);
    EXPECT_EQ(assembler.Add(hostile), FrameAssembler::Outcome::kNonsense) << "fault " << i;
  }
}

TEST(FrameAssembler, RefusesStripsThatOverlap) {
  FrameAssembler assembler;
  for (int32_t s = 0; s < 4; ++s) assembler.Add(StripOf(1, 1, s));
  for (int32_t s = 0; s < 3; ++s) assembler.Add(StripOf(1, 0, s));
  image_strip_t overlapping = StripOf(1, 0, 3);
  overlapping.offset_bytes = 2000;
  EXPECT_EQ(assembler.Add(overlapping), FrameAssembler::Outcome::kNonsense);
}

TEST(FrameAssembler, BoundsUnfinishedFrames) {
  FrameAssembler assembler;
  for (int64_t frame = 0; frame < 1000; ++frame) {
    image_strip_t strip = StripOf(frame, 0, 0);
    strip.width_px = 8000;
    strip.height_px = 8000;
    strip.n_strips = 64'000;
    assembler.Add(strip);
  }
  EXPECT_LE(assembler.partial(), 4U);
}

}  // namespace
}  // namespace plslam::bus

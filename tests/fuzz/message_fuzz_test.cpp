// SPDX-License-Identifier: BSD-3-Clause
// Mutates messages of all types: bytes that pass the check must decode within a bound of memory, and every consumer
// (conversions, frames, keyframes, order and repair) must survive their content.
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "core/bus/delivery/ordered_reader.h"
#include "core/bus/logs/log_writer.h"
#include "core/bus/messages/convert.h"
#include "core/bus/messages/frame_assembler.h"
#include "core/bus/messages/keyframe_channel.h"
#include "core/bus/messages/loop_channel.h"
#include "core/bus/messages/map_pages.h"
#include "core/bus/transport/wire.h"
#include "core/datasets/log_dataset.h"
#include "core/map/map_follower.h"
#include "plslam/camera_t.hpp"
#include "plslam/image_strip_t.hpp"
#include "plslam/keyframe_t.hpp"
#include "plslam/map_update_t.hpp"
#include "tests/fuzz/message_mutator.h"
#include "tests/support/fuzzing.h"
#include "tests/unit/bus/allocation_counter.h"
#include "tests/unit/bus/bus_fixture.h"
#include "tests/unit/bus/map_owner.h"
#include "tests/unit/bus/random_message.h"

namespace plslam::bus {
namespace {

using plslam::test::Fuzz;
using plslam::test::Mutate;
using Random = std::mt19937_64;
using ByteVector = std::vector<uint8_t>;

TEST(MessageFuzz, CheckedBytesDecodeWithinABound) {
  test::GeneratedTypes();  // the table of decoders is made at its first use, and is not theirs
  Fuzz([](Random& random) {
    const auto layouts = MessageLayouts();
    const MessageLayout& layout = layouts[random() % layouts.size()];
    ByteVector bytes = test::RandomMessage(layout, random);
    Mutate(bytes, random);
    const auto length = MessageLength(layout, bytes);
    if (!length) return;
    ASSERT_LE(*length, bytes.size());
    test::allocated = 0;
    const auto again = test::DecodeAndEncode(std::string(layout.name), ByteView(bytes).first(*length));
    ASSERT_LE(test::allocated, 64 * bytes.size() + 1000) << layout.name;
    ASSERT_TRUE(again.decoded) << layout.name;
    ASSERT_EQ(again.encoded, ByteVector(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(*length)));
  });
}

template <class T>
std::optional<T> Checked(const ByteVector& bytes) {
  T message;
  if (!MessageLength(*FindMessageLayout(T::getTypeName()), bytes)) return std::nullopt;
  if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) return std::nullopt;
  return message;
}

template <class T>
ByteVector Encoded(const T& message) {
  ByteVector bytes(static_cast<size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

RigCalibration SmallRig() {
  RigCalibration rig;
  rig.left.width_px = 16;
  rig.left.height_px = 8;
  rig.left.fx_px = rig.left.fy_px = 10.0;
  rig.right = rig.left;
  rig.baseline_m = 0.1;
  return rig;
}

TEST(MessageFuzz, RigsAreRefusedOrSound) {
  Fuzz([](Random& random) {
    ByteVector bytes = Encoded(ToMessage(SmallRig()));
    Mutate(bytes, random);
    const auto message = Checked<camera_t>(bytes);
    if (!message) return;
    const auto rig = FromMessage(*message);
    if (!rig) return;
    ASSERT_TRUE(std::isfinite(rig->left.fx_px) && rig->left.fx_px > 0.0);
    ASSERT_TRUE(rig->left.T_b_cam.IsFinite() && rig->right.T_b_cam.IsFinite());
    ASSERT_GT(rig->left.width_px, 0);
  });
}

image_strip_t Strip(int8_t camera, int32_t strip) {
  image_strip_t message{};
  message.header.source = 1;
  message.header.seq = 2 * camera + strip;
  message.camera = camera;
  message.strip = strip;
  message.n_strips = 2;
  message.width_px = 32;
  message.height_px = 16;
  message.encoding = "mono8";
  message.offset_bytes = 256 * strip;
  message.n_bytes = 256;
  message.data.assign(256, 7);
  return message;
}

TEST(MessageFuzz, StripsMakeCompleteFramesOrNone) {
  FrameAssembler assembler;
  Fuzz([&](Random& random) {
    for (int8_t camera = 0; camera < 2; ++camera) {
      for (int32_t s = 0; s < 2; ++s) {
        image_strip_t strip = Strip(camera, s);
        strip.frame_id = static_cast<int64_t>(random() % 3);
        ByteVector bytes = Encoded(strip);
        if (random() % 2 == 0) Mutate(bytes, random);
        const auto message = Checked<image_strip_t>(bytes);
        if (!message || assembler.Add(*message) != FrameAssembler::Outcome::kComplete) continue;
        const StereoImages images = assembler.TakeFrame().images;
        ASSERT_FALSE(images.left.empty());
        ASSERT_FALSE(images.right.empty());
      }
    }
    ASSERT_LE(assembler.partial(), FrameAssembler::kMaxPartial);
  });
}

TEST(MessageFuzz, KeyframesAreRefusedOrSound) {
  Keyframe keyframe;
  keyframe.name.number = 3;
  keyframe.camera = {400.0, 320.0, 240.0, 0.12, 640, 480};
  for (int i = 0; i < 30; ++i) {
    keyframe.features.points.emplace_back();
    keyframe.point_landmark_ids.push_back(-1);
    keyframe.features.lines.emplace_back();
    keyframe.line_landmark_ids.push_back(i);
  }
  const auto pages = CutIntoPages(keyframe, 2000);
  KeyframeAssembler assembler;
  Fuzz([&](Random& random) {
    for (const keyframe_t& page : pages) {
      ByteVector bytes = Encoded(page);
      if (random() % 4 == 0) Mutate(bytes, random);
      const auto message = Checked<keyframe_t>(bytes);
      if (!message || assembler.Add(*message) != PageOutcome::kComplete) continue;
      const Keyframe whole = assembler.Take();
      ASSERT_TRUE(whole.T_odom_kf.IsFinite() && whole.T_prevkf_kf.IsFinite() && whole.covariance.allFinite());
      ASSERT_EQ(whole.features.points.size(), whole.point_landmark_ids.size());
      ASSERT_EQ(whole.features.points.size(), whole.point_map_ids.size());
      for (const StereoPoint& point : whole.features.points) ASSERT_TRUE(point.left.px.allFinite());
    }
  });
}

TEST(MessageFuzz, MapUpdatesAreRefusedOrSound) {
  std::vector<std::vector<map_update_t>> versions;
  test::MapOwner owner(1);
  for (int i = 0; i < 6; ++i) versions.push_back(CutIntoPages(owner.Next(60), 3000));
  Fuzz([&](Random& random) {
    MapUpdateAssembler assembler;
    MapFollower replica;
    for (const auto& pages : versions) {
      for (const map_update_t& page : pages) {
        ByteVector bytes = Encoded(page);
        if (random() % 8 == 0) Mutate(bytes, random);
        const auto message = Checked<map_update_t>(bytes);
        if (message && assembler.Add(*message) == PageOutcome::kComplete) {
          replica.Apply(assembler.Take());
        }
      }
    }
    for (const auto& [id, point] : replica.map().points()) ASSERT_TRUE(point.p_w.allFinite());
    for (const auto& [id, keyframe] : replica.map().keyframes()) {
      ASSERT_LT(keyframe.parent_id, id);
      ASSERT_TRUE(keyframe.T_w_kf.IsFinite());
    }
  });
}

TEST(MessageFuzz, LoopClosuresAreRefusedOrSound) {
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kLoop;
  closure.keyframe.number = 40;
  closure.edges.push_back({1, 40, SE3(), Matrix6d::Identity(), 50, 5});
  for (int i = 0; i < 60; ++i) {
    closure.points.push_back({i, i + 1});
    closure.poses.push_back({i, SE3()});
  }
  const auto pages = CutIntoPages(closure, 1500);
  LoopClosureAssembler assembler;
  Fuzz([&](Random& random) {
    for (const loop_closure_t& page : pages) {
      ByteVector bytes = Encoded(page);
      if (random() % 4 == 0) Mutate(bytes, random);
      const auto message = Checked<loop_closure_t>(bytes);
      if (!message || assembler.Add(*message) != PageOutcome::kComplete) continue;
      const LoopClosure whole = assembler.Take();
      for (const LoopEdge& edge : whole.edges) ASSERT_LT(edge.old_keyframe_id, edge.keyframe_id);
      for (const CorrectedPose& pose : whole.poses) ASSERT_TRUE(pose.T_w_kf.IsFinite());
    }
  });
}

TEST(MessageFuzz, OrderSurvivesAnyNumbers) {
  Fuzz([](Random& random) {
    OrderedReader reader(true, 50'000, 0);
    const ByteVector message(100, 0);
    const auto number = [&]() -> int64_t {
      switch (random() % 16) {
        case 0:
          return static_cast<int64_t>(random()) & INT64_MAX;
        case 1:
          return INT64_MAX - static_cast<int64_t>(random() % 3);
        case 2:
          return kMaxNumber + 1 - static_cast<int64_t>(random() % 3);
        default:
          return static_cast<int64_t>(random() % 50);
      }
    };
    int64_t last = -1;
    for (int64_t now = 0; now < 300; ++now) {
      const int64_t t = now * 20'000'000;
      if (random() % 4 == 0) reader.OnAnnounce(number(), number(), t);
      reader.OnMessage(number(), message, t);
      while (reader.Front() != nullptr) {
        ASSERT_GT(reader.delivered() + 1, last);
        last = reader.delivered() + 1;
        reader.Pop(t);
      }
      const auto request = reader.Poll(t);
      ASSERT_TRUE(!request || request->ranges.size() <= 32);
      ASSERT_LE(reader.buffered_bytes(), 50'000);
    }
  });
}

TEST(MessageFuzz, DamagedLogsAreReadOrRefused) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "log";
  Fuzz([&](Random& random) {
    {
      LogWriter writer(path);
      ByteVector camera = Encoded(ToMessage(SmallRig()));
      if (random() % 8 == 0) Mutate(camera, random);
      writer.Write("CAMERA", camera, 1);
      for (int i = 0; i < 8; ++i) {
        image_strip_t strip = Strip(static_cast<int8_t>(i / 2 % 2), i % 2);
        strip.frame_id = i / 4;
        strip.header.t_ns = i / 4;
        ByteVector bytes = Encoded(strip);
        if (random() % 8 == 0) Mutate(bytes, random);
        writer.Write("STEREO_FRAME", bytes, i);
      }
    }
    std::ifstream in(path, std::ios::binary);
    ByteVector bytes((std::istreambuf_iterator<char>(in)), {});
    if (random() % 2 == 0) Mutate(bytes, random);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    try {
      const auto dataset = OpenLogDataset(path);
      for (int i = 0; i < dataset->size(); ++i) dataset->Read(i);
    } catch (const DatasetError&) {
    }
  });
}

}  // namespace
}  // namespace plslam::bus

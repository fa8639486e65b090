// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/bus/random_message.h"

#include <functional>
#include <map>

#include "plslam/announce_t.hpp"
#include "plslam/bodies_t.hpp"
#include "plslam/body_t.hpp"
#include "plslam/camera_t.hpp"
#include "plslam/command_answer_t.hpp"
#include "plslam/command_t.hpp"
#include "plslam/corrected_pose_t.hpp"
#include "plslam/counter_t.hpp"
#include "plslam/grid_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/header_t.hpp"
#include "plslam/image_strip_t.hpp"
#include "plslam/imu_interval_t.hpp"
#include "plslam/imu_sample_t.hpp"
#include "plslam/imu_t.hpp"
#include "plslam/intrinsics_t.hpp"
#include "plslam/keyframe_name_t.hpp"
#include "plslam/keyframe_t.hpp"
#include "plslam/line_feature_t.hpp"
#include "plslam/loop_answer_t.hpp"
#include "plslam/loop_closure_t.hpp"
#include "plslam/loop_edge_t.hpp"
#include "plslam/map_adjustment_t.hpp"
#include "plslam/map_id_t.hpp"
#include "plslam/map_keyframe_t.hpp"
#include "plslam/map_line_t.hpp"
#include "plslam/map_point_t.hpp"
#include "plslam/map_request_t.hpp"
#include "plslam/map_totals_t.hpp"
#include "plslam/map_update_t.hpp"
#include "plslam/map_version_t.hpp"
#include "plslam/mask_t.hpp"
#include "plslam/moved_keyframe_t.hpp"
#include "plslam/observation_t.hpp"
#include "plslam/point_feature_t.hpp"
#include "plslam/polygon_t.hpp"
#include "plslam/pose3_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/range_t.hpp"
#include "plslam/rectified_camera_t.hpp"
#include "plslam/relocalisation_t.hpp"
#include "plslam/repair_request_t.hpp"
#include "plslam/robot_motion_t.hpp"
#include "plslam/run_t.hpp"
#include "plslam/same_landmarks_t.hpp"
#include "plslam/stage_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "plslam/submap_t.hpp"
#include "plslam/surface_point_t.hpp"
#include "plslam/track_line_t.hpp"
#include "plslam/track_point_t.hpp"
#include "plslam/tracks_t.hpp"
#include "plslam/warning_t.hpp"
#include "plslam/withdrawn_t.hpp"

namespace plslam::bus::test {
namespace {

template <class T>
DecodedAgain Roundtrip(ByteView bytes) {
  T message;
  DecodedAgain result;
  result.decoded = message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) >= 0;
  if (!result.decoded) return result;
  result.encoded.resize(static_cast<size_t>(message.getEncodedSize()));
  message.encode(result.encoded.data(), 0, static_cast<int>(result.encoded.size()));
  return result;
}

template <class... T>
std::map<std::string, std::function<DecodedAgain(ByteView)>> TableOf() {
  return {{T::getTypeName(), &Roundtrip<T>}...};
}

const auto& Table() {
  static const auto table =
      TableOf<announce_t, bodies_t, body_t, camera_t, command_answer_t, command_t, corrected_pose_t, counter_t,
              grid_t, ground_truth_t, header_t, image_strip_t, imu_interval_t, imu_sample_t, imu_t, intrinsics_t,
              keyframe_name_t, keyframe_t, line_feature_t, loop_answer_t, loop_closure_t, loop_edge_t,
              map_adjustment_t, map_id_t, map_keyframe_t, map_line_t, map_point_t, map_request_t, map_totals_t,
              map_update_t, map_version_t, mask_t, moved_keyframe_t, point_feature_t, polygon_t, pose3_t, pose_t,
              range_t, rectified_camera_t, relocalisation_t, repair_request_t, robot_motion_t, run_t,
              same_landmarks_t, observation_t, stage_t, status_t, stream_t, submap_t, surface_point_t, track_line_t,
              track_point_t, tracks_t, warning_t, withdrawn_t>();
  return table;
}

void AppendInteger(std::vector<uint8_t>& bytes, uint64_t value, int n) {
  for (int i = n - 1; i >= 0; --i) bytes.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

class Writer {
 public:
  Writer(std::vector<uint8_t>& bytes, std::mt19937_64& random) : bytes_(bytes), random_(random) {}

  void Struct(const MessageLayout& layout) {
    std::vector<int32_t> sizes(layout.members.size(), -1);
    for (size_t i = 0; i < layout.members.size(); ++i) {
      const LayoutMember& member = layout.members[i];
      if (IsSize(layout, i)) {
        sizes[i] = static_cast<int32_t>(random_() % 4);
        AppendInteger(bytes_, static_cast<uint64_t>(sizes[i]), 4);
        continue;
      }
      size_t count = 1;
      for (const auto& d : member.dimensions) count *= d.size_member < 0 ? d.constant : sizes[d.size_member];
      for (size_t k = 0; k < count; ++k) Value(layout, member);
    }
  }

 private:
  static bool IsSize(const MessageLayout& layout, size_t i) {
    for (const LayoutMember& member : layout.members) {
      for (const auto& d : member.dimensions) {
        if (d.size_member == static_cast<int>(i)) return true;
      }
    }
    return false;
  }

  void Value(const MessageLayout& owner, const LayoutMember& member) {
    static const std::map<WireType, int> kBytes = {
        {WireType::kBoolean, 1}, {WireType::kByte, 1},  {WireType::kInt8, 1},  {WireType::kInt16, 2},
        {WireType::kInt32, 4},   {WireType::kInt64, 8}, {WireType::kFloat, 4}, {WireType::kDouble, 8}};
    if (member.type == WireType::kStruct) return Struct(owner.table()[static_cast<size_t>(member.struct_index)]);
    if (member.type != WireType::kString) return AppendInteger(bytes_, random_(), kBytes.at(member.type));
    const size_t length = random_() % 6;
    AppendInteger(bytes_, length + 1, 4);
    for (size_t i = 0; i < length; ++i) bytes_.push_back(static_cast<uint8_t>('a' + random_() % 26));
    bytes_.push_back(0);
  }

  std::vector<uint8_t>& bytes_;
  std::mt19937_64& random_;
};

}  // namespace

std::vector<uint8_t> RandomMessage(const MessageLayout& layout, std::mt19937_64& random) {
  std::vector<uint8_t> bytes;
  AppendInteger(bytes, static_cast<uint64_t>(layout.fingerprint()), 8);
  Writer(bytes, random).Struct(layout);
  return bytes;
}

std::vector<std::string> GeneratedTypes() {
  std::vector<std::string> names;
  for (const auto& [name, roundtrip] : Table()) names.push_back(name);
  return names;
}

DecodedAgain DecodeAndEncode(const std::string& type, ByteView bytes) { return Table().at(type)(bytes); }

}  // namespace plslam::bus::test

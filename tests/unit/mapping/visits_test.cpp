// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/visits.h"

#include <gtest/gtest.h>

#include "core/map/map.h"

namespace plslam::mapping {
namespace {

/// Keyframes of sessions that move along z.
class Paths {
 public:
  void Add(double z_m, SessionId session = 1) {
    MapKeyframe keyframe;
    keyframe.id = KeyframeId(map_.keyframes().size());
    keyframe.name.session = session;
    keyframe.T_w_kf = SE3(Eigen::Quaterniond::Identity(), {0.0, 0.0, z_m});
    for (const auto& [id, other] : map_.keyframes()) {
      if (other.name.session == session) keyframe.previous_id = id;
    }
    if (keyframe.previous_id >= 0) {
      keyframe.T_prevkf_kf = map_.FindKeyframe(keyframe.previous_id)->T_w_kf.Inverse() * keyframe.T_w_kf;
    }
    map_.Put(keyframe);
    visits_.Add(keyframe);
  }
  bool IsBefore(int earlier, int keyframe) const {
    return visits_.IsBefore(*map_.FindKeyframe(earlier), *map_.FindKeyframe(keyframe));
  }

 private:
  Map map_;
  Visits visits_;
};

TEST(Visits, OneOnAStraightPath) {
  Paths paths;
  for (int i = 0; i < 100; ++i) paths.Add(i);
  for (int i = 0; i < 99; ++i) EXPECT_FALSE(paths.IsBefore(i, 99)) << i;
  EXPECT_FALSE(paths.IsBefore(99, 99));
  EXPECT_FALSE(paths.IsBefore(99, 50)) << "it is later";
}

TEST(Visits, AnotherOneAfterTheReturn) {
  Paths paths;
  for (int i = 0; i <= 20; ++i) paths.Add(i);
  for (int i = 19; i >= 0; --i) paths.Add(i);
  EXPECT_TRUE(paths.IsBefore(0, 40)) << "40 m of path, at the same place";
  EXPECT_TRUE(paths.IsBefore(10, 30));
  EXPECT_FALSE(paths.IsBefore(19, 21)) << "a few steps back and forth are one visit";
  EXPECT_FALSE(paths.IsBefore(39, 40));
}

TEST(Visits, SessionsAreVisits) {
  Paths paths;
  for (int i = 0; i < 3; ++i) paths.Add(i, 1);
  paths.Add(0.0, 2);
  paths.Add(3.0, 1);
  paths.Add(1.0, 2);
  EXPECT_TRUE(paths.IsBefore(1, 5)) << "older than the session";
  EXPECT_FALSE(paths.IsBefore(4, 5)) << "of another robot at the same time";
}

TEST(Visits, SessionWithUnknownPathIsOneVisit) {
  Map map;
  for (int id = 0; id < 4; ++id) {
    MapKeyframe keyframe;
    keyframe.id = id;
    keyframe.name.session = id < 2 ? 1 : 2;
    map.Put(keyframe);
  }
  const Visits visits;
  EXPECT_FALSE(visits.IsBefore(*map.FindKeyframe(0), *map.FindKeyframe(1)));
  EXPECT_TRUE(visits.IsBefore(*map.FindKeyframe(1), *map.FindKeyframe(3))) << "of another session";
}

}  // namespace
}  // namespace plslam::mapping

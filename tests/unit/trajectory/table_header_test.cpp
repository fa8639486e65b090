// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectories/table_header.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/io/trajectories/trajectory.h"
#include "tests/support/text_file.h"

namespace plslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::string Header(const std::string& line) { return line + "\n"; }

/// Three poses 1 s apart with the quaternion 0.6 (z), 0.8 (w), whose time is a multiple of `unit`.
std::string Rows(const std::string& first_time, int64_t unit, const std::string& pose, char separator = ',') {
  std::string text;
  const int64_t begin = std::stoll(first_time);
  for (int i = 0; i < 3; ++i) text += std::to_string(begin + i * unit) + separator + pose + "\n";
  return text;
}

class HeaderOfTruth : public testing::Test {
 protected:
  TrajectoryFile Read(const std::string& text, std::optional<TrajectoryFormat> format = std::nullopt) const {
    return ReadTrajectoryFile(folder_.Write("t", text), format, BadRows::kRefuse);
  }
  std::string Error(const std::string& text, std::optional<TrajectoryFormat> format = std::nullopt) const {
    try {
      Read(text, format);
      return "";
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }
  /// Expects a pose at 1621218775 s with w = 0.8 as its first, and another one a second later.
  static void ExpectThePoses(const TrajectoryFile& file, const std::string& what) {
    ASSERT_EQ(file.poses.size(), 3U) << what;
    EXPECT_EQ(file.poses[0].t_ns, 1'621'218'775'000'000'000) << what;
    EXPECT_EQ(file.poses[1].t_ns, 1'621'218'776'000'000'000) << what;
    EXPECT_NEAR(file.poses[0].T_a_b.rotation().w(), 0.8, 1e-12) << what;
    EXPECT_NEAR(file.poses[0].T_a_b.rotation().z(), 0.6, 1e-12) << what;
    EXPECT_EQ(file.poses[0].T_a_b.translation(), Eigen::Vector3d(1, 2, 3)) << what;
    EXPECT_TRUE(file.notes.empty()) << what;
  }

  const ScratchFolder folder_;
};

constexpr const char* kLast = "1,2,3,0,0,0.6,0.8";   // qw last
constexpr const char* kFirst = "1,2,3,0.8,0,0,0.6";  // qw first

TEST_F(HeaderOfTruth, NamesTheOrderOfTheQuaternion) {
  const std::string ns = "1621218775000000000";
  for (const char* header :
       {"#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_x [],q_RS_y [],q_RS_z [],q_RS_w []",
        "#ts (ns),tx (m),ty (m),tz (m),qx,qy,qz,qw", "ts (ns),tx (m),ty (m),tz (m),qx,qy,qz,qw",
        "#timestamp,p_x,p_y,p_z,q_x,q_y,q_z,q_w", "time_ns,x,y,z,quat_x,quat_y,quat_z,quat_w",
        "stamp,pose.position.x,pose.position.y,pose.position.z,pose.orientation.x,pose.orientation.y,"
        "pose.orientation.z,pose.orientation.w"}) {
    ExpectThePoses(Read(Header(header) + Rows(ns, 1'000'000'000, kLast)), header);
  }
  for (const char* header :
       {"#timestamp,p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []",
        "timestamp[ns],px,py,pz,qw,qx,qy,qz", "# no names", ""}) {
    ExpectThePoses(Read(Header(header) + Rows(ns, 1'000'000'000, kFirst)), header);
    ExpectThePoses(Read(Header(header) + Rows(ns, 1'000'000'000, kFirst), TrajectoryFormat::kEuroc), header);
  }
  ExpectThePoses(Read("timestamp,tx,ty,tz,qw,qx,qy,qz\n" + Rows("1621218775", 1, kFirst)), "seconds with qw first");
  ExpectThePoses(Read("# timestamp tx ty tz qw qx qy qz\n" + Rows("1621218775", 1, "1 2 3 0.8 0 0 0.6", ' ')),
                 "blanks");
}

TEST_F(HeaderOfTruth, NamesTheUnitOfTime) {
  const std::string names = ",tx,ty,tz,qx,qy,qz,qw\n";
  ExpectThePoses(Read("time [s]" + names + Rows("1621218775", 1, kLast)), "s");
  ExpectThePoses(Read("timestamp_ms" + names + Rows("1621218775000", 1000, kLast)), "ms");
  ExpectThePoses(Read("# t (us)" + names + Rows("1621218775000000", 1'000'000, kLast)), "us");
  ExpectThePoses(
      Read("# timestamp [ms] tx ty tz qx qy qz qw\n" + Rows("1621218775000", 1000, "1 2 3 0 0 0.6 0.8", ' '),
           TrajectoryFormat::kTum),
      "ms with blanks");
}

TEST_F(HeaderOfTruth, NamesFurtherColumns) {
  ExpectThePoses(Read("frame,t [ns],qw,qx,qy,qz,x,y,z\n0,1621218775000000000,0.8,0,0,0.6,1,2,3\n"
                      "1,1621218776000000000,0.8,0,0,0.6,1,2,3\n2,1621218777000000000,0.8,0,0,0.6,1,2,3\n"),
                 "another order of columns");
  EXPECT_THAT(Error("frame,t [ns],qw,qx,qy,qz,x,y,z\n0,1621218775000000000,0.8,0,0,0.6,1,2\n"),
              HasSubstr("8 columns, but a row of this file, by its header, has at least 9"));
  EXPECT_THAT(Error("t,x,y,z,qx,qy,qz,qw,qw\n1,0,0,0,0,0,0,1,1\n"), HasSubstr("are both the w of a quaternion"));
}

TEST_F(HeaderOfTruth, ContradictsTheTimes) {
  EXPECT_THAT(Error("t [ns],x,y,z,qx,qy,qz,qw\n" + Rows("1621218775000", 50, kLast)),
              AllOf(HasSubstr("t:1: the column 't [ns]' is in nanoseconds by its name"),
                    HasSubstr("are they in milliseconds?")));
  EXPECT_THAT(Error("t [s],x,y,z,qx,qy,qz,qw\n" + Rows("1621218775000000000", 50'000'000, kLast)),
              HasSubstr("are they in nanoseconds?"));
}

TEST(UnitOfCommas, FollowsFromTheSteps) {
  const ScratchFolder folder;
  const auto read = [&](const std::string& text) {
    return ReadTrajectoryFile(folder.Write("t", text), std::nullopt, BadRows::kRefuse);
  };
  // Seconds of TUM, in any notation.
  for (const std::string& text : {Rows("0", 1, kLast), Rows("1621218775", 1, kLast)}) {
    const TrajectoryFile file = read(text);
    EXPECT_EQ(file.format, TrajectoryFormat::kTum);
    EXPECT_EQ(file.poses[1].t_ns - file.poses[0].t_ns, 1'000'000'000);
    EXPECT_NEAR(file.poses[0].T_a_b.rotation().w(), 0.8, 1e-12);
    EXPECT_THAT(file.notes.remarks, ElementsAre(HasSubstr("are in seconds: read as TUM's")));
  }
  // Nanoseconds of EuRoC, of a clock that starts at 0 too, and with a point.
  const std::vector<std::vector<const char*>> all_times{
      {"0", "1000000000", "2000000000"},
      {"0.0", "1000000000.0", "2000000000.0"},
      {"1200000000", "1250000000", "1300000000"},
      {"1621218775000000000.0", "1621218776000000000.0", "1621218777000000000.0"}};
  for (const std::vector<const char*>& times : all_times) {
    std::string text;
    for (const char* time : times) text += fmt::format("{},{}\n", time, kFirst);
    const TrajectoryFile file = read(text);
    EXPECT_EQ(file.format, TrajectoryFormat::kEuroc) << times[0];
    EXPECT_NEAR(file.poses[0].T_a_b.rotation().w(), 0.8, 1e-12) << times[0];
    EXPECT_GE(file.poses[1].t_ns - file.poses[0].t_ns, 50'000'000) << times[0];
  }
}

TEST(UnitOfCommas, OtherUnitsAreAskedFor) {
  const ScratchFolder folder;
  const auto error = [&](const std::string& text) -> std::string {
    try {
      ReadTrajectoryFile(folder.Write("t", text), std::nullopt, BadRows::kPassOver);
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(error(Rows("1621218775000", 1000, kLast)),
              AllOf(HasSubstr("seem to be in milliseconds"), HasSubstr("[ms]")));
  EXPECT_THAT(error(Rows("1621218775000000", 1'000'000, kLast)), HasSubstr("seem to be in microseconds"));
  EXPECT_THAT(error(Rows("1621218775000000", 50'000, kLast)), HasSubstr("seem to be in microseconds"));
  EXPECT_THAT(error(Rows("0", 50, kLast)), HasSubstr("are they in milliseconds?"));
  EXPECT_THAT(error(Rows("0", 50'000, kLast)), HasSubstr("are they in microseconds?"));
  EXPECT_THAT(error("1621218775.5,1,2,3,0,0,0.6,0.8,0\n1621218776.5,1,2,3,0,0,0.6,0.8,0\n"
                    "1621218777.5,1,2,3,0,0,0.6,0.8,0\n"),
              HasSubstr("is in seconds, but in nanoseconds in the EuRoC format: name the columns"));
}

}  // namespace
}  // namespace plslam

// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectories/trajectory.h"

#include <gmock/gmock.h>

#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"

namespace plslam {
namespace {

using testing::HasSubstr;

double Distance(const SE3& a, const SE3& b) { return (a.Inverse() * b).Log().norm(); }

Trajectory SomeTrajectory() {
  Trajectory trajectory;
  for (int i = 0; i < 20; ++i) {
    Vector6d x;
    x << 0.1 * i, -2.0 * i, 300.0 + i, 0.15 * i, -0.1 * i, 0.05;
    trajectory.push_back({1403636579763555584 + i * 50000000LL + i, SE3::Exp(x)});
  }
  return trajectory;
}

std::string ErrorOf(const std::string& path, const std::string& times = "") {
  try {
    ReadTrajectory(path, times);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

class TrajectoryFormats : public testing::TestWithParam<TrajectoryFormat> {};

TEST_P(TrajectoryFormats, RoundTripKeepsPosesAndExactTimes) {
  const ScratchFolder folder;
  const Trajectory written = SomeTrajectory();
  WriteTrajectory(folder.Path("t"), GetParam(), written);
  const Trajectory read = ReadTrajectory(folder.Path("t"));
  ASSERT_EQ(read.size(), written.size());
  for (size_t i = 0; i < read.size(); ++i) {
    EXPECT_LT(Distance(read[i].T_a_b, written[i].T_a_b), 1e-8);
    const bool has_times = GetParam() != TrajectoryFormat::kKitti;
    EXPECT_EQ(read[i].t_ns, has_times ? written[i].t_ns : static_cast<int64_t>(i) * 1000000000);
  }
  EXPECT_FALSE(std::filesystem::exists(folder.Path("t.part")));
}

TEST_P(TrajectoryFormats, EmptyTrajectoryIsAFileWithoutRows) {
  const ScratchFolder folder;
  WriteTrajectory(folder.Path("t"), GetParam(), {});
  EXPECT_TRUE(ReadTrajectory(folder.Path("t"), GetParam()).empty());
}

TEST_P(TrajectoryFormats, PoseThatIsNotFiniteIsNotWritten) {
  const ScratchFolder folder;
  Trajectory trajectory = SomeTrajectory();
  trajectory[3].T_a_b = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, NAN, 0));
  EXPECT_THROW(WriteTrajectory(folder.Path("t"), GetParam(), trajectory), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(folder.Path("t")));
}

INSTANTIATE_TEST_SUITE_P(All, TrajectoryFormats,
                         testing::Values(TrajectoryFormat::kTum, TrajectoryFormat::kKitti, TrajectoryFormat::kEuroc));

TEST(Trajectory, HandWrittenFilesOfAllFormatsMeanTheSame) {
  const ScratchFolder folder;
  // A quarter turn about z, at (1, 2, 3).
  const std::string s = "0.70710678";
  const std::string tum = folder.Write("tum", "# t tx ty tz qx qy qz qw\n\n1.5 1 2 3 0 0 " + s + " " + s + "\r\n");
  const std::string kitti = folder.Write("kitti", "0 -1 0 1 1 0 0 2 0 0 1 3\n");
  const std::string times = folder.Write("times", "1.5e+00\n");
  const std::string euroc = folder.Write("euroc", "#t\n1500000000, 1,2,3, " + s + ",0,0," + s + ", 9,9,9\n");
  for (const Trajectory& t : {ReadTrajectory(tum), ReadTrajectory(kitti, times), ReadTrajectory(euroc)}) {
    ASSERT_EQ(t.size(), 1u);
    EXPECT_EQ(t[0].t_ns, 1500000000);
    EXPECT_LT((t[0].T_a_b * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm(), 1e-12);
  }
}

TEST(Trajectory, TumRowHasTheCommonFormat) {
  const ScratchFolder folder;
  const SE3 T(Eigen::Quaterniond(-1, 0, 0, 0), Eigen::Vector3d(1, -2, 0.5));
  WriteTrajectory(folder.Path("t"), TrajectoryFormat::kTum, {{103391400, T}});
  EXPECT_THAT(ReadText(folder.Path("t")), HasSubstr("0.103391400 1.000000000 -2.000000000 0.500000000 "));
  EXPECT_THAT(ReadText(folder.Path("t")), HasSubstr(" 1.000000000000\n")) << "w >= 0";
}

TEST(Trajectory, SecondsOfNegativeTimesKeepTheirSign) {
  EXPECT_EQ(SecondsText(-1), "-0.000000001");
  EXPECT_EQ(SecondsText(-1500000000), "-1.500000000");
  EXPECT_EQ(SecondsText(INT64_MIN), "-9223372036.854775808");
}

TEST(Trajectory, ErrorsNameFileLineAndValue) {
  const ScratchFolder folder;
  const auto error = [&](const std::string& content) { return ErrorOf(folder.Write("t", content)); };
  const std::string row = "1 0 0 0 0 0 0 1\n";
  EXPECT_EQ(error(row), "");
  EXPECT_THAT(error("1 2 3\n"), HasSubstr("t:1: 3 numbers fit none"));
  EXPECT_THAT(error(row + "2 0 0 0 0 0 0\n"), HasSubstr("t:2: 7 numbers, but a row of the TUM format has 8"));
  EXPECT_THAT(error(row + "# x\n2 0 nan 0 0 0 0 1\n"), HasSubstr("t:3: 'nan' is not a finite number"));
  EXPECT_THAT(error(row + "2 0 1m 0 0 0 0 1\n"), HasSubstr("t:2: '1m'"));
  EXPECT_THAT(error("1 0 0 0 0 0 0 0.5\n"), HasSubstr("t:1: the quaternion has norm 0.5, not 1"));
  EXPECT_THAT(error("1 0 0 0 0 0 0 0\n"), HasSubstr("norm 0"));
  EXPECT_THAT(error(row + row), HasSubstr("t:2: time 1000000000 ns is not after the 1000000000 ns"));
  EXPECT_THAT(error("1403636579763555584 0 0 0 0 0 0 1\n"), HasSubstr("is it in nanoseconds?"));
  EXPECT_THAT(error("4700000000 0 0 0 0 0 0 1\n"), HasSubstr("t:1: time 4700000000000000000 ns is beyond"));
  EXPECT_THAT(error("1,2,3\n"), HasSubstr("t:1: 3 columns, but a row of the EuRoC format has at least 8"));
  EXPECT_EQ(error("timestamp,a,b,c,d,e,f,g\n1,0,0,0,1,0,0,0\n"), "") << "names of columns";
  EXPECT_THAT(error("1,0,0,0,1,0,0,0\ntimestamp,a,b,c,d,e,f,g\n"), HasSubstr("t:2: 'timestamp'"));
  EXPECT_THAT(error("2 0 0 0 0 1 0 0 0 0 1 0\n"), HasSubstr("t:1: the matrix is not a rotation"));
  EXPECT_THAT(error("-1 0 0 0 0 1 0 0 0 0 1 0\n"), HasSubstr("determinant -1"));
}

/// The poses that remain of a truth with bad rows, and its notes.
struct Kept {
  std::vector<int64_t> t_s;
  Notes notes;
};

Kept KeptOf(const std::string& path, std::optional<TrajectoryFormat> format = std::nullopt) {
  const TrajectoryFile file = ReadTrajectoryFile(path, format, BadRows::kPassOver);
  Kept kept{{}, file.notes};
  for (const TrajectoryPose& pose : file.poses) kept.t_s.push_back(pose.t_ns / 1'000'000'000);
  return kept;
}

TEST(TruthRows, BadRowsAreSkippedWithOneNote) {
  const ScratchFolder folder;
  const std::string pose = " 0 0 0 0 0 0 1\n";
  const Kept twice = KeptOf(folder.Write("t", "1" + pose + "2" + pose + "2 9 0 0 0 0 0 1\n3" + pose));
  EXPECT_THAT(twice.t_s, testing::ElementsAre(1, 2, 3));
  EXPECT_THAT(twice.notes.warnings,
              testing::ElementsAre(HasSubstr("t:3: time 2000000000 ns is not after the 2000000000 ns of the "
                                             "previous row; 1 of 4 rows is skipped")));
  EXPECT_EQ(ReadTrajectoryFile(folder.Path("t"), {}, BadRows::kPassOver).poses[1].T_a_b.translation().x(), 0.0);
  const Kept nan = KeptOf(folder.Write("t", "1" + pose + "2 nan nan nan nan nan nan nan\n3 0 0\n4" + pose));
  EXPECT_THAT(nan.t_s, testing::ElementsAre(1, 4));
  EXPECT_THAT(nan.notes.warnings,
              testing::ElementsAre(HasSubstr("t:2: 'nan' is not a finite number; 2 of 4 rows are skipped")));
  EXPECT_TRUE(KeptOf(folder.Write("t", "1" + pose)).notes.empty());
}

TEST(TruthRows, FutureTimeSkipsOneRow) {
  const ScratchFolder folder;
  const std::string pose = " 0 0 0 0 0 0 1\n";
  const Kept late = KeptOf(folder.Write("t", "1" + pose + "900" + pose + "2" + pose + "3" + pose));
  EXPECT_THAT(late.t_s, testing::ElementsAre(1, 2, 3));
  EXPECT_THAT(late.notes.warnings, testing::ElementsAre(HasSubstr("t:2: time 900000000000 ns is out of order")));
  const Kept swapped = KeptOf(folder.Write("t", "1" + pose + "3" + pose + "2" + pose + "4" + pose));
  EXPECT_EQ(swapped.t_s.size(), 3U);
}

TEST(TruthRows, PosesOfKittiKeepTheirNumbers) {
  const ScratchFolder folder;
  const std::string eye = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  const std::string poses = folder.Write("poses", eye + "nan 0 0 0 0 1 0 0 0 0 1 0\n" + eye);
  EXPECT_THAT(KeptOf(poses).t_s, testing::ElementsAre(0, 2));
  const TrajectoryFile timed =
      ReadTrajectoryFile(poses, {}, BadRows::kPassOver, folder.Write("times", "10\n11\n12\n"));
  ASSERT_EQ(timed.poses.size(), 2U);
  EXPECT_EQ(timed.poses[1].t_ns, 12'000'000'000);
  EXPECT_EQ(timed.n_rows, 3U);
}

TEST(TruthRows, CommasWithSecondsAreOfTum) {
  const ScratchFolder folder;
  const auto note = testing::ElementsAre(HasSubstr("in seconds: read as TUM's t,tx,ty,tz,qx,qy,qz,qw"));
  const std::string end = ",1,2,3,0,0,0.6,0.8\n";
  for (const std::string& rows :
       {"1621218775.0" + end + "1621218776.0" + end, "1621218775" + end + "1621218776" + end,
        "1305031098.6659" + end + "1305031098.6758" + end, "0.0" + end + "0.1" + end}) {
    for (const std::optional<TrajectoryFormat> format :
         {std::optional<TrajectoryFormat>(), std::optional(TrajectoryFormat::kEuroc)}) {
      const TrajectoryFile file = ReadTrajectoryFile(folder.Write("t", rows), format, BadRows::kRefuse);
      EXPECT_EQ(file.format, TrajectoryFormat::kTum) << rows;
      EXPECT_THAT(file.notes.remarks, note) << rows;
      ASSERT_EQ(file.poses.size(), 2U) << rows;
      EXPECT_NEAR(file.poses[0].T_a_b.rotation().w(), 0.8, 1e-12) << rows;
    }
  }
  // Nanoseconds of a clock that starts at 0, from its second second on.
  const TrajectoryFile euroc =
      ReadTrajectoryFile(folder.Write("t", "1450000000" + end + "1500000000" + end), {}, BadRows::kRefuse);
  EXPECT_EQ(euroc.format, TrajectoryFormat::kEuroc);
  EXPECT_EQ(euroc.poses[0].t_ns, 1450000000);
  EXPECT_TRUE(euroc.notes.empty());
  EXPECT_EQ(ReadTrajectoryFile(folder.Write("t", "1403715274312143104" + end), {}, BadRows::kRefuse).format,
            TrajectoryFormat::kEuroc);
  EXPECT_THAT(ErrorOf(folder.Write("t", "1621218775.5,1,2,3,0,0,0.6,0.8,0,0,0\n")),
              HasSubstr("t:1: time '1621218775.5' is in seconds, but in nanoseconds in the EuRoC format"));
}

TEST(Trajectory, TimesFileMustMatchThePoses) {
  const ScratchFolder folder;
  const std::string eye = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  const std::string poses = folder.Write("poses", eye + eye);
  const auto error = [&](const std::string& times) { return ErrorOf(poses, folder.Write("times", times)); };
  EXPECT_EQ(error("0\n1\n"), "");
  EXPECT_THAT(error("0\n"), HasSubstr("1 times for the 2 poses"));
  EXPECT_THAT(error("0\n1\n2\n"), HasSubstr("3 times for the 2 poses"));
  EXPECT_THAT(error("0\n0\n"), HasSubstr("times:2: time 0 s is not after"));
  EXPECT_THAT(error("0\nx\n"), HasSubstr("times:2: 'x'"));
}

TEST(Trajectory, RoundedRotationsAreNormalised) {
  const ScratchFolder folder;
  const Trajectory t = ReadTrajectory(folder.Write("t", "1 0 0 0 0.6005 0 0 0.8\n"));
  EXPECT_NEAR(t[0].T_a_b.rotation().norm(), 1.0, 1e-15);
}

TEST(Trajectory, UnwritableFolderIsNamed) {
  const ScratchFolder folder;
  try {
    WriteTrajectory(folder.Path("none/t"), TrajectoryFormat::kTum, SomeTrajectory());
    FAIL() << "was written";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("none/t: cannot be created: No such file"));
  }
}

TEST(Trajectory, UsersNameThreeFormats) {
  EXPECT_EQ(ChoiceFromName<TrajectoryFormat>("kitti"), TrajectoryFormat::kKitti);
  EXPECT_EQ(ChoiceFromName<TrajectoryFormat>("KITTI"), std::nullopt);
}

TEST(Trajectory, RealTrajectoriesSurviveAllFormats) {
  PLSLAM_REQUIRE_DATA(data, "trajectories");
  const ScratchFolder folder;
  const std::string kitti = (data / "kitti").string();
  const std::vector<Trajectory> all{ReadTrajectory(kitti + "/03.txt", kitti + "/03_times.txt"),
                                    ReadTrajectory(kitti + "/10.txt", kitti + "/10_times.txt"),
                                    ReadTrajectory((data / "euroc/V101_GT.txt").string())};
  EXPECT_EQ(all[0].size(), 801u);
  EXPECT_EQ(all[0][1].t_ns, 103391400);
  EXPECT_EQ(all[2].front().t_ns, 1403715274312143104);
  for (const Trajectory& original : all) {
    for (const auto format : {TrajectoryFormat::kTum, TrajectoryFormat::kKitti, TrajectoryFormat::kEuroc}) {
      WriteTrajectory(folder.Path("t"), format, original);
      const Trajectory read = ReadTrajectory(folder.Path("t"));
      ASSERT_EQ(read.size(), original.size());
      double worst = 0.0;
      for (size_t i = 0; i < read.size(); ++i) {
        worst = std::max(worst, Distance(read[i].T_a_b, original[i].T_a_b));
        const bool has_times = format != TrajectoryFormat::kKitti;
        ASSERT_EQ(read[i].t_ns, has_times ? original[i].t_ns : static_cast<int64_t>(i) * 1000000000);
      }
      EXPECT_LT(worst, 2e-8) << "format " << static_cast<int>(format);
    }
  }
}

}  // namespace
}  // namespace plslam

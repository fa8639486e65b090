// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/datasets/imu_files.h"
#include "core/datasets/imu_join.h"
#include "core/datasets/imu_topics.h"
#include "core/datasets/open_dataset.h"
#include "tests/unit/datasets/bag_file.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"
#include "tests/unit/datasets/db3_file.h"
#include "tests/unit/datasets/mcap_file.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using test::MakeMcapFile;
using test::RecordingOptions;
using test::TinyImuTopic;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int64_t kMilli_ns = 1'000'000;
constexpr int64_t kImages_ns = 1'000 * kMilli_ns;  ///< of the images

const SE3 kImuPose(Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d(0.0, 0.6, 0.8))), {0.01, -0.02, 0.03});

/// A sample every 10 ms, around the images.
std::vector<ImuSample> Samples() {
  std::vector<ImuSample> samples;
  for (int i = -2; i < 25; ++i) {
    samples.push_back({kImages_ns + 10 * kMilli_ns * i, {0.1 * i, 0.2, 1.0 / 3.0}, {0.01 * i, -0.5, 9.81}});
  }
  return samples;
}

/// `imu.yaml` with all keys.
constexpr const char* kFullImuYaml =
    "T_c_imu: [1, 0, 0, 0.1, 0, 1, 0, 0.2, 0, 0, 1, 0.3]\n"
    "rate_hz: 100\ngyroscope_noise_density: 1.7e-4\ngyroscope_random_walk: 2.0e-5\n"
    "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n";

class RecordedImu : public test::RecordingFileTest {
 protected:
  RecordedImu() : RecordingFileTest("a.mcap") {}
  fs::path Beside(const char* name) const { return fs::path(path()).parent_path() / name; }
};

TEST_F(RecordedImu, SamplesOfTheFolderItWasMadeOf) {
  std::string csv = "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
  for (const ImuSample& s : Samples()) {
    csv += fmt::format("{},{},{},{},{},{},{}\n", s.t_ns, s.rate_rad_s.x(), s.rate_rad_s.y(), s.rate_rad_s.z(),
                       s.force_m_s2.x(), s.force_m_s2.y(), s.force_m_s2.z());
  }
  const fs::path original = Beside("original.csv");
  test::WriteText(original, csv);
  Notes notes;
  const std::vector<ImuSample> samples = ReadImuSamples(original.string(), &notes);
  ASSERT_EQ(samples, Samples());

  const RecordingOptions options{.imus = {{"/imu0", samples}}, .T_camera_imu = kImuPose};
  for (const char* compression : {"", "lz4", "zstd"}) {
    RecordingOptions chunks = options;
    chunks.compression = compression;
    MakeMcapFile(path(), chunks);
    EXPECT_EQ(OpenDataset(path(), "")->ImuSamples(), Samples()) << compression;
  }
  test::MakeBagFile(Beside("a.bag"), options);
  test::MakeDb3File(Beside("a.db3"), options);
  test::MakeRos2Bag(Beside("walk"), {.split = true}, options);
  for (const char* name : {"a.bag", "a.db3", "walk"}) {
    const auto dataset = OpenDataset(Beside(name).string(), "");
    EXPECT_EQ(dataset->ImuSamples(), Samples()) << name;
    ASSERT_TRUE(dataset->rig().imu) << name;
    EXPECT_LT((dataset->rig().imu->T_b_imu.Inverse() * kImuPose).translation().norm(), 1e-12) << name;
    EXPECT_NEAR(dataset->rig().imu->rate_hz, 100.0, 1e-9) << name;
    EXPECT_EQ(dataset->rig().imu->noise.gyroscope_rad_s_sqrt_hz, ImuNoise().gyroscope_rad_s_sqrt_hz) << name;
    EXPECT_THAT(dataset->Notes().warnings, IsEmpty()) << name;
    EXPECT_THAT(dataset->Notes().remarks, ElementsAre(HasSubstr("/imu0 has no noise densities"))) << name;
  }
}

TEST_F(RecordedImu, FilesStateWhatTransformsDoNot) {
  const RecordingOptions options{.imus = {{"/imu0", Samples()}}};
  MakeMcapFile(path(), options);
  const auto unknown = OpenDataset(path(), "");
  EXPECT_FALSE(unknown->rig().imu);
  EXPECT_THAT(unknown->ImuSamples(), IsEmpty());
  EXPECT_THAT(unknown->Notes().warnings,
              ElementsAre(AllOf(HasSubstr("/imu0: the inertial sensor is not used: its pose is not known"),
                                HasSubstr("its frame 'imu' with 'camera'"),
                                HasSubstr("write T_c_imu (docs/imu.md) to " + Beside("imu.yaml").string()))));

  test::WriteText(Beside("imu.yaml"), kFullImuYaml);
  const auto beside = OpenDataset(path(), "");
  ASSERT_TRUE(beside->rig().imu);
  EXPECT_EQ(beside->rig().imu->T_b_imu.translation(), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(beside->rig().imu->noise.accelerometer_walk_m_s3_sqrt_hz, 3e-3);
  EXPECT_TRUE(beside->Notes().empty());

  test::WriteText(Beside("imu.yaml"), "gyroscope_noise_density: 1\n");
  EXPECT_THAT(Error(), AllOf(HasSubstr("imu.yaml:1"), HasSubstr("gyroscope_random_walk")));
  fs::remove(Beside("imu.yaml"));

  test::WriteText(Beside("camera.yaml"),
                  std::string("baseline_m: 0.125\nleft: {resolution_px: [48, 32], focal_length_px: [40, 40], "
                              "principal_point_px: [24, 16]}\nimu: {T_c_imu: [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, "
                              "0]}\n"));
  const auto by_camera = OpenDataset(path() + "?camera=" + Beside("camera.yaml").string(), "");
  ASSERT_TRUE(by_camera->rig().imu);
  EXPECT_EQ(by_camera->rig().imu->T_b_imu.translation().x(), 0.5);
  EXPECT_EQ(by_camera->ImuSamples(), Samples());
}

TEST_F(RecordedImu, DisorderedAndRepeatedSamples) {
  std::vector<ImuSample> shuffled = Samples();
  std::swap(shuffled[3], shuffled[9]);
  shuffled.push_back(shuffled[5]);
  shuffled.push_back({0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  shuffled.push_back({kImages_ns + kMilli_ns, Eigen::Vector3d(NAN, 0.0, 0.0), Eigen::Vector3d::Zero()});
  MakeMcapFile(path(), {.imus = {{"/imu0", shuffled}}, .T_camera_imu = kImuPose});
  const auto dataset = OpenDataset(path(), "");
  EXPECT_EQ(dataset->ImuSamples(), Samples());
  EXPECT_THAT(dataset->Notes().warnings,
              ElementsAre("1 message of /imu0 is skipped: another one has the same header stamp",
                          "1 message of /imu0 is skipped: the header stamp is zero",
                          "1 message of /imu0 is skipped: they are damaged"));
}

TEST_F(RecordedImu, RatesAndForcesApartAreJoined) {
  TinyImuTopic rates{"/camera/gyro/sample", {}, "imu"}, forces{"/camera/accel/sample", {}, "imu"};
  rates.has_force = forces.has_rate = false;
  for (int i = 0; i < 40; ++i)
    rates.samples.push_back({kImages_ns + 5 * kMilli_ns * i, {1.0 * i, 0.0, 0.0}, {0.0, 0.0, 0.0}});
  // A force of 0.1 per ms, every 16 ms, from the third rate on.
  for (int i = 0; i < 10; ++i) {
    const int64_t after_ms = 8 + 16 * i;
    forces.samples.push_back(
        {kImages_ns + kMilli_ns * after_ms, {0.0, 0.0, 0.0}, {0.1 * static_cast<double>(after_ms), 0.0, 9.8}});
  }
  MakeMcapFile(path(), {.imus = {rates, forces}, .T_camera_imu = kImuPose});
  const auto dataset = OpenDataset(path(), "");
  const std::vector<ImuSample>& samples = dataset->ImuSamples();
  ASSERT_EQ(samples.size(), 29U) << "from 10 to 150 ms";
  for (size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].t_ns, kImages_ns + 5 * kMilli_ns * static_cast<int64_t>(i + 2));
    EXPECT_EQ(samples[i].rate_rad_s.x(), static_cast<double>(i + 2));
    EXPECT_NEAR(samples[i].force_m_s2.x(), 0.1 * 5.0 * static_cast<double>(i + 2), 1e-12);
  }
  EXPECT_THAT(dataset->Notes().warnings,
              ElementsAre(HasSubstr("11 of 40 rates of /camera/gyro/sample have no partner around them on "
                                    "/camera/accel/sample")));
}

TEST_F(RecordedImu, OneOfSeveralOrNone) {
  std::vector<ImuSample> others = Samples();
  for (ImuSample& sample : others) sample.rate_rad_s *= 2.0;
  MakeMcapFile(path(), {.left = "/rig/cam0/image_raw",
                        .right = "/rig/cam1/image_raw",
                        .imus = {{"/gps/imu", others}, {"/rig/imu", Samples()}},
                        .T_camera_imu = kImuPose});
  EXPECT_EQ(OpenDataset(path(), "")->ImuSamples(), Samples());
  EXPECT_THAT(OpenDataset(path(), "")->Notes().remarks.front(),
              HasSubstr("of 2 inertial sensors that of /rig/imu is used (FILE?imu=TOPIC names another one)"));
  EXPECT_EQ(OpenDataset(path() + "?imu=/gps/imu", "")->ImuSamples(), others);
  EXPECT_THAT(OpenDataset(path() + "?imu=none", "")->ImuSamples(), IsEmpty());
  EXPECT_TRUE(OpenDataset(path() + "?imu=none", "")->Notes().empty());
  EXPECT_THAT(Error("?imu=/imu"), HasSubstr("has no samples (sensor_msgs/Imu) on the topic imu=/imu; they are on "
                                            "/gps/imu, /rig/imu"));
}

TEST_F(RecordedImu, SamplesOfAnotherTimeAreNotUsed) {
  std::vector<ImuSample> later = Samples();
  for (ImuSample& sample : later) sample.t_ns += 3600'000 * kMilli_ns;
  MakeMcapFile(path(), {.imus = {{"/imu0", later}}, .T_camera_imu = kImuPose});
  const auto dataset = OpenDataset(path(), "");
  EXPECT_FALSE(dataset->rig().imu);
  EXPECT_THAT(
      dataset->Notes().warnings,
      ElementsAre(HasSubstr("/imu0: the inertial sensor is not used: its samples are of 3600.980000000 s to")));
  EXPECT_THAT(Error("?imu=/imu0"), HasSubstr("its samples are of 3600.980000000 s to"));
}

TEST(ImuTopics, NamesOfOneSensor) {
  EXPECT_EQ(ImuTopicsOf("/imu"), (ImuTopics{"/imu", "/imu"}));
  for (const char* topic : {"/d455/gyro/sample", "/d455/accel/sample"}) {
    EXPECT_EQ(ImuTopicsOf(topic), (ImuTopics{"/d455/gyro/sample", "/d455/accel/sample"}));
  }
  const auto sensors = ImuTopicsAmong({"/d455/accel/sample", "/d455/gyro/sample", "/d455/imu", "/t265/gyro/sample"});
  ASSERT_EQ(sensors.size(), 2U);
  EXPECT_EQ(NearestImu(sensors, "/d455/infra1/image_rect_raw").rates, "/d455/imu") << "complete messages first";
  EXPECT_EQ(NearestImu({{"/a/imu", "/a/imu"}, {"/ab/imu", "/ab/imu"}}, "/ab/image").rates, "/ab/imu");
  EXPECT_EQ(NearestImu({{"/a/imu", "/a/imu"}, {"/ab/imu", "/ab/imu"}}, "/abc/image").rates, "/a/imu");
}

TEST(ImuJoin, RatesWaitForForces) {
  ImuJoin join;
  join.AddRate(10, Eigen::Vector3d(1.0, 0.0, 0.0));
  EXPECT_THAT(join.Take(), IsEmpty());
  join.AddForce(20, Eigen::Vector3d(0.0, 0.0, 2.0));
  EXPECT_THAT(join.Take(), IsEmpty()) << "no force before it";
  EXPECT_EQ(join.n_dropped(), 1);
  join.AddRate(25, Eigen::Vector3d(2.0, 0.0, 0.0));
  EXPECT_THAT(join.Take(), IsEmpty());
  join.AddForce(30, Eigen::Vector3d(0.0, 0.0, 4.0));
  EXPECT_THAT(join.Take(),
              ElementsAre(ImuSample{25, Eigen::Vector3d(2.0, 0.0, 0.0), Eigen::Vector3d(0.0, 0.0, 3.0)}));
  join.AddRate(30, Eigen::Vector3d(3.0, 0.0, 0.0));
  EXPECT_THAT(join.Take(),
              ElementsAre(ImuSample{30, Eigen::Vector3d(3.0, 0.0, 0.0), Eigen::Vector3d(0.0, 0.0, 4.0)}));
  join.AddRate(40, Eigen::Vector3d(3.0, 0.0, 0.0));
  join.AddForce(31 + ImuJoin::kLongestForceGap_ns, Eigen::Vector3d(0.0, 0.0, 4.0));
  EXPECT_THAT(join.Take(), IsEmpty()) << "its forces are too far apart";
}

TEST(ImuJoin, ClockThatIsSetBackBeginsAgain) {
  constexpr int64_t kLater_ns = 10 * ImuJoin::kLongestDelay_ns;
  ImuJoin join;
  join.AddForce(kLater_ns, Eigen::Vector3d(0.0, 0.0, 1.0));
  join.AddRate(kLater_ns + 5, Eigen::Vector3d(1.0, 0.0, 0.0));
  join.AddRate(kLater_ns + 5, Eigen::Vector3d(2.0, 0.0, 0.0));
  EXPECT_EQ(join.n_dropped(), 1) << "repeated";
  join.AddForce(10, Eigen::Vector3d(0.0, 0.0, 2.0));
  join.AddForce(20, Eigen::Vector3d(0.0, 0.0, 4.0));
  join.AddRate(15, Eigen::Vector3d(3.0, 0.0, 0.0));
  EXPECT_THAT(join.Take(),
              ElementsAre(ImuSample{15, Eigen::Vector3d(3.0, 0.0, 0.0), Eigen::Vector3d(0.0, 0.0, 3.0)}));
}

}  // namespace
}  // namespace plslam

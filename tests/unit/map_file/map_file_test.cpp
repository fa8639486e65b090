// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/maps/map_file.h"

#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "tests/support/feature_world.h"
#include "tests/unit/map_file/stored_maps.h"

namespace plslam {
namespace {

using test::RandomStoredMap;
using testing::HasSubstr;

std::string ErrorOf(const std::function<void()>& f) {
  try {
    f();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

std::string DecodeError(const std::vector<uint8_t>& bytes) {
  return ErrorOf([&] { DecodeMap(bytes); });
}

std::string EncodeError(const StoredMap& stored) {
  return ErrorOf([&] { EncodeMap(stored); });
}

/// Removed at the end of the scope.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name)
      : path_(std::filesystem::path(testing::TempDir()) / (std::to_string(::getpid()) + name)) {}
  ~TemporaryFile() { std::filesystem::remove(path_); }
  std::string path() const { return path_.string(); }
  void Write(const std::vector<uint8_t>& bytes) const {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  std::vector<uint8_t> Read() const {
    std::ifstream in(path_, std::ios::binary);
    return std::vector<uint8_t>((std::istreambuf_iterator<char>(in)), {});
  }

 private:
  std::filesystem::path path_;
};

bool SameBits(const SE3& a, const SE3& b) {
  const auto same = [](double x, double y) { return std::bit_cast<uint64_t>(x) == std::bit_cast<uint64_t>(y); };
  const Eigen::Vector4d& q = a.rotation().coeffs();
  return std::equal(q.begin(), q.end(), b.rotation().coeffs().begin(), same) &&
         std::equal(a.translation().begin(), a.translation().end(), b.translation().begin(), same);
}

void ExpectSameGraphs(const Map& a, const Map& b) {
  EXPECT_EQ(a.Totals(), b.Totals());
  for (const auto& [id, keyframe] : a.keyframes()) {
    ASSERT_NE(b.FindKeyframe(id), nullptr) << id;
    EXPECT_TRUE(SameBits(keyframe.T_w_kf, b.FindKeyframe(id)->T_w_kf)) << id;
    EXPECT_EQ(a.Neighbours(id, 1), b.Neighbours(id, 1)) << id;
    EXPECT_EQ(a.Children(id), b.Children(id)) << id;
    // Features beyond the end have no landmark.
    auto points_a = a.LandmarksOf(id).points;
    auto points_b = b.LandmarksOf(id).points;
    points_a.resize(100, -1);
    points_b.resize(100, -1);
    EXPECT_EQ(points_a, points_b) << id;
  }
}

TEST(MapFile, RoundTripGivesTheSameMapAndBytes) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const StoredMap stored = seed % 2 == 0 ? RandomStoredMap(seed, 400) : test::OfTwoCameras(seed, 400);
    const std::vector<uint8_t> bytes = EncodeMap(stored);
    StoredMap loaded = DecodeMap(bytes);
    ExpectSameGraphs(stored.map, loaded.map);
    EXPECT_EQ(loaded.rig, stored.rig);
    EXPECT_EQ(loaded.sessions, stored.sessions);
    EXPECT_EQ(loaded.features.size(), stored.features.size());
    for (const auto& [id, features] : stored.features) EXPECT_EQ(loaded.features.at(id).image, features.image) << id;
    EXPECT_EQ(loaded.map.loops().size(), stored.map.loops().size());
    EXPECT_TRUE(loaded.map.TakeChanges().empty());
    EXPECT_EQ(EncodeMap(loaded), bytes) << "seed " << seed;
  }
}

TEST(MapFile, AnEmptyMap) {
  const std::vector<uint8_t> bytes = EncodeMap({});
  const StoredMap loaded = DecodeMap(bytes);
  EXPECT_EQ(loaded.map.Totals(), MapTotals());
  EXPECT_EQ(EncodeMap(loaded), bytes);
}

TEST(MapFile, FilesHoldTheSameBytes) {
  const TemporaryFile file("map.plmap");
  const StoredMap stored = RandomStoredMap(3, 200);
  WriteMapFile(file.path(), stored);
  EXPECT_EQ(file.Read(), EncodeMap(stored));
  EXPECT_EQ(EncodeMap(ReadMapFile(file.path())), file.Read());
  EXPECT_FALSE(std::filesystem::exists(file.path() + ".part"));
}

TEST(MapFile, MapWithoutKeyframesDoesNotReplaceAnother) {
  const TemporaryFile file("map.plmap");
  WriteMapFile(file.path(), RandomStoredMap(3, 20));
  const std::vector<uint8_t> bytes = file.Read();
  EXPECT_THAT(ErrorOf([&] { WriteMapFile(file.path(), {}); }), HasSubstr("is not written: the map has no keyframes"));
  EXPECT_EQ(file.Read(), bytes);
}

TEST(MapFile, NearlyUnitQuaternionsKeepTheirBits) {
  StoredMap stored;
  MapKeyframe keyframe;
  keyframe.name.number = 0;
  keyframe.frame_id = FrameId(0);
  keyframe.id = KeyframeId(keyframe.name.number);
  keyframe.T_w_kf = SE3::FromUnit(Eigen::Quaterniond(0.6 + 1e-16, 0.0, -0.8, 1e-17), {0.1, -0.0, 1e-300});
  stored.map.Put(keyframe);
  stored.next_keyframe_id = 1;
  const StoredMap loaded = DecodeMap(EncodeMap(stored));
  EXPECT_TRUE(SameBits(loaded.map.keyframes().at(0).T_w_kf, keyframe.T_w_kf));
}

TEST(MapFile, EveryTruncationIsRefused) {
  const std::vector<uint8_t> bytes = EncodeMap(RandomStoredMap(5, 30));
  const size_t step = std::max<size_t>(1, bytes.size() / 300);
  for (size_t n = 0; n < bytes.size(); n += n < 100 ? 1 : step) {
    const std::string error = DecodeError({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n)});
    EXPECT_THAT(error,
                testing::AnyOf(HasSubstr("is not a map file (too short)"), HasSubstr("was truncated or damaged")))
        << n;
  }
  std::vector<uint8_t> longer = bytes;
  longer.push_back(0);
  EXPECT_THAT(DecodeError(longer), HasSubstr("was truncated or damaged"));
}

TEST(MapFile, EveryFlippedBitIsSeen) {
  const std::vector<uint8_t> bytes = EncodeMap(RandomStoredMap(6, 10));
  for (size_t i = 0; i < bytes.size(); i += i < 100 ? 1 : 97) {
    std::vector<uint8_t> flipped = bytes;
    flipped[i] ^= static_cast<uint8_t>(1U << (i % 8));
    EXPECT_NE(DecodeError(flipped), "no error") << i;
  }
}

TEST(MapFile, ForeignAndNewerFilesAreRefusedByName) {
  const TemporaryFile file("foreign.plmap");
  const auto read = [&] { return ErrorOf([&] { ReadMapFile(file.path()); }); };
  EXPECT_THAT(read(), HasSubstr("foreign.plmap: cannot be read: No such file or directory"));
  file.Write({});
  EXPECT_THAT(read(), HasSubstr("foreign.plmap: is not a map file (too short)"));
  file.Write(std::vector<uint8_t>(1000, 'x'));
  EXPECT_THAT(read(), HasSubstr("foreign.plmap: is not a map file"));
  std::vector<uint8_t> bytes = EncodeMap(RandomStoredMap(6, 10));
  bytes[8] = 9;
  test::Sign(bytes);
  file.Write(bytes);
  EXPECT_THAT(read(), HasSubstr("foreign.plmap: is a map file of format 9, but this program reads formats 1 to 3"));
  EXPECT_THAT(ErrorOf([] { ReadMapFile(testing::TempDir()); }), HasSubstr("cannot be"));
}

StoredMap WithoutVerticals(StoredMap stored) {
  const auto keyframes = stored.map.keyframes();
  for (const auto& [id, keyframe] : keyframes) {
    MapKeyframe blind = keyframe;
    blind.up.reset();
    stored.map.Put(blind);
  }
  return stored;
}

TEST(MapFile, LowestFormatThatHoldsTheMap) {
  EXPECT_EQ(EncodeMap(WithoutVerticals(RandomStoredMap(6, 10)))[8], 1) << "older programs read it";
  EXPECT_EQ(EncodeMap(WithoutVerticals(test::OfTwoCameras(6, 30)))[8], 2);
  EXPECT_EQ(EncodeMap(RandomStoredMap(6, 10))[8], 3);
}

TEST(MapFile, VerticalsAreKept) {
  const StoredMap stored = RandomStoredMap(6, 100);
  const StoredMap again = DecodeMap(EncodeMap(stored));
  int n = 0;
  for (const auto& [id, keyframe] : stored.map.keyframes()) {
    const auto& up = again.map.FindKeyframe(id)->up;
    ASSERT_EQ(up.has_value(), keyframe.up.has_value()) << id;
    if (!up) continue;
    ++n;
    EXPECT_EQ(up->direction, keyframe.up->direction) << id;
    EXPECT_EQ(up->sigma_rad, keyframe.up->sigma_rad) << id;
  }
  EXPECT_GT(n, 0);
  StoredMap bad = stored;
  MapKeyframe keyframe = bad.map.keyframes().begin()->second;
  keyframe.up = UpDirection{Eigen::Vector3d(0.0, 2.0, 0.0), 0.1};
  bad.map.Put(keyframe);
  EXPECT_THAT(EncodeError(bad), HasSubstr("is not a unit vector with a positive sigma"));
}

TEST(MapFile, LengthBeyondTheFileIsRefused) {
  std::vector<uint8_t> bytes = EncodeMap({});
  // The number of bytes of the rig.
  const uint64_t huge = std::numeric_limits<uint64_t>::max() / 2;
  std::memcpy(bytes.data() + 56 + 8, &huge, 8);
  test::Sign(bytes);
  EXPECT_THAT(DecodeError(bytes), HasSubstr("is shorter than it states"));
}

TEST(MapFile, MapsThatCouldNotBeLoadedAreNotSaved) {
  const StoredMap good = RandomStoredMap(7, 200);
  const KeyframeId some_keyframe = good.map.keyframes().begin()->first;
  StoredMap bad = good;
  bad.next_keyframe_id = 0;
  EXPECT_THAT(EncodeError(bad), HasSubstr("the next keyframe would be 0"));
  bad = good;
  bad.features.clear();
  EXPECT_THAT(EncodeError(bad), HasSubstr("which has 0"));
  bad = good;
  bad.features[bad.next_keyframe_id];
  EXPECT_THAT(EncodeError(bad), HasSubstr("which is not in the map"));
  bad = good;
  test::ChangeFeatures(bad.features, some_keyframe, [](StereoFeatures& of) {
    of.points[0].left.px.x() = std::numeric_limits<double>::quiet_NaN();
  });
  EXPECT_THAT(EncodeError(bad), HasSubstr("has a feature with invalid values"));
  bad = good;
  bad.features.at(some_keyframe).image = TakenImage{0, 0, 0, 480, 400.0};
  EXPECT_THAT(EncodeError(bad),
              HasSubstr("is invalid: 0 x 480 px from (0, 0) on, taken with a focal length of 400 px"));
  bad = good;
  bad.map.SetPose(some_keyframe, SE3::FromUnit(Eigen::Quaterniond(1.1, 0.0, 0.0, 0.0), {0.0, 0.0, 0.0}),
                  Matrix6d::Zero());
  EXPECT_THAT(EncodeError(bad), HasSubstr("whose rotation is not unit"));
  bad = good;
  bad.map.SetPose(some_keyframe, SE3(), -Matrix6d::Identity());
  EXPECT_THAT(EncodeError(bad), HasSubstr("invalid covariance"));
  bad = good;
  bad.map.SetPosition(bad.map.points().begin()->first, {0.0, std::numeric_limits<double>::infinity(), 0.0},
                      Eigen::Matrix3d::Zero());
  EXPECT_THAT(EncodeError(bad), HasSubstr("has invalid values"));
  bad = good;
  bad.sessions[3].keyframe_id = 1 << 30;
  EXPECT_THAT(EncodeError(bad), HasSubstr("session 3 ends with keyframe 1073741824"));
  bad = good;
  bad.sessions[bad.newest_session].keyframe_id = -1;
  EXPECT_THAT(EncodeError(bad), HasSubstr("ends with keyframe -1"));
  bad = good;
  bad.sessions[SessionId(bad.newest_session.value + 1)].keyframe_id = some_keyframe;
  EXPECT_THAT(EncodeError(bad), HasSubstr("which is not in the map or not of this session"));
  bad = good;
  LoopEdge loop;
  loop.old_keyframe_id = loop.keyframe_id = some_keyframe;
  bad.map.Add(loop);
  EXPECT_THAT(EncodeError(bad), HasSubstr("has invalid values"));
}

TEST(MapFile, MissingFoldersAreNamed) {
  EXPECT_THAT(ErrorOf([] { WriteMapFile("/no/such/folder/a.plmap", {}); }), HasSubstr("/no/such/folder/a.plmap"));
}

}  // namespace
}  // namespace plslam

// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/sealed_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/files/archive.h"

namespace plslam {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// With private fields, listed once.
class Trace {
 public:
  Trace() = default;
  Trace(int64_t id, SE3 pose) : id_(id), pose_(std::move(pose)) {}
  bool operator==(const Trace& other) const {
    return id_ == other.id_ && pose_.translation() == other.pose_.translation() &&
           pose_.rotation().coeffs() == other.pose_.rotation().coeffs();
  }
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.id_, self.pose_);
  }

 private:
  int64_t id_ = 0;
  SE3 pose_;
};

struct Things {
  std::vector<Trace> traces;
  std::deque<std::pair<int64_t, float>> pairs;
  std::map<int64_t, std::vector<uint8_t>> bytes;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  bool flag = false;
  std::string text;
  std::optional<Trace> present;
  std::optional<std::string> absent;

  bool operator==(const Things&) const = default;
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.traces, self.pairs, self.bytes, self.matrix, self.flag, self.text, self.present, self.absent);
  }
};

Things SomeThings() {
  Things things;
  const SE3 pose = SE3::Exp((Vector6d() << 1.0, -2.0, 3.0, 0.1, 0.2, -0.3).finished());
  things.traces = {{7, pose}, {8, pose * pose}};
  things.pairs = {{1, 0.5F}, {2, -0.25F}};
  things.bytes = {{-3, {}}, {5, {1, 2, 255}}};
  things.matrix = Eigen::Matrix3d::Constant(1.0 / 3.0);
  things.flag = true;
  things.text = "two words";
  things.present = Trace(9, pose);
  return things;
}

TEST(Archive, ValuesSurviveTheRoundTripBitForBit) {
  const Things things = SomeThings();
  const std::vector<uint8_t> bytes = archive::ToBytes(things);
  Things back;
  archive::FromBytes(bytes, back);
  EXPECT_EQ(back, things);
  EXPECT_EQ(archive::ToBytes(back), bytes);
}

TEST(Archive, OptionalsReplaceWhatWasThere) {
  std::optional<int32_t> value = 7;
  archive::FromBytes(archive::ToBytes(std::optional<int32_t>()), value);
  EXPECT_EQ(value, std::nullopt);
  const std::vector<uint8_t> bytes = archive::ToBytes(std::optional<int32_t>(5));
  EXPECT_EQ(bytes, (std::vector<uint8_t>{1, 5, 0, 0, 0}));
  archive::FromBytes(bytes, value);
  EXPECT_EQ(value, 5);
  EXPECT_THROW(archive::FromBytes(std::vector<uint8_t>{2, 5, 0, 0, 0}, value), std::runtime_error);
}

TEST(Archive, TruncatedOverlongAndOversizedBytesThrow) {
  const std::vector<uint8_t> bytes = archive::ToBytes(SomeThings());
  for (size_t n = 0; n < bytes.size(); ++n) {
    Things back;
    EXPECT_THROW(archive::FromBytes(std::span(bytes).first(n), back), std::runtime_error) << n;
  }
  std::vector<uint8_t> more = bytes;
  more.push_back(0);
  Things back;
  EXPECT_THROW(archive::FromBytes(more, back), std::runtime_error);
  const std::vector<uint8_t> promise = archive::ToBytes(uint64_t{1} << 60);
  std::vector<Trace> many;
  EXPECT_THROW(archive::FromBytes(promise, many), std::runtime_error);
}

class SealedFile : public testing::TestWithParam<Checksum> {
 protected:
  void TearDown() override { std::filesystem::remove(Path()); }
  static std::string Path() { return testing::TempDir() + "sealed_file_" + std::to_string(getpid()); }
  static void Overwrite(size_t place, char value) {
    std::fstream file(Path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(place));
    file.put(value);
  }
  auto Reading() const {
    return [this] { ReadSealedFile(Path(), kind_); };
  }

  const FileKind kind_{{'P', 'L', 'S', 'L', 'T', 'E', 'S', 'T'}, 3, "test file", GetParam()};
  const std::vector<uint8_t> content_{1, 2, 3, 4, 5};
};

TEST_P(SealedFile, RoundTrip) {
  WriteSealedFile(Path(), kind_, content_);
  EXPECT_EQ(ReadSealedFile(Path(), kind_), content_);
  WriteSealedFile(Path(), kind_, {});
  EXPECT_TRUE(ReadSealedFile(Path(), kind_).empty());
}

TEST_P(SealedFile, MissingForeignTruncatedOrDamagedFiles) {
  EXPECT_THAT(Reading(),
              ThrowsMessage<std::runtime_error>(HasSubstr(Path() + ": cannot be read: No such file or directory")));
  WriteSealedFile(Path(), kind_, content_);
  EXPECT_THAT(
      [&] {
        ReadSealedFile(Path(), {{'O', 'T', 'H', 'E', 'R'}, 3, "map"});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("is not a map")));
  EXPECT_THAT(
      [&] {
        ReadSealedFile(Path(), {kind_.magic, 4, "test file"});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("is a test file of format 3, but this program reads format 4")));
  Overwrite(sizeof(Seal) + 2, 'x');
  EXPECT_THAT(Reading(), ThrowsMessage<std::runtime_error>(HasSubstr("its checksum is wrong")));
  std::filesystem::resize_file(Path(), sizeof(Seal) + 3);
  EXPECT_THAT(Reading(), ThrowsMessage<std::runtime_error>(HasSubstr("has 3 bytes of content instead of 5")));
  std::filesystem::resize_file(Path(), 10);
  EXPECT_THAT(Reading(), ThrowsMessage<std::runtime_error>(HasSubstr("too short")));
}

TEST_P(SealedFile, FolderIsRefused) {
  std::filesystem::create_directory(Path());
  EXPECT_THAT(Reading(), ThrowsMessage<std::runtime_error>(HasSubstr("is a folder, not a file")));
}

INSTANTIATE_TEST_SUITE_P(Checksums, SealedFile, testing::Values(Checksum::kBlake2b, Checksum::kPoly1305),
                         [](const auto& of) { return of.param == Checksum::kBlake2b ? "Blake2b" : "Poly1305"; });

}  // namespace
}  // namespace plslam

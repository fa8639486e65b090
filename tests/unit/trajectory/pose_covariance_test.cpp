// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectories/pose_covariance.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/text_file.h"

namespace plslam {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

PoseCovariance SomeCovariance(int64_t t_ns) {
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = 1e-3 * ((7 * i) % 11 - 4.7);
  return {t_ns, A * A.transpose()};
}

std::string Row(const std::string& t, double diagonal, double corner) {
  std::string text = t;
  for (int i = 0; i < 36; ++i) text += fmt::format(" {}", i % 7 == 0 ? diagonal : (i == 1 ? corner : 0.0));
  return text + "\n";
}

TEST(PoseCovariance, ReadsTheBitsThatWereWritten) {
  const ScratchFolder folder;
  const std::vector<PoseCovariance> written{SomeCovariance(1), SomeCovariance(1403636579763555584)};
  WritePoseCovariances(folder.Path("c.txt"), written);
  const std::vector<PoseCovariance> read = ReadPoseCovariances(folder.Path("c.txt"));
  ASSERT_EQ(read.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read[i].t_ns, written[i].t_ns);
    EXPECT_EQ(read[i].covariance, written[i].covariance);
  }
}

TEST(PoseCovariance, ErrorsNameFileLineAndValue) {
  const ScratchFolder folder;
  const auto message = [&](const std::string& content) -> std::string {
    try {
      ReadPoseCovariances(folder.Write("c.txt", content));
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(message(Row("1.0", 1.0, 0.0)), "");
  EXPECT_THAT(message("1 2 3\n"), HasSubstr("c.txt:1: 3 numbers"));
  EXPECT_THAT(message(Row("1.0", -1.0, 0.0)), HasSubstr("c.txt:1: the covariance has the negative variance -1"));
  EXPECT_THAT(message(Row("1.0", 1.0, 0.5)), HasSubstr("not symmetric (off by 0.5)"));
  EXPECT_THAT(message(Row("1.0", 1.0, 0.0) + Row("1.0", 1.0, 0.0)), HasSubstr("c.txt:2: time 1.0 s"));
}

}  // namespace
}  // namespace plslam

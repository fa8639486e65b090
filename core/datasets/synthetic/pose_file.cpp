// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/datasets/dataset.h"
#include "core/datasets/synthetic/motion.h"
#include "core/errors/error_text.h"
#include "core/files/dataset_error.h"

namespace plslam::synthetic {
namespace {

constexpr size_t kMaxPoses = 1000000;

struct Line {
  const std::string& path;
  int number;
  [[noreturn]] void Fail(const std::string& reason) const {
    throw DatasetError(path + ":" + std::to_string(number) + ": " + reason);
  }
};

std::vector<double> Numbers(const Line& line, const std::string& text) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* end = at + text.size();
  while (true) {
    while (at != end && (*at == ' ' || *at == '\t' || *at == '\r')) {
      ++at;
    }
    if (at == end) {
      return numbers;
    }
    double value = 0.0;
    const auto [stop, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) {
      const char* token_end = std::find_if(at, end, [](char c) { return c == ' ' || c == '\t'; });
      line.Fail(fmt::format("'{}' is not a finite number", Shown({at, static_cast<size_t>(token_end - at)})));
    }
    numbers.push_back(value);
    at = stop;
  }
}

SE3 PoseOfTum(const Line& line, const std::vector<double>& n) {
  const Eigen::Quaterniond q(n[7], n[4], n[5], n[6]);
  if (std::abs(q.norm() - 1.0) > 0.01) {
    line.Fail("the quaternion has length " + std::to_string(q.norm()) + ", not 1");
  }
  return {q, Eigen::Vector3d(n[1], n[2], n[3])};
}

SE3 PoseOfKitti(const Line& line, const std::vector<double>& n) {
  Eigen::Matrix3d R;
  R << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > 0.01 || R.determinant() < 0.0) {
    line.Fail("the first three columns are not a rotation");
  }
  return {R, Eigen::Vector3d(n[3], n[7], n[11])};
}

void AddPose(const Line& line, const std::vector<double>& numbers, size_t columns, FilePoses& out) {
  if (numbers.size() != columns || (columns != 8 && columns != 12)) {
    line.Fail("has " + std::to_string(numbers.size()) +
              " numbers; a pose has 8 (TUM) or 12 (KITTI), the same number on every line");
  }
  if (out.T_w_c.size() >= kMaxPoses) {
    line.Fail("more than " + std::to_string(kMaxPoses) + " poses");
  }
  const SE3 pose = columns == 8 ? PoseOfTum(line, numbers) : PoseOfKitti(line, numbers);
  if (pose.translation().cwiseAbs().maxCoeff() > 1e5) {
    line.Fail("a position more than 100 km from the origin");
  }
  out.T_w_c.push_back(pose);
  if (columns == 8) {
    if (std::abs(numbers[0]) > 9e9) {
      line.Fail("the time " + std::to_string(numbers[0]) + " s cannot be represented in nanoseconds");
    }
    const auto t_ns = static_cast<int64_t>(std::floor(numbers[0] * 1e9 + 0.5));
    if (!out.t_ns.empty() && t_ns <= out.t_ns.back()) {
      line.Fail("the time does not increase");
    }
    out.t_ns.push_back(t_ns);
  }
}

}  // namespace

FilePoses ReadPoses(const std::string& path) {
  std::ifstream file = AsDatasetError([&] { return OpenInput(path); });
  FilePoses poses;
  size_t columns = 0;
  std::string text;
  for (int number = 1; std::getline(file, text); ++number) {
    const Line line{path, number};
    if (text.empty() || text[0] == '#' || text[0] == '\r') {
      continue;
    }
    const std::vector<double> numbers = Numbers(line, text);
    if (numbers.empty()) {
      continue;
    }
    columns = columns == 0 ? numbers.size() : columns;
    AddPose(line, numbers, columns, poses);
  }
  if (poses.T_w_c.empty()) {
    throw DatasetError(path + ": the trajectory file contains no pose");
  }
  return poses;
}

}  // namespace plslam::synthetic

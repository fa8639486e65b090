// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectories/pose_covariance.h"

#include <fmt/format.h>

#include <iterator>

#include "core/files/atomic_file.h"
#include "core/files/text_rows.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {
namespace {

PoseCovariance ParseRow(const TextRow& row) {
  if (row.fields.size() != 37) {
    row.Fail(fmt::format("{} numbers, but a row of a covariance file has a time and 36", row.fields.size()));
  }
  PoseCovariance result;
  result.t_ns = row.Scaled(0, 9);
  for (int i = 0; i < 36; ++i) result.covariance(i / 6, i % 6) = row.Number(static_cast<size_t>(i) + 1);
  const double asymmetry = (result.covariance - result.covariance.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > 1e-6 * result.covariance.cwiseAbs().maxCoeff()) {
    row.Fail(fmt::format("the covariance is not symmetric (off by {:.3g})", asymmetry));
  }
  const double smallest = result.covariance.diagonal().minCoeff();
  if (smallest < 0.0) row.Fail(fmt::format("the covariance has the negative variance {:.6g}", smallest));
  return result;
}

}  // namespace

std::vector<PoseCovariance> ReadPoseCovariances(const std::string& path) {
  std::vector<PoseCovariance> covariances;
  ForEachRow(path, [&](const TextRow& row) {
    const PoseCovariance covariance = ParseRow(row);
    if (!covariances.empty() && covariance.t_ns <= covariances.back().t_ns) {
      row.Fail(fmt::format("time {} s is not after the previous one", row.fields[0]));
    }
    covariances.push_back(covariance);
  });
  return covariances;
}

PoseCovarianceWriter::PoseCovarianceWriter(const std::string& path) : file_(path) {
  file_.Append("# t [s], covariance of [translation_m; rotation_rad] (6x6, row by row), T_true = T * Exp(x)\n");
}

void PoseCovarianceWriter::Add(const PoseCovariance& row) {
  std::string text = SecondsText(row.t_ns);
  for (int i = 0; i < 36; ++i) fmt::format_to(std::back_inserter(text), " {}", row.covariance(i / 6, i % 6));
  text += '\n';
  file_.Append(text);
}

void WritePoseCovariances(const std::string& path, const std::vector<PoseCovariance>& covariances) {
  PoseCovarianceWriter writer(path);
  for (const PoseCovariance& row : covariances) writer.Add(row);
  writer.PutInPlace();
}

}  // namespace plslam

#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

namespace plslam {

/// Compares `trajectory.tum` with `groundtruth.tum` in a folder of outputs: errors by name, as `evaluate` gives them.
/// Nothing where there is no ground truth.
std::optional<nlohmann::json> EvaluateRunFiles(const std::filesystem::path& out, int64_t n_frames);

/// Absolute error of `trajectory_live.tum`, in metres. Nothing where there is no such file or no ground truth.
std::optional<double> LiveError_m(const std::filesystem::path& out);

/// Writes `summary.json` (beside it first, then renamed). Throws std::runtime_error where that fails.
void WriteSummary(const std::filesystem::path& out, const nlohmann::json& summary);

}  // namespace plslam

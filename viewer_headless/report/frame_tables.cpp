// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/frame_tables.h"

#include <algorithm>
#include <map>

namespace plslam::viewer {
namespace {

/// Odometry's path in the map's frame as it was when each session began.
class OdometryPath {
 public:
  Eigen::Vector3d operator()(const FrameRecord& frame) {
    const auto first = T_w_odom_.try_emplace(frame.session, frame.T_w_odom).first;
    return first->second * frame.T_odom_c.translation();
  }

 private:
  std::map<SessionId, SE3> T_w_odom_;
};

/// Columns under construction.
struct FrameColumns {
  std::vector<int32_t> id, points, lines, tracked_points, tracked_lines;
  std::vector<float> t_s, entropy_ratio, live, odom, stages_ms;
  std::vector<uint8_t> session, state, keyframe;

  void Add(FrameId frame_id, const FrameRecord& frame, size_t n_stages) {
    id.push_back(Clamp32(frame_id.value));
    points.push_back(frame.counts.points);
    lines.push_back(frame.counts.lines);
    tracked_points.push_back(frame.counts.tracked_points);
    tracked_lines.push_back(frame.counts.tracked_lines);
    entropy_ratio.push_back(frame.entropy_ratio);
    state.push_back(static_cast<uint8_t>(frame.state));
    keyframe.push_back(frame.keyframe_id >= 0 ? 1 : 0);
    Append((frame.T_w_odom * frame.T_odom_c).translation(), live);
    AppendRow(frame.stages_ms, n_stages, stages_ms);
  }

  Table Take(size_t n_stages) {
    return {{"id", 1, std::move(id)},
            {"t_s", 1, std::move(t_s)},
            {"session", 1, std::move(session)},
            {"state", 1, std::move(state)},
            {"keyframe", 1, std::move(keyframe)},
            {"points", 1, std::move(points)},
            {"lines", 1, std::move(lines)},
            {"tracked_points", 1, std::move(tracked_points)},
            {"tracked_lines", 1, std::move(tracked_lines)},
            {"entropy_ratio", 1, std::move(entropy_ratio)},
            {"live", 3, std::move(live)},
            {"odom", 3, std::move(odom)},
            {"stages_ms", std::max(1, static_cast<int>(n_stages)), std::move(stages_ms)}};
  }
};

}  // namespace

int64_t FrameStride(const Recorder& recorder) {
  int64_t stride = 1;
  const auto n = static_cast<int64_t>(recorder.frames().size());
  while ((n + stride - 1) / stride > static_cast<int64_t>(kMaxReportFrames)) stride *= 2;
  return stride;
}

Table FrameTable(const Recorder& recorder, int64_t stride, int64_t first_row) {
  FrameColumns columns;
  OdometryPath odometry;
  std::map<SessionId, uint8_t> sessions;
  const size_t n_stages = recorder.stage_names().size();
  const int64_t began_ns = recorder.frames().empty() ? 0 : recorder.frames().First().second.t_ns;
  int64_t i = 0;
  for (const auto& [frame_id, frame] : recorder.frames()) {
    const Eigen::Vector3d p_odom = odometry(frame);
    const uint8_t session = sessions.try_emplace(frame.session, static_cast<uint8_t>(sessions.size())).first->second;
    const int64_t at = i++;
    if (at % stride != 0 || at / stride < first_row) continue;
    columns.Add(FrameId(frame_id), frame, n_stages);
    columns.t_s.push_back(static_cast<float>(1e-9 * static_cast<double>(frame.t_ns - began_ns)));
    columns.session.push_back(session);
    Append(p_odom, columns.odom);
  }
  return columns.Take(n_stages);
}

}  // namespace plslam::viewer

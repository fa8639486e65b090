// SPDX-License-Identifier: BSD-3-Clause
#include "core/ros/ros_messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/files/bytes.h"
#include "core/io/maps/map_ply.h"
#include "core/ros/cdr_writer.h"
#include "core/ros/ros_topics.h"

namespace plslam {
namespace {

constexpr int32_t kLineList = 5;
constexpr double kLineWidth_m = 0.01;
constexpr double kLoopWidth_m = 0.03;
constexpr Colour kLoopColour{220, 40, 40};

void PutTime(CdrWriter& cdr, int64_t t_ns) {
  constexpr int64_t kSecond_ns = 1'000'000'000;
  cdr.Put(static_cast<int32_t>(t_ns / kSecond_ns));
  cdr.Put(static_cast<uint32_t>(t_ns % kSecond_ns));
}

void PutHeader(CdrWriter& cdr, int64_t t_ns, std::string_view frame) {
  PutTime(cdr, t_ns);
  cdr.Put(frame);
}

void Put(CdrWriter& cdr, const Eigen::Vector3d& v) {
  for (const double x : v) cdr.Put(x);
}

void Put(CdrWriter& cdr, const SE3& pose) {
  Put(cdr, pose.translation());
  const Eigen::Quaterniond& q = pose.rotation();
  for (const double x : {q.x(), q.y(), q.z(), q.w()}) cdr.Put(x);
}

void Put(CdrWriter& cdr, const Matrix6d& covariance) {
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) cdr.Put(covariance(row, column));
  }
}

void Put(CdrWriter& cdr, const Colour& colour) {
  for (const uint8_t channel : colour) cdr.Put(static_cast<float>(channel) / 255.0F);
  cdr.Put(1.0F);
}

struct ColouredLine {
  Eigen::Vector3d from, to;
  Colour colour;
};

Eigen::Vector3d Seen(const RosView& view, const Eigen::Vector3d& p_w) {
  return view.T_frame_w ? *view.T_frame_w * p_w : p_w;
}

std::string LineMarker(int64_t t_ns, std::string_view name, const RosView& view, double width_m,
                       const std::vector<ColouredLine>& lines) {
  CdrWriter cdr;
  PutHeader(cdr, t_ns, view.frame);
  cdr.Put(name);
  for (const int32_t value : {0, kLineList, 0}) cdr.Put(value);  // id, type, action: add
  Put(cdr, SE3());
  Put(cdr, Eigen::Vector3d(width_m, 0.0, 0.0));
  Put(cdr, Colour{255, 255, 255});
  cdr.Put(int32_t{0});  // it stays
  cdr.Put(uint32_t{0});
  cdr.Put(false);
  cdr.PutCount(2 * lines.size());
  for (const ColouredLine& line : lines) {
    Put(cdr, Seen(view, line.from));
    Put(cdr, Seen(view, line.to));
  }
  cdr.PutCount(2 * lines.size());
  for (const ColouredLine& line : lines) {
    Put(cdr, line.colour);
    Put(cdr, line.colour);
  }
  cdr.Put("");  // texture: resource, and an image with header, format and bytes
  PutHeader(cdr, 0, "");
  cdr.Put("");
  cdr.PutBytes("");
  cdr.PutCount(0);
  cdr.Put("");  // text
  cdr.Put("");  // mesh: resource, and a file with name and bytes
  cdr.Put("");
  cdr.PutBytes("");
  cdr.Put(false);
  return std::move(cdr).Take();
}

/// ROS has no name for the double sphere: a reader that does not know our name rejects it.
std::string_view RosLensName(std::string_view model) {
  if (model == lens_model::kPinhole || model == lens_model::kRadtan) return "plumb_bob";
  return model == lens_model::kRational ? "rational_polynomial" : model;
}

/// Types of sensor_msgs/PointField, both of four bytes.
enum FieldType : uint8_t { kUint32 = 6, kFloat32 = 7 };

struct CloudField {
  const char* name;
  FieldType type;
};

/// The members of sensor_msgs/PointCloud2 in front of its data, for points in one row.
void PutCloudHead(CdrWriter& cdr, int64_t t_ns, const RosView& view, const std::vector<CloudField>& fields,
                  size_t n_points) {
  constexpr uint32_t kField_bytes = 4;
  const auto point_bytes = static_cast<uint32_t>(kField_bytes * fields.size());
  PutHeader(cdr, t_ns, view.frame);
  cdr.Put(uint32_t{1});
  cdr.Put(static_cast<uint32_t>(n_points));
  cdr.PutCount(fields.size());
  uint32_t offset = 0;
  for (const CloudField& field : fields) {
    cdr.Put(field.name);
    cdr.Put(std::exchange(offset, offset + kField_bytes));
    cdr.Put(static_cast<uint8_t>(field.type));
    cdr.Put(uint32_t{1});
  }
  cdr.Put(false);
  cdr.Put(point_bytes);
  cdr.Put(static_cast<uint32_t>(point_bytes * n_points));
}

/// Bytes of a float that holds no number but a colour: blue, green, red.
void AppendColour(const Colour& colour, std::string& data) {
  for (const uint8_t channel : {colour[2], colour[1], colour[0], uint8_t{0}}) AppendLittleEndian(channel, data);
}

}  // namespace

std::string RosTransforms(int64_t t_ns, const std::vector<RosTransform>& transforms) {
  CdrWriter cdr;
  cdr.PutCount(transforms.size());
  for (const RosTransform& transform : transforms) {
    PutHeader(cdr, t_ns, transform.parent);
    cdr.Put(transform.child);
    Put(cdr, transform.T_parent_child);
  }
  return std::move(cdr).Take();
}

std::string RosOdometryMessage(const RosOdometry& odometry) {
  CdrWriter cdr;
  PutHeader(cdr, odometry.t_ns, odometry.parent);
  cdr.Put(odometry.child);
  Put(cdr, odometry.T_parent_child);
  Put(cdr, odometry.covariance);
  for (const double x : odometry.velocity) cdr.Put(x);
  Put(cdr, odometry.velocity_covariance);
  return std::move(cdr).Take();
}

std::string RosPoseWithCovariance(int64_t t_ns, std::string_view frame, const SE3& pose, const Matrix6d& covariance) {
  CdrWriter cdr;
  PutHeader(cdr, t_ns, frame);
  Put(cdr, pose);
  Put(cdr, covariance);
  return std::move(cdr).Take();
}

std::string RosPath(int64_t t_ns, std::string_view frame, const Trajectory& trajectory) {
  CdrWriter cdr;
  PutHeader(cdr, t_ns, frame);
  cdr.PutCount(trajectory.size());
  for (const TrajectoryPose& pose : trajectory) {
    PutHeader(cdr, pose.t_ns, frame);
    Put(cdr, pose.T_a_b);
  }
  return std::move(cdr).Take();
}

std::string RosPoseArray(int64_t t_ns, std::string_view frame, const Trajectory& trajectory) {
  CdrWriter cdr;
  PutHeader(cdr, t_ns, frame);
  cdr.PutCount(trajectory.size());
  for (const TrajectoryPose& pose : trajectory) Put(cdr, pose.T_a_b);
  return std::move(cdr).Take();
}

std::string RosCompressedImage(int64_t t_ns, const std::string& format, std::string_view file) {
  CdrWriter cdr;
  PutHeader(cdr, t_ns, kRosCamera);
  cdr.Put(std::string_view(format));
  cdr.PutBytes(file);
  return std::move(cdr).Take();
}

std::string RosCameraInfoMessage(int64_t t_ns, const CameraCalibration& camera) {
  CdrWriter cdr;
  PutHeader(cdr, t_ns, kRosCamera);
  cdr.Put(static_cast<uint32_t>(camera.height_px));
  cdr.Put(static_cast<uint32_t>(camera.width_px));
  std::vector<double> distortion = camera.distortion;
  if (camera.model == lens_model::kPinhole || camera.model == lens_model::kRadtan) distortion.resize(5);
  cdr.Put(RosLensName(camera.model));
  cdr.PutCount(distortion.size());
  for (const double value : distortion) cdr.Put(value);
  const double fx = camera.fx_px, fy = camera.fy_px, cx = camera.cx_px, cy = camera.cy_px;
  for (const double value : {fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0}) cdr.Put(value);
  for (const double value : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) cdr.Put(value);
  for (const double value : {fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0}) cdr.Put(value);
  for (int i = 0; i < 6; ++i) cdr.Put(uint32_t{0});  // no binning, the whole image
  cdr.Put(false);
  return std::move(cdr).Take();
}

std::string RosPoints(int64_t t_ns, const Map& map, const RosView& view) {
  CdrWriter cdr;
  PutCloudHead(cdr, t_ns, view,
               {{"x", kFloat32}, {"y", kFloat32}, {"z", kFloat32}, {"rgb", kFloat32}, {"observations", kUint32}},
               map.points().size());
  std::string data;
  const HeightColours colour_of(map);
  for (const auto& [id, point] : map.points()) {
    for (const double value : Seen(view, point.p_w)) AppendLittleEndian(static_cast<float>(value), data);
    AppendColour(colour_of(point.p_w), data);
    AppendLittleEndian(static_cast<uint32_t>(point.observations.size()), data);
  }
  cdr.PutBytes(data);
  cdr.Put(true);
  return std::move(cdr).Take();
}

std::string RosSurfaces(int64_t t_ns, const std::vector<SurfacePoint>& points_w, const RosView& view) {
  CdrWriter cdr;
  PutCloudHead(cdr, t_ns, view,
               {{"x", kFloat32},
                {"y", kFloat32},
                {"z", kFloat32},
                {"rgb", kFloat32},
                {"normal_x", kFloat32},
                {"normal_y", kFloat32},
                {"normal_z", kFloat32}},
               points_w.size());
  std::string data;
  for (const SurfacePoint& point : points_w) {
    const Eigen::Vector3d normal = UnitNormal(point).cast<double>();
    for (const double value : Seen(view, point.p.cast<double>())) AppendLittleEndian(static_cast<float>(value), data);
    AppendColour({point.grey, point.grey, point.grey}, data);
    const Eigen::Vector3d turned = view.T_frame_w ? view.T_frame_w->R() * normal : normal;
    for (const double value : turned) AppendLittleEndian(static_cast<float>(value), data);
  }
  cdr.PutBytes(data);
  cdr.Put(true);
  return std::move(cdr).Take();
}

std::string RosLines(int64_t t_ns, const Map& map, const RosView& view) {
  std::vector<ColouredLine> lines;
  for (const auto& [id, line] : map.lines()) {
    lines.push_back({line.segment_w.p, line.segment_w.q, ObservationsColour(line.observations.size())});
  }
  return LineMarker(t_ns, "lines", view, kLineWidth_m, lines);
}

std::string RosLoops(int64_t t_ns, const Map& map, const RosView& view) {
  std::vector<ColouredLine> lines;
  for (const LoopEdge& loop : map.loops()) {
    const MapKeyframe* const from = map.FindKeyframe(loop.old_keyframe_id);
    const MapKeyframe* const to = map.FindKeyframe(loop.keyframe_id);
    if (from == nullptr || to == nullptr) continue;  // culled since
    lines.push_back({from->T_w_kf.translation(), to->T_w_kf.translation(), kLoopColour});
  }
  return LineMarker(t_ns, "loops", view, kLoopWidth_m, lines);
}

std::string RosOccupancyGrid(int64_t t_ns, const OccupancyGrid& grid, const RosView& view) {
  const SE3 T_frame_level = view.T_frame_w ? *view.T_frame_w * grid.T_w_level : grid.T_w_level;
  const Eigen::Vector3d corner(grid.cell_m * grid.first_column, grid.cell_m * grid.first_row, grid.floor_m);
  CdrWriter cdr;
  PutHeader(cdr, t_ns, view.frame);
  PutTime(cdr, t_ns);
  cdr.Put(static_cast<float>(grid.cell_m));
  cdr.Put(static_cast<uint32_t>(grid.n_columns));
  cdr.Put(static_cast<uint32_t>(grid.n_rows));
  Put(cdr, SE3(T_frame_level.rotation(), T_frame_level * corner));
  std::string cells(grid.cells.size(), '\0');
  std::ranges::transform(grid.cells, cells.begin(), [](uint8_t cell) {
    return static_cast<char>(cell == OccupancyGrid::kUnknown ? -1 : cell == OccupancyGrid::kFree ? 0 : 100);
  });
  cdr.PutBytes(cells);
  return std::move(cdr).Take();
}

std::string RosDiagnosticMessage(const RosDiagnostic& diagnostic) {
  CdrWriter cdr;
  PutHeader(cdr, diagnostic.t_ns, "");
  cdr.PutCount(1);
  cdr.Put(static_cast<uint8_t>(diagnostic.level));
  for (const std::string& text : {diagnostic.name, diagnostic.message, std::string()})
    cdr.Put(std::string_view(text));
  cdr.PutCount(diagnostic.values.size());
  for (const auto& [key, value] : diagnostic.values) {
    cdr.Put(std::string_view(key));
    cdr.Put(std::string_view(value));
  }
  return std::move(cdr).Take();
}

}  // namespace plslam

// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/map_obj.h"

#include <fmt/format.h>

#include <iterator>
#include <map>
#include <vector>

#include "core/io/maps/map_ply.h"

namespace plslam::exports {
namespace {

/// Numbers vertices as the format does, from 1.
class ObjText {
 public:
  void Name(const std::string& object) { fmt::format_to(out_, "o {}\n", object); }

  size_t AddVertex(const Eigen::Vector3d& p_w, const Colour& colour) {
    fmt::format_to(out_, "v {:.6f} {:.6f} {:.6f} {:.3f} {:.3f} {:.3f}\n", p_w.x(), p_w.y(), p_w.z(),
                   colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0);
    return ++n_vertices_;
  }

  void AddElement(char kind, const std::vector<size_t>& vertices) {
    fmt::format_to(out_, "{} {}\n", kind, fmt::join(vertices, " "));
  }

  std::string Take() { return std::move(text_); }

 private:
  std::string text_ = "# points, lines and the path of the keyframes; metres\n";
  std::back_insert_iterator<std::string> out_{text_};
  size_t n_vertices_ = 0;
};

void AddPoints(const Map& map, ObjText& obj) {
  const HeightColours colour_of(map);
  obj.Name("points");
  for (const auto& [id, point] : map.points()) obj.AddElement('p', {obj.AddVertex(point.p_w, colour_of(point.p_w))});
}

void AddLines(const Map& map, ObjText& obj) {
  obj.Name("lines");
  for (const auto& [id, line] : map.lines()) {
    const Colour colour = ObservationsColour(line.observations.size());
    const size_t p = obj.AddVertex(line.segment_w.p, colour);
    obj.AddElement('l', {p, obj.AddVertex(line.segment_w.q, colour)});
  }
}

void AddPaths(const Map& map, ObjText& obj) {
  std::map<SessionId, std::vector<size_t>> ways;
  obj.Name("keyframes");
  for (const auto& [id, keyframe] : map.keyframes()) {
    ways[keyframe.name.session].push_back(obj.AddVertex(keyframe.T_w_kf.translation(), {0, 0, 0}));
  }
  for (const auto& [session, way] : ways) {
    if (way.size() > 1) obj.AddElement('l', way);
  }
}

}  // namespace

std::string MapObj(const Map& map) {
  ObjText obj;
  if (!map.points().empty()) AddPoints(map, obj);
  if (!map.lines().empty()) AddLines(map, obj);
  if (!map.keyframes().empty()) AddPaths(map, obj);
  return obj.Take();
}

}  // namespace plslam::exports

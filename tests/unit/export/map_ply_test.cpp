// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/maps/map_ply.h"

#include <gmock/gmock.h>

#include <cstring>
#include <sstream>

namespace plslam::exports {
namespace {

struct Vertex {
  float p[3];
  uint8_t rgb[3];
  int32_t observations;
};

/// An independent reader for exactly the layout in the header.
struct Ply {
  std::vector<std::string> header;
  std::vector<Vertex> vertices;
  std::vector<std::pair<int32_t, int32_t>> edges;
};

template <class Number>
Number Take(const std::string& bytes, size_t& at) {
  Number number{};
  std::memcpy(&number, bytes.data() + at, sizeof(Number));
  at += sizeof(Number);
  return number;
}

Ply Read(const std::string& bytes) {
  Ply ply;
  size_t at = bytes.find("end_header\n") + std::strlen("end_header\n");
  std::istringstream lines(bytes.substr(0, at));
  size_t n_vertices = 0, n_edges = 0;
  for (std::string line; std::getline(lines, line);) {
    ply.header.push_back(line);
    std::sscanf(line.c_str(), "element vertex %zu", &n_vertices);
    std::sscanf(line.c_str(), "element edge %zu", &n_edges);
  }
  EXPECT_EQ(bytes.size(), at + n_vertices * 19 + n_edges * 8);
  for (size_t i = 0; i < n_vertices; ++i) {
    Vertex& vertex = ply.vertices.emplace_back();
    for (float& value : vertex.p) value = Take<float>(bytes, at);
    for (uint8_t& channel : vertex.rgb) channel = Take<uint8_t>(bytes, at);
    vertex.observations = Take<int32_t>(bytes, at);
  }
  for (size_t i = 0; i < n_edges; ++i) {
    const auto from = Take<int32_t>(bytes, at);
    ply.edges.emplace_back(from, Take<int32_t>(bytes, at));
  }
  return ply;
}

Map SomeMap() {
  Map map;
  for (int i = 0; i < 3; ++i) {
    MapKeyframe keyframe;
    keyframe.id = i;
    keyframe.parent_id = i - 1;
    map.Put(keyframe);
  }
  for (int i = 0; i < 11; ++i) {
    MapPoint point;
    point.id = 2 * i;
    point.p_w = {1.0 + i, -0.5 * i, 3.0};
    point.observations = {{0, i}, {2, i}};
    map.Put(point);
  }
  for (int i = 0; i < 2; ++i) {
    MapLine line;
    line.id = i;
    line.segment_w = {{7.0, 8.0, 9.0 + i}, {-7.0, -8.0, -9.0}};
    line.observations = {{1, i}};
    map.Put(line);
  }
  return map;
}

TEST(MapPly, PointsThenLineEndpointsJoinedByEdges) {
  const Ply ply = Read(MapPly(SomeMap()));
  EXPECT_THAT(ply.header, testing::IsSupersetOf({"ply", "format binary_little_endian 1.0", "element vertex 15",
                                                 "property float x", "property uchar red", "element edge 2",
                                                 "property int vertex1", "property int vertex2"}));
  ASSERT_EQ(ply.vertices.size(), 15U);
  EXPECT_EQ(ply.vertices[3].p[0], 4.0F);
  EXPECT_EQ(ply.vertices[3].p[1], -1.5F);
  EXPECT_EQ(ply.vertices[3].observations, 2);
  EXPECT_EQ(ply.vertices[13].p[2], 10.0F);
  EXPECT_EQ(ply.vertices[13].observations, 1);
  EXPECT_THAT(ply.edges, testing::ElementsAre(testing::Pair(11, 12), testing::Pair(13, 14)));
}

TEST(MapPly, LowPointsAreBlueAndHighPointsRed) {
  const Ply ply = Read(MapPly(SomeMap()));
  EXPECT_THAT(ply.vertices[0].rgb, testing::ElementsAre(0, 0, 255));
  EXPECT_THAT(ply.vertices[10].rgb, testing::ElementsAre(255, 0, 0));
}

TEST(MapPly, EmptyMap) {
  const Ply ply = Read(MapPly(Map()));
  EXPECT_TRUE(ply.vertices.empty());
  EXPECT_TRUE(ply.edges.empty());
}

}  // namespace
}  // namespace plslam::exports

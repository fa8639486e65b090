// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <opencv2/viz.hpp>

#include "dense_process/products.h"
#include "tests/support/shell.h"

namespace plslam::dense {
namespace {

/// Products of two planes, of grey 90 and 200.
Products TwoPlanesOfGrey(double voxel_m) {
  const StereoCamera camera{
      .f_px = 100.0, .cx_px = 40.0, .cy_px = 30.0, .baseline_m = 0.1, .width_px = 80, .height_px = 60};
  DepthImage depth;
  depth.z_m = cv::Mat(60, 80, CV_32F, cv::Scalar(2.0));
  depth.sigma_m = cv::Mat(60, 80, CV_32F, cv::Scalar(0.01));
  DenseMap map(voxel_m, 0.0);
  KeyframePoses poses;
  for (int64_t i = 0; i < 3; ++i) {
    poses[{1, FrameId(i)}] = SE3();
    poses[{2, FrameId(i)}] = SE3(Eigen::Quaterniond::Identity(), {3.0, 0.0, 0.0});
  }
  for (const auto& [name, pose] : poses) {
    const cv::Mat grey(60, 80, CV_8U, cv::Scalar(name.first == SessionId(1) ? 90 : 200));
    EXPECT_TRUE(map.Add(name, depth, grey, camera, poses));
  }
  return MakeProducts(map, poses, Vertical(), {}, 1.0);
}

/// Files of a small map, for readers that other people have written.
class ForeignReaders : public testing::Test {
 protected:
  static constexpr double kVoxel_m = 0.05;

  ForeignReaders() { EXPECT_GT(products_.surface.triangles.size(), 2000U); }

  std::string Write(ProductKind kind, const std::string& name) const {
    WriteProducts(folder_.Path(""), products_, kind);
    return folder_.Path(name);
  }
  static double Distance(const cv::Vec3f& a, const Eigen::Vector3f& b) {
    return (Eigen::Vector3f(a[0], a[1], a[2]) - b).norm();
  }
  /// Compares the vertices that VTK has read.
  void ExpectVertices(const cv::viz::Mesh& mesh) const {
    const Surface& surface = products_.surface;
    ASSERT_EQ(mesh.cloud.total(), surface.vertices.size());
    for (size_t i = 0; i < surface.vertices.size(); i += 17) {
      const auto at = static_cast<int>(i);
      EXPECT_LT(Distance(mesh.cloud.at<cv::Vec3f>(at), surface.vertices[i].p), 1e-4);
    }
  }
  /// Compares its triangles: the number of their corners, and these.
  void ExpectTriangles(const cv::viz::Mesh& mesh) const {
    const Surface& surface = products_.surface;
    // OpenCV adds one element.
    ASSERT_GE(mesh.polygons.total(), 4 * surface.triangles.size());
    ASSERT_LE(mesh.polygons.total(), 4 * surface.triangles.size() + 1);
    for (size_t i = 0; i < surface.triangles.size(); i += 13) {
      const int* const corners = mesh.polygons.ptr<int>() + 4 * i;
      EXPECT_EQ(corners[0], 3);
      for (size_t k = 0; k < 3; ++k) EXPECT_EQ(corners[k + 1], static_cast<int>(surface.triangles[i][k]));
    }
  }

  const ScratchFolder folder_;
  const Products products_ = TwoPlanesOfGrey(kVoxel_m);
};

TEST_F(ForeignReaders, VtkReadsMeshAndCloud) {
  const auto mesh = cv::viz::Mesh::load(Write(ProductKind::kMesh, "mesh.ply"), cv::viz::Mesh::LOAD_PLY);
  ExpectVertices(mesh);
  ExpectTriangles(mesh);
  ASSERT_EQ(mesh.colors.total(), products_.surface.vertices.size());
  for (size_t i = 0; i < products_.surface.vertices.size(); i += 17) {
    const auto colour = mesh.colors.at<cv::Vec3b>(static_cast<int>(i));
    const uint8_t grey = products_.surface.vertices[i].grey;
    EXPECT_EQ(colour, cv::Vec3b(grey, grey, grey));
  }
  ExpectVertices(cv::viz::Mesh::load(Write(ProductKind::kCloud, "cloud.ply"), cv::viz::Mesh::LOAD_PLY));
}

TEST_F(ForeignReaders, VtkReadsTheObj) {
  std::ofstream(folder_.Path("coloured.obj")) << "v 1 2 3 0 0 1\nv 4 5 6 1 0 0\nv 4 5 7 1 0 0\nf 1 2 3\n";
  const auto three = cv::viz::Mesh::load(folder_.Path("coloured.obj"), cv::viz::Mesh::LOAD_OBJ);
  if (three.cloud.total() != 3 || Distance(three.cloud.at<cv::Vec3f>(1), {4.0F, 5.0F, 6.0F}) > 1e-5) {
    GTEST_SKIP() << "this VTK misreads vertices with colours, as 9.3 does";
  }
  const auto mesh = cv::viz::Mesh::load(Write(ProductKind::kMeshObj, "mesh.obj"), cv::viz::Mesh::LOAD_OBJ);
  ExpectVertices(mesh);
  ExpectTriangles(mesh);
}

/// A reader after the description of the format: statements in lines, numbers from 1, colours as MeshLab and Blender
/// have them, after the position.
TEST_F(ForeignReaders, ObjHasGreysNormalsAndTriangles) {
  std::ifstream file(Write(ProductKind::kMeshObj, "mesh.obj"));
  std::vector<std::vector<double>> vertices, normals;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string statement, corner;
    words >> statement;
    if (statement == "v" || statement == "vn") {
      std::vector<double>& numbers = (statement == "v" ? vertices : normals).emplace_back();
      for (double number = 0.0; words >> number;) numbers.push_back(number);
    } else if (statement == "f") {
      std::array<uint32_t, 3> triangle{};
      for (uint32_t& index : triangle) {
        ASSERT_TRUE(words >> corner) << line;
        index = static_cast<uint32_t>(std::stoul(corner)) - 1;
        EXPECT_EQ(corner, std::to_string(index + 1) + "//" + std::to_string(index + 1));
      }
      EXPECT_FALSE(words >> corner) << line;
      triangles.push_back(triangle);
    }
  }
  const Surface& surface = products_.surface;
  ASSERT_EQ(vertices.size(), surface.vertices.size());
  ASSERT_EQ(normals.size(), surface.vertices.size());
  EXPECT_EQ(triangles, surface.triangles);
  int n_bright = 0;
  for (size_t i = 0; i < vertices.size(); ++i) {
    ASSERT_EQ(vertices[i].size(), 6U);
    ASSERT_EQ(normals[i].size(), 3U);
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<size_t>(k);
      EXPECT_NEAR(vertices[i][at], surface.vertices[i].p[k], 1e-4);
      EXPECT_NEAR(normals[i][at], surface.vertices[i].normal[k], 1e-3);
      EXPECT_EQ(std::lround(255.0 * vertices[i][at + 3]), surface.vertices[i].grey);
    }
    n_bright += surface.vertices[i].grey > 150 ? 1 : 0;
  }
  EXPECT_GT(n_bright, 300);
}

TEST_F(ForeignReaders, OctomapToolsReadTheTrees) {
  PLSLAM_REQUIRE_PROGRAM("bt2vrml");
  PLSLAM_REQUIRE_PROGRAM("compare_octrees");
  Write(ProductKind::kOctoMap, "map.bt");
  const auto run = [&](const std::string& line) {
    return plslam::test::Shell(folder_, "cd '" + folder_.Path("") + "' && " + line);
  };
  ASSERT_EQ(run("bt2vrml map.bt").exit_code, 0);
  // Boxes of one voxel, or of eight and more that are all occupied.
  std::istringstream vrml(ReadText(folder_.Path("map.bt.wrl")));
  std::map<std::tuple<int64_t, int64_t, int64_t>, bool> occupied;
  products_.volume.Visit([&](const Volume::Voxel& voxel) {
    if (ContentOf(voxel, kVoxel_m) == Content::kOccupied)
      occupied[{voxel.index.x(), voxel.index.y(), voxel.index.z()}] = false;
  });
  ASSERT_GT(occupied.size(), 2000U);
  int64_t n_voxels = 0;
  std::string word;
  double x = 0.0, y = 0.0, z = 0.0, size = 0.0;
  while (vrml >> word) {
    if (word == "translation") vrml >> x >> y >> z;
    if (word != "size" || !(vrml >> size)) continue;
    const auto n = static_cast<int64_t>(std::lround(size / kVoxel_m));
    const auto first = [&](double centre) { return std::lround((centre - 0.5 * size) / kVoxel_m); };
    for (int64_t i = 0; i < n * n * n; ++i) {
      const auto found = occupied.find({first(x) + i % n, first(y) + i / n % n, first(z) + i / n / n});
      EXPECT_TRUE(found != occupied.end() && !std::exchange(found->second, true)) << x << " " << y << " " << z;
      ++n_voxels;
    }
  }
  EXPECT_EQ(n_voxels, static_cast<int64_t>(occupied.size()));
  ASSERT_EQ(run("convert_octree map.bt converted.ot").exit_code, 0);
  const plslam::test::ShellResult compared = run("compare_octrees map.ot converted.ot");
  EXPECT_EQ(compared.exit_code, 0);
  EXPECT_NE((compared.out + compared.error).find("KLD: 0\n"), std::string::npos) << compared.out << compared.error;
}

}  // namespace
}  // namespace plslam::dense

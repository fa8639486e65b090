// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include <octomap/octomap.h>
#include <opencv2/imgproc.hpp>

#include "dense_process/products.h"
#include "tests/support/data_folder.h"
#include "tests/support/python.h"
#include "tests/support/shell.h"
#include "tests/support/text_file.h"
#include "tests/unit/dense/seen_world.h"

namespace plslam::dense {
namespace {

using test::Quantile;
using test::SeenWorld;

struct World {
  const char* options;
  int step;
  double voxel_m;
  double median_m;
  double most_m;  ///< bound on the error of nine tenths
  double completeness;
  double most_mb;  ///< bound on memory: for 100 m2 of floor, or 1 km of street
  double size;     ///< in these units
};

// The walls of the corridor are blank: they remain unknown.
class BuiltInWorld : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, BuiltInWorld,
                         testing::Values(World{"room", 10, 0.05, 0.015, 0.05, 0.85, 60.0, 0.48},
                                         World{"corridor?frames=300", 10, 0.05, 0.015, 0.05, 0.45, 60.0, 0.24},
                                         World{"street?frames=200", 4, 0.2, 0.06, 0.2, 0.95, 300.0, 0.06}));

TEST_P(BuiltInWorld, SurfacesAreWhereTheyAre) {
  const World& world = GetParam();
  const SeenWorld seen(world.options, world.step, world.voxel_m);
  const std::vector<double> errors = seen.Errors(10.0);
  ASSERT_GT(errors.size(), 1000U);
  const double completeness = seen.Completeness(5.0);
  printf("error: median %.4f, 90 %% %.4f, 99 %% %.4f m; completeness %.3f; error / sigma: 68 %% %.2f\n",
         Quantile(errors, 0.5), Quantile(errors, 0.9), Quantile(errors, 0.99), completeness,
         Quantile(seen.normalised(), 0.68));
  EXPECT_LT(Quantile(errors, 0.5), world.median_m);
  EXPECT_LT(Quantile(errors, 0.9), world.most_m);
  EXPECT_GT(completeness, world.completeness);
  const double doubled = test::DoubledShare(seen.simulator().world(), seen.surface().vertices, world.voxel_m);
  printf("doubled: %.4f\n", doubled);
  EXPECT_LT(doubled, 0.01);
  const double mb = 1e-6 * static_cast<double>(seen.map().bytes()) / world.size;
  printf("memory: %.1f MB for %s, %.1f kB per m3\n", mb, world.most_mb > 100.0 ? "1 km" : "100 m2",
         1e-3 * seen.map().BytesPerCubicMetre());
  EXPECT_LT(mb, world.most_mb);
  EXPECT_GT(Quantile(seen.normalised(), 0.68), 0.5) << "standard deviations are too large";
  EXPECT_LT(Quantile(seen.normalised(), 0.68), 1.5) << "standard deviations are too small";
}

/// Cells of the grid in which the world has an obstacle of the robot's height.
cv::Mat TrueObstacles(const SeenWorld& seen, const Products& products, double robot_height_m) {
  const GroundGrid& grid = products.grid;
  cv::Mat obstacles = cv::Mat::zeros(grid.cells.size(), CV_8UC1);
  const double step_m = 0.3 * grid.cell_m;
  for (const synthetic::Quad& quad : seen.simulator().world().quads()) {
    const int n_s = 1 + static_cast<int>(quad.edge_s.norm() / step_m);
    const int n_t = 1 + static_cast<int>(quad.edge_t.norm() / step_m);
    for (int s = 0; s <= n_s; ++s) {
      for (int t = 0; t <= n_t; ++t) {
        const Eigen::Vector3d p = products.T_level_w * (quad.origin + quad.edge_s * s / n_s + quad.edge_t * t / n_t);
        const double above_m = p.z() - products.floor_m;
        const Eigen::Vector2i cell = grid.CellAt(p.x(), p.y());
        const bool inside = cell.x() >= 0 && cell.y() >= 0 && cell.x() < obstacles.cols && cell.y() < obstacles.rows;
        if (inside && above_m > 0.1 && above_m < robot_height_m) obstacles.at<uint8_t>(cell.y(), cell.x()) = 255;
      }
    }
  }
  return obstacles;
}

class RoomProducts : public testing::Test {
 protected:
  static constexpr double kRobot_m = 1.0;
  static void SetUpTestSuite() {
    seen_ = new SeenWorld("room", 10, 0.05);
    Vertical vertical;
    vertical.up_w = seen_->simulator().world().up();
    products_ = new Products(MakeProducts(seen_->map(), seen_->poses(), vertical, seen_->Path(), kRobot_m));
  }
  static void TearDownTestSuite() {
    delete products_;
    delete seen_;
  }
  static void WriteAll(const std::filesystem::path& folder) {
    for (const auto& [name, kind] : kProductKinds) WriteProducts(folder, *products_, kind);
    WriteFrames(folder, *products_);
  }

  static SeenWorld* seen_;
  static Products* products_;
};
SeenWorld* RoomProducts::seen_ = nullptr;
Products* RoomProducts::products_ = nullptr;

TEST_F(RoomProducts, CellsAgreeWithTheTruePlan) {
  ASSERT_TRUE(products_->has_floor);
  const cv::Mat& cells = products_->grid.cells;
  const cv::Mat obstacles = TrueObstacles(*seen_, *products_, kRobot_m);
  cv::Mat near;
  cv::dilate(obstacles, near, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  int n_free = 0, n_occupied = 0, wrong_free = 0, wrong_occupied = 0;
  for (int y = 0; y < cells.rows; ++y) {
    for (int x = 0; x < cells.cols; ++x) {
      if (cells.at<uint8_t>(y, x) == OccupancyGrid::kFree) {
        ++n_free;
        wrong_free += obstacles.at<uint8_t>(y, x) != 0 ? 1 : 0;
      } else if (cells.at<uint8_t>(y, x) == OccupancyGrid::kOccupied) {
        ++n_occupied;
        wrong_occupied += near.at<uint8_t>(y, x) == 0 ? 1 : 0;
      }
    }
  }
  printf("%d free cells, %d wrong; %d occupied cells, %d wrong\n", n_free, wrong_free, n_occupied, wrong_occupied);
  EXPECT_GT(n_free, 5000);
  EXPECT_GT(n_occupied, 300);
  EXPECT_LT(wrong_free + wrong_occupied, 0.05 * (n_free + n_occupied));
}

TEST_F(RoomProducts, DrivenPathIsFree) {
  for (const Eigen::Vector3d& p : products_->path) {
    const Eigen::Vector2i cell = products_->grid.CellAt(p.x(), p.y());
    EXPECT_EQ(products_->grid.cells.at<uint8_t>(cell.y(), cell.x()), OccupancyGrid::kFree);
  }
  // Not only because they are set: the surfaces have no obstacle there.
  const GroundGrid seen = MakeProducts(seen_->map(), seen_->poses(), products_->vertical, {}, kRobot_m).grid;
  for (const Eigen::Vector3d& p : products_->path) {
    const Eigen::Vector2i cell = seen.CellAt(p.x(), p.y());
    EXPECT_NE(seen.cells.at<uint8_t>(cell.y(), cell.x()), OccupancyGrid::kOccupied) << p.transpose();
  }
}

TEST_F(RoomProducts, FloorIsLevel) {
  // The world's floor is 8 x 6 m.
  const Eigen::Vector3d up_level = products_->T_level_w.rotation() * seen_->simulator().world().up();
  EXPECT_NEAR(up_level.z(), 1.0, 1e-9);
  double lowest = 1e9;
  for (const synthetic::Quad& quad : seen_->simulator().world().quads()) {
    lowest = std::min(lowest, (products_->T_level_w * quad.origin).z());
  }
  EXPECT_NEAR(products_->floor_m, lowest, 0.02);
}

/// The rules of nav2's map_server, from its documentation: row 0 is the largest y, the origin the lower left pixel.
TEST_F(RoomProducts, MapServerReadsTheGrid) {
  const std::filesystem::path folder = testing::TempDir() + "dense_products";
  std::filesystem::create_directories(folder);
  WriteAll(folder);
  const std::string yaml = ReadText(folder / "map.yaml");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(yaml, found, std::regex("origin: \\[([^,]+), ([^,]+), 0.0\\]")));
  const double x0 = std::stod(found[1]), y0 = std::stod(found[2]);
  ASSERT_TRUE(std::regex_search(yaml, found, std::regex("resolution: (\\S+)")));
  const double resolution = std::stod(found[1]);
  EXPECT_NE(yaml.find("free_thresh: 0.196"), std::string::npos);
  const std::string pgm = ReadText(folder / "map.pgm");
  ASSERT_TRUE(std::regex_search(pgm.substr(0, 40), std::regex("^P5\n(\\d+) (\\d+)\n255\n")));
  const int width = products_->grid.cells.cols, height = products_->grid.cells.rows;
  const std::string head = "P5\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
  ASSERT_EQ(pgm.size(), head.size() + static_cast<size_t>(width) * static_cast<size_t>(height));
  int n_path = 0;
  for (const Eigen::Vector3d& p : products_->path) {
    const int column = static_cast<int>(std::floor((p.x() - x0) / resolution));
    const int row = height - 1 - static_cast<int>(std::floor((p.y() - y0) / resolution));
    const auto grey = static_cast<uint8_t>(pgm[head.size() + static_cast<size_t>(row * width + column)]);
    EXPECT_LT((255 - grey) / 255.0, 0.196) << "free";
    ++n_path;
  }
  EXPECT_GT(n_path, 200);
}

TEST_F(RoomProducts, PythonReadsThemAsArrays) {
  const std::string python = plslam::test::PythonWithNumpy();
  if (python.empty()) GTEST_SKIP() << "no Python with numpy here";
  const ScratchFolder folder;
  WriteAll(folder.Path(""));
  folder.Write("program.py", R"py(
import json, plslam
mesh, cloud, grid = plslam.read_surface("mesh.ply"), plslam.read_surface("cloud.ply"), plslam.read_grid(".")
with open("path.csv") as file:
    path = [[float(word) for word in line.split(",")] for line in file if line[0] not in "x#"]
data = open("mesh.ply", "rb").read()
open("short.ply", "wb").write(data[:-1])
try:
    plslam.read_surface("short.ply")
    error = ""
except plslam.FileError as caught:
    error = str(caught)
print(json.dumps({
    "points": len(mesh.position_m), "triangles": len(mesh.triangles), "cloud": cloud.triangles is None,
    "last": mesh.position_m[-1].tolist(), "corner": mesh.triangles[-1].tolist(), "shape": list(grid.cells.shape),
    "occupied": int((grid.cells == grid.OCCUPIED).sum()), "free": int((grid.cells == grid.FREE).sum()),
    "path": len(path), "path_free": sum(grid.cell(x, y) == grid.FREE for x, y in path),
    "outside": grid.cell(1e6, 0.0), "error": error}))
)py");
  const plslam::test::ShellResult result =
      plslam::test::Shell(folder, "cd '" + folder.Path("") + "' && PYTHONDONTWRITEBYTECODE=1 PYTHONPATH='" +
                                      PLSLAM_PYTHON_FOLDER + "' " + python + " program.py");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const auto seen = nlohmann::json::parse(result.out);
  const Surface& surface = products_->surface;
  const cv::Mat& cells = products_->grid.cells;
  EXPECT_EQ(seen["points"], surface.vertices.size());
  EXPECT_EQ(seen["triangles"], surface.triangles.size());
  EXPECT_EQ(seen["cloud"], true);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(seen["last"][i].get<float>(), surface.vertices.back().p[i]);
    EXPECT_EQ(seen["corner"][i], surface.triangles.back()[i]);
  }
  EXPECT_EQ(seen["shape"], (std::vector<int>{cells.rows, cells.cols}));
  EXPECT_EQ(seen["occupied"], cv::countNonZero(cells == 0));
  EXPECT_EQ(seen["free"], cv::countNonZero(cells == 254));
  EXPECT_GT(seen["path"], 200);
  EXPECT_EQ(seen["path_free"], seen["path"]);
  EXPECT_EQ(seen["outside"], -1);
  EXPECT_NE(seen["error"].get<std::string>().find("short.ply: has"), std::string::npos);
}

TEST_F(RoomProducts, OctomapReadsTheTree) {
  const std::filesystem::path folder = testing::TempDir() + "dense_octomap";
  std::filesystem::create_directories(folder);
  WriteAll(folder);
  octomap::OcTree tree(0.1);
  ASSERT_TRUE(tree.readBinary((folder / "map.bt").string()));
  EXPECT_DOUBLE_EQ(tree.getResolution(), 0.05);
  // The camera was in free space, and each ray from it to a surface ends in an occupied voxel or an unknown one.
  const Eigen::Vector3d eye = products_->path.front();
  const octomap::OcTreeNode* node = tree.search(eye.x(), eye.y(), eye.z());
  ASSERT_NE(node, nullptr);
  EXPECT_FALSE(tree.isNodeOccupied(node));
  int n_occupied = 0, n = 0;
  for (size_t i = 0; i < products_->surface.vertices.size(); i += 50) {
    const Eigen::Vector3d p = products_->T_level_w * products_->surface.vertices[i].p.cast<double>();
    const octomap::OcTreeNode* at = tree.search(p.x(), p.y(), p.z());
    ++n;
    n_occupied += at != nullptr && tree.isNodeOccupied(at) ? 1 : 0;
  }
  EXPECT_GT(n_occupied, 0.8 * n);
}

TEST(Floor, NeedsAHorizontalSurface) {
  Surface wall;
  for (int i = 0; i < 5000; ++i)
    wall.vertices.push_back({{0.0F, 0.01F * static_cast<float>(i % 100), 0.0F}, {1.0F, 0.0F, 0.0F}, 0});
  EXPECT_FALSE(Floor(wall, 0.05).found());
}

/// A level of 4 x 4 m, a ramp of 20 %, a second level, and a table.
TEST(Floor, FollowsARampAndLeavesOutATable) {
  Surface ground;
  const auto add = [&](double x, double y, double z, double slope) {
    ground.vertices.push_back(
        {Eigen::Vector3d(x, y, z).cast<float>(), Eigen::Vector3d(-slope, 0.0, 1.0).normalized().cast<float>(), 0});
  };
  const auto height = [](double x) { return x < 4.0 ? 0.0 : x < 9.0 ? 0.2 * (x - 4.0) : 1.0; };
  for (double y = 0.0; y < 4.0; y += 0.05) {
    for (double x = 0.0; x < 14.0; x += 0.05) add(x, y, height(x), x < 4.0 || x >= 9.0 ? 0.0 : 0.2);
    for (double x = 1.0; x < 2.0; x += 0.05) add(x, y, 0.75, 0.0);
  }
  const Floor floor(ground, 0.05);
  ASSERT_TRUE(floor.found());
  EXPECT_NEAR(floor.HeightAt(1.5, 1.0), 0.0, 0.03) << "below the table";
  EXPECT_NEAR(floor.HeightAt(6.5, 1.0), height(6.5), 0.25) << "in steps of two metres";
  EXPECT_NEAR(floor.HeightAt(13.0, 1.0), 1.0, 0.05);
  EXPECT_NEAR(floor.HeightAt(40.0, 1.0), 1.0, 0.05) << "the nearest tile";
}

}  // namespace
}  // namespace plslam::dense

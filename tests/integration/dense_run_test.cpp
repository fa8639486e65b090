// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/bus/channels.h"
#include "core/bus/logs/log_reader.h"
#include "core/bus/messages/submap_channel.h"
#include "core/datasets/synthetic/simulator.h"
#include "core/map/occupancy_grid.h"
#include "plslam/grid_t.hpp"
#include "tests/integration/run_watcher.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/shell.h"
#include "tests/support/text_file.h"
#include "tests/unit/dense/seen_world.h"
#include "tools/export/cloud_file.h"
#include "tools/export/grid_files.h"

namespace plslam {
namespace {

using test::WholeRun;
using testing::HasSubstr;

constexpr const char* kRoom = "synthetic:room?size=376x240&frames=160";

class DenseRun : public testing::Test {
 protected:
  /// Number of occupied cells of the grid.
  static int Occupied(const WholeRun& run) {
    const std::string pgm = run.Read("map.pgm");
    const size_t head = pgm.find("\n255\n") + 5;
    int n = 0;
    for (size_t i = head; i < pgm.size(); ++i) n += pgm[i] == '\0' ? 1 : 0;
    return n;
  }
};

/// Two runs of the room for all tests here: one recorded and saved, the other with surfaces alone.
class SharedDenseRun : public DenseRun {
 protected:
  static const WholeRun& Recorded() {
    if (recorded_ == nullptr) {
      recorded_ = std::make_unique<WholeRun>();
      Run(*recorded_, {"run", kRoom, "--dense", "--strict", "--record", recorded_->log(), "--save-map",
                       (recorded_->out() / "room.plmap").string()});
    }
    return *recorded_;
  }
  static const WholeRun& Alone() {
    if (alone_ == nullptr) Run(*(alone_ = std::make_unique<WholeRun>()), {"run", kRoom, "--dense"});
    return *alone_;
  }
  static void TearDownTestSuite() {
    recorded_.reset();
    alone_.reset();
  }

 private:
  static void Run(WholeRun& run, const std::vector<std::string>& arguments) {
    EXPECT_EQ(run.Run(arguments), 0) << run.Logs();
  }

  static inline std::unique_ptr<WholeRun> recorded_, alone_;
};

TEST_F(SharedDenseRun, SurfacesAndGridAreWritten) {
  const WholeRun& run = Recorded();
  const std::string cloud = run.Read("cloud.ply");
  EXPECT_THAT(cloud.substr(0, 400), HasSubstr("element vertex"));
  EXPECT_GT(cloud.size(), 27U * 3000U);
  for (const char* file : {"mesh.ply", "map.bt", "map.ot", "map_distance.png", "map_height.png", "path.csv"}) {
    EXPECT_FALSE(run.Read(file).empty()) << file;
  }
  EXPECT_THAT(run.Read("map.yaml"), HasSubstr("image: map.pgm"));
  EXPECT_GT(Occupied(run), 100);
  const auto frames = nlohmann::json::parse(run.Read("frames.json"));
  EXPECT_EQ(frames["up_from"], "lines");
  EXPECT_EQ(frames["voxel_m"], 0.05);
  const auto summary = run.Summary();
  EXPECT_EQ(summary["processes"]["dense"]["exit_code"], 0);
  EXPECT_TRUE(summary["warnings"].empty()) << summary["warnings"].dump();
}

TEST_F(SharedDenseRun, GridOnTheBusIsThatOfTheFiles) {
  const WholeRun& run = Recorded();
  const ScratchFolder scratch;
  const test::ShellResult exported =
      test::Shell(scratch, fmt::format("'{}/plslam' export '{}' --format mcap --out '{}'",
                                       test::BinaryFolder().string(), run.out().string(), scratch.Path("mcap")));
  EXPECT_EQ(exported.exit_code, 0) << exported.error;
  EXPECT_THAT(exported.out, HasSubstr(", the grid, the surfaces"));
  const std::optional<OccupancyGrid> written = exports::ReadGridFiles(run.out().string());
  ASSERT_TRUE(written);
  GridTiles tiles;
  int64_t number = 0;
  bus::LogReader log(run.log());
  while (const auto event = log.Next()) {
    grid_t tile;
    if (event->channel != bus::kGrid.name) continue;
    const auto data = log.Data(event->data_offset, event->data_bytes);
    ASSERT_TRUE(data);
    ASSERT_GE(tile.decode(data->data(), 0, static_cast<int>(data->size())), 0);
    if (std::exchange(number, tile.grid) != tile.grid) tiles = {};
    ASSERT_TRUE(tiles.Add({written->T_w_level, tile.floor_m, tile.cell_m, tile.first_column, tile.first_row,
                           tile.n_columns, tile.n_rows, tile.cells}));
  }
  const OccupancyGrid whole = tiles.Whole();
  EXPECT_EQ(whole.cell_m, written->cell_m);
  EXPECT_NEAR(whole.floor_m, written->floor_m, whole.cell_m);
  int n_other = 0;
  for (int row = 0; row < written->n_rows; ++row) {
    for (int column = 0; column < written->n_columns; ++column) {
      const int x = written->first_column + column, y = written->first_row + row;
      n_other += whole.At(x, y) != written->At(x, y) ? 1 : 0;
    }
  }
  EXPECT_EQ(n_other, 0);
}

/// The surface points on the bus at the end of a recorded run, in w.
std::vector<SurfacePoint> RecordedCloud(const WholeRun& run) {
  bus::SubmapAssembler assembler;
  SurfaceCloud cloud;
  bus::LogReader log(run.log());
  while (const auto event = log.Next()) {
    submap_t page;
    if (event->channel != bus::kSubmap.name) continue;
    const auto data = log.Data(event->data_offset, event->data_bytes);
    EXPECT_TRUE(data && page.decode(data->data(), 0, static_cast<int>(data->size())) >= 0);
    if (assembler.Add(page) != bus::PageOutcome::kComplete) continue;
    bus::SubmapMessage message = assembler.Take();
    SubmapCloud& submap = cloud.submaps[message.number];
    if (message.only_moved) message.submap.points = std::move(submap.points);
    submap = std::move(message.submap);
  }
  return cloud.PointsInW();
}

TEST_F(SharedDenseRun, CloudOnTheBusIsThatOfTheFiles) {
  const WholeRun& run = Recorded();
  std::vector<SurfacePoint> sent = RecordedCloud(run);
  std::optional<std::vector<SurfacePoint>> written = exports::ReadCloudFile(run.out().string());
  ASSERT_TRUE(written);
  ASSERT_EQ(sent.size(), written->size());
  ASSERT_GT(sent.size(), 3000U);
  // Submaps have another order than the file.
  const auto place = [](const SurfacePoint& point) {
    const Eigen::Vector3i p = (1000.0F * point.p).array().round().cast<int>();
    return std::tuple(p.x(), p.y(), p.z());
  };
  std::ranges::sort(sent, {}, place);
  std::ranges::sort(*written, {}, place);
  size_t n_far = 0;
  for (size_t i = 0; i < sent.size(); ++i) n_far += (sent[i].p - (*written)[i].p).norm() > 0.003F ? 1 : 0;
  // Rounding to millimetres exchanges some neighbours.
  EXPECT_LT(n_far, sent.size() / 50);
}

TEST_F(SharedDenseRun, SameInputTwiceGivesTheSameBits) {
  const WholeRun &one = Recorded(), &two = Alone();
  EXPECT_NE(one.Read("mesh.ply"), "");
  for (const char* file : {"mesh.ply", "map.bt", "map.pgm", "frames.json"})
    EXPECT_EQ(one.Read(file), two.Read(file)) << file;
  EXPECT_EQ(one.Read("trajectory.tum"), two.Read("trajectory.tum"));
}

TEST_F(SharedDenseRun, TrajectoryIsThatOfARunWithoutSurfaces) {
  const WholeRun& with = Recorded();
  WholeRun without;
  ASSERT_EQ(without.Run({"run", kRoom}), 0) << without.Logs();
  EXPECT_EQ(with.Read("trajectory.tum"), without.Read("trajectory.tum"));
  EXPECT_FALSE(std::filesystem::exists(without.out() / "cloud.ply"));
}

TEST_F(DenseRun, SavedMapContinuesWithItsSurfaces) {
  const std::string room = "synthetic:room?size=376x240&frames=150";
  WholeRun run;
  const std::string map = (run.folder() / "room.plmap").string();
  ASSERT_EQ(run.Run({"run", room, "--stop", "120", "--dense", "--save-map", map}), 0) << run.Logs();
  ASSERT_TRUE(std::filesystem::exists(map + ".surfaces"));
  const int occupied = Occupied(run);
  ASSERT_EQ(run.Run({"run", room, "--start", "100", "--stop", "200", "--dense", "--map", map, "--strict"}), 0)
      << run.Logs();
  EXPECT_THAT(run.Logs(), HasSubstr("continuing the surfaces of"));
  EXPECT_GT(Occupied(run), occupied) << "the first part is there, too";
  EXPECT_EQ(run.Run({"run", room, "--stop", "20", "--dense", "--map", map, "--set", "dense.voxel_m=0.1"}), 1);
  EXPECT_THAT(run.Logs(),
              HasSubstr("dense.voxel_m is 0.1, but the surfaces that are to be continued have voxels of 0.05"));
}

TEST_F(SharedDenseRun, SavedSurfacesAreExported) {
  const WholeRun& run = Recorded();
  const ScratchFolder scratch;
  const std::string map = scratch.Path("room.plmap"), out = scratch.Path("export");
  for (const char* part : {"", ".surfaces"}) {
    std::filesystem::copy_file((run.out() / "room.plmap").string() + part, map + part);
  }
  const auto exported = [&](const std::string& formats) {
    return test::Shell(scratch, fmt::format("'{}/plslam' export '{}' --out '{}' --format {}",
                                            test::BinaryFolder().string(), map, out, formats));
  };
  const test::ShellResult done = exported("cloud mesh octomap grid");
  ASSERT_EQ(done.exit_code, 0) << done.error;
  for (const char* file : {"cloud.ply", "mesh.ply", "map.bt", "map.ot", "map.pgm", "map.yaml", "frames.json"}) {
    EXPECT_EQ(ReadText(std::filesystem::path(out) / file), run.Read(file)) << file;
    EXPECT_THAT(done.out, HasSubstr(file));
  }
  std::filesystem::remove(map + ".surfaces");
  const test::ShellResult without = exported("grid");
  EXPECT_EQ(without.exit_code, 1);
  EXPECT_THAT(without.error, HasSubstr("grid needs the surfaces of a saved map: plslam run --dense --save-map"));
  std::ofstream(map + ".surfaces") << "no surfaces";
  const test::ShellResult damaged = exported("grid");
  EXPECT_EQ(damaged.exit_code, 1);
  EXPECT_THAT(damaged.error, HasSubstr("room.plmap.surfaces"));
  EXPECT_EQ(std::ranges::count(damaged.error, '\n'), 1) << damaged.error;
}

TEST_F(DenseRun, GuessedVerticalIsReported) {
  WholeRun run;
  // Without lines, and in voxels so large that few surface elements show a direction.
  ASSERT_EQ(run.Run({"run", "synthetic:corridor?size=376x240&frames=300", "--stop", "60", "--features", "points",
                     "--dense", "--set", "dense.voxel_m=0.4"}),
            0)
      << run.Logs();
  EXPECT_THAT(run.Summary()["warnings"].dump(), HasSubstr("vertical_guessed"));
  EXPECT_THAT(run.Read("frames.json"), HasSubstr("\"up_from\": \"cameras\""));
}

// mapping_process refuses to replace the map of another place.
TEST_F(DenseRun, RefusedSaveLeavesTheSurfacesThere) {
  WholeRun run;
  const std::string map = (run.folder() / "room.plmap").string();
  ASSERT_EQ(run.Run({"run", kRoom, "--stop", "60", "--dense", "--save-map", map}), 0) << run.Logs();
  const std::string surfaces = ReadText(map + ".surfaces");
  const std::string other = "synthetic:corridor?size=376x240&frames=60";
  EXPECT_EQ(run.Run({"run", other, "--dense", "--save-map", map}), 1) << run.Logs();
  EXPECT_EQ(ReadText(map + ".surfaces"), surfaces);
  // Without dense_process nothing is known of surfaces; these do not fit the map that replaces it.
  ASSERT_EQ(run.Run({"run", other, "--save-map", map, "--force"}), 0) << run.Logs();
  const ScratchFolder scratch;
  const test::ShellResult exported =
      test::Shell(scratch, fmt::format("'{}/plslam' export '{}' --out '{}' --format cloud",
                                       test::BinaryFolder().string(), map, scratch.Path("export")));
  EXPECT_EQ(exported.exit_code, 1);
  EXPECT_THAT(exported.error, HasSubstr("are the surfaces of another map"));
}

TEST_F(DenseRun, UnsavedSurfacesAreAnError) {
  WholeRun run;
  const std::string map = (run.folder() / "room.plmap").string();
  std::filesystem::create_directories(map + ".surfaces/in the way");
  EXPECT_EQ(run.Run({"run", kRoom, "--stop", "60", "--dense", "--save-map", map}), 1) << run.Logs();
  EXPECT_THAT(run.Summary()["reason"].dump(), HasSubstr("room.plmap.surfaces"));
  EXPECT_TRUE(std::filesystem::exists(map));
}

TEST_F(DenseRun, FullDiskUnderTheFilesIsAnError) {
  const WholeRun run;
  const test::RunWatcher bus;
  const std::filesystem::path disk = run.folder() / "disk";
  const std::string bin = test::BinaryFolder().string();
  // The process alone writes to the full disk.
  const auto code = test::OnASmallDisk(
      disk, 16,
      fmt::format("{0}/dense_process --url {1} --set dense.out='{2}/dense' & {0}/plslam run "
                  "'synthetic:room?size=160x120&frames=40' --url {1} --out '{3}'; kill -INT \\$!; wait \\$!",
                  bin, bus.url(), disk.string(), run.out().string()));
  if (!code) GTEST_SKIP() << "no file system of its own may be mounted here";
  const std::string log = ReadText(disk.string() + ".sh.log");
  EXPECT_EQ(*code, 1) << log;
  EXPECT_THAT(log, testing::ContainsRegex("dense: error: .*cannot be written: No space left on device")) << log;
}

TEST_F(DenseRun, KilledProcessContinuesFromItsState) {
  WholeRun run;
  run.Start({"run", "synthetic:room?size=376x240&frames=300", "--dense"});
  ASSERT_TRUE(WholeRun::WaitFor([&] { return std::filesystem::exists(run.out() / ".dense_state"); })) << run.Logs();
  ASSERT_TRUE(run.Signal("dense_process", SIGKILL));
  EXPECT_EQ(run.Wait(), 0) << run.Logs();
  EXPECT_THAT(run.Logs(), HasSubstr("continuing the surfaces of"));
  EXPECT_EQ(run.Summary()["processes"]["dense"]["restarts"], 1);
  EXPECT_GT(Occupied(run), 300);
  EXPECT_FALSE(std::filesystem::exists(run.out() / ".dense_state")) << "of this run only";
}

TEST_F(DenseRun, KeyframesWithoutImagesAreReported) {
  WholeRun run;
  run.Start({"run", "synthetic:room?size=376x240&frames=300", "--dense"});
  const std::filesystem::path state = run.out() / ".dense_state";
  ASSERT_TRUE(WholeRun::WaitFor([&] { return std::filesystem::exists(state); })) << run.Logs();
  // Keyframes follow that the next process receives with their images.
  ASSERT_TRUE(run.Signal("player", SIGSTOP));
  const pid_t first = run.PidOf("dense_process");
  ASSERT_TRUE(run.Signal("dense_process", SIGSTOP));  // otherwise it could write its state again
  // Without its state the next process has the keyframes of the histories, but not their images.
  std::filesystem::remove(state);
  ASSERT_TRUE(run.Signal("dense_process", SIGKILL));
  ASSERT_TRUE(WholeRun::WaitFor([&] {
    const pid_t next = run.PidOf("dense_process");
    return next != -1 && next != first;
  })) << run.Logs();
  ASSERT_TRUE(run.Signal("player", SIGCONT));
  EXPECT_EQ(run.Wait(), 0) << run.Logs();
  EXPECT_THAT(run.Summary()["warnings"].dump(), HasSubstr("surfaces_missing"));
}

TEST_F(DenseRun, PersonWhoPassesLeavesNoObstacle) {
  // Nothing else is different.
  WholeRun with, without;
  const std::string room = "synthetic:room?size=376x240&frames=300";
  ASSERT_EQ(with.Run({"run", room + "&bodies=1&body=cross&share=0.2", "--dense"}), 0) << with.Logs();
  ASSERT_EQ(without.Run({"run", room, "--dense"}), 0) << without.Logs();
  EXPECT_LT(Occupied(with), 1.05 * Occupied(without));
}

/// Vertices of a binary PLY file as dense_process writes it, 27 bytes each, in the frame of a world.
std::vector<dense::Surface::Vertex> VerticesOf(const std::string& ply, const SE3& T_world_w) {
  const std::string count = "element vertex ";
  const size_t n = std::stoul(ply.substr(ply.find(count) + count.size()));
  const size_t begin = ply.find("end_header\n") + 11;
  std::vector<dense::Surface::Vertex> vertices;
  for (size_t i = 0; i < n; ++i) {
    Eigen::Vector3f p, normal;
    std::memcpy(p.data(), ply.data() + begin + 27 * i, sizeof(p));
    std::memcpy(normal.data(), ply.data() + begin + 27 * i + sizeof(p), sizeof(normal));
    vertices.push_back(
        {(T_world_w * p.cast<double>()).cast<float>(), (T_world_w.R() * normal.cast<double>()).cast<float>(), 0});
  }
  return vertices;
}

/// Errors of every 7th vertex.
std::vector<double> ErrorsOf(const std::vector<dense::Surface::Vertex>& vertices, const synthetic::World& world) {
  std::vector<Eigen::Vector3d> points;
  for (size_t i = 0; i < vertices.size(); i += 7) points.push_back(vertices[i].p.cast<double>());
  return dense::test::DistancesFrom(world, points);
}

TEST_F(DenseRun, SecondLapDoublesNoWall) {
  const std::string world = "room?size=376x240&frames=160&loops=2";
  WholeRun run;
  ASSERT_EQ(run.Run({"run", "synthetic:" + world, "--dense"}), 0) << run.Logs();
  const synthetic::Simulator simulator(synthetic::ParseOptions(world));
  const std::vector<dense::Surface::Vertex> vertices = VerticesOf(run.Read("mesh.ply"), simulator.T_w_c(0));
  const std::vector<double> errors = ErrorsOf(vertices, simulator.world());
  ASSERT_GT(errors.size(), 1000U);
  const double doubled = dense::test::DoubledShare(simulator.world(), vertices, 0.05);
  printf("error: median %.4f, 90 %% %.4f, 99 %% %.4f m; doubled %.4f\n", dense::test::Quantile(errors, 0.5),
         dense::test::Quantile(errors, 0.9), dense::test::Quantile(errors, 0.99), doubled);
  EXPECT_LT(dense::test::Quantile(errors, 0.5), 0.02);
  EXPECT_LT(dense::test::Quantile(errors, 0.9), 0.06);
  EXPECT_LT(doubled, 0.01);
}

/// A street of 50 m, and a map that has forgotten all but its end.
TEST_F(DenseRun, ForgottenPlacesLeaveNoSurface) {
  WholeRun run;
  ASSERT_EQ(
      run.Run({"run", "synthetic:street?size=376x240&frames=300", "--dense", "--set", "mapping.max_keyframes=4"}), 0)
      << run.Logs();
  std::vector<Eigen::Vector3d> keyframes;
  std::istringstream lines(run.Read("keyframes.tum"));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    double t = 0.0;
    Eigen::Vector3d p;
    if (words >> t >> p.x() >> p.y() >> p.z()) keyframes.push_back(p);
  }
  ASSERT_GE(keyframes.size(), 2U);
  ASSERT_LE(keyframes.size(), 4U);
  const std::vector<dense::Surface::Vertex> vertices = VerticesOf(run.Read("mesh.ply"), SE3());
  ASSERT_GT(vertices.size(), 1000U);
  const auto is_far = [&](const dense::Surface::Vertex& vertex) {
    // Depth reaches 23 m.
    return std::ranges::all_of(keyframes,
                               [&](const Eigen::Vector3d& p) { return (p - vertex.p.cast<double>()).norm() > 25.0; });
  };
  EXPECT_EQ(std::ranges::count_if(vertices, is_far), 0);
}

}  // namespace
}  // namespace plslam

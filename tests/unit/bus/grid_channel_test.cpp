// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/grid_channel.h"

#include <gtest/gtest.h>

#include <mutex>
#include <thread>

#include "core/bus/channels.h"
#include "plslam/grid_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

OccupancyGrid GridOf(uint8_t value) {
  OccupancyGrid grid{SE3(), 0.25, 0.05, -3, 4, 200, 2, {}};
  grid.cells.assign(400, value);
  return grid;
}

/// A publisher and a subscriber, each with a bus that runs.
class GridChannel : public testing::Test {
 protected:
  ~GridChannel() override {
    sender_.Stop();
    reader_.Stop();
    sends_.join();
    reads_.join();
  }
  static BusOptions Options(const std::string& url) {
    BusOptions options;
    options.url = url;
    return options;
  }
  /// Returns the grid after `n` tiles.
  OccupancyGrid WholeAfter(int64_t n) {
    EXPECT_TRUE(tiles_.Reaches(n));
    const std::lock_guard lock(mutex_);
    return whole_;
  }

  const std::string url_ = test::PrivateUrl();
  Bus reader_{Options(url_), "reader"};
  Bus sender_{Options(url_), "dense"};
  test::Waiter tiles_;
  std::mutex mutex_;
  OccupancyGrid whole_;
  GridSubscriber subscriber_{reader_, [this] {
                               {
                                 const std::lock_guard lock(mutex_);
                                 whole_ = subscriber_.Whole();
                               }
                               tiles_.Add();
                             }};
  std::thread reads_{[this] { reader_.Run(); }}, sends_{[this] { sender_.Run(); }};
};

TEST_F(GridChannel, CarriesTheChangedTiles) {
  GridPublisher publisher(sender_);
  publisher.Publish(GridOf(OccupancyGrid::kFree));
  OccupancyGrid whole = WholeAfter(3);
  EXPECT_EQ(whole.At(-3, 4), OccupancyGrid::kFree);
  EXPECT_EQ(whole.At(196, 5), OccupancyGrid::kFree);
  EXPECT_EQ(whole.At(197, 5), OccupancyGrid::kUnknown);
  EXPECT_EQ(whole.floor_m, 0.25);
  // Another frame begins another grid.
  OccupancyGrid turned = GridOf(OccupancyGrid::kOccupied);
  turned.T_w_level = SE3(Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0), Eigen::Vector3d(1.0, 2.0, 3.0));
  turned.n_columns = 1;
  turned.cells.resize(2);
  publisher.Publish(turned);
  whole = WholeAfter(4);
  EXPECT_EQ(whole.At(-3, 4), OccupancyGrid::kOccupied);
  EXPECT_EQ(whole.At(-2, 4), OccupancyGrid::kUnknown);
  EXPECT_EQ(whole.T_w_level.translation(), turned.T_w_level.translation());
}

// Planners must not keep obstacles of a map that was reset.
TEST_F(GridChannel, ReplacedMapHasNoCells) {
  GridPublisher publisher(sender_);
  publisher.Clear();
  publisher.Publish(GridOf(OccupancyGrid::kOccupied));
  EXPECT_EQ(WholeAfter(3).At(-3, 4), OccupancyGrid::kOccupied);
  publisher.Clear();
  const OccupancyGrid whole = WholeAfter(6);
  EXPECT_EQ(whole.At(-3, 4), OccupancyGrid::kUnknown);
  EXPECT_EQ(whole.At(196, 5), OccupancyGrid::kUnknown);
  publisher.Publish(GridOf(OccupancyGrid::kFree));
  EXPECT_EQ(WholeAfter(9).At(-3, 4), OccupancyGrid::kFree);
}

TEST_F(GridChannel, NewestPublisherReplacesTheOther) {
  test::Waiter arrived;
  reader_.Subscribe<grid_t>(kGrid, [&](const grid_t&) { arrived.Add(); });
  GridPublisher killed(sender_);
  killed.Publish(GridOf(OccupancyGrid::kFree));
  EXPECT_TRUE(arrived.Reaches(3));
  test::RunningBus restarted(Options(url_), "dense");
  restarted.Start();
  GridPublisher newest(*restarted);
  newest.Publish(GridOf(OccupancyGrid::kOccupied));
  EXPECT_TRUE(arrived.Reaches(6));
  // Its last messages arrive late.
  killed.Publish(GridOf(OccupancyGrid::kUnknown));
  EXPECT_TRUE(arrived.Reaches(9));
  EXPECT_EQ(WholeAfter(6).At(-3, 4), OccupancyGrid::kOccupied);
  EXPECT_EQ(tiles_.value(), 6) << "they change nothing";
}

TEST_F(GridChannel, InvalidTilesAreCounted) {
  grid_t tile{};
  tile.T_w_level.q_wxyz[0] = 1.0;
  tile.cell_m = 0.1;
  tile.n_columns = tile.n_rows = GridTiles::kTile;
  tile.cells.assign(size_t{GridTiles::kTile} * GridTiles::kTile, 17);  // no value of a cell
  tile.n_cells = static_cast<int32_t>(tile.cells.size());
  sender_.Publish(kGrid, tile);
  tile.cells.assign(tile.cells.size(), OccupancyGrid::kFree);
  sender_.Publish(kGrid, tile);
  const OccupancyGrid whole = WholeAfter(1);
  EXPECT_EQ(reader_.counters().rejected, 1);
  EXPECT_EQ(whole.At(0, 0), OccupancyGrid::kFree);
}

}  // namespace
}  // namespace plslam::bus

// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/heard_surfaces.h"

#include <gtest/gtest.h>

#include <atomic>

#include "core/bus/channels.h"
#include "core/run/process_names.h"
#include "plslam/status_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::viewer {
namespace {

status_t DenseStatus(int64_t source, const char* state, int n_tiles, int n_submaps) {
  status_t status{};
  status.header.source = source;
  status.process = process_name::kDense;
  status.state = state;
  for (const auto& [name, n] : {std::pair(dense_counter::kTiles, n_tiles), {dense_counter::kSubmaps, n_submaps}}) {
    counter_t& counter = status.counters.emplace_back();
    counter.name = name;
    counter.value = n;
  }
  status.n_counters = static_cast<int32_t>(status.counters.size());
  return status;
}

class HeardSurfacesTest : public testing::Test {
 protected:
  static bus::BusOptions Options(const std::string& url) {
    bus::BusOptions options;
    options.url = url;
    return options;
  }

  const std::string url_ = bus::test::PrivateUrl();
  bus::test::Waiter news_;
  std::atomic<int64_t> source_ = 0;
  bus::test::RunningBus reader_{Options(url_), "viewer"};
  bus::test::RunningBus sender_{Options(url_), "dense"};
};

TEST_F(HeardSurfacesTest, LastMessagesAreAwaited) {
  // Before those of `heard`, whose news say that the message has arrived.
  reader_->Subscribe<submap_t>(bus::kSubmap, [this](const submap_t& m) { source_ = m.header.source; });
  HeardSurfaces heard(*reader_, [this] { news_.Add(); });
  EXPECT_FALSE(heard.MayCome()) << "there is no dense_process";
  reader_.Start();
  sender_.Start();
  bus::GridPublisher grid(*sender_);
  bus::SubmapPublisher submaps(*sender_);
  grid.Publish({SE3(), 0.0, 0.05, 0, 0, 1, 1, {OccupancyGrid::kFree}});
  submaps.Publish({0.05, {{0, {1, 0, SE3(), std::vector<SurfacePoint>(5)}}}}, bus::SubmapPublisher::Changes::kAll);
  ASSERT_TRUE(news_.Reaches(2));
  EXPECT_EQ(heard.cloud().n_points(), 5U);
  EXPECT_EQ(heard.Grid().At(0, 0), OccupancyGrid::kFree);
  heard.OnStatus(DenseStatus(source_, process_state::kRunning, 1, 1));
  EXPECT_TRUE(heard.MayCome()) << "it is at work";
  heard.OnStatus(DenseStatus(source_, process_state::kFinished, 1, 1));
  EXPECT_FALSE(heard.MayCome());
  for (const auto& [n_tiles, n_submaps] : {std::pair(2, 1), {1, 2}}) {
    heard.OnStatus(DenseStatus(source_, process_state::kFinished, n_tiles, n_submaps));
    EXPECT_TRUE(heard.MayCome()) << "a message is on its way";
  }
  heard.OnStatus(DenseStatus(source_ + 1, process_state::kFinished, 1, 1));
  EXPECT_TRUE(heard.MayCome()) << "those are messages of the process before it";
  heard.OnStatus(DenseStatus(source_ + 1, process_state::kFailed, 0, 0));
  EXPECT_FALSE(heard.MayCome());
}

}  // namespace
}  // namespace plslam::viewer

#include "vo_process/side_worker.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace plslam {
namespace {

TEST(SideWorker, RunsBothEachTime) {
  SideWorker worker;
  int here = 0;
  int there = 0;
  for (int i = 0; i < 1000; ++i) worker.RunBoth([&] { ++here; }, [&] { ++there; });
  EXPECT_EQ(here, 1000);
  EXPECT_EQ(there, 1000);
}

TEST(SideWorker, RunsOnAnotherThread) {
  SideWorker worker;
  std::thread::id here;
  std::thread::id there;
  worker.RunBoth([&] { here = std::this_thread::get_id(); }, [&] { there = std::this_thread::get_id(); });
  EXPECT_NE(here, there);
}

TEST(SideWorker, ThrowsWhatEitherThrowsAndGoesOn) {
  SideWorker worker;
  const auto fail = [] { throw std::runtime_error("no"); };
  const auto nothing = [] {};
  EXPECT_THROW(worker.RunBoth(fail, nothing), std::runtime_error);
  EXPECT_THROW(worker.RunBoth(nothing, fail), std::runtime_error);
  EXPECT_THROW(worker.RunBoth(fail, fail), std::runtime_error);
  int ran = 0;
  worker.RunBoth([&] { ++ran; }, nothing);
  EXPECT_EQ(ran, 1);
}

}  // namespace
}  // namespace plslam

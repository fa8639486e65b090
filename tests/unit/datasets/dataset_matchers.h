// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam::test {

/// The one sentence with which `f` fails; a test failure where it does not throw DatasetError, or in several lines.
inline std::string ErrorOf(const std::function<void()>& f) {
  try {
    f();
  } catch (const DatasetError& error) {
    const std::string what = error.what();
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    return what;
  } catch (const std::exception& error) {
    ADD_FAILURE() << "not a DatasetError: " << error.what();
    return "";
  }
  ADD_FAILURE() << "no error";
  return "";
}

}  // namespace plslam::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>

namespace plslam {

/// An input that cannot be read, in one sentence that names file and line.
class DatasetError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Runs `f`; errors of the general readers (text_rows.h, trajectory.h), which name file and line already, leave it as
/// DatasetError.
template <class F>
auto AsDatasetError(F f) {
  try {
    return f();
  } catch (const DatasetError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw DatasetError(error.what());
  }
}

}  // namespace plslam

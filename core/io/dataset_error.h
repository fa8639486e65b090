#pragma once

#include <stdexcept>

#include "core/io/dataset.h"

namespace plslam {

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

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam {

/// Opens a built-in world from "synthetic:NAME?option=value&..." (the text after "synthetic:" is `description`).
/// Throws DatasetError with the known names or options where one is unknown.
std::unique_ptr<Dataset> OpenSyntheticDataset(const std::string& description);

}  // namespace plslam

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/datasets/synthetic/texture.h"

namespace plslam::test {

/// Side of a painted vehicle: panels, a row of windows, stripes along it, print and dirt. A function of its seed.
synthetic::Texture PaintVehicle(uint64_t seed);

/// A picture of `folder`, chosen by `seed`. Throws DatasetError where the folder has none.
synthetic::Texture PictureOf(const std::string& folder, uint64_t seed);

}  // namespace plslam::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/datasets/dataset.h"
#include "core/features/features.h"
#include "core/features/options.h"

namespace plslam::train_vocabulary {

/// Number of images so far, and of all.
using ImageProgress = std::function<void(int, int)>;

/// Calls `use(index, features)` with the features of the rectified left image of every `stride`-th frame, in order, as
/// vo_process extracts them. Throws DatasetError, or std::runtime_error if the rig cannot be rectified.
void ForEachLeftImage(const Dataset& dataset, int stride, const FeatureOptions& options,
                      const std::function<void(int, const ImageFeatures&)>& use, const ImageProgress& progress);

/// The same for a folder of images as they are, or a dataset of any kind that the player plays. A folder that has
/// images in itself is taken as the former.
void ForEachImageOf(const std::string& source, int stride, const FeatureOptions& options,
                    const std::function<void(const ImageFeatures&)>& use, const ImageProgress& progress);

}  // namespace plslam::train_vocabulary

// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/keyframe_images.h"

#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/io/maps/map_camera.h"

namespace plslam::exports {
KeyframeImages::KeyframeImages(std::shared_ptr<const Dataset> dataset, const StereoCamera& camera)
    : dataset_(std::move(dataset)) {
  rectifier_ = std::make_unique<Rectifier>(dataset_->rig());
  const std::string difference = CameraDifference(camera, rectifier_->camera());
  if (!difference.empty()) {
    throw std::runtime_error(
        fmt::format("{}: its rectified camera is not that of the map: {}", dataset_->name(), difference));
  }
  for (int i = 0; i < dataset_->size(); ++i) index_of_[dataset_->t_ns(i)] = i;
}

std::optional<cv::Mat> KeyframeImages::At(int64_t t_ns) const {
  const auto index = index_of_.find(t_ns);
  if (index == index_of_.end()) return std::nullopt;
  return rectifier_->RectifyLeft(dataset_->Read(index->second).left);
}

}  // namespace plslam::exports

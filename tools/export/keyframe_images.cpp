// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/keyframe_images.h"

#include <fmt/format.h>

#include <stdexcept>

#include "core/datasets/open_dataset.h"
#include "core/io/maps/map_camera.h"

namespace plslam {

KeyframeImages::KeyframeImages(const std::string& dataset, const StereoCamera& camera)
    : dataset_(OpenDataset(dataset, "")) {
  rectifier_ = std::make_unique<Rectifier>(dataset_->rig());
  const std::string difference = CameraDifference(camera, rectifier_->camera());
  if (!difference.empty()) {
    throw std::runtime_error(fmt::format("{}: its rectified camera is not that of the map: {}", dataset, difference));
  }
  for (int i = 0; i < dataset_->size(); ++i) index_of_[dataset_->t_ns(i)] = i;
}

std::optional<cv::Mat> KeyframeImages::At(int64_t t_ns) const {
  const auto index = index_of_.find(t_ns);
  if (index == index_of_.end()) return std::nullopt;
  return rectifier_->RectifyLeft(dataset_->Read(index->second).left);
}

}  // namespace plslam

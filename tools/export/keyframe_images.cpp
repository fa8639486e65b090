#include "tools/export/keyframe_images.h"

#include <fmt/format.h>

#include <stdexcept>

#include "core/datasets/open_dataset.h"

namespace plslam {
namespace {

std::string CameraText(const StereoCamera& c) {
  return fmt::format("{} x {} px, focal length {:.6g} px, centre {:.6g} {:.6g} px, baseline {:.6g} m", c.width_px,
                     c.height_px, c.f_px, c.cx_px, c.cy_px, c.baseline_m);
}

bool IsSame(const StereoCamera& a, const StereoCamera& b) {
  return a.f_px == b.f_px && a.cx_px == b.cx_px && a.cy_px == b.cy_px && a.baseline_m == b.baseline_m &&
         a.width_px == b.width_px && a.height_px == b.height_px;
}

}  // namespace

KeyframeImages::KeyframeImages(const std::string& dataset, const StereoCamera& camera)
    : dataset_(OpenDataset(dataset, "")) {
  rectifier_ = std::make_unique<Rectifier>(dataset_->rig());
  if (!IsSame(rectifier_->camera(), camera)) {
    throw std::runtime_error(fmt::format("{}: its rectified camera ({}) is not that of the map ({})", dataset,
                                         CameraText(rectifier_->camera()), CameraText(camera)));
  }
  for (int i = 0; i < dataset_->size(); ++i) index_of_[dataset_->t_ns(i)] = i;
}

std::optional<cv::Mat> KeyframeImages::At(int64_t t_ns) const {
  const auto index = index_of_.find(t_ns);
  if (index == index_of_.end()) return std::nullopt;
  return rectifier_->RectifyLeft(dataset_->Read(index->second).left);
}

}  // namespace plslam

// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/shifted_dataset.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace plslam {
namespace {

class ShiftedDataset : public Dataset {
 public:
  ShiftedDataset(std::unique_ptr<Dataset> dataset, int offset)
      : dataset_(std::move(dataset)), offset_(offset), first_(std::max(-offset, 0)) {}

  std::string name() const override { return dataset_->name(); }
  const RigCalibration& rig() const override { return dataset_->rig(); }
  int size() const override { return dataset_->size() - std::abs(offset_); }
  int64_t t_ns(int index) const override { return dataset_->t_ns(first_ + index); }
  StereoImages Read(int index) const override {
    StereoImages images = dataset_->Read(first_ + index);
    images.right = dataset_->Read(first_ + index + offset_).right;
    images.frame_id = index;
    return images;
  }
  std::string Missing(int index) const override {
    const std::string left = dataset_->Missing(first_ + index);
    return left.empty() ? dataset_->Missing(first_ + index + offset_) : left;
  }
  std::optional<SE3> GroundTruth(int index) const override { return dataset_->GroundTruth(first_ + index); }
  bool HasRecordedTruth() const override { return dataset_->HasRecordedTruth(); }
  std::vector<std::string> Notes() const override { return dataset_->Notes(); }

 private:
  std::unique_ptr<Dataset> dataset_;
  int offset_;
  int first_;
};

}  // namespace

std::unique_ptr<Dataset> ShiftRightImages(std::unique_ptr<Dataset> dataset, int offset) {
  if (offset == 0) return dataset;
  if (dataset->rig().kind == RigCalibration::Kind::kRgbd) {
    throw DatasetError(dataset->name() + ": player.right_offset_frames=" + std::to_string(offset) +
                       " is for pairs of two cameras, and this one has depth images; leave it at 0");
  }
  if (std::abs(offset) >= dataset->size()) {
    throw DatasetError(dataset->name() + ": player.right_offset_frames=" + std::to_string(offset) +
                       " leaves none of its " + std::to_string(dataset->size()) +
                       " frames with a right image; give fewer");
  }
  return std::make_unique<ShiftedDataset>(std::move(dataset), offset);
}

}  // namespace plslam

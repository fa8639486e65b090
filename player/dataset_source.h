// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/datasets/dataset.h"
#include "core/stream/frame_source.h"
#include "player/frame_loader.h"
#include "player/options.h"
#include "player/pacing.h"

namespace plslam::player {

/// The frames of a dataset in the order of the options, read ahead.
class DatasetSource : public stream::FrameSource {
 public:
  /// Throws std::runtime_error if the dataset cannot be opened, lacks frames of the range to play, or the options do
  /// not fit it.
  explicit DatasetSource(const PlayerOptions& options);

  std::string name() const override { return dataset_->name(); }
  const RigCalibration& rig() const override { return rig_; }
  /// Sentences on what can make the frames wrong or incomplete.
  std::vector<std::string> warnings() const;
  double scan_s() const { return dataset_->scan_s(); }
  int64_t size() const override { return order_.size(); }
  int64_t period_ns() const override { return order_.period_ns(); }
  bool HasRecordedTruth() const override { return dataset_->HasRecordedTruth(); }
  int64_t Begin(const std::optional<stream::ResumePoint>& behind) override;
  std::optional<LoadedFrame> Next() override;
  void Stop() override;

 private:
  std::unique_ptr<Dataset> dataset_;
  const RigCalibration rig_;  // the dataset's, with the masks of the options
  const PlayOrder order_;
  std::mutex mutex_;  // of making and stopping `loader_`
  std::optional<FrameLoader> loader_;
  bool stopped_ = false;
  std::vector<std::string> warned_;  // of the notes of reading
};

}  // namespace plslam::player

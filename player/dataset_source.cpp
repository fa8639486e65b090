// SPDX-License-Identifier: BSD-3-Clause
#include "player/dataset_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/datasets/camera_file.h"
#include "core/datasets/open_dataset.h"
#include "core/errors/log.h"

namespace plslam::player {
namespace {

constexpr size_t kFramesAhead = 2;

std::unique_ptr<Dataset> Open(const PlayerOptions& options) {
  if (options.dataset.empty()) throw std::runtime_error("no dataset is given: player DATASET (see --help)");
  std::unique_ptr<Dataset> dataset =
      ShiftRightImages(OpenDataset(options.dataset, options.kind), static_cast<int>(options.right_offset_frames));
  for (const std::string& remark : dataset->Notes().remarks) LogInfo("{}: {}", dataset->name(), remark);
  return dataset;
}

/// The rig of what is played. An inertial sensor without samples is none, and no sensor has measured the way back.
RigCalibration RigToPlay(const Dataset& dataset, const PlayerOptions& options) {
  RigCalibration rig = dataset.rig();
  if (dataset.ImuSamples().empty() || options.bounce) rig.imu.reset();
  const auto add = [](const char* key, const std::string& path, CameraCalibration* camera) {
    if (path.empty()) return;
    try {
      AddMaskImage(path, camera);
    } catch (const DatasetError& error) {
      throw DatasetError(fmt::format("player.{} = {}", key, error.what()));
    }
  };
  add("mask_left", options.mask_left, &rig.left);
  add("mask_right", options.mask_right, &rig.right);
  return rig;
}

PlayOrder Order(const Dataset& dataset, const PlayerOptions& options) {
  const auto time_of = [&dataset](int index) { return dataset.t_ns(index); };
  try {
    return {dataset.size(), time_of, options, dataset.rig().rate_hz};
  } catch (const std::runtime_error& error) {
    throw DatasetError(fmt::format("{}: {}", dataset.name(), error.what()));
  }
}

/// Missing files are reported before the first frame, not when playing reaches them.
void CheckFilesAreThere(const Dataset& dataset, const PlayOrder& order, bool skip_bad) {
  std::string first;
  int n = 0;
  for (const int index : order.pass()) {
    const std::string missing = dataset.Missing(index);
    if (missing.empty()) continue;
    ++n;
    if (first.empty()) first = missing;
  }
  if (n == 0) return;
  const std::string sentence = fmt::format("{}; {} of {} frames lack an image", first, n, order.pass().size());
  if (!skip_bad) throw DatasetError(sentence + " (--skip-bad skips them)");
  LogWarning("{}", sentence);
}

}  // namespace

DatasetSource::DatasetSource(const PlayerOptions& options)
    : dataset_(Open(options)), rig_(RigToPlay(*dataset_, options)), order_(Order(*dataset_, options)) {
  CheckFilesAreThere(*dataset_, order_, options.skip_bad);
}

std::vector<std::string> DatasetSource::warnings() const {
  std::vector<std::string> warnings;
  for (const std::string& warning : dataset_->Notes().warnings) {
    warnings.push_back(fmt::format("{}: {}", dataset_->name(), warning));
  }
  return warnings;
}

int64_t DatasetSource::Begin(const std::optional<stream::ResumePoint>& behind) {
  PlayOrder order = order_;
  const int64_t skipped = behind ? order.SkipTo(behind->t_ns) : 0;
  const std::scoped_lock lock(mutex_);
  loader_.reset();
  if (!stopped_) {
    const std::optional<int64_t> sent_ns = behind ? std::optional(behind->t_ns) : std::nullopt;
    loader_.emplace(*dataset_, std::move(order), kFramesAhead, sent_ns);
  }
  return behind ? std::max<int64_t>(0, skipped - behind->frame_id.value - 1) : 0;
}

std::optional<LoadedFrame> DatasetSource::Next() {
  std::optional<LoadedFrame> frame = loader_ ? loader_->Next() : std::nullopt;
  // The first finding of a kind, and, after the last frame, its count.
  const std::vector<std::string> warnings = dataset_->NotesOfReading().warnings;
  if (warnings.size() > warned_.size() || (!frame && warnings != warned_)) {
    for (const std::string& warning : warnings) LogWarning("{}: {}", dataset_->name(), warning);
    warned_ = warnings;
  }
  return frame;
}

void DatasetSource::Stop() {
  const std::scoped_lock lock(mutex_);
  stopped_ = true;
  if (loader_) loader_->Stop();
}

}  // namespace plslam::player

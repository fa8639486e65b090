#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/bus/messages/frame_channel.h"
#include "core/geometry/rectifier.h"
#include "core/map/map.h"
#include "viewer_headless/film.h"
#include "viewer_headless/options.h"
#include "viewer_headless/overlay_queue.h"
#include "viewer_headless/recorder.h"
#include "viewer_headless/report/picture_store.h"

namespace plslam {

/// Brings image, features and pose of frames together and hands the pictures to whom they are for: files in `overlays/`,
/// the report, the film of the run. Best effort: what does not come is missing.
class PictureNode {
 public:
  /// What the pictures are for beside the options. Both stay.
  struct Sources {
    const Map* map = nullptr;       ///< what the film shows; nullptr: no film
    PictureStore* store = nullptr;  ///< gets what the report wants; nullptr: no report
  };

  /// `rejected` is called for images that are none. Whoever is not wanted costs nothing.
  PictureNode(bus::Bus& bus, const ViewerOptions& options, Sources sources, std::function<void()> rejected);

  /// From now on images are of that camera; `rate_hz`: images a second, 0 where unknown.
  void SetRectifier(const Rectifier* rectifier, double rate_hz = 0.0);
  void AddPose(const FramePose& pose);
  /// A new stream begins: its film replaces the one before, and its report has a store of its own.
  void BeginAgain(PictureStore* store);
  /// No more pictures of this run: the film gets its name.
  void EndFilm() { film_.reset(); }

 private:
  void OnFrame(const bus::FrameSubscriber::Frame& frame);
  void Use(const std::optional<OverlayQueue::Ready>& ready);
  void WriteOverlay(int64_t frame_id, const cv::Mat& picture) const;

  ViewerOptions options_;
  Sources sources_;
  std::function<void()> rejected_;
  OverlayQueue queue_;
  const Rectifier* rectifier_ = nullptr;
  double rate_hz_ = 0.0;
  std::unique_ptr<Film> film_;
  /// Poses whose pictures may still come.
  std::map<int64_t, FramePose> poses_;
  std::unique_ptr<bus::FrameSubscriber> frames_;
};

}  // namespace plslam

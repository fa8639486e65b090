// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/bus/messages/frame_channel.h"
#include "core/geometry/rectifier.h"
#include "core/map/map.h"
#include "viewer_headless/film.h"
#include "viewer_headless/options.h"
#include "viewer_headless/overlay.h"
#include "viewer_headless/recorder.h"
#include "viewer_headless/report/picture_store.h"
#include "viewer_headless/report/small_images.h"

namespace plslam::viewer {

/// Brings image, features and pose of frames together and hands the pictures to whom they are for: files in
/// `overlays/`, the report, the film of the run. In lockstep every frame has its picture, but for those from before
/// this process listened; in real time what does not come is missing.
class PictureNode {
 public:
  /// What the pictures are for beside the options. Both stay.
  struct Sources {
    const Map* map = nullptr;       ///< what the film shows; nullptr: no film
    PictureStore* store = nullptr;  ///< gets what the report wants; nullptr: no report
  };

  /// `rejected` is called for images that are none, `came` for each picture. Whoever is not wanted costs nothing.
  PictureNode(bus::Bus& bus, const ViewerOptions& options, Sources sources, std::function<void()> rejected,
              std::function<void()> came);

  /// From now on images are of that rig, which `rectification` is for.
  void SetCamera(const RigCalibration& rig, const Rectification& rectification);
  /// Once for each frame.
  void AddPose(const FramePose& pose);
  /// A new stream begins: its film replaces the one before, and its report has a store of its own.
  void BeginAgain(PictureStore* store);

  /// Pictures of frames that this process can have heard of have not all come yet.
  bool MayCome() const;

  /// What became of the pictures of a run.
  struct Result {
    int64_t missing = 0;  ///< pictures that somebody wanted, and that are nowhere
    /// A sentence for each thing that was asked for by name (overlays, the film) and is not there.
    std::vector<std::string> failures;
  };
  /// No more pictures of this run: the film gets its name, if it is whole. `lockstep`: every picture was promised.
  /// `ended`: the stream has come to its end; else frames behind the newest picture are not missed. May be called
  /// again.
  Result Finish(const Recorder& recorder, bool lockstep, bool ended);

 private:
  /// What images of a rig go through.
  struct Camera {
    RigCalibration rig;
    int width_px = 0;
    SmallRectifier left;
    SmallRectifier right;
    /// For pictures as large as the images; made when the first one is wanted.
    std::optional<Rectifier> whole;
  };

  void OnFrame(const bus::FrameSubscriber::Frame& frame);
  void UseAll();
  void Use(const OverlayQueue::Ready& ready);
  void Store(const OverlayQueue::Ready& ready);
  cv::Mat Draw(const OverlayQueue::Ready& ready);
  void WriteOverlay(int64_t frame_id, const cv::Mat& picture);
  bool IsOverlay(int64_t frame_id) const;
  /// The report wants it.
  bool IsStored(int64_t frame_id) const;
  std::string OverlayFile(int64_t frame_id) const;
  /// Why there are no overlays, or no film, of some frames; empty where all is there.
  std::string LackOfOverlays(const Recorder& recorder, bool lockstep, int64_t last) const;
  std::string LackOfFilm(bool lockstep, int64_t missing);
  std::string Why() const;

  ViewerOptions options_;
  Sources sources_;
  std::function<void()> rejected_;
  std::function<void()> came_;
  OverlayQueue queue_;
  std::optional<Camera> camera_;
  std::unique_ptr<Film> film_;
  int64_t n_pictures_ = 0;
  int64_t newest_ = -1;  ///< frame that has a picture
  /// Why a picture that had come could not be used or written; of the first.
  std::string problem_;
  /// Once the film is over: why it is not there, or nothing.
  std::optional<std::string> film_problem_;
  std::unique_ptr<bus::FrameSubscriber> frames_;
};

}  // namespace plslam::viewer

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
#include "core/run/recorder.h"
#include "viewer_headless/film.h"
#include "viewer_headless/options.h"
#include "viewer_headless/overlay.h"
#include "viewer_headless/report/picture_store.h"
#include "viewer_headless/report/small_images.h"

namespace plslam::viewer {

/// Combines image, features and pose of frames and passes the pictures to their users: files in `overlays/`, the
/// report, the film of the run. In lockstep every frame has its picture, except for frames before this process
/// listened; in real time, pictures may be missing.
class PictureNode {
 public:
  /// The users of the pictures beside the options. Both outlive this object.
  struct Sources {
    const Map* map = nullptr;       ///< the map in the film; nullptr: no film
    PictureStore* store = nullptr;  ///< receives the pictures of the report; nullptr: no report
  };

  /// `rejected` is called for invalid images, `came` for each picture. An unused output costs nothing.
  PictureNode(bus::Bus& bus, const ViewerOptions& options, Sources sources, std::function<void()> rejected,
              std::function<void()> came);

  /// Sets the rig of the following images; `rectification` belongs to it.
  void SetCamera(const RigCalibration& rig, const Rectification& rectification);
  /// Adds the pose of a frame; once for each frame.
  void AddPose(const FramePose& pose);
  /// Begins a new stream: its film replaces the previous one, and its report has its own store.
  void StartNewRun(PictureStore* store);

  /// Returns whether pictures of frames since this process listens are still missing.
  bool MayCome() const;

  /// Result of the pictures of a run.
  struct Result {
    int64_t missing = 0;  ///< requested pictures that do not exist
    /// One sentence for each explicitly requested output (overlays, the film) that is missing.
    std::vector<std::string> failures;
    std::string film_note;  ///< Film::note
  };
  /// Ends the pictures of this run: the film gets its final name if it is complete. `lockstep`: every picture was
  /// promised. `ended`: the end of the stream has arrived; otherwise frames after the newest picture do not count as
  /// missing. May be called again.
  Result Finish(const Recorder& recorder, bool lockstep, bool ended);

 private:
  /// The calibration and the rectifiers of the images.
  struct Camera {
    RigCalibration rig;
    int width_px = 0;
    SmallRectifier left;
    SmallRectifier right;
    /// Rectifier at full image size; created when first needed.
    std::optional<Rectifier> whole;
  };

  void OnFrame(const bus::FrameSubscriber::Frame& frame);
  void UseAll();
  void Use(const OverlayQueue::Ready& ready);
  void Store(const OverlayQueue::Ready& ready);
  cv::Mat Draw(const OverlayQueue::Ready& ready);
  void WriteOverlay(FrameId frame_id, const cv::Mat& picture);
  bool IsOverlay(FrameId frame_id) const;
  /// Returns whether the report needs it.
  bool IsStored(FrameId frame_id) const;
  std::string OverlayFile(FrameId frame_id) const;
  /// Return the reason why some frames have no overlays, or no film; empty if all exist.
  std::string LackOfOverlays(const Recorder& recorder, bool lockstep, FrameId last) const;
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
  FrameId newest_;  ///< frame that has a picture
  /// The reason why a received picture could not be used or written, for the first such picture.
  std::string problem_;
  /// After the end of the film: the reason why it does not exist, or empty.
  std::optional<std::string> film_problem_;
  std::string film_note_;
  std::unique_ptr<bus::FrameSubscriber> frames_;
};

}  // namespace plslam::viewer

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/files/dataset_error.h"
#include "core/files/notes.h"
#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"
#include "core/io/images/image_file.h"

namespace plslam {

/// A sequence of stereo pairs with random access. Reading the list is cheap; images are read on demand.
class Dataset {
 public:
  virtual ~Dataset() = default;

  virtual std::string name() const = 0;
  virtual const RigCalibration& rig() const = 0;
  /// Number of pairs.
  virtual int size() const = 0;
  /// Strictly increasing.
  virtual int64_t t_ns(int index) const = 0;
  /// Throws DatasetError if an image is missing, truncated, of the wrong size, or the two differ in size. `frame_id` is
  /// the index.
  virtual StereoImages Read(int index) const = 0;
  /// Returns the reason why the pair is missing, as far as that is known without reading it: a file is missing, or has
  /// no partner. Empty otherwise. Cheap.
  virtual std::string Missing(int /*index*/) const { return {}; }
  /// Returns the file of the left image; empty if it is not a separate file.
  virtual std::string LeftFile(int /*index*/) const { return {}; }
  /// Returns the true pose at the time of the pair; nullopt if unknown. Dense ground truth of another sensor is
  /// interpolated and moved to the left camera here.
  virtual std::optional<SE3> GroundTruth(int index) const = 0;
  /// All samples of the inertial sensor, in order of increasing time; empty if `rig().imu` is.
  virtual const std::vector<ImuSample>& ImuSamples() const;
  /// Returns whether there is recorded truth, of whatever frames: if most have none, it is of other times.
  virtual bool HasRecordedTruth() const { return false; }
  /// Returns what opening has found ("3 images of cam0 have no partner in cam1").
  virtual plslam::Notes Notes() const { return {}; }
  /// Returns what `Read` has found so far: values above the white level. The sentences change as their counts grow.
  virtual plslam::Notes NotesOfReading() const { return {}; }
  /// Returns the time that it took to read a whole recording that has no usable index, or is truncated, as a note
  /// reports; 0 for others.
  virtual double scan_s() const { return 0.0; }
};

inline const std::vector<ImuSample>& Dataset::ImuSamples() const {
  static const std::vector<ImuSample> kNone;
  return kNone;
}

}  // namespace plslam

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/files/notes.h"
#include "core/geometry/calibration.h"

namespace plslam {

/// Images are not wider or higher, whatever describes them.
inline constexpr int kMaxImageSide_px = 16384;

/// A whole number of pixels from 1 to that.
bool IsImageSide(double side_px);

/// Returns the reason why a rig is invalid, in one phrase with value and bound; empty if it is valid. Sizes are 16 to
/// 16384 px, focal lengths 1 to 100000 px, principal points within one image size of the image, distortion coefficients
/// as many as the model has, all numbers finite, both images of one size, and the right camera 0.1 mm to 100 m to the
/// right of the left one, or above or below it, looking the same way (within 45 degrees).
std::string RigComplaint(const RigCalibration& rig);

/// Warns if the cameras of a stereo rig are more than 1 m apart, most often because of a wrong unit: "FILE: the
/// cameras are 6 m apart: REMEDY".
void WarnOfLongBaseline(const std::string& path, const RigCalibration& rig, const std::string& remedy, Notes* notes);
/// Warns if the principal point of a camera is far from the middle of its images, by the same part of width and height:
/// then a calibration is of images of another size. "WHAT: the principal point ...".
void WarnOfOtherScale(const std::string& what, const RigCalibration& rig, Notes* notes);
/// The remedy for files whose lengths are in metres by definition.
inline constexpr const char* kLengthsAreMetres = "lengths must be in metres; are these?";
/// Larger ones get a warning.
inline constexpr double kUsualBaseline_m = 1.0;
/// Larger ones are errors.
inline constexpr double kMaxBaseline_m = 100.0;

/// Parts of it for one camera: image size, focal lengths, principal point (needs the size), model, distortion.
std::string SizeComplaint(const CameraCalibration& camera);
std::string FocalComplaint(const CameraCalibration& camera);
std::string CentreComplaint(const CameraCalibration& camera);
std::string ModelComplaint(const CameraCalibration& camera);
std::string DistortionComplaint(const CameraCalibration& camera);

}  // namespace plslam

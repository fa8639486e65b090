// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

/// Protocol between viewer_headless and plslam_film, on the standard input and output of the latter:
///
///   "WIDTH HEIGHT RATE\n"                what the film is; even numbers of pixels, pictures a second
///       "ready\n", or "error WHY\n", or "unable WHY\n" where there is no encoder
///   byte 1, WIDTH * HEIGHT * 3 bytes     a picture, BGR; any number of them
///   byte 0                               the film is whole
///       "done\n" or "error WHY\n"
///
/// If the input ends before byte 0, no film is left.
namespace plslam::film_stream {

inline constexpr char kPicture = 1;
inline constexpr char kEnd = 0;
inline constexpr char kReady[] = "ready";
inline constexpr char kDone[] = "done";
inline constexpr char kError[] = "error ";
inline constexpr char kUnable[] = "unable ";
inline constexpr int kMaxSide_px = 16384;

/// The name of FILE.mp4 while it is written.
inline std::string PartOf(const std::string& file) { return file.substr(0, file.size() - 4) + ".part.mp4"; }

}  // namespace plslam::film_stream

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <string>

namespace plslam::viewer {

/// plslam_film: reads pictures from `in` as film_stream.h tells, writes them into the MP4 file (H.264, else MPEG-4)
/// by OpenCV's FFmpeg, and answers on `out`. The file has its name when it is whole; while it is written it ends in
/// ".part.mp4", and that is removed where the pictures end before. Returns the exit code of the program: 0 also where
/// no film was begun.
int WriteFilm(const std::string& file, std::FILE* in, std::FILE* out);

}  // namespace plslam::viewer

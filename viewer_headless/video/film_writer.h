// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <string>

namespace plslam::viewer {

/// plslam_film: reads pictures from `in` in the protocol of film_stream.h, writes them into the MP4 file (H.264) by
/// GStreamer, which is initialised, and answers on `out`. The file gets its name when it is complete; until then its
/// name ends in ".part.mp4", and it is removed if the pictures end early. Returns the exit code of the program: 0 also
/// if no film was begun.
int WriteFilm(const std::string& file, std::FILE* in, std::FILE* out);

}  // namespace plslam::viewer

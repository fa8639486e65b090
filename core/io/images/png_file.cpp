// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/images/png_file.h"

#include "core/io/files/atomic_file.h"
#include "core/io/images/png_codec.h"

namespace plslam {

void WritePng(const std::string& path, const cv::Mat& image, std::optional<int> compression) {
  WriteFileAtomically(path, EncodePng(image, compression));
}

}  // namespace plslam

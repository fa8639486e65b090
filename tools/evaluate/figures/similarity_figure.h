// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/io/maps/map_file.h"
#include "tools/evaluate/figures/drawing.h"

namespace plslam {

/// The similarity matrices of a map's keyframes by points, lines and both (PL-SLAM fig. 5) side by side at column
/// width, each with its own scale: dark for 0, bright for the largest but the highest half per cent of all
/// off-diagonal ones. Of more than 400 keyframes every so many-th is shown. Names are those of the vocabularies'
/// files. Throws std::runtime_error where these cannot be read.
Drawing SimilarityFigure(const std::string& title, const StoredMap& stored, const std::string& point_vocabulary,
                         const std::string& line_vocabulary);

}  // namespace plslam

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plslam {

/// Returns whether the right images of a pair of topics are depth maps by their name: it contains "depth", as those of
/// all drivers do ("aligned_depth_to_color", "depth_registered"), more often than that of the left ones. A name that
/// both share, as of the camera ("/depthai/left", "/depthai/right"), has no meaning.
bool NamesDepth(std::string_view left, std::string_view right);

/// Returns the pairs of image topics that look like a stereo camera (names that differ by left and right, cam0 and
/// cam1, infra1 and infra2, or image_0 and image_1), in the order of their names.
std::vector<std::pair<std::string, std::string>> StereoTopics(const std::set<std::string>& images);

/// Returns the pairs of colour and depth topics of RGB-D cameras: beside a namespace of depth maps in pixels of the
/// colour image ("aligned_depth_to_color", "depth_registered", "depth") is one named color or rgb.
std::vector<std::pair<std::string, std::string>> RgbdTopics(const std::set<std::string>& images);

}  // namespace plslam

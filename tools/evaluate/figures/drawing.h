// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace plslam {

/// Points of print, 1/72 inch; x right, y down, from the upper left corner.
using Place = Eigen::Vector2d;

/// Red, green, blue.
using Ink = std::array<uint8_t, 3>;

struct Stroke {
  Ink ink{};
  double width_pt = 0.75;
  bool dashed = false;
};

/// A polyline; filled where `fill` says so, and then closed.
struct DrawnPath {
  std::vector<Place> places;
  Stroke stroke;
  std::optional<Ink> fill;
};

/// Many lines of one look.
struct DrawnSegments {
  std::vector<std::array<Place, 2>> segments;
  Stroke stroke;
};

/// Many discs of one look.
struct DrawnDots {
  std::vector<Place> places;
  double radius_pt = 1.0;
  Ink ink{};
};

/// One line of text, printable ASCII; `anchor` is the share of its width that lies left of `at`, which is on the base
/// line.
struct DrawnText {
  Place at = Place::Zero();
  std::string text;
  double size_pt = 7.0;
  double anchor = 0.0;
  Ink ink{};
};

/// A picture, 8-bit grey or BGR, stretched over a box.
struct DrawnImage {
  Place corner = Place::Zero();
  Place size = Place::Zero();
  cv::Mat image;
};

/// A figure as a list of shapes, the first lowest: written as SVG, where everything stays sharp, or drawn as pixels.
struct Drawing {
  Place size = Place::Zero();
  std::vector<std::variant<DrawnPath, DrawnSegments, DrawnDots, DrawnText, DrawnImage>> shapes;
};

/// A self-contained SVG document of its size in print; pictures are inside, as PNG.
std::string ToSvg(const Drawing& drawing);

/// On white, 8-bit BGR.
cv::Mat ToPicture(const Drawing& drawing, double pixels_per_pt);

/// Width of a text, in points: an upper bound for the faces of both outputs.
double TextWidth(const std::string& text, double size_pt);

}  // namespace plslam

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

namespace plslam::evaluate {

/// Points of print, 1/72 inch; x right, y down, from the upper left corner.
using Place = Eigen::Vector2d;

/// Red, green, blue.
using Ink = std::array<uint8_t, 3>;

struct Stroke {
  Ink ink{};
  double width_pt = 0.75;
  bool dashed = false;
};

/// A polyline; closed and filled if `fill` is set.
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

/// One line of text, printable ASCII (anything else becomes a question mark); `anchor` is the share of its width that
/// lies left of `at`, which is on the base line. The face is DejaVu Sans; without it the one that fontconfig finds
/// nearest, and without any font cairo's own.
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

/// A figure as a list of shapes, the first lowest, on white.
struct Drawing {
  Place size = Place::Zero();
  std::vector<std::variant<DrawnPath, DrawnSegments, DrawnDots, DrawnText, DrawnImage>> shapes;
};

/// Dots an inch of pictures.
inline constexpr double kPrintDpi = 600.0;

enum class DrawingFormat { kSvg, kPdf, kPng };

/// By the ending of a file's name, in upper or lower case: .svg, .pdf or .png. Throws std::runtime_error for any other.
DrawingFormat DrawingFormatOf(const std::string& path);

/// Writes the drawing in the format of the file's ending, a PNG with `kPrintDpi`; whole or not at all
/// (`WriteFileAtomically`). The same drawing gives the same bytes: no file holds a time. Throws std::runtime_error
/// where the ending is no format or the file cannot be written.
void WriteDrawing(const std::string& path, const Drawing& drawing);

/// An SVG document of its size in print with everything in it: letters are shapes, and pictures are PNG. `id_prefix`
/// begins all ids: drawings in one page need different ones.
std::string ToSvg(const Drawing& drawing, const std::string& id_prefix = "");

/// One page of its size in print, with text that can be selected and searched.
std::string ToPdf(const Drawing& drawing);

/// 8-bit BGR.
cv::Mat ToPicture(const Drawing& drawing, double dpi = kPrintDpi);

/// Width of a text in points, the same in all formats.
double TextWidth(const std::string& text, double size_pt);

}  // namespace plslam::evaluate

// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/drawing/drawing.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <new>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "core/files/atomic_file.h"
#include "core/files/bytes.h"
#include "core/io/images/png_codec.h"

namespace plslam::evaluate {
namespace {

constexpr double kPointsPerInch = 72.0;
constexpr const char* kFace = "DejaVu Sans";

struct CairoDeleter {
  void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_font_options_t* options) const { cairo_font_options_destroy(options); }
};
using Cairo = std::unique_ptr<cairo_t, CairoDeleter>;
using CairoSurface = std::unique_ptr<cairo_surface_t, CairoDeleter>;
using CairoFontOptions = std::unique_ptr<cairo_font_options_t, CairoDeleter>;

void CheckCairo(cairo_status_t status) {
  if (status == CAIRO_STATUS_NO_MEMORY) throw std::bad_alloc();
  if (status != CAIRO_STATUS_SUCCESS) {
    throw std::runtime_error(fmt::format("the drawing fails: {}", cairo_status_to_string(status)));
  }
}

/// Fonts without hints to whole pixels, whatever the settings of the desktop: widths are the same in all formats.
void SelectFont(cairo_t* cairo, double size_pt) {
  const CairoFontOptions options(cairo_font_options_create());
  cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(cairo, options.get());
  cairo_select_font_face(cairo, kFace, CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, size_pt);
}

std::string Printable(const std::string& text) {
  std::string printable = text;
  for (char& c : printable) c = c >= ' ' && c < 127 ? c : '?';
  return printable;
}

double Advance(cairo_t* cairo, const std::string& printable) {
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, printable.c_str(), &extents);
  return extents.x_advance;
}

/// An image in cairo's format. `pixels` must outlive the surface.
CairoSurface ImageSurface(const cv::Mat& image, cv::Mat& pixels) {
  cv::cvtColor(image, pixels, image.channels() == 1 ? cv::COLOR_GRAY2BGRA : cv::COLOR_BGR2BGRA);
  return CairoSurface(cairo_image_surface_create_for_data(pixels.data, CAIRO_FORMAT_RGB24, pixels.cols, pixels.rows,
                                                          static_cast<int>(pixels.step)));
}

/// Draws shapes in points.
class Painter {
 public:
  explicit Painter(cairo_t* cairo) : cairo_(cairo) {
    cairo_set_line_cap(cairo_, CAIRO_LINE_CAP_ROUND);
    cairo_set_line_join(cairo_, CAIRO_LINE_JOIN_ROUND);
  }

  void operator()(const DrawnPath& path) {
    for (const Place& place : path.places) LineTo(place);
    if (path.fill) {
      cairo_close_path(cairo_);
      Use(*path.fill);
      cairo_fill_preserve(cairo_);
    }
    Finish(path.stroke);
  }

  void operator()(const DrawnSegments& segments) {
    for (const auto& [p, q] : segments.segments) {
      MoveTo(p);
      LineTo(q);
    }
    Finish(segments.stroke);
  }

  /// As strokes of no length with round ends: a quarter of the bytes of circles.
  void operator()(const DrawnDots& dots) {
    for (const Place& place : dots.places) {
      MoveTo(place);
      cairo_close_path(cairo_);
    }
    Finish({dots.ink, 2.0 * dots.radius_pt, false});
  }

  void operator()(const DrawnText& text) {
    const std::string printable = Printable(text.text);
    SelectFont(cairo_, text.size_pt);
    Use(text.ink);
    MoveTo({text.at.x() - text.anchor * Advance(cairo_, printable), text.at.y()});
    cairo_show_text(cairo_, printable.c_str());
    cairo_new_path(cairo_);
  }

  void operator()(const DrawnImage& image) {
    if (image.image.empty()) return;
    cv::Mat pixels;
    const CairoSurface surface = ImageSurface(image.image, pixels);
    if (cairo_surface_get_type(cairo_get_target(cairo_)) == CAIRO_SURFACE_TYPE_SVG) {
      Attach(EncodePng(image.image), surface.get());
    }
    const double pt_per_px = image.size.x() / image.image.cols;
    cairo_save(cairo_);
    cairo_translate(cairo_, image.corner.x(), image.corner.y());
    cairo_scale(cairo_, pt_per_px, image.size.y() / image.image.rows);
    cairo_set_source_surface(cairo_, surface.get(), 0.0, 0.0);
    // Pixels that are larger than those of print stay squares.
    const bool larger = pt_per_px * kPrintDpi > kPointsPerInch;
    cairo_pattern_set_filter(cairo_get_source(cairo_), larger ? CAIRO_FILTER_NEAREST : CAIRO_FILTER_GOOD);
    cairo_paint(cairo_);
    cairo_restore(cairo_);
    // Pages are written at their end: an unfinished surface would be copied from `pixels` after their destruction.
    cairo_surface_finish(surface.get());
  }

 private:
  /// Attaches the PNG file itself to be stored in an SVG: cairo would write grey pixels as colour.
  static void Attach(std::string png, cairo_surface_t* surface) {
    auto held = std::make_unique<std::string>(std::move(png));
    const auto* bytes = reinterpret_cast<const unsigned char*>(held->data());
    const auto free = [](void* file) { delete static_cast<std::string*>(file); };
    CheckCairo(cairo_surface_set_mime_data(surface, CAIRO_MIME_TYPE_PNG, bytes, held->size(), free, held.get()));
    // NOLINTNEXTLINE(bugprone-unused-return-value): the surface deletes it.
    held.release();
  }

  // Coordinates far outside the drawing are invisible, and would overflow cairo's fixed-point numbers.
  static double Near(double pt) { return std::clamp(pt, -1e5, 1e5); }
  void MoveTo(const Place& place) { cairo_move_to(cairo_, Near(place.x()), Near(place.y())); }
  /// The first of a path moves there.
  void LineTo(const Place& place) { cairo_line_to(cairo_, Near(place.x()), Near(place.y())); }

  void Use(const Ink& ink) { cairo_set_source_rgb(cairo_, ink[0] / 255.0, ink[1] / 255.0, ink[2] / 255.0); }

  void Finish(const Stroke& stroke) {
    static constexpr std::array<double, 2> kDash_pt{3.0, 2.0};
    if (stroke.width_pt <= 0.0) return cairo_new_path(cairo_);
    Use(stroke.ink);
    cairo_set_line_width(cairo_, stroke.width_pt);
    cairo_set_dash(cairo_, kDash_pt.data(), stroke.dashed ? 2 : 0, 0.0);
    cairo_stroke(cairo_);
  }

  cairo_t* cairo_;
};

/// The one way from shapes to any format. The surface has `units_per_pt` units a point.
void Paint(const Drawing& drawing, double units_per_pt, cairo_surface_t* surface) {
  const Cairo cairo(cairo_create(surface));
  cairo_scale(cairo.get(), units_per_pt, units_per_pt);
  cairo_set_source_rgb(cairo.get(), 1.0, 1.0, 1.0);
  cairo_paint(cairo.get());
  Painter painter(cairo.get());
  for (const auto& shape : drawing.shapes) std::visit(painter, shape);
  CheckCairo(cairo_status(cairo.get()));
  cairo_surface_finish(surface);
  CheckCairo(cairo_surface_status(surface));
}

cairo_status_t AppendTo(void* file, const unsigned char* bytes, unsigned int n) {
  return AppendBytes(*static_cast<std::string*>(file), bytes, n) ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_NO_MEMORY;
}

/// Numbers surfaces and images from 1 in the order of the document: cairo counts them over the whole run of a program,
/// so that they would depend on earlier drawings. `prefix` begins them and the ids of glyphs, which cairo counts by
/// document.
std::string WithOwnIds(const std::string& svg, const std::string& prefix) {
  std::string own;
  std::map<std::string, size_t> numbers;
  size_t copied = 0;
  for (size_t at = svg.find_first_of("\"#"); at != std::string::npos; at = svg.find_first_of("\"#", at + 1)) {
    const bool named = svg[at] == '"' && at >= 4 && svg.compare(at - 4, 4, " id=") == 0;
    const bool used = svg[at] == '#' && at >= 1 && (svg[at - 1] == '"' || svg[at - 1] == '(');
    if (!named && !used) continue;
    const size_t begin = at + 1, end = svg.find_first_of("\")", begin);
    if (end == std::string::npos) break;
    const std::string id = svg.substr(begin, end - begin);
    own.append(svg, copied, begin - copied);
    own += prefix;
    if (id.starts_with("glyph")) {
      own += id;
    } else {
      const size_t number = numbers.emplace(id, numbers.size() + 1).first->second;
      own += fmt::format("{}{}", id.substr(0, id.find_first_of("0123456789")), number);
    }
    copied = at = end;
  }
  return own.append(svg, copied);
}

}  // namespace

DrawingFormat DrawingFormatOf(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending == ".svg") return DrawingFormat::kSvg;
  if (ending == ".pdf") return DrawingFormat::kPdf;
  if (ending == ".png") return DrawingFormat::kPng;
  throw std::runtime_error(path + ": a drawing is written as .svg, .pdf or .png");
}

void WriteDrawing(const std::string& path, const Drawing& drawing) {
  switch (DrawingFormatOf(path)) {
    case DrawingFormat::kSvg:
      return WriteFileAtomically(path, ToSvg(drawing));
    case DrawingFormat::kPdf:
      return WriteFileAtomically(path, ToPdf(drawing));
    case DrawingFormat::kPng:
      return WriteFileAtomically(path, EncodePng(ToPicture(drawing)));
  }
}

std::string ToSvg(const Drawing& drawing, const std::string& id_prefix) {
  std::string svg;
  const CairoSurface surface(cairo_svg_surface_create_for_stream(AppendTo, &svg, drawing.size.x(), drawing.size.y()));
  // The default before cairo 1.18.
  cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_PT);
  Paint(drawing, 1.0, surface.get());
  return WithOwnIds(svg, id_prefix);
}

std::string ToPdf(const Drawing& drawing) {
  std::string pdf;
  const CairoSurface surface(cairo_pdf_surface_create_for_stream(AppendTo, &pdf, drawing.size.x(), drawing.size.y()));
  // Without a date the same drawing is the same file.
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATE_DATE, "");
  Paint(drawing, 1.0, surface.get());
  return pdf;
}

cv::Mat ToPicture(const Drawing& drawing, double dpi) {
  const double px_per_pt = dpi / kPointsPerInch;
  const auto px = [&](double pt) { return std::max(1, static_cast<int>(std::lround(pt * px_per_pt))); };
  cv::Mat pixels(px(drawing.size.y()), px(drawing.size.x()), CV_8UC4);
  const CairoSurface surface(cairo_image_surface_create_for_data(pixels.data, CAIRO_FORMAT_RGB24, pixels.cols,
                                                                 pixels.rows, static_cast<int>(pixels.step)));
  Paint(drawing, px_per_pt, surface.get());
  cv::Mat picture;
  cv::cvtColor(pixels, picture, cv::COLOR_BGRA2BGR);
  return picture;
}

double TextWidth(const std::string& text, double size_pt) {
  const CairoSurface surface(cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1));
  const Cairo cairo(cairo_create(surface.get()));
  SelectFont(cairo.get(), size_pt);
  return Advance(cairo.get(), Printable(text));
}

}  // namespace plslam::evaluate

// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <iterator>

#include "core/io/files/bytes.h"
#include "core/io/images/png_codec.h"
#include "tools/evaluate/figures/drawing.h"

namespace plslam {
namespace {

std::string Name(const Ink& ink) { return fmt::format("#{:02x}{:02x}{:02x}", ink[0], ink[1], ink[2]); }

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '&') {
      escaped += "&amp;";
    } else if (c >= ' ' && c < 127) {
      escaped += c;
    } else {
      escaped += '?';
    }
  }
  return escaped;
}

class SvgWriter {
 public:
  explicit SvgWriter(std::string& svg) : svg_(svg), out_(svg) {}

  void operator()(const DrawnPath& path) {
    if (path.places.empty()) return;
    svg_ += "<path d=\"";
    for (size_t i = 0; i < path.places.size(); ++i) Move(i == 0 ? 'M' : 'L', path.places[i]);
    if (path.fill) svg_ += 'Z';
    fmt::format_to(out_, "\" fill=\"{}\"", path.fill ? Name(*path.fill) : "none");
    Finish(path.stroke);
  }

  void operator()(const DrawnSegments& segments) {
    if (segments.segments.empty()) return;
    svg_ += "<path d=\"";
    for (const auto& [p, q] : segments.segments) {
      Move('M', p);
      Move('L', q);
    }
    svg_ += "\" fill=\"none\"";
    Finish(segments.stroke);
  }

  /// As strokes of no length with round ends: a tenth of the bytes of circles.
  void operator()(const DrawnDots& dots) {
    if (dots.places.empty()) return;
    svg_ += "<path d=\"";
    for (const Place& place : dots.places) {
      Move('M', place);
      svg_ += "h0";
    }
    svg_ += "\" fill=\"none\"";
    Finish({dots.ink, 2.0 * dots.radius_pt, false});
  }

  void operator()(const DrawnText& text) {
    const char* anchor = text.anchor < 0.25 ? "start" : text.anchor < 0.75 ? "middle" : "end";
    fmt::format_to(out_,
                   "<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{:g}\" text-anchor=\"{}\" fill=\"{}\">{}</text>\n",
                   text.at.x(), text.at.y(), text.size_pt, anchor, Name(text.ink), Escaped(text.text));
  }

  void operator()(const DrawnImage& image) {
    fmt::format_to(out_,
                   "<image x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" preserveAspectRatio=\"none\" "
                   "xlink:href=\"data:image/png;base64,{}\"/>\n",
                   image.corner.x(), image.corner.y(), image.size.x(), image.size.y(),
                   Base64(EncodePng(image.image)));
  }

 private:
  void Move(char command, const Place& place) {
    fmt::format_to(out_, "{}{:.2f} {:.2f}", command, place.x(), place.y());
  }

  void Finish(const Stroke& stroke) {
    fmt::format_to(out_, " stroke=\"{}\" stroke-width=\"{:.3g}\"", Name(stroke.ink), stroke.width_pt);
    if (stroke.dashed) svg_ += " stroke-dasharray=\"3 2\"";
    svg_ += "/>\n";
  }

  std::string& svg_;
  std::back_insert_iterator<std::string> out_;
};

}  // namespace

std::string ToSvg(const Drawing& drawing) {
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{0:.2f}pt\" "
      "height=\"{1:.2f}pt\" viewBox=\"0 0 {0:.2f} {1:.2f}\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
      "<g font-family=\"Helvetica, Arial, 'Liberation Sans', sans-serif\" stroke-linecap=\"round\" "
      "stroke-linejoin=\"round\">\n",
      drawing.size.x(), drawing.size.y());
  SvgWriter writer(svg);
  for (const auto& shape : drawing.shapes) std::visit(writer, shape);
  return svg + "</g>\n</svg>\n";
}

}  // namespace plslam

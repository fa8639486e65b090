// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/video/film_writer.h"

#include <fmt/format.h>
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "viewer_headless/video/film_stream.h"

namespace plslam::viewer {
namespace {

/// H.264 by gstreamer1.0-plugins-ugly. MPEG-4 by gstreamer1.0-libav has wrong times, and few players read VP9 in MP4.
constexpr const char* kPipeline =
    "appsrc name=pictures ! videoconvert ! video/x-raw,format=I420 ! "
    "x264enc speed-preset=veryfast pass=quant quantizer=21 ! mp4mux ! filesink name=file";
/// Pictures that wait for the encoder.
constexpr uint64_t kWaitingPictures = 4;
constexpr GstClockTime kTick = 5 * GST_MSECOND;

struct FilmFormat {
  int width_px = 0;
  int height_px = 0;
  double rate_hz = 0.0;

  bool IsGood() const {
    const auto is_side = [](int px) { return px >= 2 && px <= film_stream::kMaxSide_px && px % 2 == 0; };
    return is_side(width_px) && is_side(height_px) && std::isfinite(rate_hz) && rate_hz > 0.0;
  }
};

void Answer(std::FILE* out, const std::string& line) {
  std::fputs((line + "\n").c_str(), out);
  std::fflush(out);
}

int Refuse(std::FILE* out, const std::string& why) {
  Answer(out, film_stream::kError + why);
  return 1;
}

/// Returns the reason why the file cannot be written, by trying: GStreamer reports it in the words of its plug-ins.
/// Empty if it can be written.
std::string WhyNotWritable(const std::string& part) {
  const std::vector<char> some(64 * 1024);
  errno = 0;
  std::FILE* file = std::fopen(part.c_str(), "ab");
  const bool written = file != nullptr && std::fwrite(some.data(), 1, some.size(), file) == some.size();
  const bool closed = file != nullptr && std::fclose(file) == 0;
  return written && closed ? "" : std::strerror(errno);
}

template <class T>
using GstPointer = std::unique_ptr<T, void (*)(gpointer)>;

/// Encodes pictures into an MP4 file.
class FilmPipeline {
 public:
  FilmPipeline(const std::string& file, const FilmFormat& format) : format_(format) {
    pipeline_.reset(gst_parse_launch_full(kPipeline, nullptr, GST_PARSE_FLAG_FATAL_ERRORS, nullptr));
    if (!pipeline_) return;
    GstElement* const source = gst_bin_get_by_name(GST_BIN(pipeline_.get()), "pictures");
    pictures_.reset(source);
    int numerator = 20, denominator = 1;
    gst_util_double_to_fraction(format.rate_hz, &numerator, &denominator);
    GstCaps* const caps = gst_caps_new_simple("video/x-raw", "format", G_TYPE_STRING, "BGR", "width", G_TYPE_INT,
                                              format.width_px, "height", G_TYPE_INT, format.height_px, "framerate",
                                              GST_TYPE_FRACTION, numerator, denominator, nullptr);
    g_object_set(source, "caps", caps, "format", GST_FORMAT_TIME, "max-bytes", guint64{0}, nullptr);
    gst_caps_unref(caps);
    const GstPointer<GstElement> sink(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "file"), gst_object_unref);
    g_object_set(sink.get(), "location", file.c_str(), nullptr);
    bus_.reset(gst_element_get_bus(pipeline_.get()));
  }
  ~FilmPipeline() {
    if (pipeline_) gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
  }
  FilmPipeline(const FilmPipeline&) = delete;
  FilmPipeline& operator=(const FilmPipeline&) = delete;

  bool has_encoder() const { return pipeline_ != nullptr; }
  /// Opens the file. Returns whether that succeeded, as `Add` and `Finish` do.
  bool Start() { return gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING) != GST_STATE_CHANGE_FAILURE; }

  /// Reads a picture, BGR. `is_whole` becomes false if the input ends within it.
  bool Add(std::FILE* in, bool* is_whole) {
    if (!WaitForEncoder()) return false;
    GstBuffer* const buffer = gst_buffer_new_allocate(nullptr, PictureBytes(), nullptr);
    GstMapInfo map;
    gst_buffer_map(buffer, &map, GST_MAP_WRITE);
    const auto row_bytes = static_cast<size_t>(3 * format_.width_px);
    for (int y = 0; y < format_.height_px && *is_whole; ++y) {
      *is_whole = std::fread(map.data + static_cast<size_t>(y) * Stride(), 1, row_bytes, in) == row_bytes;
    }
    gst_buffer_unmap(buffer, &map);
    const auto time = [this](int64_t n) {
      return static_cast<GstClockTime>(1e9 * static_cast<double>(n) / format_.rate_hz);
    };
    GST_BUFFER_PTS(buffer) = time(n_);
    GST_BUFFER_DURATION(buffer) = time(n_ + 1) - time(n_);
    ++n_;
    return gst_app_src_push_buffer(GST_APP_SRC(pictures_.get()), buffer) == GST_FLOW_OK;
  }

  /// Completes the file.
  bool Finish() {
    if (gst_app_src_end_of_stream(GST_APP_SRC(pictures_.get())) != GST_FLOW_OK) return false;
    constexpr auto kEnds = static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR);
    const GstPointer<GstMessage> end(gst_bus_timed_pop_filtered(bus_.get(), GST_CLOCK_TIME_NONE, kEnds), FreeMessage);
    const bool complete = GST_MESSAGE_TYPE(end.get()) == GST_MESSAGE_EOS;
    return gst_element_set_state(pipeline_.get(), GST_STATE_NULL) != GST_STATE_CHANGE_FAILURE && complete;
  }

 private:
  static void FreeMessage(gpointer message) { gst_message_unref(static_cast<GstMessage*>(message)); }
  /// Returns when few pictures wait for the encoder; false if it has failed. (An appsrc that blocks would do so forever
  /// after a failure.)
  bool WaitForEncoder() {
    do {
      const bool is_full =
          gst_app_src_get_current_level_bytes(GST_APP_SRC(pictures_.get())) > kWaitingPictures * PictureBytes();
      const GstPointer<GstMessage> error(
          gst_bus_timed_pop_filtered(bus_.get(), is_full ? kTick : 0, GST_MESSAGE_ERROR), FreeMessage);
      if (error) return false;
      if (!is_full) return true;
    } while (true);
  }
  /// Rows of GStreamer begin at multiples of four bytes.
  size_t Stride() const { return GST_ROUND_UP_4(static_cast<size_t>(3 * format_.width_px)); }
  size_t PictureBytes() const { return Stride() * static_cast<size_t>(format_.height_px); }

  const FilmFormat format_;
  GstPointer<GstElement> pipeline_{nullptr, gst_object_unref};
  GstPointer<GstElement> pictures_{nullptr, gst_object_unref};
  GstPointer<GstBus> bus_{nullptr, gst_object_unref};
  int64_t n_ = 0;
};

int RefuseToWrite(std::FILE* out, const std::string& file) {
  const std::string part = film_stream::PartOf(file);
  const std::string why = WhyNotWritable(part);
  std::remove(part.c_str());
  return Refuse(out, fmt::format("{}: cannot be written: {}", file, why.empty() ? "the encoder failed" : why));
}

}  // namespace

int WriteFilm(const std::string& file, std::FILE* in, std::FILE* out) {
  char line[256];
  if (std::fgets(line, sizeof(line), in) == nullptr) return 0;
  FilmFormat format;
  if (std::sscanf(line, "%d %d %lf", &format.width_px, &format.height_px, &format.rate_hz) != 3 || !format.IsGood()) {
    return Refuse(out, fmt::format("{}: a film needs an even width and height of at most {} pixels, and a rate", file,
                                   film_stream::kMaxSide_px));
  }
  const std::string part = film_stream::PartOf(file);
  FilmPipeline film(part, format);
  if (!film.has_encoder()) {
    Answer(out, film_stream::kUnable + file +
                    ": GStreamer cannot write MP4 files here (packages gstreamer1.0-plugins-good and -ugly)");
    return 1;
  }
  if (!film.Start()) return RefuseToWrite(out, file);
  Answer(out, film_stream::kReady);
  int mark = std::fgetc(in);
  for (bool is_whole = true; mark == film_stream::kPicture; mark = is_whole ? std::fgetc(in) : EOF) {
    if (film.Add(in, &is_whole)) continue;
    RefuseToWrite(out, file);
    // The viewer reads the answer before the next picture, which it must be able to send.
    while (std::fgetc(in) != EOF) {
    }
    return 1;
  }
  if (mark != film_stream::kEnd) {
    std::remove(part.c_str());
    return Refuse(out, file + ": the pictures ended before the film was complete");
  }
  if (!film.Finish()) return RefuseToWrite(out, file);
  std::error_code error;
  std::filesystem::rename(part, file, error);
  if (error) {
    std::remove(part.c_str());
    return Refuse(out, fmt::format("{}: cannot be renamed: {}", file, error.message()));
  }
  Answer(out, film_stream::kDone);
  return 0;
}

}  // namespace plslam::viewer

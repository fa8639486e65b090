// SPDX-License-Identifier: BSD-3-Clause
#include "camera/camera_pipeline.h"

#include <fmt/format.h>
#include <gst/app/gstappsink.h>
#include <gst/gst.h>
#include <gst/video/video.h>

#include <stdexcept>

#include "camera/pipeline_text.h"
#include "core/bus/transport/wall_clock.h"

namespace plslam::camera {
namespace {

/// Limit for opening files and decoding their first images.
constexpr GstClockTime kPrepareLimit = 10 * GST_SECOND;
/// A failed element reports its reason a little later, on its own thread.
constexpr GstClockTime kFailureLimit = GST_SECOND / 2;
/// Buffers of each camera; of live cameras, the oldest is dropped when there are more.
constexpr guint kMostBuffers = 4;
constexpr size_t kLongestDetails = 120;

template <class T>
using Owned = std::unique_ptr<T, void (*)(T*)>;

template <class T>
Owned<T> Own(T* object) {
  return {object, [](T* o) { gst_object_unref(o); }};
}

void InitialiseOnce() {
  static const bool done = [] {
    gst_init(nullptr, nullptr);
    return true;
  }();
  static_cast<void>(done);
}

/// "Cannot identify device '/dev/video9'. (v4l2src0: system error: No such file or directory)".
std::string SentenceOf(GstMessage* message) {
  GError* error = nullptr;
  gchar* debug = nullptr;
  gst_message_parse_error(message, &error, &debug);
  const std::string details = debug == nullptr ? "" : debug;
  // The first line is the location in GStreamer's own source.
  const size_t line = details.find('\n');
  std::string more = line == std::string::npos ? "" : details.substr(line + 1);
  for (char& c : more) c = c == '\n' ? ' ' : c;
  if (more.size() > kLongestDetails) more = more.substr(0, kLongestDetails) + "...";
  std::string text = fmt::format("{} ({}{}{})", error->message, GST_OBJECT_NAME(GST_MESSAGE_SRC(message)),
                                 more.empty() ? "" : ": ", more);
  if (details.find("not-negotiated") != std::string::npos) {
    text += "; is `videoconvert ! video/x-raw,format=GRAY8` before each appsink, and does the camera have this size?";
  }
  if (details.find("Missing decoder") != std::string::npos) text += "; apt-get install gstreamer1.0-libav";
  g_error_free(error);
  g_free(debug);
  return text;
}

}  // namespace

struct CameraPipeline::Impl {
  explicit Impl(Wakeup* w) : wakeup(w) {}

  Wakeup* wakeup;
  Owned<GstElement> pipeline = Own<GstElement>(nullptr);
  Owned<GstBus> bus = Own<GstBus>(nullptr);
  std::array<Owned<GstElement>, 2> sinks{Own<GstElement>(nullptr), Own<GstElement>(nullptr)};

  GstAppSink* Sink(Side side) const { return GST_APP_SINK(sinks[static_cast<size_t>(side)].get()); }
  void FindSink(Side side);
  void ListenTo(Side side);
  std::string FailureText(GstClockTime patience = 0) const;
};

namespace {

const char* NameOf(Side side) { return side == Side::kLeft ? kLeftSink : kRightSink; }

Owned<GstElement> Parse(const std::string& text) {
  GError* error = nullptr;
  GstElement* element = gst_parse_launch_full(text.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &error);
  if (error != nullptr) {
    std::string why = error->message;
    if (g_error_matches(error, GST_PARSE_ERROR, GST_PARSE_ERROR_NO_SUCH_ELEMENT) == TRUE) {
      why += ": apt-get install gstreamer1.0-plugins-good (libaravis-0.8-0 for aravissrc), or give another";
    }
    g_error_free(error);
    if (element != nullptr) gst_object_unref(element);
    throw std::runtime_error(fmt::format("the pipeline cannot be built: {}", why));
  }
  if (!GST_IS_PIPELINE(element)) {
    // A single element, which has no appsinks.
    gst_object_unref(element);
    throw std::runtime_error("the pipeline is a single element, but must end in two appsinks, left and right");
  }
  return Own(element);
}

}  // namespace

void CameraPipeline::Impl::FindSink(Side side) {
  auto& sink = sinks[static_cast<size_t>(side)];
  sink.reset(gst_bin_get_by_name(GST_BIN(pipeline.get()), NameOf(side)));
  if (!sink || !GST_IS_APP_SINK(sink.get())) {
    throw std::runtime_error(
        fmt::format("the pipeline has no `appsink name={0}`: the {0} images must end there", NameOf(side)));
  }
}

void CameraPipeline::Impl::ListenTo(Side side) {
  GstAppSink* sink = Sink(side);
  GstAppSinkCallbacks callbacks{};
  callbacks.eos = [](GstAppSink*, gpointer user) { static_cast<Wakeup*>(user)->Call(); };
  callbacks.new_sample = [](GstAppSink*, gpointer user) {
    static_cast<Wakeup*>(user)->Call();
    return GST_FLOW_OK;
  };
  gst_app_sink_set_callbacks(sink, &callbacks, wakeup, nullptr);
  gst_app_sink_set_max_buffers(sink, kMostBuffers);
  gst_app_sink_set_drop(sink, FALSE);
  gst_base_sink_set_sync(GST_BASE_SINK(sink), FALSE);
  GstCaps* caps = gst_caps_from_string("video/x-raw,format=GRAY8");
  gst_app_sink_set_caps(sink, caps);
  gst_caps_unref(caps);
}

/// Errors only: the others are dropped before they are kept.
std::string CameraPipeline::Impl::FailureText(GstClockTime patience) const {
  GstMessage* message = gst_bus_timed_pop_filtered(bus.get(), patience, GST_MESSAGE_ERROR);
  if (message == nullptr) return "";
  std::string text = SentenceOf(message);
  gst_message_unref(message);
  return text;
}

CameraPipeline::CameraPipeline(const std::string& text, Wakeup* wakeup) : impl_(std::make_unique<Impl>(wakeup)) {
  InitialiseOnce();
  impl_->pipeline = Parse(text);
  for (const Side side : {Side::kLeft, Side::kRight}) impl_->FindSink(side);
  for (const Side side : {Side::kLeft, Side::kRight}) impl_->ListenTo(side);
  auto* pipeline = GST_PIPELINE(impl_->pipeline.get());
  gst_pipeline_use_clock(pipeline, Own(gst_system_clock_obtain()).get());
  impl_->bus = Own(gst_pipeline_get_bus(pipeline));
  const auto keep_errors = [](GstBus*, GstMessage* message, gpointer user) {
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
      static_cast<Wakeup*>(user)->Call();
      return GST_BUS_PASS;
    }
    gst_message_unref(message);
    return GST_BUS_DROP;
  };
  gst_bus_set_sync_handler(impl_->bus.get(), keep_errors, wakeup, nullptr);
  const auto fail = [this](const char* otherwise) {
    const std::string why = impl_->FailureText(kFailureLimit);
    gst_element_set_state(impl_->pipeline.get(), GST_STATE_NULL);
    throw std::runtime_error(why.empty() ? otherwise : why);
  };
  GstStateChangeReturn change = gst_element_set_state(impl_->pipeline.get(), GST_STATE_PAUSED);
  if (change == GST_STATE_CHANGE_ASYNC) {
    change = gst_element_get_state(impl_->pipeline.get(), nullptr, nullptr, kPrepareLimit);
  }
  if (change == GST_STATE_CHANGE_FAILURE) fail("the pipeline cannot be started");
  if (change == GST_STATE_CHANGE_ASYNC) fail("the pipeline produced no image within 10 s");
  is_live_ = change == GST_STATE_CHANGE_NO_PREROLL;
  if (!is_live_) return;
  for (const Side side : {Side::kLeft, Side::kRight}) gst_app_sink_set_drop(impl_->Sink(side), TRUE);
}

CameraPipeline::~CameraPipeline() {
  if (!impl_->pipeline) return;
  gst_element_set_state(impl_->pipeline.get(), GST_STATE_NULL);
  gst_bus_set_sync_handler(impl_->bus.get(), nullptr, nullptr, nullptr);
}

void CameraPipeline::Play() { gst_element_set_state(impl_->pipeline.get(), GST_STATE_PLAYING); }

std::string CameraPipeline::Failure() { return impl_->FailureText(); }

bool CameraPipeline::ended(Side side) const { return gst_app_sink_is_eos(impl_->Sink(side)) == TRUE; }

namespace {

cv::Mat CopyPixels(GstSample* sample, const char* side) {
  GstVideoInfo info;
  const GstCaps* caps = gst_sample_get_caps(sample);
  if (caps == nullptr || gst_video_info_from_caps(&info, caps) == FALSE) {
    throw std::runtime_error(fmt::format("the {} images are not raw video", side));
  }
  GstVideoFrame frame;
  if (gst_video_frame_map(&frame, &info, gst_sample_get_buffer(sample), GST_MAP_READ) == FALSE) {
    throw std::runtime_error(fmt::format("a {} image cannot be read", side));
  }
  const cv::Mat pixels(GST_VIDEO_FRAME_HEIGHT(&frame), GST_VIDEO_FRAME_WIDTH(&frame), CV_8UC1,
                       GST_VIDEO_FRAME_PLANE_DATA(&frame, 0),
                       static_cast<size_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0)));
  cv::Mat copy = pixels.clone();
  gst_video_frame_unmap(&frame);
  return copy;
}

int64_t RunningTime_ns(GstSample* sample, const char* side) {
  const GstBuffer* buffer = gst_sample_get_buffer(sample);
  if (!GST_BUFFER_PTS_IS_VALID(buffer)) {
    throw std::runtime_error(fmt::format(
        "the {} images have no times: give their rate, as in multifilesrc caps=image/png,framerate=20/1", side));
  }
  const GstSegment* segment = gst_sample_get_segment(sample);
  const guint64 t_ns = gst_segment_to_running_time(segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
  return static_cast<int64_t>(GST_CLOCK_TIME_IS_VALID(t_ns) ? t_ns : GST_BUFFER_PTS(buffer));
}

}  // namespace

std::optional<CapturedImage> CameraPipeline::Take(Side side) {
  GstSample* sample = gst_app_sink_try_pull_sample(impl_->Sink(side), 0);
  if (sample == nullptr) return std::nullopt;
  const std::unique_ptr<GstSample, void (*)(GstSample*)> owned(sample, gst_sample_unref);
  const int64_t base_ns =
      is_live_ ? static_cast<int64_t>(gst_element_get_base_time(impl_->pipeline.get())) : int64_t{0};
  return CapturedImage{base_ns + RunningTime_ns(sample, NameOf(side)), CopyPixels(sample, NameOf(side))};
}

int64_t UtcOfGstClock_ns() {
  InitialiseOnce();
  const auto clock = Own(gst_system_clock_obtain());
  return 1000 * bus::WallClock_us() - static_cast<int64_t>(gst_clock_get_time(clock.get()));
}

}  // namespace plslam::camera

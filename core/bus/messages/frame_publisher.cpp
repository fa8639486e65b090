#include <algorithm>
#include <stdexcept>

#include "core/bus/messages/frame_assembler.h"
#include "core/bus/messages/frame_channel.h"
#include "plslam/image_strip_t.hpp"

namespace plslam::bus {
namespace {

const char* EncodingOf(const cv::Mat& image, bool is_right) {
  if (image.type() == CV_8UC1) return "mono8";
  if (image.type() == CV_16UC1 && is_right) return "depth16";
  throw std::invalid_argument("a frame needs 8-bit grey images, or a 16-bit depth map on the right; OpenCV type " +
                              std::to_string(image.type()) + " is neither");
}

/// Bytes of image in each strip: whole rows where one fits, else what fits.
int64_t StripBytes(const image_strip_t& empty, int64_t row_bytes, int64_t page_bytes) {
  const int64_t room = page_bytes - empty.getEncodedSize();
  if (room < 256) throw std::invalid_argument("bus.max_message_bytes leaves no room for images");
  return room >= row_bytes ? room / row_bytes * row_bytes : room;
}

void CheckSize(const StereoImages& frame, const cv::Mat& image) {
  if (image.empty()) throw std::invalid_argument("a frame needs two images");
  if (FrameAssembler::CanHold(image.cols, image.rows, static_cast<int64_t>(image.elemSize()))) return;
  throw std::runtime_error("frame " + std::to_string(frame.frame_id) + ": an image of " + std::to_string(image.cols) +
                           " x " + std::to_string(image.rows) + " pixels, " + std::to_string(image.elemSize()) +
                           " bytes each, is larger than readers take (" +
                           std::to_string(FrameAssembler::kMaxImageBytes) + " bytes, " +
                           std::to_string(FrameAssembler::kMaxSide_px) + " pixels a side)");
}

}  // namespace

FramePublisher::FramePublisher(Bus& bus, bool lockstep) : bus_(bus), lockstep_(lockstep) {}

void FramePublisher::Publish(const StereoImages& images) {
  CheckSize(images, images.left);
  CheckSize(images, images.right);
  PublishImage(images, images.left, 0);
  PublishImage(images, images.right, 1);
}

void FramePublisher::PublishImage(const StereoImages& frame, const cv::Mat& image, int8_t camera) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  image_strip_t strip{};
  strip.header.t_ns = frame.t_ns;
  strip.frame_id = frame.frame_id;
  strip.camera = camera;
  strip.width_px = whole.cols;
  strip.height_px = whole.rows;
  strip.encoding = EncodingOf(whole, camera == 1);
  const auto total = static_cast<int64_t>(whole.total() * whole.elemSize());
  const int64_t run = StripBytes(strip, total / whole.rows, bus_.page_bytes());
  strip.n_strips = static_cast<int32_t>((total + run - 1) / run);
  for (int64_t offset = 0; offset < total; offset += run, ++strip.strip) {
    const int64_t end = std::min(total, offset + run);
    strip.offset_bytes = static_cast<int32_t>(offset);
    strip.n_bytes = static_cast<int32_t>(end - offset);
    strip.data.assign(whole.data + offset, whole.data + end);
    bus_.Publish(lockstep_ ? kStereoFrame : kStereoFrameLive, strip);
  }
}

}  // namespace plslam::bus

// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/frame_assembler.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "plslam/image_strip_t.hpp"

namespace plslam::bus {
namespace {

/// All strips of an image but the last have at least so many bytes, so that a few strips cannot claim a table of
/// millions.
constexpr int64_t kMinStripBytes = 256;

/// Returns the OpenCV type of an encoding for that camera; -1 if it is invalid.
int PixelType(const image_strip_t& strip) {
  if (strip.encoding == strip_encoding::kGrey) return CV_8UC1;
  return strip.encoding == strip_encoding::kDepth && strip.camera == 1 ? CV_16UC1 : -1;
}

}  // namespace

bool FrameAssembler::Image::Tiled() const {
  int64_t end = 0;
  for (const Tile& tile : tiles) {
    if (tile.offset != end) return false;
    end += tile.bytes;
  }
  return end == bytes;
}

bool FrameAssembler::CanHold(int32_t width_px, int32_t height_px, int64_t pixel_bytes) {
  return width_px > 0 && height_px > 0 && width_px <= kMaxSide_px && height_px <= kMaxSide_px &&
         pixel_bytes * width_px * height_px <= kMaxImageBytes;
}

/// Fills in the image's properties from its first strip, if they are valid.
bool FrameAssembler::Describe(const image_strip_t& strip, Image& image) {
  const int type = PixelType(strip);
  const int64_t pixel_bytes = type == CV_16UC1 ? 2 : 1;
  if (type < 0 || !CanHold(strip.width_px, strip.height_px, pixel_bytes)) return false;
  const int64_t bytes = pixel_bytes * strip.width_px * strip.height_px;
  if (strip.n_strips < 1 || strip.n_strips > 1 + bytes / kMinStripBytes) return false;
  image.bytes = bytes;
  image.encoding = strip.encoding;
  image.tiles.resize(static_cast<size_t>(strip.n_strips));
  image.pixels.create(strip.height_px, strip.width_px, type);
  return true;
}

bool FrameAssembler::Fits(const image_strip_t& strip, const Image& image) {
  return strip.width_px == image.pixels.cols && strip.height_px == image.pixels.rows &&
         strip.encoding == image.encoding && strip.n_strips == static_cast<int32_t>(image.tiles.size()) &&
         strip.strip >= 0 && strip.strip < strip.n_strips && strip.n_bytes > 0 && strip.offset_bytes >= 0 &&
         int64_t{strip.offset_bytes} + strip.n_bytes <= image.bytes &&
         static_cast<size_t>(strip.n_bytes) == strip.data.size();
}

FrameAssembler::Partial& FrameAssembler::PartialOf(const image_strip_t& strip) {
  const SourceId source(strip.header.source);
  const auto found = std::find_if(partials_.begin(), partials_.end(), [&](const Partial& p) {
    return p.source == source && p.frame_id == FrameId(strip.frame_id);
  });
  if (found != partials_.end()) return *found;
  Partial& partial = partials_.emplace_back();
  partial.source = source;
  partial.frame_id = FrameId(strip.frame_id);
  partial.t_ns = strip.header.t_ns;
  return partial;
}

FrameAssembler::Outcome FrameAssembler::Add(const image_strip_t& strip) {
  if (strip.camera != 0 && strip.camera != 1) return Outcome::kNonsense;
  if (strip.header.seq < std::max(strip.strip, 0)) return Outcome::kNonsense;  // strips before it have numbers too
  Partial& partial = PartialOf(strip);
  Image& image = partial.images[strip.camera == 1 ? 1 : 0];
  const bool known = !image.tiles.empty() || Describe(strip, image);
  if (!known || !Fits(strip, image) || partial.t_ns != strip.header.t_ns) {
    Forget(SourceId(strip.header.source), FrameId(strip.frame_id));
    return Outcome::kNonsense;
  }
  Tile& tile = image.tiles[static_cast<size_t>(strip.strip)];
  if (tile.bytes != 0) return Outcome::kRepeated;
  tile = {strip.offset_bytes, strip.n_bytes};
  ++image.received;
  std::memcpy(image.pixels.data + strip.offset_bytes, strip.data.data(), strip.data.size());
  if (strip.camera == 0) partial.left_seq = strip.header.seq - strip.strip;
  Bound(partial);
  if (!partial.images[0].Complete() || !partial.images[1].Complete()) return Outcome::kTaken;

  const bool whole = partial.images[0].Tiled() && partial.images[1].Tiled();
  if (whole) {
    complete_ = AssembledFrame{
        {partial.frame_id, partial.t_ns, std::move(partial.images[0].pixels), std::move(partial.images[1].pixels)},
        partial.source,
        partial.left_seq,
        static_cast<int64_t>(partial.images[0].tiles.size() + partial.images[1].tiles.size())};
  }
  partials_.remove_if([&](const Partial& p) { return &p == &partial; });
  return whole ? Outcome::kComplete : Outcome::kNonsense;
}

AssembledFrame FrameAssembler::TakeFrame() { return std::move(*std::exchange(complete_, std::nullopt)); }

void FrameAssembler::Forget(SourceId source, FrameId frame_id) {
  partials_.remove_if([&](const Partial& p) { return p.source == source && p.frame_id <= frame_id; });
}

void FrameAssembler::Bound(const Partial& newest) {
  const auto bytes = [&] {
    int64_t sum = 0;
    for (const Partial& p : partials_) sum += p.images[0].bytes + p.images[1].bytes;
    return sum;
  };
  while ((partials_.size() > kMaxPartial || bytes() > kMaxBytes) && &partials_.front() != &newest) {
    partials_.pop_front();
  }
}

}  // namespace plslam::bus

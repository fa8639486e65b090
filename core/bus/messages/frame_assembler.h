// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <list>
#include <optional>
#include <string>
#include <vector>

#include "core/ids/ids.h"
#include "core/io/images/image_file.h"

namespace plslam {
class image_strip_t;
}

namespace plslam::bus {

/// Values of `image_strip_t.encoding`.
namespace strip_encoding {
inline constexpr const char* kGrey = "mono8";
inline constexpr const char* kDepth = "depth16";  ///< of the right image only
}  // namespace strip_encoding

/// A frame put together from strips.
struct AssembledFrame {
  StereoImages images;
  SourceId source;
  int64_t first_seq = 0;  ///< number of its first strip
  int64_t n_strips = 0;   ///< of both images
  double came_s = 0.0;    ///< steady clock, when it was complete
};

/// Puts strips together, in any order and with repetitions, for any number of publishers. Memory is bounded, whatever
/// the strips claim: at most kMaxPartial unfinished frames and kMaxBytes; the oldest are given up.
class FrameAssembler {
 public:
  static constexpr int64_t kMaxImageBytes = 64'000'000;
  static constexpr int32_t kMaxSide_px = 32'768;
  static constexpr size_t kMaxPartial = 8;
  static constexpr int64_t kMaxBytes = 4 * kMaxImageBytes;

  /// Returns whether an image of this size is accepted, with so many bytes for a pixel.
  static bool CanHold(int32_t width_px, int32_t height_px, int64_t pixel_bytes);

  enum class Outcome { kTaken, kRepeated, kComplete, kNonsense };

  /// kComplete: `TakeFrame` has the frame. kNonsense: sizes that do not fit together; the frame is given up.
  Outcome Add(const image_strip_t& strip);
  AssembledFrame TakeFrame();

  /// Gives up unfinished frames of `source` up to `frame_id`.
  void Forget(SourceId source, FrameId frame_id);
  size_t partial() const { return partials_.size(); }

 private:
  struct Tile {
    int32_t offset = 0;
    int32_t bytes = 0;  // 0: not here yet
  };
  struct Image {
    cv::Mat pixels;
    std::string encoding;
    std::vector<Tile> tiles;
    size_t received = 0;
    int64_t bytes = 0;

    bool Complete() const { return !tiles.empty() && received == tiles.size(); }
    bool Tiled() const;
  };
  struct Partial {
    SourceId source;
    FrameId frame_id = 0;
    int64_t t_ns = 0;
    int64_t left_seq = 0;  // number of the first left strip
    std::array<Image, 2> images;
  };

  Partial& PartialOf(const image_strip_t& strip);
  static bool Describe(const image_strip_t& strip, Image& image);
  static bool Fits(const image_strip_t& strip, const Image& image);
  void Bound(const Partial& newest);

  std::list<Partial> partials_;  // oldest first
  std::optional<AssembledFrame> complete_;
};

}  // namespace plslam::bus

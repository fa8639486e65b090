#include "core/io/png_filter.h"

#include <algorithm>

namespace plslam {
namespace {

enum Filter : uint8_t { kNone, kSub, kUp, kAverage, kPaeth };

/// Paeth's choice: of left `a`, above `b` and above left `c` the nearest to a + b - c, the first of equals. Without a
/// branch, and for numbers and lanes of them: where 3c - a - b is beyond both a and b it is the one on the other side,
/// and c where it lies between them.
template <class T>
T Paeth(T a, T b, T c) {
  const T side = 3 * c - a - b;
  const T low = a < b ? a : b;
  const T high = a < b ? b : a;
  const T low_or_c = high <= side ? low : c;
  return side <= low ? high : low_or_c;
}

/// `predict(left, above, above_left)` of every byte is added to it.
template <class Predict>
void Add(uint8_t* row, const uint8_t* above, size_t row_bytes, size_t pixel_bytes, const Predict& predict) {
  const size_t edge = std::min(pixel_bytes, row_bytes);
  for (size_t x = 0; x < edge; ++x) row[x] = static_cast<uint8_t>(row[x] + predict(0, above[x], 0));
  for (size_t x = edge; x < row_bytes; ++x) {
    row[x] = static_cast<uint8_t>(row[x] + predict(row[x - pixel_bytes], above[x], above[x - pixel_bytes]));
  }
}

bool UndoRow(Filter filter, uint8_t* row, const uint8_t* above, size_t row_bytes, size_t pixel_bytes) {
  switch (filter) {
    case kNone:
      return true;
    case kSub:
      Add(row, above, row_bytes, pixel_bytes, [](int a, int, int) { return a; });
      return true;
    case kUp:
      Add(row, above, row_bytes, pixel_bytes, [](int, int b, int) { return b; });
      return true;
    case kAverage:
      Add(row, above, row_bytes, pixel_bytes, [](int a, int b, int) { return (a + b) / 2; });
      return true;
    case kPaeth:
      Add(row, above, row_bytes, pixel_bytes, Paeth<int>);
      return true;
  }
  return false;
}

// Each byte of a Paeth row waits for the one before it. Eight rows at once, each a byte behind the row above it, keep the
// processor busy: the new bytes of all lanes are what the lanes below them have above next.
constexpr size_t kLanes = 8;
using Lanes = int16_t __attribute__((vector_size(2 * kLanes)));

class PaethRows {
 public:
  /// `first` byte of the first row, `stride` from row to row; the row above it ends where it begins.
  PaethRows(uint8_t* first, size_t stride, size_t row_bytes)
      : first_(first), stride_(stride), row_bytes_(row_bytes) {}

  void Undo() {
    const size_t end = row_bytes_ + kLanes - 1;
    const size_t middle = std::min(kLanes - 1, end);
    for (size_t x = 0; x < middle; ++x) Step<true>(x);
    for (size_t x = middle; x < row_bytes_; ++x) Step<false>(x);
    for (size_t x = std::max(middle, row_bytes_); x < end; ++x) Step<true>(x);
  }

 private:
  /// Byte x of the first row, x - 1 of the second, and so on; `kAtEdge`: some of them are none.
  template <bool kAtEdge>
  void Step(size_t x) {
    const auto is_byte = [&](size_t lane) { return !kAtEdge || (x >= lane && x - lane < row_bytes_); };
    const auto at = [&](size_t lane) -> uint8_t& { return first_[lane * stride_ + x - lane]; };
    Lanes filtered{};
    for (size_t lane = 0; lane < kLanes; ++lane) {
      if (is_byte(lane)) filtered[lane] = at(lane);
    }
    const Lanes above_left = above_;
    above_ = __builtin_shuffle(left_, Lanes{7, 0, 1, 2, 3, 4, 5, 6});
    above_[0] = is_byte(0) ? *(&at(0) - stride_) : 0;
    left_ = (filtered + Paeth(left_, above_, above_left)) & 0xff;
    for (size_t lane = 0; lane < kLanes; ++lane) {
      if (is_byte(lane)) at(lane) = static_cast<uint8_t>(left_[lane]);
    }
  }

  uint8_t* first_;
  size_t stride_;
  size_t row_bytes_;
  Lanes left_{};
  Lanes above_{};
};

}  // namespace

bool UndoPngFilters(std::vector<uint8_t>& rows, size_t n_rows, size_t row_bytes, size_t pixel_bytes) {
  const size_t stride = row_bytes + 1;
  const std::vector<uint8_t> zeros(row_bytes);
  const auto is_paeth = [&](size_t y) { return rows[y * stride] == kPaeth; };
  for (size_t y = 0; y < n_rows;) {
    uint8_t* const row = &rows[y * stride] + 1;
    size_t n_paeth = 0;
    while (n_paeth < kLanes && y + n_paeth < n_rows && is_paeth(y + n_paeth)) ++n_paeth;
    if (pixel_bytes == 1 && y > 0 && n_paeth == kLanes) {
      PaethRows(row, stride, row_bytes).Undo();
      y += kLanes;
      continue;
    }
    const auto filter = static_cast<Filter>(rows[y * stride]);
    if (!UndoRow(filter, row, y > 0 ? row - stride : zeros.data(), row_bytes, pixel_bytes)) return false;
    ++y;
  }
  return true;
}

}  // namespace plslam

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace plslam {

/// Undoes the filters of PNG (ISO/IEC 15948, 9.2) in place. `rows` holds, for each of `n_rows`, its filter and
/// `row_bytes` bytes; a pixel has `pixel_bytes`. False where a filter is none.
bool UndoPngFilters(std::vector<uint8_t>& rows, size_t n_rows, size_t row_bytes, size_t pixel_bytes);

}  // namespace plslam

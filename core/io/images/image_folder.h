// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <tuple>

namespace plslam {

/// Key of an image within its folder: the last number of its name (an integer, or with a point: "1305031102.175"), or
/// the whole name without extension if it has no number. Ordered by value, names without a number last.
struct ImageKey {
  bool has_number = false;
  std::string whole;     ///< digits before the point, without leading zeros
  std::string fraction;  ///< digits after it
  std::string name;      ///< if there is no number

  bool operator<(const ImageKey& other) const {
    const auto rank = [](const ImageKey& k) {
      return std::tuple(!k.has_number, k.whole.size(), k.whole, k.fraction, k.name);
    };
    return rank(*this) < rank(other);
  }
};

ImageKey KeyOfImage(const std::string& file_name);

/// Returns the images (png, jpg, jpeg, pgm; no hidden files) of a folder by their keys. Throws DatasetError if two have
/// the same key, or the folder cannot be read or has none.
std::map<ImageKey, std::string> ListImages(const std::string& folder);

}  // namespace plslam

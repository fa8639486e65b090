// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/evaluate/drawing/drawing.h"

namespace plslam::test {

/// The texts of a drawing, the lowest first.
inline std::vector<std::string> DrawnTexts(const evaluate::Drawing& drawing) {
  std::vector<std::string> texts;
  for (const auto& shape : drawing.shapes) {
    if (const auto* text = std::get_if<evaluate::DrawnText>(&shape)) texts.push_back(text->text);
  }
  return texts;
}

}  // namespace plslam::test

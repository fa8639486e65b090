// SPDX-License-Identifier: BSD-3-Clause
#include "tests/tools/body_texture.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/datasets/synthetic/canvas.h"
#include "core/datasets/synthetic/exact_math.h"
#include "core/io/images/image_file.h"
#include "core/io/images/image_folder.h"

namespace plslam::test {

using synthetic::Canvas;
using synthetic::Random;
using synthetic::Texture;

namespace {

constexpr int kWidth = 1024;
constexpr int kHeight = 512;

void PaintWindows(Random& random, Canvas& canvas) {
  const int n = 4 + random.Int(5);
  const double width = static_cast<double>(kWidth) / n;
  const double top = kHeight * random.Uniform(0.10, 0.2);
  const double bottom = kHeight * random.Uniform(0.36, 0.46);
  for (int i = 0; i < n; ++i) {
    const auto glass = static_cast<float>(random.Uniform(20.0, 70.0));
    canvas.Rectangle((i + 0.08) * width, top, (i + 0.92) * width, bottom, glass);
    const double x = (i + random.Uniform(0.2, 0.7)) * width;
    const double right = x + width * random.Uniform(0.05, 0.2);
    canvas.Rectangle(x, random.Uniform(top, bottom), right, bottom, glass + 60.0F);
    const double radius = random.Uniform(6.0, 18.0);
    canvas.Disc((i + random.Uniform(0.2, 0.8)) * width, 0.5 * (top + bottom), radius, glass + 90.0F);
  }
}

void PaintPrint(Random& random, Canvas& canvas) {
  for (int i = 0; i < 420; ++i) {
    const double x = random.Uniform(0.0, kWidth);
    const double y = random.Uniform(random.Chance(0.3) ? 0.0 : 0.45 * kHeight, kHeight);
    const auto value = static_cast<float>(random.Uniform(5.0, 250.0));
    switch (random.Int(3)) {
      case 0:
        canvas.Glyph(random, x, y, random.Uniform(14.0, 60.0), value);
        break;
      case 1: {
        const double angle = random.Uniform(0.0, synthetic::kPi);
        const double half_width = random.Uniform(2.5, 12.0);
        canvas.TurnedRectangle(x, y, random.Uniform(4.0, 30.0), half_width, angle, value);
        break;
      }
      default:
        canvas.Disc(x, y, random.Uniform(2.5, 9.0), value);
    }
  }
}

}  // namespace

Texture PaintVehicle(uint64_t seed) {
  Random random(synthetic::Hash(seed, 7001));
  Canvas canvas(kWidth, kHeight, static_cast<float>(random.Uniform(90.0, 160.0)));
  const int panels = 5 + random.Int(6);
  for (int i = 0; i < panels; ++i) {
    const double x = kWidth * (i + random.Uniform(-0.2, 0.2)) / panels;
    canvas.Rectangle(x, 0.0, x + static_cast<double>(kWidth) / panels, kHeight,
                     static_cast<float>(random.Uniform(70.0, 180.0)));
  }
  PaintWindows(random, canvas);
  for (int i = 0; i < 4; ++i) {
    const double y = random.Uniform(0.48 * kHeight, 0.97 * kHeight);
    const auto shade = static_cast<float>(random.Uniform(20.0, 230.0));
    canvas.Rectangle(0.0, y, kWidth, y + random.Uniform(3.0, 14.0), shade);
  }
  PaintPrint(random, canvas);
  canvas.AddNoise(synthetic::Hash(seed, 7002), 64, 16.0F, 4);
  canvas.AddNoise(synthetic::Hash(seed, 7004), 4, 22.0F, 2);
  return canvas.ToTexture(Texture::Border::kClamp);
}

Texture PictureOf(const std::string& folder, uint64_t seed) {
  const std::map<ImageKey, std::string> files = ListImages(folder);
  const auto index = static_cast<int64_t>(synthetic::Hash(seed, 7003) % files.size());
  cv::Mat picture;
  cv::resize(ReadGreyImage(std::next(files.begin(), index)->second), picture, cv::Size(kHeight, kHeight), 0.0, 0.0,
             cv::INTER_AREA);
  std::vector<float> pixels(picture.total());
  std::copy(picture.begin<uint8_t>(), picture.end<uint8_t>(), pixels.begin());
  return {picture.cols, picture.rows, Texture::Border::kClamp, pixels};
}

}  // namespace plslam::test

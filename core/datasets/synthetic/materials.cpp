// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/materials.h"

#include <algorithm>

#include "core/datasets/synthetic/canvas.h"
#include "core/datasets/synthetic/exact_math.h"

namespace plslam::synthetic {
namespace {

using Border = Texture::Border;

void ScatterShapes(Canvas& canvas, Random& random, int count, double least_size, double largest_size) {
  for (int i = 0; i < count; ++i) {
    const double x = random.Uniform(0.0, canvas.width());
    const double y = random.Uniform(0.0, canvas.height());
    const double size = random.Uniform(least_size, largest_size);
    const auto value = static_cast<float>(random.Uniform(15.0, 240.0));
    const double angle = random.Uniform(0.0, kPi);
    switch (random.Int(4)) {
      case 0:
        canvas.TurnedRectangle(x, y, size, size * random.Uniform(0.2, 1.0), angle, value);
        break;
      case 1:
        canvas.Triangle({{{x, y - size},
                          {x + size * random.Uniform(0.5, 1.0), y + size * random.Uniform(0.0, 1.0)},
                          {x - size * random.Uniform(0.2, 1.0), y + size}}},
                        value);
        break;
      case 2:
        canvas.Disc(x, y, 0.6 * size, value);
        break;
      default:
        canvas.Glyph(random, x, y, 1.5 * size, value);
        break;
    }
  }
}

void WriteText(Canvas& canvas, Random& random, double x0, double y, double x1, double size, float value) {
  for (double x = x0; x + size < x1; x += 0.9 * size) {
    if (random.Chance(0.85)) {
      canvas.Glyph(random, x, y, size, value);
    }
  }
}

void PaintWindow(Canvas& canvas, Random& random, double x, double y, double w, double h) {
  const auto frame = static_cast<float>(random.Uniform(190.0, 235.0));
  const auto glass = static_cast<float>(random.Uniform(30.0, 90.0));
  canvas.Rectangle(x - 4, y - 4, x + w + 4, y + h + 4, frame);
  canvas.Rectangle(x + 3, y + 3, x + w - 3, y + h - 3, glass);
  if (random.Chance(0.6)) {  // curtains
    const auto curtain = static_cast<float>(random.Uniform(110.0, 200.0));
    canvas.Rectangle(x + 3, y + 3, x + w * random.Uniform(0.15, 0.35), y + h - 3, curtain);
    canvas.Rectangle(x + w * random.Uniform(0.65, 0.85), y + 3, x + w - 3, y + h - 3, curtain);
  }
  if (random.Chance(0.4)) {  // a blind
    canvas.Rectangle(x + 3, y + 3, x + w - 3, y + h * random.Uniform(0.2, 0.6), frame - 30.0F);
  }
  canvas.Rectangle(x + 0.5 * w - 2, y, x + 0.5 * w + 2, y + h, frame);
  canvas.Rectangle(x, y + 0.35 * h - 2, x + w, y + 0.35 * h + 2, frame);
  canvas.Rectangle(x - 8, y + h + 4, x + w + 8, y + h + 9, 0.8F * frame);  // sill
  canvas.Rectangle(x - 8, y + h + 9, x + w + 8, y + h + 12, 50.0F);
}

}  // namespace

Texture PaintPlain(uint64_t seed, float value, float grain) {
  Canvas canvas(128, 128, value);
  canvas.AddNoise(seed, 64, grain, 3);
  return canvas.ToTexture(Border::kRepeat);
}

Texture PaintPlaster(uint64_t seed, float value, float contrast) {
  Canvas canvas(512, 512, value);
  canvas.AddNoise(seed, 128, 0.4F * contrast, 3);
  canvas.AddNoise(seed + 1, 16, 0.6F * contrast, 4);
  return canvas.ToTexture(Border::kRepeat);
}

Texture PaintWallpaper(uint64_t seed, float value, float contrast) {
  Canvas canvas(512, 512, value);
  Random random(seed);
  canvas.AddNoise(seed, 256, 0.5F * contrast, 3);
  for (int stripe = 0; stripe < 8; ++stripe) {
    canvas.Rectangle(stripe * 64, 0, stripe * 64 + 20, 512, value - 0.5F * contrast);
  }
  for (int i = 0; i < 90; ++i) {
    const double sign = random.Chance(0.5) ? 1.0 : -1.0;
    const auto shade = static_cast<float>(value + sign * contrast * random.Uniform(0.4, 1.3));
    const double angle = random.Uniform(0.0, kPi);
    const double half_width = random.Uniform(2.0, 9.0);
    const double half_length = random.Uniform(4.0, 14.0);
    const double y = random.Uniform(20.0, 490.0);
    const double x = random.Uniform(20.0, 490.0);
    canvas.TurnedRectangle(x, y, half_length, half_width, angle, shade);
  }
  canvas.AddNoise(seed + 1, 8, 0.3F * contrast, 3);
  return canvas.ToTexture(Border::kRepeat);
}

Texture PaintBricks(uint64_t seed, float value) {
  Canvas canvas(512, 512, value + 45.0F);
  Random random(seed);
  for (int row = 0; row < 8; ++row) {
    const int shift = row % 2 == 0 ? 0 : 64;
    for (int column = -1; column < 4; ++column) {
      const auto shade = static_cast<float>(value + random.Uniform(-30.0, 30.0));
      const double x = column * 128 + shift;
      canvas.Rectangle(x + 4, row * 64 + 4, x + 124, row * 64 + 60, shade);
      if (column == -1) {  // the brick across the seam
        canvas.Rectangle(x + 4 + 512, row * 64 + 4, x + 124 + 512, row * 64 + 60, shade);
      }
    }
  }
  canvas.AddNoise(seed, 32, 10.0F, 5);
  return canvas.ToTexture(Border::kRepeat);
}

Texture PaintPlanks(uint64_t seed, float value) {
  Canvas canvas(512, 512, value);
  Random random(seed);
  for (int board = 0; board < 8; ++board) {
    const double y = board * 64;
    const double joint = random.Uniform(40.0, 460.0);
    canvas.Rectangle(0, y, joint, y + 64, static_cast<float>(value + random.Uniform(-22.0, 22.0)));
    canvas.Rectangle(joint, y, 512, y + 64, static_cast<float>(value + random.Uniform(-22.0, 22.0)));
    for (int grain = 0; grain < 14; ++grain) {
      const double gx = random.Uniform(0.0, 400.0);
      const double gy = y + random.Uniform(4.0, 58.0);
      const auto shade = static_cast<float>(value + random.Uniform(-45.0, 5.0));
      const double height = random.Uniform(0.8, 2.5);
      const double length = random.Uniform(20.0, 110.0);
      canvas.Rectangle(gx, gy, gx + length, gy + height, shade);
    }
    if (random.Chance(0.5)) {
      const double radius = random.Uniform(3.0, 8.0);
      const double knot_y = y + random.Uniform(15.0, 50.0);
      const double knot_x = random.Uniform(20.0, 490.0);
      canvas.Disc(knot_x, knot_y, radius, value - 60.0F);
    }
    canvas.Rectangle(0, y, 512, y + 2, value - 70.0F);
    canvas.Rectangle(joint - 1, y, joint + 1, y + 64, value - 70.0F);
  }
  canvas.AddNoise(seed, 32, 6.0F, 5);
  return canvas.ToTexture(Border::kRepeat);
}

Texture PaintTiles(uint64_t seed, float value) {
  Canvas canvas(512, 512, value - 55.0F);
  Random random(seed);
  for (int i = 0; i < 16; ++i) {
    const int row = i / 4;
    const double x = i % 4 * 128;
    const double y = row * 128;
    canvas.Rectangle(x + 3, y + 3, x + 125, y + 125, static_cast<float>(value + random.Uniform(-8.0, 8.0)));
  }
  canvas.AddNoise(seed, 64, 5.0F, 5);
  return canvas.ToTexture(Border::kRepeat);
}

Texture PaintPoster(uint64_t seed) {
  Canvas canvas(512, 512, 150.0F);
  Random random(seed);
  canvas.AddNoise(seed, 128, 60.0F, 3);
  ScatterShapes(canvas, random, 10, 50.0, 110.0);
  ScatterShapes(canvas, random, 40, 14.0, 45.0);
  ScatterShapes(canvas, random, 120, 4.0, 12.0);
  for (int line = 0; line < 3; ++line) {
    const float shade = random.Chance(0.5) ? 20.0F : 235.0F;
    const double size = random.Uniform(14.0, 30.0);
    const double y = 40.0 + line * 150.0 + random.Uniform(0.0, 80.0);
    WriteText(canvas, random, 30.0, y, 480.0, size, shade);
  }
  canvas.Rectangle(0, 0, 512, 8, 235.0F);
  canvas.Rectangle(0, 504, 512, 512, 235.0F);
  canvas.Rectangle(0, 0, 8, 512, 235.0F);
  canvas.Rectangle(504, 0, 512, 512, 235.0F);
  return canvas.ToTexture(Border::kClamp);
}

Texture PaintBooks(uint64_t seed) {
  Canvas canvas(512, 256, 35.0F);
  Random random(seed);
  double x = 4.0;
  while (x < 500.0) {
    const double width = random.Uniform(10.0, 32.0);
    const double top = random.Uniform(20.0, 90.0);
    const auto cover = static_cast<float>(random.Uniform(40.0, 220.0));
    canvas.Rectangle(x, top, x + width - 1.5, 256, cover);
    const float print = cover > 130.0F ? 30.0F : 225.0F;
    canvas.Rectangle(x + 2, top + 12, x + width - 3, top + 15, print);
    for (double y = top + 25; y < 220.0; y += 0.9 * width) {
      if (random.Chance(0.6)) {
        canvas.Glyph(random, x + 0.2 * width, y, 0.6 * width, print);
      }
    }
    x += width;
    if (random.Chance(0.08)) {
      x += random.Uniform(10.0, 40.0);
    }
  }
  canvas.AddNoise(seed, 16, 5.0F, 3);
  return canvas.ToTexture(Border::kClamp);
}

Texture PaintBox(uint64_t seed) {
  Random random(seed);
  const auto value = static_cast<float>(random.Uniform(100.0, 190.0));
  Canvas canvas(256, 256, value);
  canvas.AddNoise(seed, 128, 12.0F, 6);
  canvas.Rectangle(0, 118, 256, 140, value + 30.0F);
  const double x = random.Uniform(20.0, 100.0);
  const double y = random.Uniform(20.0, 60.0);
  canvas.Rectangle(x, y, x + 120, y + 75, 230.0F);
  for (int line = 0; line < 4; ++line) {
    WriteText(canvas, random, x + 6, y + 5 + 17 * line, x + 114, 12.0, 30.0F);
  }
  WriteText(canvas, random, 20.0, 170.0, 236.0, random.Uniform(24.0, 48.0), value - 75.0F);
  return canvas.ToTexture(Border::kClamp);
}

Texture PaintDoor(uint64_t seed, float value) {
  Canvas canvas(128, 256, value);
  for (const double top : {18.0, 138.0}) {
    canvas.Rectangle(20, top, 108, top + 98, value - 25.0F);
    canvas.Rectangle(24, top + 4, 108, top + 98, value + 15.0F);
    canvas.Rectangle(24, top + 4, 104, top + 94, value - 6.0F);
  }
  canvas.Rectangle(110, 118, 120, 142, 70.0F);
  canvas.Rectangle(98, 126, 116, 131, 40.0F);
  canvas.AddNoise(seed, 64, 4.0F, 4);
  return canvas.ToTexture(Border::kClamp);
}

Texture PaintFacade(uint64_t seed, int columns, int rows) {
  Random random(seed);
  const auto value = static_cast<float>(random.Uniform(110.0, 190.0));
  Canvas canvas(1024, 512, value);
  canvas.AddNoise(seed, 256, 14.0F, 3);
  if (random.Chance(0.5)) {  // courses of masonry
    for (int y = 0; y < 512; y += 8) {
      for (int x = y / 8 % 2 == 0 ? 0 : -12; x < 1024; x += 24) {
        canvas.Rectangle(x, y, x + 23, y + 7, static_cast<float>(value + random.Uniform(-18.0, 18.0)));
      }
    }
  }
  const double cell_w = 1024.0 / columns;
  const double cell_h = 512.0 / rows;
  const double w = cell_w * random.Uniform(0.35, 0.55);
  const double h = cell_h * random.Uniform(0.5, 0.62);
  const int door = random.Int(columns);
  for (int row = 0; row < rows; ++row) {
    canvas.Rectangle(0, row * cell_h, 1024, row * cell_h + 3, value - 35.0F);
    for (int column = 0; column < columns; ++column) {
      const double x = column * cell_w + 0.5 * (cell_w - w);
      const double y = row * cell_h + 0.2 * cell_h;
      if (row == rows - 1 && column == door) {
        canvas.Rectangle(x - 6, y, x + w + 6, 512, 215.0F);
        canvas.Rectangle(x, y + 6, x + w, 512, static_cast<float>(random.Uniform(40.0, 90.0)));
        canvas.Rectangle(x + 0.45 * w, y + 30, x + 0.55 * w, 512, 25.0F);
      } else {
        PaintWindow(canvas, random, x, y, w, h);
      }
    }
  }
  canvas.AddNoise(seed + 1, 16, 8.0F, 4);
  return canvas.ToTexture(Border::kClamp);
}

Texture PaintAsphalt(uint64_t seed) {
  Canvas canvas(512, 512, 95.0F);
  Random random(seed);
  for (int patch = 0; patch < 7; ++patch) {
    const auto shade = static_cast<float>(random.Uniform(70.0, 120.0));
    const double angle = random.Uniform(-0.2, 0.2);
    const double half_width = random.Uniform(10.0, 40.0);
    const double half_length = random.Uniform(15.0, 60.0);
    const double y = random.Uniform(80.0, 430.0);
    const double x = random.Uniform(80.0, 430.0);
    canvas.TurnedRectangle(x, y, half_length, half_width, angle, shade);
  }
  for (int crack = 0; crack < 16; ++crack) {
    const double angle = random.Uniform(0.0, kPi);
    const double half_length = random.Uniform(12.0, 50.0);
    const double y = random.Uniform(60.0, 450.0);
    const double x = random.Uniform(60.0, 450.0);
    canvas.TurnedRectangle(x, y, half_length, 1.2, angle, 55.0F);
  }
  canvas.AddNoise(seed, 64, 10.0F, 3);
  canvas.AddNoise(seed + 1, 8, 16.0F, 4);
  return canvas.ToTexture(Border::kRepeat);
}

Texture PaintCar(uint64_t seed) {
  Random random(seed);
  const auto paint = static_cast<float>(random.Uniform(40.0, 215.0));
  Canvas canvas(256, 128, paint);
  canvas.Rectangle(0, 0, 256, 44, paint - 20.0F);
  canvas.Rectangle(14, 6, 120, 42, 45.0F);
  canvas.Rectangle(128, 6, 236, 42, 45.0F);
  canvas.Rectangle(0, 104, 256, 128, 30.0F);
  canvas.Rectangle(123, 44, 125, 100, paint - 35.0F);
  canvas.Rectangle(105, 54, 118, 58, 20.0F);
  canvas.Rectangle(0, 50, 14, 62, 235.0F);
  canvas.Rectangle(244, 50, 256, 66, 60.0F);
  for (const double x : {52.0, 204.0}) {
    canvas.Disc(x, 102, 25, 18.0F);
    canvas.Disc(x, 102, 14, 150.0F);
    canvas.Disc(x, 102, 5, 60.0F);
  }
  canvas.AddNoise(seed, 64, 8.0F, 3);
  return canvas.ToTexture(Border::kClamp);
}

}  // namespace plslam::synthetic

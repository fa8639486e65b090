// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/datasets/synthetic/texture.h"

/// Painted textures of the synthetic worlds. Each is a function of its seed; those that tile repeat without a seam.
namespace plslam::synthetic {

/// Grey `value` with faint grain of +-`grain`.
Texture PaintPlain(uint64_t seed, float value, float grain);
/// Uneven plaster or carpet: blotches of many sizes, +-`contrast`.
Texture PaintPlaster(uint64_t seed, float value, float contrast);
/// Plaster with a weak printed pattern, like wallpaper.
Texture PaintWallpaper(uint64_t seed, float value, float contrast);
/// 4 x 8 bricks with mortar.
Texture PaintBricks(uint64_t seed, float value);
/// Eight floor boards with grain, joints at random positions.
Texture PaintPlanks(uint64_t seed, float value);
/// 4 x 4 tiles with joints.
Texture PaintTiles(uint64_t seed, float value);
/// High contrast: turned rectangles, triangles, discs and glyphs of many sizes; does not tile.
Texture PaintPoster(uint64_t seed);
/// Book spines side by side; does not tile.
Texture PaintBooks(uint64_t seed);
/// Cardboard with labels, tape and print; does not tile.
Texture PaintBox(uint64_t seed);
/// A panelled door: soft panels and a handle; does not tile.
Texture PaintDoor(uint64_t seed, float value);
/// A house front, `columns` x `rows` windows with frames and bars over bricks or plaster; does not tile.
Texture PaintFacade(uint64_t seed, int columns, int rows);
/// Asphalt with patches and cracks.
Texture PaintAsphalt(uint64_t seed);
/// Side of a parked car, without its wheels' relief; does not tile.
Texture PaintCar(uint64_t seed);

}  // namespace plslam::synthetic

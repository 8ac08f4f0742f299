#pragma once

#include "raytrace/canvas.h"
#include "raytrace/legend.h"
#include "slim/base/vec.h"

#include <string>
#include <vector>

namespace slim {

/// A panel of words for pictures whose colours are no scale: a title, and rows with a swatch of
/// colour or without.
struct Key {
    struct Row {
        std::string text;
        bool has_swatch = false;
        Vec3f srgb{};
    };
    std::string title;
    std::vector<Row> rows;
};

/// The place where the key covers the least of an object over transparent and of what else is
/// taken, upper and lower corners only.
LegendPlace best_key_place(const Key& key, const Picture& object, const PixelBox& taken = {});

/// What it takes in a width x height picture.
PixelBox key_box(const Key& key, LegendPlace place, int width, int height);

/// Share of the width of a width x height picture that the key and its margin take; 0 where
/// burn_key would refuse.
double key_share(const Key& key, int width, int height);

/// Burns the key into a picture, in the legend's style. Returns false and leaves the picture alone
/// if it would take more than 60 % of the width or 75 % of the height.
bool burn_key(const Key& key, const Canvas& canvas, LegendPlace place);

/// The same as a file of its own: SVG 1.1, millimetres.
std::string key_svg(const Key& key);

}  // namespace slim

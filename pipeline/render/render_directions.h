#pragma once

#include "raytrace/frame.h"
#include "raytrace/key.h"
#include "raytrace/picture.h"
#include "raytrace/shade.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace slim {

/// L of the model that each pixel shows, what flat is measured by.
class PixelDiagonals {
public:
    PixelDiagonals(double only) : of_model_{only} {}  // NOLINT(google-explicit-constructor)
    /// `model`: of each pixel; empty: all are of the first
    PixelDiagonals(std::vector<double> of_model, std::span<const std::uint16_t> model)
        : of_model_(std::move(of_model)), model_(model) {}
    double at(std::size_t i) const { return of_model_[model_.empty() ? 0 : model_[i]]; }

private:
    std::vector<double> of_model_;
    std::span<const std::uint16_t> model_;
};

/// Zeroes the principal directions of a frame (which holds k1 and k2), and what the curvatures do
/// along them, where there are none: umbilics, (k1 - k2) / 2 < 0.01 |k1 + k2| / 2, and flat places,
/// both curvatures below 0.2 / diagonal (NUMERICS 5.2).
void drop_undefined_directions(const PixelDiagonals& diagonals, GBuffer& frame);

/// Planes of t2 = N x t1, zero where t1 is; the frame holds both.
std::array<std::vector<float>, 3> second_directions(const GBuffer& frame);

/// |x|, |y|, |z| as red, green, blue, as a direction has no sign (Pajevic and Pierpaoli 1999); a
/// pale grey, which no direction has, where k1 and k2 are nearly equal, and fading to it where both
/// are small: radii above half a diagonal.
Picture paint_directions(const GBuffer& frame, const PixelDiagonals& diagonals, bool second,
                         const RowRange& rows);

/// What those colours mean.
Key direction_key(bool second);

}  // namespace slim

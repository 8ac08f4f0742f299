#pragma once

#include "raytrace/picture.h"
#include "slim/base/vec.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace slim {

/// A map from [0, 1] to display-referred sRGB, by linear interpolation between equidistant knots.
class ColorMap {
public:
    static constexpr std::size_t kKnots = 257;  ///< odd: a diverging map has a knot at its middle

    ColorMap(std::string name, std::span<const Vec3f> srgb_knots);

    const std::string& name() const { return name_; }
    /// t is clamped to [0, 1]; components in [0, 1], sRGB.
    Vec3f srgb(float t) const { return interpolate(srgb_, t); }
    /// The same colour in linear Rec.709, as a Picture holds it; between knots it is mixed in
    /// linear light, less than a tenth of an 8-bit step from srgb(t).
    Vec3f linear(float t) const { return interpolate(linear_, t); }

private:
    using Table = std::array<Vec3f, kKnots>;
    static Vec3f interpolate(const Table& table, float t);

    std::string name_;
    Table srgb_, linear_;
};

/// Moreland's cool-warm ("Diverging Color Maps for Scientific Visualization", ISVC 2009), computed
/// in Msh by his published algorithm from (59, 76, 192) through a light grey to (180, 4, 38): blue
/// is negative (concave), red positive (convex), as bright on either side.
const ColorMap& cool_warm();
/// viridis of van der Walt and Smith (CC0), 16 knots.
const ColorMap& viridis();
/// cividis of Nunez, Anderson and Renslow (PLoS ONE 2018), 16 knots:
/// readable with colour blindness.
const ColorMap& cividis();

/// The values that the two ends of a map stand for.
struct ValueRange {
    double lo = 0, hi = 1;
    /// The middle of the map, which is diverging, stands for 0 wherever 0 lies between the ends:
    /// each side is scaled by its own. (A range on one side of 0 takes that side's part of the
    /// map.)
    bool about_zero = false;
};

/// Where on a map, from 0 to 1, a value stands; those beyond the range at its ends.
float place_on_map(const ValueRange& range, double value);
/// The same of the value at a share of the range, from 0 at its lower end to 1:
/// the colours of a legend's bar.
inline float place_of_share(const ValueRange& range, double share) {
    return place_on_map(range, range.lo + share * (range.hi - range.lo));
}

/// The next number of the form {1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8} * 10^k that is >= v;
/// 0 for v <= 0.
double nice_ceiling(double v);

/// Value at `percentile` (0..100, nearest rank) of |v| over hit pixels with finite values; 0
/// without any. If half or more are up to `flat` in magnitude, these do not count, unless fewer
/// than one in 1000 are above: flat faces of a part must not leave its curved ones one colour.
double percentile_of_abs(std::span<const float> values, std::span<const std::uint8_t> hit,
                         double percentile, double flat = 0);

/// [-a, a] with a = nice_ceiling of what most values are up to (see percentile_of_abs), at least
/// `least` (> 0): below it, values are rounding, and a flat plane must not look like a storm.
ValueRange symmetric_range(double most, double least);

/// [least, greatest] finite value at hit pixels; a single value is widened, no value gives [0, 1].
ValueRange full_range(std::span<const float> values, std::span<const std::uint8_t> hit);

/// Paints one plane: hit pixels get the colour of their value (clamped to the range) with alpha 1.
/// No hit, and a value that is NaN, stay transparent: a hole never looks like a number
/// (CONVENTIONS 4.4).
Picture paint(int width, int height, const ColorMap& map, const ValueRange& range,
              std::span<const float> values, std::span<const std::uint8_t> hit);

}  // namespace slim

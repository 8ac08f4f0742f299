#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace slim {

/// Where a surfel's data end on one side: in its tangent plane it reaches up to u * x + v * y =
/// reach, coordinates relative to the centre and over rho; the rest of its disc would stand in the
/// air beyond a border or an edge. Departs from the paper, whose surfels are whole balls.
struct Rim {
    double u = 1, v = 0;  ///< unit
    double reach = std::numeric_limits<double>::infinity();

    bool is_whole() const { return std::isinf(reach); }
};

/// A rim in a byte: one of 32 directions in the upper five bits, one of seven reaches in the lower
/// three; 0 is the whole disc.
using PackedRim = std::uint8_t;
inline constexpr int kRimDirections = 32;
inline constexpr int kRimReaches = 7;
inline constexpr double kRimStep = 0.08;  ///< reaches are multiples of it, 0.56 at most
/// Over this distance, up to the rim, the weight of a surfel falls to zero: what is blended has no
/// step there.
inline constexpr double kRimRamp = 0.1;

/// Direction k of a rim.
inline std::array<double, 2> rim_direction(int k) {
    static const auto directions = [] {
        std::array<std::array<double, 2>, kRimDirections> out;
        for (int i = 0; i < kRimDirections; ++i) {
            const double angle = 2 * std::numbers::pi * i / kRimDirections;
            out[static_cast<std::size_t>(i)] = {std::cos(angle), std::sin(angle)};
        }
        return out;
    }();
    return directions[static_cast<std::size_t>(k)];
}

/// The rim in direction k that reaches at least so far; 0 where no rim does.
inline PackedRim pack_rim(int k, double reach) {
    const double step = std::max(1.0, std::ceil(reach / kRimStep));
    if (!(step <= kRimReaches)) return 0;
    return static_cast<PackedRim>(k << 3 | static_cast<int>(step));
}

inline Rim unpack_rim(PackedRim packed) {
    if ((packed & 7) == 0) return {};
    const auto [u, v] = rim_direction(packed >> 3);
    return {u, v, kRimStep * (packed & 7)};
}

/// A surfel's rims: none, one, or two, as at a corner or along a ridge. `second` is 0 where `first`
/// is.
struct PackedRims {
    PackedRim first = 0, second = 0;

    bool any() const { return first != 0; }
    bool operator==(const PackedRims&) const = default;
};

/// What the rim leaves of a surfel's weight at local (u, v): 1 inside, 0 from the rim on.
inline double rim_share(const Rim& rim, double u, double v) {
    return std::clamp((rim.reach - (rim.u * u + rim.v * v)) / kRimRamp, 0.0, 1.0);
}

/// The same for all of a surfel's rims.
inline double rim_share(PackedRims rims, double u, double v) {
    return std::min(rim_share(unpack_rim(rims.first), u, v),
                    rim_share(unpack_rim(rims.second), u, v));
}

}  // namespace slim

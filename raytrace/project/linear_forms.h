#pragma once

#include "raytrace/intersect/pixel_record.h"
#include "raytrace/project/surfel_lanes.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace slim {

/// Polynomials of degree D in (s, t, tau), one per lane; their coefficients in the order of
/// PixelRecord::f; of degree 1 those of 1, s, t, tau.
template <int D>
struct Form {
    static constexpr std::size_t kSize = power_start(D, D + 1);
    std::array<DoubleV, kSize> c{};
};
using Linear = Form<1>;

template <int D>
Form<D> operator+(Form<D> a, const Form<D>& b) {
    for (std::size_t i = 0; i < a.c.size(); ++i) a.c[i] += b.c[i];
    return a;
}
template <int D>
Form<D> operator-(Form<D> a, const Form<D>& b) {
    for (std::size_t i = 0; i < a.c.size(); ++i) a.c[i] -= b.c[i];
    return a;
}
template <int D>
Form<D> operator*(const DoubleV& f, Form<D> a) {
    for (DoubleV& c : a.c) c *= f;
    return a;
}

/// Where a coefficient of degree D lands in one of degree D + 1, times 1, s, t or tau.
template <int D>
constexpr std::array<std::array<std::uint8_t, 4>, Form<D>::kSize> product_places() {
    std::array<std::array<std::uint8_t, 4>, Form<D>::kSize> places{};
    const auto place = [](int p, int i, int j) {
        return static_cast<std::uint8_t>(power_start(D + 1, p) + n_planar(i + j - 1) +
                                         static_cast<std::size_t>(j));
    };
    std::size_t at = 0;
    for (int p = 0; p <= D; ++p)
        for (int degree = 0; degree <= D - p; ++degree)
            for (int j = 0; j <= degree; ++j) {
                const int i = degree - j;
                places[at++] = {place(p, i, j), place(p, i + 1, j), place(p, i, j + 1),
                                place(p + 1, i, j)};
            }
    return places;
}

template <int D>
Form<D + 1> operator*(const Linear& a, const Form<D>& b) {
    static constexpr auto kPlaces = product_places<D>();
    Form<D + 1> out;
#pragma GCC unroll 16  // so that the places are known to the compiler
    for (std::size_t k = 0; k < b.c.size(); ++k)
#pragma GCC unroll 4
        for (std::size_t n = 0; n < 4; ++n) out.c[kPlaces[k][n]] += a.c[n] * b.c[k];
    return out;
}

}  // namespace slim

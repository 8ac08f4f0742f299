#pragma once

#include "raytrace/picture.h"

#include <algorithm>
#include <cstddef>

namespace slim::test {

/// A white picture.
inline Picture white(int width, int height) {
    Picture p(width, height);
    std::fill(p.rgba.begin(), p.rgba.end(), 1.0f);
    return p;
}

/// Pixels that two pictures do not share.
inline int n_different(const Picture& a, const Picture& b) {
    int n = 0;
    for (std::size_t i = 0; i < a.n_pixels(); ++i)
        n += !std::equal(&a.rgba[4 * i], &a.rgba[4 * i] + 4, &b.rgba[4 * i]);
    return n;
}

/// Pixels that are not white.
inline int n_inked(const Picture& p) { return n_different(p, white(p.width, p.height)); }

}  // namespace slim::test

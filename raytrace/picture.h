#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// A picture in linear Rec.709: RGBA, premultiplied, row-major from the top left. False colours
/// live here too, decoded from sRGB: encoding gives their bytes back exactly,
/// and box filters mix light.
struct Picture {
    int width = 0, height = 0;
    std::vector<float> rgba;  ///< 4 * width * height

    Picture() = default;
    Picture(int w, int h)
        : width(w),
          height(h),
          rgba(4 * static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}

    std::size_t n_pixels() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
    float* pixel(int x, int y) { return rgba.data() + 4 * index(x, y); }
    const float* pixel(int x, int y) const { return rgba.data() + 4 * index(x, y); }
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
};

/// Display-referred sRGB, 8 bits, RGBA with straight (not premultiplied) alpha.
struct Picture8 {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;
};

/// The sRGB curve (IEC 61966-2-1), both ways; inputs outside [0, 1] are clamped on encoding and a
/// NaN becomes 0.
float srgb_from_linear(float linear);
float linear_from_srgb(float srgb);

/// Unpremultiplies, applies the sRGB curve and rounds to 8 bits. Parallel over rows.
Picture8 encode_srgb8(const Picture& picture);

/// Mean of factor x factor blocks (premultiplied, linear: edges come out right).
/// Width and height must be multiples of the factor (SLIM_CHECK).
Picture box_downsample(const Picture& picture, int factor);

}  // namespace slim

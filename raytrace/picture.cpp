#include "raytrace/picture.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kRowGrain = 16;

/// A pixel's channels.
using FourV = stdx::simd<float, stdx::simd_abi::deduce_t<float, 4>>;

std::uint8_t quantize(float display) {
    return static_cast<std::uint8_t>(std::lround(display * 255.0f));
}

void encode_pixel(const float* in, std::uint8_t* out) {
    const float alpha = std::clamp(in[3], 0.0f, 1.0f);
    const float unmultiply = alpha > 0 ? 1 / alpha : 0.0f;
    for (int c = 0; c < 3; ++c) out[c] = quantize(srgb_from_linear(in[c] * unmultiply));
    out[3] = quantize(alpha);
}

/// Mean of one block into out[4]; rows of the block in order, so the sum is always the same.
void mean_of_block(const Picture& in, int x0, int y0, int factor, float* out) {
    const float scale = 1 / static_cast<float>(factor * factor);
    FourV sum(0.0f);
    for (int y = y0; y < y0 + factor; ++y) {
        const float* row = in.pixel(x0, y);
        for (int x = 0; x < factor; ++x) sum += FourV(row + 4 * x, stdx::element_aligned);
    }
    (sum * scale).copy_to(out, stdx::element_aligned);
}

}  // namespace

float srgb_from_linear(float linear) {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 1;
    return linear <= 0.0031308f ? 12.92f * linear
                                : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float linear_from_srgb(float srgb) {
    if (!(srgb > 0)) return 0;
    return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f);
}

Picture8 encode_srgb8(const Picture& picture) {
    Picture8 out{picture.width, picture.height, {}};
    out.rgba.resize(picture.rgba.size());
    parallel_blocks(static_cast<std::size_t>(picture.height), kRowGrain,
                    [&](std::size_t begin, std::size_t end) {
                        const auto width = static_cast<std::size_t>(picture.width);
                        for (std::size_t i = begin * width; i < end * width; ++i)
                            encode_pixel(&picture.rgba[4 * i], &out.rgba[4 * i]);
                    });
    return out;
}

Picture box_downsample(const Picture& picture, int factor) {
    SLIM_CHECK(factor, >=, 1);
    SLIM_CHECK(picture.width % factor + picture.height % factor, ==, 0);
    Picture out(picture.width / factor, picture.height / factor);
    parallel_blocks(static_cast<std::size_t>(out.height), kRowGrain,
                    [&](std::size_t begin, std::size_t end) {
                        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
                            for (int x = 0; x < out.width; ++x)
                                mean_of_block(picture, x * factor, y * factor, factor,
                                              out.pixel(x, y));
                    });
    return out;
}

}  // namespace slim

#include "pipeline/render/render_directions.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kPixelGrain = 1 << 12;
constexpr float kUmbilic = 0.01f;
constexpr double kFlat = 0.2;  // a radius of five diagonals: noise turns what is flatter any way
/// Paler than any direction: of a unit vector's |x|, |y|, |z| grey is 0.577.
constexpr float kUndefinedGrey = 0.86f;
/// (k1 - k2) / (|k1| + |k2|) from which on a direction has its full colour.
constexpr float kClear = 0.1f;
/// Larger curvature times the diagonal from which on it has.
constexpr float kBent = 2;

Vec3f first_direction(const GBuffer& b, std::size_t i) {
    return {b.direction[0][i], b.direction[1][i], b.direction[2][i]};
}

Vec3f second_direction(const GBuffer& b, std::size_t i) {
    return cross(Vec3f{b.normal[0][i], b.normal[1][i], b.normal[2][i]}, first_direction(b, i));
}

float clearness(const GBuffer& b, double diagonal, std::size_t i) {
    const float k1 = std::abs(b.k1[i]), k2 = std::abs(b.k2[i]), sum = k1 + k2;
    if (!(sum > 0)) return 0;
    const float apart = std::clamp((b.k1[i] - b.k2[i]) / (kClear * sum), 0.0f, 1.0f);
    const float bent = static_cast<float>(diagonal) * std::max(k1, k2) / kBent;
    return apart * std::clamp(bent, 0.0f, 1.0f);
}

}  // namespace

void drop_undefined_directions(const PixelDiagonals& diagonals, GBuffer& b) {
    parallel_blocks(b.n_pixels(), kPixelGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const float k1 = b.k1[i], k2 = b.k2[i];
            const double diagonal = diagonals.at(i);
            const auto flat = static_cast<float>(diagonal > 0 ? kFlat / diagonal : kFlat);
            const bool umbilic = k1 - k2 < kUmbilic * std::abs(k1 + k2);
            if (!umbilic && !(std::abs(k1) < flat && std::abs(k2) < flat)) continue;
            if (b.has(kDirectionChannel))
                for (auto& plane : b.direction) plane[i] = 0;
            if (b.has(kThirdOrderChannel))
                for (auto& plane : b.third) plane[i] = 0;
        }
    });
}

std::array<std::vector<float>, 3> second_directions(const GBuffer& b) {
    std::array<std::vector<float>, 3> planes;
    for (auto& plane : planes) plane.resize(b.n_pixels());
    parallel_blocks(b.n_pixels(), kPixelGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3f t = second_direction(b, i);
            for (std::size_t axis = 0; axis < 3; ++axis) planes[axis][i] = t[axis];
        }
    });
    return planes;
}

Picture paint_directions(const GBuffer& b, const PixelDiagonals& diagonals, bool second,
                         const RowRange& rows) {
    Picture out(b.width, rows.end - rows.begin);
    const std::size_t first = b.index(0, rows.begin);
    parallel_blocks(out.n_pixels(), kPixelGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const std::size_t i = first + k;
            if (!b.hit[i]) continue;
            const Vec3f t = second ? second_direction(b, i) : first_direction(b, i);
            const float share = sq_length(t) > 0 ? clearness(b, diagonals.at(i), i) : 0;
            float* p = &out.rgba[4 * k];
            for (std::size_t c = 0; c < 3; ++c)
                p[c] = linear_from_srgb(std::abs(t[c]) * share + kUndefinedGrey * (1 - share));
            p[3] = 1;
        }
    });
    return out;
}

Key direction_key(bool second) {
    constexpr float kEven = 0.577f;
    const Vec3f grey{kUndefinedGrey, kUndefinedGrey, kUndefinedGrey};
    return {second ? "direction of k2, no sign" : "direction of k1, no sign",
            {{"|x|, world", true, {1, 0, 0}},
             {"|y|", true, {0, 1, 0}},
             {"|z|", true, {0, 0, 1}},
             {"|x| = |y| = |z|", true, {kEven, kEven, kEven}},
             {"none: flat or k1 = k2", true, grey}}};
}

}  // namespace slim

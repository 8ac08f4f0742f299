#include "raytrace/trace/openness_filter.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace slim {
namespace {

/// RMS error of openness by one ray; by n stratified ones n^(3/4) times less (Mitchell 1996).
/// Measured: notes/0005.
constexpr float kErrorOfOne = 0.5f;
/// In units of that error: what differs more is something else; up to half of it all count alike,
/// else the pattern of interleaved samples stays.
constexpr float kMostErrors = 7.0f;
constexpr float kAlike = 0.5f;
/// Sine of the angle between the way to another pixel and the surface, above which that is another
/// one.
constexpr float kMostSlope = 0.25f;
constexpr float kLeastAgreement = 0.9f;  // of normals: 26 degrees

/// Planes with a row's length.
struct Rows {
    const SurfacePlanes& planes;
    const PositionRest& rest;
    std::span<const float> open;
    std::vector<float> hit;
    std::size_t width, height;

    Rows(const SurfacePlanes& p, const PositionRest& low, std::span<const float> o)
        : planes(p),
          rest(low),
          open(o),
          hit(p.buffer.hit.begin(), p.buffer.hit.end()),
          width(static_cast<std::size_t>(p.buffer.width)),
          height(static_cast<std::size_t>(p.buffer.height)) {}
};

float squared(float x) { return x * x; }
float above_zero(float x) { return x > 0 ? x : 0.0f; }

/// What is left of a difference of positions where one float lacks it.
struct RestOf {
    const float* low;
    float operator()(std::size_t q, std::size_t i) const { return low[q] - low[i]; }
};
struct NoRest {
    float operator()(std::size_t, std::size_t) const { return 0; }
};

/// Adds one neighbour, `step` entries further on, of the pixels [begin, end): `share` is its weight
/// in the mean.
template <class Rest>
void add_neighbour(const Rows& r, const std::array<Rest, 3>& rest, std::size_t begin,
                   std::size_t end, std::ptrdiff_t step, float share, float inv_most,
                   float* __restrict sum, float* __restrict weight) {
    const GBuffer& b = r.planes.buffer;
    const float *const px = b.position[0].data(), *const py = b.position[1].data(),
                       *const pz = b.position[2].data(), *const nx = b.normal[0].data(),
                       *const ny = b.normal[1].data(), *const nz = b.normal[2].data(),
                       *const open = r.open.data(), *const hit = r.hit.data();
    constexpr float kSteep = 1 / (kMostSlope * kMostSlope), kFacing = 1 / (1 - kLeastAgreement);
#pragma GCC ivdep
    for (std::size_t i = begin; i < end; ++i) {
        const std::size_t q = i + static_cast<std::size_t>(step);
        const float dx = px[q] - px[i] + rest[0](q, i), dy = py[q] - py[i] + rest[1](q, i),
                    dz = pz[q] - pz[i] + rest[2](q, i);
        const float off = nx[i] * dx + ny[i] * dy + nz[i] * dz;
        const float sq_way = dx * dx + dy * dy + dz * dz;
        const float agreement = nx[i] * nx[q] + ny[i] * ny[q] + nz[i] * nz[q];
        const float in_plane = above_zero(1 - off * off / (sq_way + 1e-37f) * kSteep);
        const float facing = above_zero((agreement - kLeastAgreement) * kFacing);
        const float seen = hit[q] > 0 ? 1.0f : 0.0f, other = hit[q] > 0 ? open[q] : 0.0f;
        const float beyond = above_zero(std::abs(other - open[i]) * inv_most - kAlike);
        const float alike = above_zero(1 - squared(beyond * (1 / (1 - kAlike))));
        const float w = share * seen * in_plane * facing * alike * alike;
        sum[i - begin] += w * other, weight[i - begin] += w;
    }
}

void filter_row(const Rows& r, std::size_t y, float inv_most, std::span<float> sum,
                std::span<float> weight, std::vector<float>& out) {
    const std::size_t row = y * r.width;
    for (std::size_t x = 0; x < r.width; ++x) sum[x] = r.open[row + x], weight[x] = 1;
    for (int dy = -kOpennessReach; dy <= kOpennessReach; ++dy) {
        const auto other = static_cast<std::ptrdiff_t>(y) + dy;
        if (other < 0 || other >= static_cast<std::ptrdiff_t>(r.height)) continue;
        for (int dx = -kOpennessReach; dx <= kOpennessReach; ++dx) {
            if (dx == 0 && dy == 0) continue;
            // Four in a row: both outer ones count half.
            const float share = (std::abs(dx) == kOpennessReach ? 0.5f : 1.0f) *
                                (std::abs(dy) == kOpennessReach ? 0.5f : 1.0f);
            const auto left = static_cast<std::size_t>(std::max(0, -dx)),
                       right = static_cast<std::size_t>(std::max(0, dx));
            if (left + right >= r.width) continue;
            const auto add = [&](const auto& rest) {
                add_neighbour(r, rest, row + left, row + r.width - right,
                              dy * static_cast<std::ptrdiff_t>(r.width) + dx, share, inv_most,
                              &sum[left], &weight[left]);
            };
            if (r.rest[0].empty())
                add(std::array<NoRest, 3>{});
            else
                add(std::array{RestOf{r.rest[0].data()}, RestOf{r.rest[1].data()},
                               RestOf{r.rest[2].data()}});
        }
    }
    for (std::size_t x = 0; x < r.width; ++x)
        out[row + x] = r.hit[row + x] > 0 ? sum[x] / weight[x] : 0.0f;
}

}  // namespace

std::vector<float> filtered_openness(const SurfacePlanes& planes, std::span<const float> open,
                                     int samples, const PositionRest& rest) {
    const Rows rows(planes, rest, open);
    const float most = kMostErrors * kErrorOfOne * std::pow(static_cast<float>(samples), -0.75f);
    std::vector<float> out(open.size());
    constexpr std::size_t kGrain = 16;
    parallel_blocks(rows.height, kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<float> sum(rows.width), weight(rows.width);
        for (std::size_t y = begin; y < end; ++y)
            filter_row(rows, y, 1 / most, sum, weight, out);
    });
    return out;
}

}  // namespace slim

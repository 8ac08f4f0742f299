#include "raytrace/trace/openness_filter.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace slim {
namespace {

/// RMS error of openness by one ray; by n stratified ones n^(3/4) times less (Mitchell 1996). Measured: notes/0005.
constexpr float kErrorOfOne = 0.5f;
/// In units of that error: what differs more is something else.
constexpr float kMostErrors = 7.0f;
/// Sine of the angle between the way to another pixel and the surface, above which that is another one.
constexpr float kMostSlope = 0.25f;
constexpr float kLeastAgreement = 0.9f;  // of normals: 26 degrees

/// Planes with a row's length.
struct Rows {
    const SurfacePlanes& planes;
    std::span<const float> open;
    std::vector<float> hit;
    std::size_t width, height;

    Rows(const SurfacePlanes& p, std::span<const float> o)
        : planes(p),
          open(o),
          hit(p.buffer.hit.begin(), p.buffer.hit.end()),
          width(static_cast<std::size_t>(p.buffer.width)),
          height(static_cast<std::size_t>(p.buffer.height)) {}
};

float squared(float x) { return x * x; }

/// Adds one neighbour, `step` entries further on, of the pixels [begin, end): `share` is its weight in the
/// mean.
void add_neighbour(const Rows& r, std::size_t begin, std::size_t end, std::ptrdiff_t step, float share, float inv_sq_most,
                   float* sum, float* weight) {
    const std::array<const float*, 3> p{r.planes.buffer.position[0].data(), r.planes.buffer.position[1].data(),
                                        r.planes.buffer.position[2].data()},
        n{r.planes.buffer.normal[0].data(), r.planes.buffer.normal[1].data(), r.planes.buffer.normal[2].data()};
    const float *open = r.open.data(), *hit = r.hit.data();
    for (std::size_t i = begin; i < end; ++i) {
        const std::size_t q = i + static_cast<std::size_t>(step);
        const float dx = p[0][q] - p[0][i], dy = p[1][q] - p[1][i], dz = p[2][q] - p[2][i];
        const float off = n[0][i] * dx + n[1][i] * dy + n[2][i] * dz;
        const float sq_way = dx * dx + dy * dy + dz * dz;
        const float agreement = n[0][i] * n[0][q] + n[1][i] * n[1][q] + n[2][i] * n[2][q];
        const float steep = off * off / (sq_way + 1e-37f) * (1 / (kMostSlope * kMostSlope));
        const float in_plane = std::max(0.0f, 1 - steep);
        const float facing = std::max(0.0f, (agreement - kLeastAgreement) * (1 / (1 - kLeastAgreement)));
        const float alike = std::max(0.0f, 1 - squared(open[q] - open[i]) * inv_sq_most);
        const float w = hit[q] > 0 ? share * in_plane * facing * alike * alike : 0.0f;
        sum[i - begin] += w * (hit[q] > 0 ? open[q] : 0.0f), weight[i - begin] += w;
    }
}

void filter_row(const Rows& r, std::size_t y, float inv_sq_most, std::span<float> sum, std::span<float> weight,
                std::vector<float>& out) {
    const std::size_t row = y * r.width;
    for (std::size_t x = 0; x < r.width; ++x) sum[x] = r.open[row + x], weight[x] = 1;
    for (int dy = -kOpennessReach; dy <= kOpennessReach; ++dy) {
        const auto other = static_cast<std::ptrdiff_t>(y) + dy;
        if (other < 0 || other >= static_cast<std::ptrdiff_t>(r.height)) continue;
        for (int dx = -kOpennessReach; dx <= kOpennessReach; ++dx) {
            if (dx == 0 && dy == 0) continue;
            // Four in a row: both outer ones count half.
            const float share = (std::abs(dx) == kOpennessReach ? 0.5f : 1.0f) * (std::abs(dy) == kOpennessReach ? 0.5f : 1.0f);
            const auto left = static_cast<std::size_t>(std::max(0, -dx)), right = static_cast<std::size_t>(std::max(0, dx));
            if (left + right >= r.width) continue;
            add_neighbour(r, row + left, row + r.width - right, dy * static_cast<std::ptrdiff_t>(r.width) + dx, share,
                          inv_sq_most, &sum[left], &weight[left]);
        }
    }
    for (std::size_t x = 0; x < r.width; ++x) out[row + x] = r.hit[row + x] > 0 ? sum[x] / weight[x] : 0.0f;
}

}  // namespace

std::vector<float> filtered_openness(const SurfacePlanes& planes, std::span<const float> open, int samples) {
    const Rows rows(planes, open);
    const float most = kMostErrors * kErrorOfOne * std::pow(static_cast<float>(samples), -0.75f);
    std::vector<float> out(open.size());
    constexpr std::size_t kGrain = 16;
    parallel_blocks(rows.height, kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<float> sum(rows.width), weight(rows.width);
        for (std::size_t y = begin; y < end; ++y) filter_row(rows, y, 1 / (most * most), sum, weight, out);
    });
    return out;
}

}  // namespace slim

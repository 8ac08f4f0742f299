#include "tests/bench/exact_crest.h"

#include "raytrace/lines/line_kind.h"
#include "slim/base/parallel.h"
#include "slim/blend/curvature.h"
#include "slim/scanner/range_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace slim::bench {
namespace {

/// One family on the exact surface: ridges, or valleys as the ridges of the surface turned inside
/// out.
struct Exact {
    const Shape& shape;
    bool ridge;
    double step = 1e-3 * length(shape.bounds.hi - shape.bounds.lo);

    Vec3d foot(Vec3d p) const {
        for (int k = 0; k < 4; ++k) {
            const Jet2 f = shape.jet(p);
            p = p - f.gradient() * (f.value / sq_length(f.gradient()));
        }
        return p;
    }
    double k_at(const Vec3d& p) const {
        const SurfacePoint at = surface_point(shape.jet(p));
        return ridge ? at.k1 : -at.k2;
    }
    Vec3d along(const Vec3d& p) const {
        const Jet2 f = shape.jet(p);
        const ThirdOrder t =
            third_order_from(f.gradient(), {f.h[0], f.h[1], f.h[2], f.h[3], f.h[4], f.h[5]}, {});
        return ridge ? t.t1 : t.t2;
    }
    /// dk/dt along t.
    double rise(const Vec3d& p, const Vec3d& t) const {
        return (k_at(foot(p + t * step)) - k_at(foot(p - t * step))) / (2 * step);
    }
    double rise_like(const Vec3d& p, const Vec3d& reference) const {
        const Vec3d t = along(p);
        return rise(p, dot(t, reference) < 0 ? t * -1.0 : t);
    }
    bool bends(const Vec3d& p) const {
        const SurfacePoint at = surface_point(shape.jet(p));
        return ridge ? at.k1 > std::abs(at.k2) : -at.k2 > std::abs(at.k1);
    }
    bool is_greatest(const Vec3d& p) const {
        const Vec3d t = along(p);
        return rise_like(foot(p + t * (2 * step)), t) < 0 &&
               rise_like(foot(p - t * (2 * step)), t) > 0;
    }
    double sharpness(const Vec3d& p) const {
        constexpr double kTurn = 0.7;
        const Vec3d t = along(p),
                    inwards = surface_point(shape.jet(p)).normal * (ridge ? -1.0 : 1.0);
        const double k = k_at(p);
        double most = 0;
        for (const double side : {-kTurn, kTurn}) {
            const Vec3d there = p + (t * std::sin(side) + inwards * (1 - std::cos(side))) / k;
            most = std::max(most, k_at(foot(there)) / k);
        }
        return 2 * (1 - most) / (kTurn * kTurn);
    }
    /// The zero of dk/dt between two points of one sheet whose directions agree.
    std::optional<Vec3d> zero_between(const Vec3d& a, const Vec3d& b) const {
        const Vec3d t = along(a);
        if (!bends(a) || !bends(b) || std::abs(dot(t, along(b))) < 0.7) return std::nullopt;
        const double at_a = rise_like(a, t);
        if ((at_a > 0) == (rise_like(b, t) > 0)) return std::nullopt;
        double lo = 0, hi = 1;
        for (int k = 0; k < 10; ++k) {
            const double middle = 0.5 * (lo + hi);
            const bool same = (rise_like(foot(a + (b - a) * middle), t) > 0) == (at_a > 0);
            (same ? lo : hi) = middle;
        }
        const Vec3d p = foot(a + (b - a) * (0.5 * (lo + hi)));
        return is_greatest(p) ? std::optional(p) : std::nullopt;
    }
};

Vec3d point_of(const GBuffer& b, std::size_t i) {
    return {static_cast<double>(b.position[0][i]), static_cast<double>(b.position[1][i]),
            static_cast<double>(b.position[2][i])};
}

/// The zeros on the edges to the right of and below the pixels of a row.
struct RowZeros {
    std::vector<std::optional<Vec3d>> right, down;
};

bool changes(const GBuffer& b, bool ridge, std::size_t i, std::size_t j) {
    if (!b.hit[i] || !b.hit[j]) return false;
    const auto vec = [](const auto& planes, std::size_t at) {
        return Vec3f{planes[0][at], planes[1][at], planes[2][at]};
    };
    const Vec3f ni = vec(b.normal, i), nj = vec(b.normal, j),
                d = vec(b.position, j) - vec(b.position, i);
    if (dot(ni, nj) < 0.5f || std::abs(dot(ni, d)) > 0.5f * length(d)) return false;
    const auto t = [&](std::size_t at, const Vec3f& n) {
        const Vec3f t1 = vec(b.direction, at);
        return ridge ? t1 : cross(n, t1);
    };
    const auto& e = b.third[ridge ? 0 : 3];
    const float turn = dot(t(i, ni), t(j, nj));
    return std::abs(turn) > 0.7f && (e[i] > 0) != ((turn < 0 ? -e[j] : e[j]) > 0);
}

RowZeros zeros_of_row(const Exact& exact, const GBuffer& b, std::size_t y) {
    const auto width = static_cast<std::size_t>(b.width),
               height = static_cast<std::size_t>(b.height);
    RowZeros out{std::vector<std::optional<Vec3d>>(width),
                 std::vector<std::optional<Vec3d>>(width)};
    for (std::size_t x = 0; x < width; ++x) {
        const std::size_t i = y * width + x;
        if (x + 1 < width && changes(b, exact.ridge, i, i + 1))
            out.right[x] =
                exact.zero_between(exact.foot(point_of(b, i)), exact.foot(point_of(b, i + 1)));
        if (y + 1 < height && changes(b, exact.ridge, i, i + width))
            out.down[x] =
                exact.zero_between(exact.foot(point_of(b, i)), exact.foot(point_of(b, i + width)));
    }
    return out;
}

CrestSample sample_of(const Exact& exact, const PixelView& view, const Vec3d& p, const Vec3d& q) {
    const auto pixel = [&](const Vec3d& at) {
        const Vec3d c = view.camera_from_local(at);
        const double scale = view.orthographic ? view.px_per_unit : view.focal_px / c.z;
        return std::array{view.center_x + scale * c.x, view.center_y + scale * c.y};
    };
    const auto a = pixel(p), b = pixel(q);
    return {exact.ridge, 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]),
            std::hypot(b[0] - a[0], b[1] - a[1]), exact.sharpness(exact.foot((p + q) * 0.5))};
}

}  // namespace

GBuffer exact_buffer(const Shape& shape, const PixelView& view, int width, int height) {
    GBuffer out;
    out.reset(width, height, line_channels(std::array{LineKind::ridge}, 3));
    const Exact ridges{shape, true}, valleys{shape, false};
    parallel_blocks(static_cast<std::size_t>(height), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin * static_cast<std::size_t>(width);
             i < end * static_cast<std::size_t>(width); ++i) {
            const double x = static_cast<double>(i % static_cast<std::size_t>(width)) + 0.5,
                         y = static_cast<double>(i / static_cast<std::size_t>(width)) + 0.5;
            const Ray ray{view.ray_origin(x, y), view.ray_direction(x, y)};
            const auto hit = first_hit(shape, ray, clip_to_shape(ray, shape));
            if (!hit) continue;
            const Vec3d p = ridges.foot(ray.origin + ray.direction * hit->t);
            const SurfacePoint at = surface_point(shape.jet(p));
            const Vec3d t1 = ridges.along(p), t2 = cross(at.normal, t1);
            out.hit[i] = 1;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                out.position[axis][i] = static_cast<float>(p[axis]);
                out.normal[axis][i] = static_cast<float>(at.normal[axis]);
                out.direction[axis][i] = static_cast<float>(t1[axis]);
            }
            out.k1[i] = static_cast<float>(at.k1), out.k2[i] = static_cast<float>(at.k2);
            out.third[0][i] = static_cast<float>(ridges.rise(p, t1));
            out.third[3][i] = static_cast<float>(-valleys.rise(p, t2));
        }
    });
    return out;
}

std::vector<CrestSample> exact_crest_lines(const Shape& shape, const PixelView& view,
                                           const GBuffer& exact) {
    const auto width = static_cast<std::size_t>(exact.width),
               height = static_cast<std::size_t>(exact.height);
    std::vector<CrestSample> out;
    for (const bool ridge : {true, false}) {
        const Exact family{shape, ridge};
        std::vector<RowZeros> rows(height);
        parallel_blocks(height, 4, [&](std::size_t begin, std::size_t end) {
            for (std::size_t y = begin; y < end; ++y) rows[y] = zeros_of_row(family, exact, y);
        });
        for (std::size_t y = 0; y + 1 < height; ++y)
            for (std::size_t x = 0; x + 1 < width; ++x) {
                std::vector<Vec3d> found;
                for (const auto& zero :
                     {rows[y].right[x], rows[y].down[x + 1], rows[y + 1].right[x], rows[y].down[x]})
                    if (zero) found.push_back(*zero);
                // Where two lines pass through one cell (beside an umbilic),
                // the pieces along its sides.
                for (std::size_t k = 0; k + 1 < found.size(); k += 2)
                    out.push_back(sample_of(family, view, found[k], found[k + 1]));
            }
    }
    return out;
}

}  // namespace slim::bench

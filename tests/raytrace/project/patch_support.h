#pragma once

#include "raytrace/project/outline.h"
#include "raytrace/project/pixel_records.h"
#include "slim/base/hash.h"
#include "slim/blend/ray_surfel.h"
#include "slim/model/surfel_tree.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace slim::test {

inline double uniform(std::uint64_t seed, std::uint64_t i) {
    return 2 * unit_interval(keyed_hash(seed, i)) - 1;
}

/// In front of a camera at the origin that looks along z.
inline Surfel random_surfel(std::uint64_t seed, int degree, double nearest) {
    Surfel s{};
    const double z = nearest + 1 + uniform(seed, 0);
    s.center = {0.5 * z * uniform(seed, 1), 0.5 * z * uniform(seed, 2), z};
    s.support_radius = 0.1 + 0.05 * uniform(seed, 3);
    s.frame = frame_from_normal(
        round_normal(normalized(Vec3d{uniform(seed, 4), uniform(seed, 5), uniform(seed, 6)})));
    const auto n = static_cast<std::uint64_t>(degree <= 1 ? 1 : n_coefficients(degree));
    for (std::uint64_t k = 0; k < n; ++k)
        s.polynomial.a[k] = (k < 3 ? 0.1 : 0.3) * uniform(seed, 10 + k);
    s.degree = degree;
    return s;
}

inline PixelView view_of(bool orthographic) {
    Camera camera;
    camera.eye = {0, 0, 0}, camera.target = {0, 0, 1}, camera.up = {0, -1, 0};
    camera.orthographic = orthographic, camera.fov_y_deg = 70, camera.width = 3;
    return pixel_view(camera, 200, 200);
}

inline void add(const PixelView& view, const Surfel& s, SurfelBatch& batch) {
    batch.add(view.camera_from_local(s.center), s.support_radius,
              octahedral_from_normal(s.frame.normal),
              std::span<const double, kMaxCoefficients>(s.polynomial.a));
}

/// A surfel as a batch of its own: all lanes repeat it.
inline SurfelLanes lanes_of(const PixelView& view, const Surfel& s) {
    SurfelBatch batch;
    add(view, s, batch);
    return batch.lanes(view);
}

/// Whether the ray of a pixel meets the surface inside its ball.
inline bool meets_patch(const PixelView& view, const Surfel& s, int x, int y) {
    const LocalRay local =
        local_ray({view.ray_origin(x + 0.5, y + 0.5), view.ray_direction(x + 0.5, y + 0.5)}, s);
    if (!local.meets_ball()) return false;
    const double half = local.half_chord();
    return ray_roots(ray_polynomial(local, s.polynomial), -half, half).n > 0;
}

/// The footprints of some patches in a window of 200 x 200.
inline std::array<Footprint, kSurfelLanes> footprints(const PixelView& view,
                                                      const SurfelLanes& lanes) {
    std::array<Footprint, kSurfelLanes> out;
    std::array<Footprint*, kSurfelLanes> to;
    for (std::size_t k = 0; k < kSurfelLanes; ++k) to[k] = &out[k];
    const RayForm form = ray_form(view, lanes);
    Footprints({0, 0, 200, 200}, form, PixelGrid(form), lanes, patch_bounds(lanes, 1)).put(to);
    return out;
}

inline Footprint footprint(const PixelView& view, const Surfel& s) {
    return footprints(view, lanes_of(view, s)).back();
}

inline bool holds(const ScreenRect& r, int x, int y) {
    return x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1;
}

}  // namespace slim::test

#include "slim/model/surfel_tree.h"

#include "slim/base/check.h"

#include <algorithm>

namespace slim {

Surfel SurfelTree::surfel(std::size_t i) const {
    const float* r = record(i);
    Surfel s{center(i), r[3], frame_from_normal(normal_from_octahedral({r[4], r[5]})), {}, 0};
    s.degree = nodes_[i].degree;
    const int n = header_.degree <= 1 ? 1 : n_coefficients(header_.degree);
    for (int k = 0; k < n; ++k) s.polynomial.a[static_cast<std::size_t>(k)] = r[6 + k];
    return s;
}

Vec3d round_normal(const Vec3d& unit_normal) {
    return normal_from_octahedral(octahedral_from_normal(unit_normal));
}

Surfel level_linear(const Surfel& s) {
    if (s.degree > 1) return s;
    const auto& a = s.polynomial.a;
    // Gradient of f = w - a0 - a1 u - a2 v; the plane's distance to the centre along the new normal.
    const double len = std::sqrt(1 + a[1] * a[1] + a[2] * a[2]);
    const Vec3d normal = s.frame.world_from_local({-a[1] / len, -a[2] / len, 1 / len});
    Surfel out = s;
    out.frame = frame_from_normal(round_normal(normal));
    out.polynomial = {};
    out.polynomial.a[0] = a[0] / len;
    return out;
}

void encode_surfels(std::span<const Surfel> surfels, SurfelTreeData& out) {
    const int degree = out.header.degree;
    const auto stride = static_cast<std::size_t>(floats_per_surfel(degree));
    out.page_origins.clear();
    out.records.assign(surfels.size() * stride, 0.0f);
    for (std::size_t page = 0; page < surfels.size(); page += kSurfelsPerPage) {
        const std::size_t end = std::min(surfels.size(), page + kSurfelsPerPage);
        Bbox box;
        for (std::size_t i = page; i < end; ++i) box.extend(surfels[i].center);
        const Vec3d origin = box.center();
        out.page_origins.push_back(origin);
        for (std::size_t i = page; i < end; ++i) {
            const Surfel s = degree <= 1 ? level_linear(surfels[i]) : surfels[i];
            float* r = out.records.data() + i * stride;
            const Vec3f c = to_float(s.center - origin);
            const Octahedral n = octahedral_from_normal(s.frame.normal);
            r[0] = c.x, r[1] = c.y, r[2] = c.z;
            r[3] = static_cast<float>(s.support_radius);
            r[4] = n.s, r[5] = n.t;
            for (std::size_t k = 6; k < stride; ++k)
                r[k] = static_cast<float>(s.polynomial.a[k - 6]);
        }
    }
}

}  // namespace slim

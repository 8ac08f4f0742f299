#include "slim/color/color_blend.h"

#include "slim/model/weight_kernel.h"

namespace slim {

Vec3f ColorBlend::of_node(const Surfel& s, std::size_t node, const Vec3d& p) const {
    const Vec3d local = s.frame.local_from_world((p - s.center) / s.support_radius);
    return unpack(colors_[node]).at(static_cast<float>(local.x), static_cast<float>(local.y));
}

Vec3f ColorBlend::at(const Vec3d& p, const Vec3d& n, std::uint32_t node,
                     std::vector<const Surfel*>& found) const {
    index_.supporters(p, found);
    Vec3f sum;
    float total = 0;
    for (const Surfel* s : found) {
        if (!(dot(s->frame.normal, n) > 0)) continue;
        const auto w = static_cast<float>(
            weight_kernel(sq_length(p - s->center) / (s->support_radius * s->support_radius)));
        sum += of_node(*s, index_.node(index_.number_of(s)), p) * w;
        total += w;
    }
    if (total > 0) return sum / total;
    return unpack(colors_[node]).at(0, 0);
}

}  // namespace slim

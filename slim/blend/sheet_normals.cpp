#include "slim/blend/sheet_normals.h"

#include "slim/blend/blend.h"

namespace slim {

std::optional<SheetNormals> sheet_normals_at(const Vec3d& p,
                                             std::span<const Surfel* const> supporters) {
    const std::optional<Vec3d> mean = normal_at(p, supporters);
    if (!mean) return std::nullopt;
    Vec3d along, against;
    for (const Surfel* s : supporters) {
        const Vec3d g = weighted_gradient(*s, p);
        (dot(g, *mean) < 0 ? against : along) += g;
    }
    if (!(sq_length(against) > 0)) return SheetNormals{*mean, {}};
    return SheetNormals{normalized(along), normalized(against)};
}

}  // namespace slim

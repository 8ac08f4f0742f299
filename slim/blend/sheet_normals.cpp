#include "slim/blend/sheet_normals.h"

#include "slim/blend/blend.h"
#include "slim/model/weight_kernel.h"

namespace slim {
namespace {

/// That of the surfel's function at p, by its say there; zero outside its ball.
Vec3d weighted_gradient(const Surfel& s, const Vec3d& p) {
    const Vec3d x = (p - s.center) / s.support_radius;
    const double sq = sq_length(x);
    return sq < 1 ? s.sheet_gradient(s.active_sheet(x), x) * weight_kernel(sq) : Vec3d{};
}

}  // namespace

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

#include "slim/edges/edge_blend.h"

#include "slim/model/weight_kernel.h"

#include <cmath>
#include <utility>

namespace slim {
namespace {

/// Cosine that a sheet's normal must have with the face that is followed: less than the least angle
/// between the sheets of a surfel, as where surfaces are blended (kSharpGate).
constexpr double kSameFace = 0.866;

/// An edge of a leaf where it is nearest a place.
struct OwnEdge {
    Vec3d x;  ///< relative to the centre, over rho
    std::array<Vec3d, 2> normal;
};

/// The normals of a pair's faces at x in the order of the side; nothing if it is another edge.
std::optional<std::array<Vec3d, 2>> normals_of_side(const Surfel& s, std::size_t pair,
                                                    const Vec3d& x, const EdgeSide& side) {
    if ((join_of_pair(*s.sharp, pair) == Join::max) != side.convex) return std::nullopt;
    const SheetPair& sheets = kSheetPairs[pair];
    std::array<Vec3d, 2> n{normalized(s.sheet_gradient(sheets.a, x)),
                           normalized(s.sheet_gradient(sheets.b, x))};
    const auto agree = [&] {
        return std::min(dot(n[0], side.normal[0]), dot(n[1], side.normal[1]));
    };
    if (agree() > kSameFace) return n;
    std::swap(n[0], n[1]);
    if (agree() > kSameFace) return n;
    return std::nullopt;
}

std::optional<OwnEdge> own_edge(const Surfel& s, std::size_t pair, const Vec3d& x,
                                const EdgeSide& side) {
    if (!normals_of_side(s, pair, x, side)) return std::nullopt;
    const auto at = nearest_on_edge(s, kSheetPairs[pair], x);
    if (!at || !(sq_length(*at - x) < kBelongs * kBelongs)) return std::nullopt;
    const auto normal = normals_of_side(s, pair, *at, side);
    if (!normal) return std::nullopt;
    return OwnEdge{*at, *normal};
}

}  // namespace

BallIndex sharp_leaves(const SurfelTree& tree, bool loose) {
    std::vector<Surfel> leaves;
    for (const SharpEntry& entry : tree.sharp()) {
        const TreeNode& node = tree.node(entry.node);
        if (node.is_leaf() && (loose || !node.is_loose()))
            leaves.push_back(tree.surfel(entry.node));
    }
    return BallIndex(std::move(leaves));
}

std::optional<BlendedEdge> EdgeBlender::blend(const Vec3d& p, const EdgeSide& side) {
    BlendedEdge sum;
    double weight = 0;
    parts_.clear();
    supporters_.clear();
    leaves_.supporters(p, supporters_);
    for (const Surfel* s : supporters_) {
        const double rho = s->support_radius;
        const Vec3d x = (p - s->center) / rho;
        const double g = weight_kernel(sq_length(x));
        for (std::size_t pair = 0; pair < n_sheet_pairs(*s); ++pair) {
            const auto own = own_edge(*s, pair, x, side);
            if (!own) continue;
            const bool shows = edge_shows(*s, kSheetPairs[pair], own->x);
            parts_.push_back({static_cast<std::uint32_t>(leaves_.number_of(s)),
                              static_cast<std::uint8_t>(pair)});
            (shows ? sum.shown : sum.cut) += g;
            sum.in_core = sum.in_core || (shows && sq_length(own->x) < kHitTrim * kHitTrim);
            weight += g, sum.radius += g * rho;
            sum.point += (s->center - p + own->x * rho) * g;
            for (std::size_t k = 0; k < 2; ++k) sum.normal[k] += own->normal[k] * g;
        }
    }
    if (!(weight > 0)) return std::nullopt;
    sum.point = p + sum.point / weight;
    sum.radius /= weight;
    for (Vec3d& n : sum.normal) n = normalized(n);
    return sum;
}

std::optional<BlendedEdge> EdgeBlender::settle(const Vec3d& p, const EdgeSide& side) {
    const auto first = blend(p, side);
    if (!first) return std::nullopt;
    return blend(first->point, {first->normal, side.convex});
}

}  // namespace slim

#include "slim/cover/second_fit.h"

#include "slim/cover/leaves_along_curve.h"
#include "slim/model/rim.h"

#include <algorithm>

namespace slim {
namespace {

constexpr std::size_t kPiece = 1024;  // leaves that wait together

}  // namespace

void SecondFit::blend(const CoveringSurfel& leaf) {
    const Surfel& s = leaf.fitted.surfel;
    const auto rho = static_cast<float>(s.support_radius);
    const Rim first = unpack_rim(s.rims.first), second = unpack_rim(s.rims.second);
    const bool is_whole = !s.rims.any();
    for (const Covered& p : leaf.covered) {
        const double share =
            is_whole ? 1 : std::min(rim_share(first, p.u, p.v), rim_share(second, p.u, p.v));
        const float weight = p.weight * static_cast<float>(share);
        blend_[p.point].weight += weight;
        blend_[p.point].height += weight * p.off * rho;
    }
}

/// In pieces: an array that doubles would take the memory of the points.
void SecondFit::wait(const FittedSurfel& leaf) {
    if (waiting_.empty() || waiting_.back().size() == kPiece)
        waiting_.emplace_back().reserve(kPiece);
    waiting_.back().push_back(leaf);
}

std::size_t SecondFit::run(const PointTree& points) {
    std::vector<FittedSurfel*> leaves;
    for (std::vector<FittedSurfel>& piece : waiting_)
        for (FittedSurfel& leaf : piece) leaves.push_back(&leaf);
    const std::size_t moved = refit_to_blend(
        points, blend_, leaves_along_curve(leaves, [](const FittedSurfel& leaf) -> const Surfel& {
            return leaf.surfel;
        }));
    std::vector<BlendResidual>().swap(blend_);
    return moved;
}

}  // namespace slim

#include "slim/cover/second_fit.h"

#include "slim/model/rim.h"

namespace slim {
namespace {

constexpr std::size_t kPiece = 1024;  // leaves that wait together

}  // namespace

void SecondFit::blend(const CoveringSurfel& leaf) {
    const Surfel& s = leaf.fitted.surfel;
    const auto rho = static_cast<float>(s.support_radius);
    for (const Covered& p : leaf.covered) {
        const float weight = p.weight * static_cast<float>(rim_share(s.rims, p.u, p.v));
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
    std::size_t moved = 0;
    for (std::vector<FittedSurfel>& leaves : waiting_)
        moved += refit_to_blend(points, blend_, leaves);
    std::vector<BlendResidual>().swap(blend_);
    return moved;
}

}  // namespace slim

#include "slim/cover/second_fit.h"

#include "slim/cover/leaves_along_curve.h"

#include <algorithm>
#include <span>

namespace slim {
namespace {

constexpr std::size_t kPiece = 1024;  // leaves that wait together

}  // namespace

void SecondFit::blend(const CoveringSurfel& leaf, bool stays) {
    const LeafShares shares(leaf.fitted.surfel);
    for (const Covered& p : leaf.covered) {
        const LeafShare share = shares.of(p);
        blend_[p.point].weight += share.weight;
        blend_[p.point].height += share.height;
        if (removes_ && stays && share.is_drawn && n_drawn_[p.point] < 255) ++n_drawn_[p.point];
    }
}

/// In pieces: an array that doubles would take the memory of the points.
void SecondFit::wait(const CoveringSurfel& leaf, std::uint32_t center) {
    if (removes_) {
        centers_.push_back(center);
        counted_.push_back(count_of(leaf));
    }
    if (waiting_.empty() || waiting_.back().size() == kPiece)
        waiting_.emplace_back().reserve(kPiece);
    waiting_.back().push_back(leaf.fitted);
}

void SecondFit::remove(const PointTree& points, const NeedlessRules& rules,
                       const CountedVisit& removed) {
    remove_needless(points, rules, centers_, blend_, n_drawn_, waiting_,
                    [&](const FittedSurfel& leaf, std::size_t number) {
                        removed(leaf, counted_[number]);
                    });
    std::vector<LeafCount>().swap(counted_);
    std::vector<std::uint32_t>().swap(centers_);
    std::vector<std::uint8_t>().swap(n_drawn_);
}

/// What the first fits leave over is known once all are made: the order of leaves says nothing.
std::size_t SecondFit::run(const PointTree& points) {
    std::vector<FittedSurfel*> waiting;
    for (std::vector<FittedSurfel>& piece : waiting_)
        for (FittedSurfel& leaf : piece) waiting.push_back(&leaf);
    const std::vector<FittedSurfel*> leaves = leaves_along_curve(
        waiting, [](const FittedSurfel& leaf) -> const Surfel& { return leaf.surfel; });
    std::vector<float> moves(blend_.size());
    std::size_t moved = 0;
    for (std::span<FittedSurfel* const> rest(leaves); !rest.empty();) {
        const auto piece = rest.first(std::min(kPiece, rest.size()));
        moved += refit_to_blend(points, blend_, piece, moves);
        rest = rest.subspan(piece.size());
    }
    for (std::size_t i = 0; i < moves.size(); ++i) blend_[i].height += moves[i];
    refit_to_blend(points, blend_, leaves);
    std::vector<BlendResidual>().swap(blend_);
    return moved;
}

}  // namespace slim

#include "slim/smooth/refit_budget.h"

#include <algorithm>

namespace slim {
namespace {

constexpr std::uint64_t kProgram = std::uint64_t{22} << 20;  ///< with what reads and writes clouds
constexpr std::uint64_t kLeaf = 600;          ///< the model's index and mapped file
constexpr std::uint64_t kPoint = 130;         ///< sorted, with its place in the pyramid
constexpr std::uint64_t kLeafOfRadii = 1500;  ///< wide_radii
constexpr std::uint64_t kFit = 1600;          ///< RefittedSurface while it is built
/// Where a point is and goes, twice, and its place in the order; as much again for what was freed
/// and not given back.
constexpr std::uint64_t kInBatches = 480;
constexpr std::uint64_t kLeastBatch = 1 << 16, kMostBatch = 1 << 20;

}  // namespace

RefitBudget refit_budget(std::uint64_t memory, std::size_t n_leaves) {
    const std::uint64_t taken = kProgram + kLeaf * n_leaves;
    const std::uint64_t rest = memory > taken ? memory - taken : 0;
    // Fits of fewer points tell more than none.
    const std::uint64_t of_radii = kLeafOfRadii * n_leaves;
    const std::uint64_t of_points =
        of_radii <= rest / 4 * 3 ? std::min(rest / 2, rest - of_radii) : rest / 2;
    const std::uint64_t points = std::min<std::uint64_t>(kMostSmoothPoints, of_points / kPoint);
    const std::uint64_t others = rest - points * kPoint;
    const std::uint64_t batch = std::clamp(points * kPoint / kInBatches, kLeastBatch, kMostBatch);
    return {static_cast<std::size_t>(points), static_cast<std::size_t>(others / kLeafOfRadii),
            static_cast<std::size_t>(others / kFit), static_cast<std::size_t>(batch)};
}

}  // namespace slim

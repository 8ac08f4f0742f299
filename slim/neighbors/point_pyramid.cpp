#include "slim/neighbors/point_pyramid.h"

#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "slim/model/surfel.h"
#include "slim/neighbors/key_sort.h"

namespace slim {
namespace {

constexpr std::uint64_t kPriority = 0x7072696f;  // purpose of the hash
constexpr std::size_t kSmallest = 512;           // a thinning below this many points serves nobody

/// Points of lower priority are in the share, < 1.
std::uint64_t limit_of(double share) { return static_cast<std::uint64_t>(share * 0x1.0p64); }

}  // namespace

std::uint64_t priority_of(std::uint64_t seed, std::uint64_t id) {
    return keyed_hash(seed, id, kPriority);
}

bool in_share(std::uint64_t seed, std::uint64_t id, double share) {
    return share >= 1 || priority_of(seed, id) < limit_of(share);
}

PointPyramid::PointPyramid(const PointBlock& block, const Bbox& box, std::uint64_t seed,
                           double share) {
    const std::size_t n = block.size();
    UnfilledVector<std::uint64_t> priority(n);
    parallel_blocks(n, 16384, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) priority[i] = priority_of(seed, block.id[i]);
    });
    by_priority_ = order_by_key(priority);

    std::vector<std::uint32_t> chosen = morton_order(block, box);
    levels_.emplace_back(block, chosen);
    shares_.push_back(share);
    for (double next = 1;;) {
        next *= kGoldenRatio * kGoldenRatio;
        if (next >= share) continue;
        const std::uint64_t limit = limit_of(next);
        parallel_erase_if(chosen, [&](std::uint32_t i) { return priority[i] >= limit; });
        if (chosen.size() < kSmallest) break;
        levels_.emplace_back(block, chosen);
        shares_.push_back(next);
    }
}

}  // namespace slim

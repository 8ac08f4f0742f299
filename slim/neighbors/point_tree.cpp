#include "slim/neighbors/point_tree.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/neighbors/morton.h"

#include <tbb/parallel_sort.h>

#include <limits>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kGrain = 16384;

}  // namespace

PointTree::PointTree(const PointBlock& block, std::span<const std::uint32_t> chosen)
    : source_(chosen.begin(), chosen.end()) {
    const std::size_t n = chosen.size();
    for (auto* a : {&x_, &y_, &z_}) a->resize(n);
    for (auto* a : {&nx_, &ny_, &nz_}) a->resize(n);
    parallel_blocks(n, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3d& p = block.position[chosen[i]];
            x_[i] = p.x, y_[i] = p.y, z_[i] = p.z;
            const Vec3f m = block.has_normals() ? block.normal[chosen[i]] : Vec3f{};
            nx_[i] = m.x, ny_[i] = m.y, nz_[i] = m.z;
        }
    });
    build_boxes();
}

void PointTree::build_boxes() {
    if (size() == 0) return;
    std::vector<Bbox> buckets((size() + kBucket - 1) / kBucket);
    parallel_blocks(buckets.size(), kGrain / kBucket, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b)
            for (std::size_t i = b * kBucket; i < std::min(size(), (b + 1) * kBucket); ++i)
                buckets[b].extend(position(i));
    });
    levels_.push_back(std::move(buckets));
    while (levels_.back().size() > kFanout) {
        const std::vector<Bbox>& below = levels_.back();
        std::vector<Bbox> above((below.size() + kFanout - 1) / kFanout);
        for (std::size_t i = 0; i < below.size(); ++i) above[i / kFanout].extend(below[i]);
        levels_.push_back(std::move(above));
    }
}

std::vector<std::uint32_t> morton_order(const PointBlock& block, const Bbox& box) {
    SLIM_CHECK(block.size(), <, std::size_t{std::numeric_limits<std::uint32_t>::max()});
    const MortonCurve curve(box);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(block.size());
    parallel_blocks(keys.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            keys[i] = {curve.key(block.position[i]), static_cast<std::uint32_t>(i)};
    });
    tbb::parallel_sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> order(keys.size());
    for (std::size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].second;
    return order;
}

}  // namespace slim

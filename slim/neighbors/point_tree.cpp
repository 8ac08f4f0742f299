#include "slim/neighbors/point_tree.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/neighbors/key_sort.h"
#include "slim/neighbors/morton.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kGrain = 16384;

}  // namespace

PointTree::PointTree(const PointBlock& block, std::span<const std::uint32_t> chosen)
    : source_(chosen.begin(), chosen.end()) {
    const std::size_t n = chosen.size();
    buckets_.resize((n + kBucket - 1) / kBucket);
    parallel_blocks(buckets_.size(), kGrain / kBucket, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) fill_bucket(block, chosen, b);
    });
    boxes_ = BoxTree(n, [&](std::size_t i) { return position(i); });
}

void PointTree::fill_bucket(const PointBlock& block, std::span<const std::uint32_t> chosen,
                            std::size_t bucket) {
    constexpr double kNowhere = std::numeric_limits<double>::infinity();
    PointBucket& out = buckets_[bucket];
    for (std::size_t k = 0; k < kBucket; ++k) {
        const std::size_t i = bucket * kBucket + k;
        const bool is_point = i < chosen.size();
        const Vec3d p = is_point ? block.position[chosen[i]] : Vec3d{kNowhere, kNowhere, kNowhere};
        const Vec3f n = is_point && block.has_normals() ? block.normal[chosen[i]] : Vec3f{};
        out.x[k] = p.x, out.y[k] = p.y, out.z[k] = p.z;
        out.nx[k] = n.x, out.ny[k] = n.y, out.nz[k] = n.z;
    }
}

namespace {

KeyedIndices curve_keys(std::span<const Vec3d> positions, const Bbox& box) {
    SLIM_CHECK(positions.size(), <, std::size_t{std::numeric_limits<std::uint32_t>::max()});
    const MortonCurve curve(box);
    KeyedIndices keys(positions.size());
    parallel_blocks(keys.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            keys[i] = {curve.key(positions[i]), static_cast<std::uint32_t>(i)};
    });
    sort_by_key(keys);
    return keys;
}

/// Puts the points of each place of the curve in an order of their own.
void order_places(const PointBlock& block, KeyedIndices& keys) {
    const auto less = [&](const KeyedIndex& a, const KeyedIndex& b) {
        const Vec3d &p = block.position[a.index], &q = block.position[b.index];
        return p.x != q.x   ? p.x < q.x
               : p.y != q.y ? p.y < q.y
               : p.z != q.z ? p.z < q.z
                            : block.id[a.index] < block.id[b.index];
    };
    for (std::size_t begin = 0; begin < keys.size();) {
        std::size_t end = begin + 1;
        while (end < keys.size() && keys[end].key == keys[begin].key) ++end;
        if (end - begin > 1)
            std::sort(keys.begin() + static_cast<std::ptrdiff_t>(begin),
                      keys.begin() + static_cast<std::ptrdiff_t>(end), less);
        begin = end;
    }
}

template <class T>
void reorder(const std::vector<std::uint32_t>& order, std::vector<T>& values) {
    if (values.empty()) return;
    std::vector<T> out(values.size());
    parallel_blocks(out.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) out[i] = values[order[i]];
    });
    values = std::move(out);
}

std::vector<std::uint32_t> indices_of(const KeyedIndices& keys) {
    std::vector<std::uint32_t> order(keys.size());
    parallel_blocks(keys.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) order[i] = keys[i].index;
    });
    return order;
}

}  // namespace

std::vector<std::uint32_t> morton_order(const PointBlock& block, const Bbox& box) {
    return indices_of(curve_keys(block.position, box));
}

void sort_along_curve(PointBlock& block, const Bbox& box) {
    KeyedIndices keys = curve_keys(block.position, box);
    order_places(block, keys);
    const std::vector<std::uint32_t> order = indices_of(keys);
    keys = {};
    reorder(order, block.position);
    run_both([&] { reorder(order, block.normal); }, [&] {
        reorder(order, block.id);
        reorder(order, block.scan);
    });
}

}  // namespace slim

#include "slim/neighbors/point_tree.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/neighbors/key_sort.h"
#include "slim/neighbors/morton.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kGrain = 16384;

bool is_whole_block(const PointBlock& block, std::span<const std::uint32_t> chosen) {
    if (chosen.size() != block.size()) return false;
    for (std::size_t i = 0; i < chosen.size(); ++i)
        if (chosen[i] != i) return false;
    return true;
}

/// The direction of a normal in whole units of PointBucket::kUnit; zero if it has none.
Vec3f packed_normal(const Vec3f& n) {
    const float len = length(n);
    if (!(len > 0)) return {};
    const float scale = PointBucket::kUnit / len;
    return {std::rint(n.x * scale), std::rint(n.y * scale), std::rint(n.z * scale)};
}

}  // namespace

PointTree::PointTree(const PointBlock& block, std::span<const std::uint32_t> chosen)
    : block_(&block), size_(chosen.size()) {
    if (!is_whole_block(block, chosen)) source_.assign(chosen.begin(), chosen.end());
    buckets_.resize((size() + kBucket - 1) / kBucket);
    boxes_ = BoxTree(size(), [&](std::size_t i) { return position(i); });
    parallel_blocks(buckets_.size(), kGrain / kBucket, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) fill_bucket(b);
    });
}

void PointTree::fill_bucket(std::size_t bucket) {
    constexpr float kNowhere = std::numeric_limits<float>::infinity();
    PointBucket& out = buckets_[bucket];
    const Bbox box = boxes_.bucket(bucket);
    out.origin = (box.lo + box.hi) * 0.5;
    out.is_exact = true;
    for (std::size_t k = 0; k < kBucket; ++k) {
        const std::size_t i = bucket * kBucket + k;
        const bool is_point = i < size();
        const Vec3f p =
            is_point ? to_float(position(i) - out.origin) : Vec3f{kNowhere, kNowhere, kNowhere};
        const Vec3f n = is_point ? packed_normal(normal(i)) : Vec3f{};
        if (is_point) out.is_exact &= to_double(p) + out.origin == position(i);
        out.x[k] = p.x, out.y[k] = p.y, out.z[k] = p.z;
        out.nx[k] = static_cast<std::int16_t>(n.x);
        out.ny[k] = static_cast<std::int16_t>(n.y);
        out.nz[k] = static_cast<std::int16_t>(n.z);
    }
}

namespace {

UnfilledVector<std::uint64_t> curve_keys(std::span<const Vec3d> positions, const Bbox& box) {
    const MortonCurve curve(box);
    UnfilledVector<std::uint64_t> keys(positions.size());
    parallel_blocks(keys.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) keys[i] = curve.key(positions[i]);
    });
    return keys;
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

}  // namespace

std::vector<std::uint32_t> morton_order(const PointBlock& block, const Bbox& box) {
    return order_by_key(curve_keys(block.position, box));
}

void sort_along_curve(PointBlock& block, const Bbox& box) {
    // The points of each place of the curve come in an order of their own.
    const auto less = [&](std::uint32_t a, std::uint32_t b) {
        const Vec3d &p = block.position[a], &q = block.position[b];
        return p.x != q.x   ? p.x < q.x
               : p.y != q.y ? p.y < q.y
               : p.z != q.z ? p.z < q.z
                            : block.id[a] < block.id[b];
    };
    const std::vector<std::uint32_t> order =
        order_by_key(curve_keys(block.position, box), [&](std::span<std::uint32_t> row) {
            std::sort(row.begin(), row.end(), less);
        });
    // Half of the bytes are positions; the first to touch a page pays for it.
    run_both([&] { reorder(order, block.position); }, [&] {
        reorder(order, block.normal);
        reorder(order, block.id);
        reorder(order, block.scan);
    });
}

}  // namespace slim

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
    boxes_ = BoxTree(n, [&](std::size_t i) { return position(i); });
}

namespace {

std::vector<KeyedIndex> curve_keys(std::span<const Vec3d> positions, const Bbox& box) {
    SLIM_CHECK(positions.size(), <, std::size_t{std::numeric_limits<std::uint32_t>::max()});
    const MortonCurve curve(box);
    std::vector<KeyedIndex> keys(positions.size());
    parallel_blocks(keys.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            keys[i] = {curve.key(positions[i]), static_cast<std::uint32_t>(i)};
    });
    sort_by_key(keys);
    return keys;
}

/// Puts the points of each place of the curve in an order of their own.
void order_places(const PointBlock& block, std::vector<KeyedIndex>& keys) {
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

std::vector<std::uint32_t> indices_of(const std::vector<KeyedIndex>& keys) {
    std::vector<std::uint32_t> order(keys.size());
    for (std::size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].index;
    return order;
}

}  // namespace

std::vector<std::uint32_t> morton_order(const PointBlock& block, const Bbox& box) {
    return indices_of(curve_keys(block.position, box));
}

void sort_along_curve(PointBlock& block, const Bbox& box) {
    std::vector<KeyedIndex> keys = curve_keys(block.position, box);
    order_places(block, keys);
    const std::vector<std::uint32_t> order = indices_of(keys);
    keys = {};
    reorder(order, block.position);
    reorder(order, block.normal);
    reorder(order, block.id);
    reorder(order, block.scan);
}

}  // namespace slim

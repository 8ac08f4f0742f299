#include "raytrace/trace/bvh.h"

#include "slim/base/parallel.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

namespace slim {
namespace {

constexpr std::uint32_t kBins = 16;
constexpr std::uint32_t kSerialItems = 8192;  ///< subtrees up to this size are built by one thread
/// Time of testing an item, where that of a box is 1 (notes/0001).
constexpr float kItemCost = 2.5f;
/// From here on halves: so deep no tree of floats gets by its areas.
constexpr int kHalvesFrom = kMostBvhDepth - 34;

using Box4 = stdx::simd<float, stdx::simd_abi::deduce_t<float, 4>>;
using Box8 = stdx::simd<float, stdx::simd_abi::deduce_t<float, 8>>;

/// A box as lo and -hi, so that one min extends it, and the number of its item in between.
struct alignas(32) Item {
    std::array<float, 8> v;  ///< lo x y z, number's bits, -hi x y z, 0

    Item() : v{kEmpty, kEmpty, kEmpty, kEmpty, kEmpty, kEmpty, kEmpty, kEmpty} {}
    Item(const BoxF& b, std::uint32_t number)
        : v{b.lo.x, b.lo.y, b.lo.z, std::bit_cast<float>(number), -b.hi.x, -b.hi.y, -b.hi.z, 0} {}

    std::uint32_t number() const { return std::bit_cast<std::uint32_t>(v[3]); }
    BoxF box() const { return {{v[0], v[1], v[2]}, {-v[4], -v[5], -v[6]}}; }
    void extend(const Item& b) {
        stdx::min(Box8(v.data(), stdx::vector_aligned), Box8(b.v.data(), stdx::vector_aligned))
            .copy_to(v.data(), stdx::vector_aligned);
    }
    /// Twice the middle.
    Box4 middle() const {
        return Box4(v.data(), stdx::vector_aligned) - Box4(v.data() + 4, stdx::vector_aligned);
    }

private:
    static constexpr float kEmpty = std::numeric_limits<float>::infinity();
};

struct Bin {
    Item box;
    std::uint32_t n = 0;
};

struct Split {
    int axis = -1;  ///< -1: none that is worth it
    std::uint32_t bin = 0;
    float cost = std::numeric_limits<float>::infinity();
};

struct Range {
    std::uint32_t begin, end;
    std::uint32_t size() const { return end - begin; }
};

/// A subtree to build: its node and its items.
struct Task {
    std::uint32_t node;
    Range items;
    int depth;
};

/// What a node's items have in common.
struct Extent {
    Item box;
    Box4 low{kHuge}, high{-kHuge};  ///< of the middles

    static constexpr float kHuge = std::numeric_limits<float>::infinity();
};

/// Which bins middles fall into, along all axes at once.
struct Binning {
    Box4 low, scale;

    explicit Binning(const Extent& e) : low(e.low) {
        const Box4 width = e.high - e.low;
        scale =
            select<Box4>(width > 0.0f, static_cast<float>(kBins) * 0.99999f / width, Box4(0.0f));
    }
    /// As whole floats.
    Box4 of(const Item& item) const {
        const Box4 at = (item.middle() - low) * scale;
        return stdx::min(stdx::max(at, Box4(0.0f)), Box4(static_cast<float>(kBins) - 1));
    }
};

/// What handles lanes is flattened: g++ 12 leaves out some calls and passes them through memory.
class Builder {
public:
    explicit Builder(std::vector<Item>& items) : items_(items) {}

    /// Builds below a node of `nodes`, or leaves subtrees of at most `serial` items to `later`.
    void build(Task root, std::uint32_t serial, std::vector<BvhNode>& nodes,
               std::vector<Task>* later) const {
        std::vector<Task> stack{root};
        while (!stack.empty()) {
            const Task task = stack.back();
            stack.pop_back();
            if (later && task.items.size() <= serial) {
                later->push_back(task);
                continue;
            }
            const Extent extent = extent_of(task.items);
            nodes[task.node].box = extent.box.box();
            int axis = 0;
            const std::uint32_t middle = divide(task, extent, axis);
            if (middle == task.items.begin) {
                nodes[task.node].first = task.items.begin;
                nodes[task.node].n_items = static_cast<std::uint16_t>(task.items.size());
                continue;
            }
            const auto child = static_cast<std::uint32_t>(nodes.size());
            nodes[task.node].first = child;
            nodes[task.node].axis = static_cast<std::uint16_t>(axis);
            nodes.resize(nodes.size() + 2);
            stack.push_back({child + 1, {middle, task.items.end}, task.depth + 1});
            stack.push_back({child, {task.items.begin, middle}, task.depth + 1});
        }
    }

private:
    using Bins = std::array<std::array<Bin, kBins>, 3>;

    [[gnu::flatten]] Extent extent_of(const Range& r) const {
        Extent e;
        for (std::uint32_t i = r.begin; i < r.end; ++i) {
            e.box.extend(items_[i]);
            e.low = stdx::min(e.low, items_[i].middle());
            e.high = stdx::max(e.high, items_[i].middle());
        }
        return e;
    }

    [[gnu::flatten]] void fill(const Range& r, const Binning& binning, Bins& bins) const {
        for (std::uint32_t i = r.begin; i < r.end; ++i) {
            const Box4 at = binning.of(items_[i]);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                Bin& bin = bins[axis][static_cast<std::size_t>(at[axis])];
                bin.box.extend(items_[i]);
                ++bin.n;
            }
        }
    }

    /// The best split along one axis.
    static Split best_along(int axis, const std::array<Bin, kBins>& bins) {
        std::array<float, kBins> right_cost{};
        Bin right;
        for (std::uint32_t b = kBins - 1; b > 0; --b) {
            right.box.extend(bins[b].box), right.n += bins[b].n;
            const float area = right.n > 0 ? right.box.box().half_area() : -1;
            right_cost[b] = area * static_cast<float>(right.n > 0 ? right.n : 1);
        }
        Split best;
        Bin left;
        for (std::uint32_t b = 1; b < kBins; ++b) {
            left.box.extend(bins[b - 1].box), left.n += bins[b - 1].n;
            if (left.n == 0 || right_cost[b] < 0) continue;
            const float area = left.box.box().half_area();
            const float cost = area * static_cast<float>(left.n) + right_cost[b];
            if (cost < best.cost) best = {axis, b, cost};
        }
        return best;
    }

    [[gnu::noinline]] Split best_split(const Range& r, const Extent& extent,
                                       const Binning& binning) const {
        Bins bins;
        fill(r, binning, bins);
        Split best;
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            if (!(extent.high[a] > extent.low[a])) continue;
            const Split split = best_along(axis, bins[a]);
            if (split.cost < best.cost) best = split;
        }
        return best;
    }

    /// Puts the items of the first child first and returns where the second one's begin; the first
    /// item itself for a leaf.
    [[gnu::flatten]] std::uint32_t divide(const Task& task, const Extent& extent, int& axis) const {
        const Range& r = task.items;
        if (r.size() <= 1) return r.begin;
        const Binning binning(extent);
        const Split best = task.depth < kHalvesFrom ? best_split(r, extent, binning) : Split{};
        const float whole = extent.box.box().half_area();
        const float unsplit = kItemCost * static_cast<float>(r.size()) * whole;
        const bool pays = best.axis >= 0 && 2 * whole + kItemCost * best.cost < unsplit;
        if (!pays && r.size() <= kMostLeafItems) return r.begin;
        if (best.axis < 0) return r.begin + r.size() / 2;
        axis = best.axis;
        const auto a = static_cast<std::size_t>(axis);
        const auto at = [&](std::uint32_t i) {
            return items_.begin() + static_cast<std::ptrdiff_t>(i);
        };
        const auto middle = std::partition(at(r.begin), at(r.end), [&](const Item& item) {
            return static_cast<std::uint32_t>(binning.of(item)[a]) < best.bin;
        });
        return static_cast<std::uint32_t>(middle - items_.begin());
    }

    std::vector<Item>& items_;
};

/// Hangs a subtree, built apart with its own node 0, below a node of the whole.
void append(const std::vector<BvhNode>& subtree, std::uint32_t at, std::vector<BvhNode>& nodes) {
    // Child k of the subtree (k >= 1) becomes node base + k.
    const auto base = static_cast<std::uint32_t>(nodes.size()) - 1;
    const auto moved = [&](BvhNode node) {
        if (!node.is_leaf()) node.first += base;
        return node;
    };
    nodes[at] = moved(subtree[0]);
    for (std::size_t k = 1; k < subtree.size(); ++k) nodes.push_back(moved(subtree[k]));
}

}  // namespace

BoxF empty_box() {
    constexpr float inf = std::numeric_limits<float>::infinity();
    return {{inf, inf, inf}, {-inf, -inf, -inf}};
}

void BoxF::extend(const BoxF& b) {
    lo = {std::min(lo.x, b.lo.x), std::min(lo.y, b.lo.y), std::min(lo.z, b.lo.z)};
    hi = {std::max(hi.x, b.hi.x), std::max(hi.y, b.hi.y), std::max(hi.z, b.hi.z)};
}

float BoxF::half_area() const {
    const Vec3f e = hi - lo;
    return e.x * e.y + e.y * e.z + e.z * e.x;
}

Bvh build_bvh(std::span<const BoxF> boxes) {
    Bvh out;
    const auto n = static_cast<std::uint32_t>(boxes.size());
    if (n == 0) return out;
    std::vector<Item> items;
    items.reserve(n);
    for (std::uint32_t i = 0; i < n; ++i) items.emplace_back(boxes[i], i);
    const Builder builder(items);
    std::vector<Task> later;
    out.nodes.resize(1);
    builder.build({0, {0, n}, 0}, kSerialItems, out.nodes, &later);
    std::vector<std::vector<BvhNode>> subtrees(later.size());
    parallel_blocks(later.size(), 1, [&](std::size_t k, std::size_t) {
        subtrees[k].resize(1);
        builder.build({0, later[k].items, later[k].depth}, 0, subtrees[k], nullptr);
    });
    for (std::size_t k = 0; k < later.size(); ++k) append(subtrees[k], later[k].node, out.nodes);
    out.order.reserve(n);
    for (const Item& item : items) out.order.push_back(item.number());
    return out;
}

std::vector<BoxF> refitted_boxes(const Bvh& bvh, std::span<const BoxF> boxes) {
    std::vector<BoxF> out(bvh.nodes.size());
    // Children come after their parents.
    for (std::size_t i = bvh.nodes.size(); i-- > 0;) {
        const BvhNode& node = bvh.nodes[i];
        out[i] = empty_box();
        if (node.is_leaf())
            for (std::uint32_t k = 0; k < node.n_items; ++k)
                out[i].extend(boxes[bvh.order[node.first + k]]);
        else
            out[i].extend(out[node.first]), out[i].extend(out[node.first + 1]);
    }
    return out;
}

}  // namespace slim

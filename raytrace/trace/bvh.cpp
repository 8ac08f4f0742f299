#include "raytrace/trace/bvh.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <array>
#include <limits>

namespace slim {
namespace {

constexpr std::uint32_t kBins = 16;
constexpr std::uint32_t kSerialItems = 8192;  ///< subtrees up to this size are built by one thread
/// Time of testing an item, where that of a box is 1 (notes/0001).
constexpr float kItemCost = 2.5f;
/// From here on halves: so deep no tree of floats gets by its areas.
constexpr int kHalvesFrom = kMostBvhDepth - 34;

struct Bin {
    BoxF box = empty_box();
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

class Builder {
public:
    Builder(std::span<const BoxF> boxes, std::vector<std::uint32_t>& order)
        : boxes_(boxes), order_(order) {}

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
            nodes[task.node].box = bounds(task.items);
            int axis = 0;
            const std::uint32_t middle = divide(task, axis);
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
    /// Twice the middle of an item's box.
    Vec3f middle_of(std::uint32_t item) const { return boxes_[item].lo + boxes_[item].hi; }

    BoxF bounds(const Range& r) const {
        BoxF box = empty_box();
        for (std::uint32_t i = r.begin; i < r.end; ++i) box.extend(boxes_[order_[i]]);
        return box;
    }

    BoxF middles(const Range& r) const {
        BoxF box = empty_box();
        for (std::uint32_t i = r.begin; i < r.end; ++i) {
            const Vec3f m = middle_of(order_[i]);
            box.extend({m, m});
        }
        return box;
    }

    /// Which bin a middle falls into.
    struct Binning {
        float lo, scale;
        Binning(float low, float high)
            : lo(low), scale(static_cast<float>(kBins) * 0.99999f / (high - low)) {}
        std::uint32_t of(float x) const {
            return std::min(kBins - 1,
                            static_cast<std::uint32_t>(std::max(0.0f, (x - lo) * scale)));
        }
    };

    /// The best split along one axis.
    Split best_along(int axis, const Range& r, const Binning& binning) const {
        std::array<Bin, kBins> bins;
        for (std::uint32_t i = r.begin; i < r.end; ++i) {
            const std::uint32_t item = order_[i];
            Bin& bin = bins[binning.of(middle_of(item)[static_cast<std::size_t>(axis)])];
            bin.box.extend(boxes_[item]);
            ++bin.n;
        }
        std::array<float, kBins> right_cost{};
        Bin right;
        for (std::uint32_t b = kBins - 1; b > 0; --b) {
            right.box.extend(bins[b].box), right.n += bins[b].n;
            right_cost[b] = right.n > 0 ? right.box.half_area() * static_cast<float>(right.n) : -1;
        }
        Split best;
        Bin left;
        for (std::uint32_t b = 1; b < kBins; ++b) {
            left.box.extend(bins[b - 1].box), left.n += bins[b - 1].n;
            if (left.n == 0 || right_cost[b] < 0) continue;
            const float cost = left.box.half_area() * static_cast<float>(left.n) + right_cost[b];
            if (cost < best.cost) best = {axis, b, cost};
        }
        return best;
    }

    /// Puts the items of the first child first and returns where the second one's begin; the first
    /// item itself for a leaf.
    std::uint32_t divide(const Task& task, int& axis) const {
        const Range& r = task.items;
        const auto n = static_cast<float>(r.size());
        if (r.size() <= 1) return r.begin;
        const BoxF box = bounds(r), mid = middles(r);
        Split best;
        if (task.depth < kHalvesFrom)
            for (int k = 0; k < 3; ++k) {
                const auto a = static_cast<std::size_t>(k);
                if (!(mid.hi[a] > mid.lo[a])) continue;
                const Split split = best_along(k, r, Binning(mid.lo[a], mid.hi[a]));
                if (split.cost < best.cost) best = split;
            }
        const float whole = box.half_area();
        const bool pays =
            best.axis >= 0 && 2 * whole + kItemCost * best.cost < kItemCost * n * whole;
        if (!pays && r.size() <= kMostLeafItems) return r.begin;
        if (best.axis < 0) return r.begin + r.size() / 2;
        axis = best.axis;
        const auto a = static_cast<std::size_t>(axis);
        const Binning binning(mid.lo[a], mid.hi[a]);
        const auto at = [&](std::uint32_t i) {
            return order_.begin() + static_cast<std::ptrdiff_t>(i);
        };
        const auto middle = std::stable_partition(at(r.begin), at(r.end), [&](std::uint32_t item) {
            return binning.of(middle_of(item)[a]) < best.bin;
        });
        return static_cast<std::uint32_t>(middle - order_.begin());
    }

    std::span<const BoxF> boxes_;
    std::vector<std::uint32_t>& order_;
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
    out.order.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) out.order[i] = i;
    const Builder builder(boxes, out.order);
    std::vector<Task> later;
    out.nodes.resize(1);
    builder.build({0, {0, n}, 0}, kSerialItems, out.nodes, &later);
    std::vector<std::vector<BvhNode>> subtrees(later.size());
    parallel_blocks(later.size(), 1, [&](std::size_t k, std::size_t) {
        subtrees[k].resize(1);
        builder.build({0, later[k].items, later[k].depth}, 0, subtrees[k], nullptr);
    });
    for (std::size_t k = 0; k < later.size(); ++k) append(subtrees[k], later[k].node, out.nodes);
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

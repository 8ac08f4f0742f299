#include "slim/tree/ball_index.h"

#include "slim/base/simd.h"
#include "slim/neighbors/morton.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace slim {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

float rounded_down(double x) {
    const float f = static_cast<float>(x);
    return f > x ? std::nextafter(f, -kInfinity) : f;
}
float rounded_up(double x) { return -rounded_down(-x); }

Bbox box_of(const Surfel& s) {
    const Vec3d r{s.support_radius, s.support_radius, s.support_radius};
    Bbox b;
    b.extend(s.center - r);
    b.extend(s.center + r);
    return b;
}

std::vector<std::uint32_t> leaf_nodes(const SurfelTree& tree) {
    std::vector<std::uint32_t> nodes;
    for (std::size_t i = 0; i < tree.n_nodes(); ++i)
        if (tree.node(i).is_leaf()) nodes.push_back(static_cast<std::uint32_t>(i));
    return nodes;
}

std::vector<Surfel> leaves_of(const SurfelTree& tree, const LeafHessians* hessians) {
    std::vector<Surfel> leaves;
    for (const std::uint32_t i : leaf_nodes(tree)) {
        leaves.push_back(tree.surfel(i));
        if (hessians) leaves.back().hessian = hessians->of(i);
    }
    return leaves;
}

std::vector<std::uint32_t> numbers_up_to(std::size_t n) {
    std::vector<std::uint32_t> numbers(n);
    std::iota(numbers.begin(), numbers.end(), 0u);
    return numbers;
}

}  // namespace

BallIndex::Boxes::Boxes() {
    for (std::size_t axis = 0; axis < 3; ++axis)
        lo[axis].fill(kInfinity), hi[axis].fill(-kInfinity);
}

void BallIndex::Boxes::set(std::size_t i, const Bbox& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        lo[axis][i] = rounded_down(box.lo[axis]);
        hi[axis][i] = rounded_up(box.hi[axis]);
    }
}

BallIndex::BallIndex(const SurfelTree& tree, const LeafHessians* hessians)
    : BallIndex(leaves_of(tree, hessians), leaf_nodes(tree)) {}

BallIndex::BallIndex(std::vector<Surfel> leaves) {
    std::vector<std::uint32_t> nodes = numbers_up_to(leaves.size());
    build(leaves, nodes);
}

BallIndex::BallIndex(std::vector<Surfel> leaves, std::vector<std::uint32_t> nodes) {
    build(leaves, nodes);
}

void BallIndex::build(std::vector<Surfel>& leaves, const std::vector<std::uint32_t>& nodes) {
    Bbox box;
    for (const Surfel& s : leaves) box.extend(s.center);
    const MortonCurve curve(box);
    std::vector<std::pair<std::uint64_t, std::size_t>> order;
    for (std::size_t i = 0; i < leaves.size(); ++i)
        order.emplace_back(curve.key(leaves[i].center), i);
    std::sort(order.begin(), order.end());
    leaves_.reserve(order.size());
    std::vector<Bbox> boxes;
    for (const auto& [key, i] : order) {
        leaves_.push_back(std::move(leaves[i]));
        nodes_.push_back(nodes[i]);
        const Surfel& s = leaves_.back();
        balls_.push_back({s.center, s.support_radius * s.support_radius});
        boxes.push_back(box_of(s));
    }
    add_level(boxes);
    while (levels_.back().size() > 1) {
        std::vector<Bbox> above((boxes.size() + kFanout - 1) / kFanout);
        for (std::size_t i = 0; i < boxes.size(); ++i) above[i / kFanout].extend(boxes[i]);
        boxes = std::move(above);
        add_level(boxes);
    }
}

void BallIndex::add_level(const std::vector<Bbox>& boxes) {
    std::vector<Boxes> level((boxes.size() + kFanout - 1) / kFanout);
    for (std::size_t i = 0; i < boxes.size(); ++i) level[i / kFanout].set(i % kFanout, boxes[i]);
    levels_.push_back(std::move(level));
}

/// Bit i: box i meets one whose corners were rounded outwards.
std::uint64_t BallIndex::meeting(const Boxes& boxes, const Vec3f& lo_down, const Vec3f& hi_up) {
    using Lanes = stdx::simd<float, stdx::simd_abi::deduce_t<float, kFanout>>;
    typename Lanes::mask_type meets(true);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Lanes lo(boxes.lo[axis].data(), stdx::element_aligned);
        const Lanes hi(boxes.hi[axis].data(), stdx::element_aligned);
        meets = meets && lo <= Lanes(hi_up[axis]) && hi >= Lanes(lo_down[axis]);
    }
    return lane_bits(meets);
}

/// Calls body(number) for the leaves whose boxes meet a box, in order.
template <class Body>
void BallIndex::for_boxes_meeting(const Bbox& box, const Body& body) const {
    if (leaves_.empty()) return;
    const Vec3f down{rounded_down(box.lo.x), rounded_down(box.lo.y), rounded_down(box.lo.z)};
    const Vec3f up{rounded_up(box.hi.x), rounded_up(box.hi.y), rounded_up(box.hi.z)};
    struct Entry {
        std::size_t level, index;
    };
    Entry stack[256];  // at most 7 wait on each of 22 levels
    std::size_t depth = 0;
    stack[depth++] = {levels_.size() - 1, 0};
    while (depth > 0) {
        const Entry e = stack[--depth];
        std::uint64_t bits = meeting(levels_[e.level][e.index], down, up);
        const std::size_t first = e.index * kFanout;
        if (e.level == 0) {
            for (; bits != 0; bits &= bits - 1)
                body(first + static_cast<std::size_t>(std::countr_zero(bits)));
            continue;
        }
        // The last one first, so that the leaves come in order.
        while (bits != 0) {
            const int last = 63 - std::countl_zero(bits);
            stack[depth++] = {e.level - 1, first + static_cast<std::size_t>(last)};
            bits ^= std::uint64_t{1} << last;
        }
    }
}

[[gnu::flatten]] void BallIndex::supporters(const Vec3d& p, std::vector<const Surfel*>& out) const {
    out.clear();
    for_boxes_meeting({p, p}, [&](std::size_t i) {
        if (sq_length(p - balls_[i].center) < balls_[i].sq_radius) out.push_back(&leaves_[i]);
    });
}

void BallIndex::near(const Bbox& box, std::vector<std::uint32_t>& out) const {
    out.clear();
    for_boxes_meeting(box, [&](std::size_t i) {
        const Vec3d& c = balls_[i].center;
        const Vec3d nearest{std::clamp(c.x, box.lo.x, box.hi.x),
                            std::clamp(c.y, box.lo.y, box.hi.y),
                            std::clamp(c.z, box.lo.z, box.hi.z)};
        if (sq_length(nearest - c) < balls_[i].sq_radius)
            out.push_back(static_cast<std::uint32_t>(i));
    });
}

}  // namespace slim

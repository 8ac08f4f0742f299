#include "raytrace/trace/bvh.h"

#include "slim/base/hash.h"
#include "slim/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace slim {
namespace {

BoxF box_at(const Vec3f& c, float half) {
    const Vec3f e{half, half, half};
    return {c - e, c + e};
}

std::vector<BoxF> random_boxes(std::size_t n) {
    std::vector<BoxF> boxes;
    for (std::size_t i = 0; i < n; ++i) {
        const auto at = [&](std::uint64_t k) {
            return static_cast<float>(unit_interval(keyed_hash(1, i, k)));
        };
        boxes.push_back(box_at({at(0), at(1), at(2)}, 0.01f * at(3)));
    }
    return boxes;
}

bool holds(const BoxF& a, const BoxF& b) {
    return a.lo.x <= b.lo.x && a.lo.y <= b.lo.y && a.lo.z <= b.lo.z && a.hi.x >= b.hi.x &&
           a.hi.y >= b.hi.y && a.hi.z >= b.hi.z;
}

/// Each item in one leaf, boxes within their parents' and around their items, nothing too deep.
void expect_sound(const Bvh& bvh, const std::vector<BoxF>& boxes) {
    std::vector<int> seen(boxes.size(), 0), depth(bvh.nodes.size(), 0);
    for (std::size_t i = 0; i < bvh.nodes.size(); ++i) {
        const BvhNode& node = bvh.nodes[i];
        ASSERT_LE(depth[i], kMostBvhDepth);
        if (node.is_leaf()) {
            ASSERT_LE(node.n_items, kMostLeafItems);
            for (std::uint32_t k = 0; k < node.n_items; ++k) {
                const std::uint32_t item = bvh.order[node.first + k];
                ++seen[item];
                ASSERT_TRUE(holds(node.box, boxes[item]));
            }
            continue;
        }
        ASSERT_GT(node.first, i);
        for (std::uint32_t child : {node.first, node.first + 1}) {
            depth[child] = depth[i] + 1;
            ASSERT_TRUE(holds(node.box, bvh.nodes[child].box));
        }
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(boxes.size()));
}

TEST(Bvh, HoldsEveryItemOnce) {
    for (const std::size_t n :
         {std::size_t{1}, std::size_t{2}, std::size_t{9}, std::size_t{30000}}) {
        SCOPED_TRACE(n);
        const auto boxes = random_boxes(n);
        expect_sound(build_bvh(boxes), boxes);
    }
}

TEST(Bvh, OfNothingHasNoNodes) { EXPECT_TRUE(build_bvh({}).nodes.empty()); }

TEST(Bvh, OfEqualBoxesIsShallow) {
    const std::vector<BoxF> boxes(5000, box_at({1, 2, 3}, 0.5f));
    expect_sound(build_bvh(boxes), boxes);
}

TEST(Bvh, OfBoxesThatShrinkGeometricallyIsNotTooDeep) {
    std::vector<BoxF> boxes;
    float x = 1;
    for (int i = 0; i < 3000; ++i, x = i % 25 == 0 ? 1 : x * 0.3f)
        boxes.push_back(box_at({x, x, x}, 0.1f * x));
    expect_sound(build_bvh(boxes), boxes);
}

TEST(Bvh, IsTheSameForAnyNumberOfThreads) {
    const auto boxes = random_boxes(60000);
    const Bvh one = [&] {
        const ThreadLimit limit(1);
        return build_bvh(boxes);
    }();
    const ThreadLimit limit(7);
    const Bvh seven = build_bvh(boxes);
    EXPECT_EQ(one.order, seven.order);
    ASSERT_EQ(one.nodes.size(), seven.nodes.size());
    for (std::size_t i = 0; i < one.nodes.size(); ++i)
        ASSERT_EQ(one.nodes[i].first, seven.nodes[i].first);
}

TEST(Bvh, RefittedBoxesHoldTheOtherBoxes) {
    auto boxes = random_boxes(500);
    const Bvh bvh = build_bvh(boxes);
    for (BoxF& b : boxes) b.lo = b.lo - Vec3f{1, 0, 0};
    const auto refitted = refitted_boxes(bvh, boxes);
    for (std::size_t i = 0; i < bvh.nodes.size(); ++i)
        for (std::uint32_t k = 0; k < bvh.nodes[i].n_items; ++k)
            ASSERT_TRUE(holds(refitted[i], boxes[bvh.order[bvh.nodes[i].first + k]]));
    EXPECT_LT(refitted[0].lo.x, bvh.nodes[0].box.lo.x - 0.9f);
}

}  // namespace
}  // namespace slim

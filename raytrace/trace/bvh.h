#pragma once

#include "slim/base/vec.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// An axis-aligned box in floats.
struct BoxF {
    Vec3f lo, hi;

    /// lo and hi in a row.
    const float* planes() const { return &lo.x; }
    void extend(const BoxF& b);
    /// Half its surface: what a ray's chance to meet it goes with.
    float half_area() const;
};

static_assert(sizeof(BoxF) == 6 * sizeof(float));

/// A box that holds nothing; the first extend() makes it that of something.
BoxF empty_box();

/// A node of a binary tree of boxes; half a cache line. Children stand side by side; the second
/// one's items lie on the far side along `axis`.
struct BvhNode {
    BoxF box;
    std::uint32_t first = 0;    ///< of two children, or of the items of a leaf
    std::uint16_t n_items = 0;  ///< 0: an inner node
    std::uint16_t axis = 0;

    bool is_leaf() const { return n_items > 0; }
};
static_assert(sizeof(BvhNode) == 32);

struct Bvh {
    std::vector<BvhNode> nodes;        ///< node 0 is the root; none without items
    std::vector<std::uint32_t> order;  ///< items by leaf
};

inline constexpr std::uint32_t kMostLeafItems = 8;
inline constexpr int kMostBvhDepth = 96;

/// A tree over boxes by the surface-area heuristic (MacDonald and Booth 1990) in bins along each
/// axis (Wald 2007). The same for any number of threads.
///
/// cost  O(n log n), in parallel below the first few thousand items; no node has more than
///       kMostLeafItems items or lies deeper than kMostBvhDepth
Bvh build_bvh(std::span<const BoxF> boxes);

/// The boxes of the same nodes over other boxes of the items.
std::vector<BoxF> refitted_boxes(const Bvh& bvh, std::span<const BoxF> boxes);

}  // namespace slim

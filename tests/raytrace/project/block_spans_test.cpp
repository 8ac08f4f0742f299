#include "raytrace/project/block_spans.h"

#include "raytrace/project/outline.h"
#include "tests/raytrace/project/patch_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace slim {
namespace {

using test::add, test::footprint, test::meets_patch, test::random_surfel, test::uniform,
    test::view_of;

/// Blocks of the tile about a surfel that its outline is said to touch;
/// other lanes hold surfels of other sizes.
BlockMask listed_blocks(const PixelView& view, const Surfel& s, std::size_t lane, TileBuffers& t) {
    const Footprint foot = footprint(view, s);
    t.x0 = static_cast<int>(foot.pixel_x) - 16, t.y0 = static_cast<int>(foot.pixel_y) - 16;
    t.clip = {t.x0, t.y0, t.x0 + kTileSize, t.y0 + kTileSize};
    BlockSpans spans;
    std::array<Footprint, kLanes> others;
    for (std::size_t k = 0; k < kLanes; ++k) {
        Surfel other = s;
        other.support_radius *= 0.3 + 0.1 * static_cast<double>(k);
        others[k] = footprint(view, other);
        spans.set(k, k == lane ? foot : others[k]);
    }
    spans.find(t);
    return spans.blocks(lane);
}

TEST(BlockSpans, HoldEveryPixelOfTheSurfaceAndAreTight) {
    int in_list = 0, met = 0;
    auto t = std::make_unique<TileBuffers>();
    for (const bool orthographic : {false, true})
        for (std::uint64_t seed = 0; seed < 80; ++seed) {
            SCOPED_TRACE(testing::Message() << orthographic << ' ' << seed);
            const PixelView view = view_of(orthographic);
            Surfel s = random_surfel(seed, 2, 1);
            for (double& a : s.polynomial.a) a *= 0.1;  // as thin as fits are
            const BlockMask listed = listed_blocks(view, s, seed % kLanes, *t);
            std::array<bool, kTileBlocks> touched{};
            for (int y = 0; y < kTileSize; ++y)
                for (int x = 0; x < kTileSize; ++x) {
                    if (t->x0 + x < 0 || t->y0 + y < 0 || t->x0 + x >= 200 || t->y0 + y >= 200)
                        continue;
                    if (!meets_patch(view, s, t->x0 + x, t->y0 + y)) continue;
                    const std::size_t block = pixel_entry(x, y) / kLanes;
                    touched[block] = true;
                    ASSERT_TRUE(listed.has(static_cast<int>(block))) << x << ' ' << y;
                }
            for (int block = 0; block < kTileBlocks; ++block) in_list += listed.has(block);
            for (const bool b : touched) met += b;
        }
    EXPECT_GT(met, 1000);
    EXPECT_LT(in_list, 1.25 * met);
}

TEST(BlockList, HoldsTheBlocksOfEachSurfelInOrder) {
    BlockList list;
    std::vector<std::pair<int, int>> expected;
    for (int surfel = 0; surfel < BlockList::kMostSurfels; ++surfel) {
        BlockMask mask;
        for (int block = 0; block < kTileBlocks; ++block) {
            // None, all, or some.
            if (surfel == 3 ||
                (surfel != 5 &&
                 keyed_hash(7, static_cast<std::uint64_t>(surfel * kTileBlocks + block)) % 3 != 0))
                continue;
            mask.add(static_cast<std::size_t>(block), 1);
            expected.emplace_back(surfel, block);
        }
        EXPECT_EQ(mask.any(), surfel != 3);
        list.add(surfel, mask);
    }
    ASSERT_EQ(list.size(), static_cast<int>(expected.size()));
    for (int k = 0; k < list.size(); ++k) {
        EXPECT_EQ(list.surfel(k), expected[static_cast<std::size_t>(k)].first);
        EXPECT_EQ(list.block(k), expected[static_cast<std::size_t>(k)].second);
    }
}

TEST(TileBuffers, BoundsOfBlocksAreThoseOfTheirPixels) {
    auto t = std::make_unique<TileBuffers>();
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < kTilePixels; ++i) {
        const double x = uniform(11, i);
        t->z.v[i] = x > 0.9    ? kInfinity
                    : x < -0.9 ? -kInfinity
                               : static_cast<float>(x + 0.01 * static_cast<double>(i / kLanes));
    }
    std::fill_n(t->z.v, kLanes, kInfinity);            // no hit in the first block,
    std::fill_n(t->z.v + kLanes, kLanes, -kInfinity);  // nothing of the window in the second
    const auto block = [&](int k) { return std::span(t->z.v + k * kLanes, kLanes); };
    EXPECT_EQ(t->bound_pixels(), kInfinity);
    for (int k = 0; k < kTileBlocks; ++k)
        EXPECT_EQ(t->block_far[k], *std::max_element(block(k).begin(), block(k).end())) << k;
    for (int k = 0; k < kTileBlocks; ++k)
        EXPECT_EQ(t->beyond(0.2f).has(k), t->block_far[k] > 0.2f) << k;
    ASSERT_TRUE(t->bound_hits());
    EXPECT_FALSE(t->within(-1e9f, 1e9f).has(0));
    EXPECT_FALSE(t->within(-1e9f, 1e9f).has(1));
    for (int k = 2; k < kTileBlocks; ++k) {
        float near = kInfinity, far = -kInfinity;
        for (const float z : block(k))
            if (std::isfinite(z)) near = std::min(near, z), far = std::max(far, z);
        EXPECT_EQ(t->block_near[k], near) << k;
        EXPECT_EQ(t->block_far[k], far) << k;
        EXPECT_EQ(t->within(0.1f, 0.2f).has(k), near <= 0.2f && far >= 0.1f) << k;
    }
}

}  // namespace
}  // namespace slim

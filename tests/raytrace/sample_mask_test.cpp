#include "raytrace/sample_mask.h"

#include "raytrace/picture_edges.h"
#include "raytrace/project/forward_renderer.h"
#include "raytrace/trace/trace_renderer.h"
#include "slim/base/hash.h"
#include "tests/raytrace/support/like_brute.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace slim {
namespace {

/// One pixel of `one_of` is wanted, here and there.
SampleMask random_mask(const PixelWindow& part, std::uint64_t seed, std::uint64_t one_of) {
    SampleMask mask(part);
    for (std::size_t i = 0; i < mask.wanted().size(); ++i)
        mask.wanted()[i] = keyed_hash(seed, i) % one_of == 0;
    return mask;
}

TEST(SampleMask, BoundsAreThoseOfItsPixels) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        SCOPED_TRACE(seed);
        const SampleMask mask = random_mask({5, 7, 23, 19}, seed, 90);
        const PixelWindow window{static_cast<int>(seed % 9), 3, 17, 31};
        int x0 = 99, x1 = -1, y0 = 99, y1 = -1;
        for (int y = 0; y < 60; ++y)
            for (int x = 0; x < 60; ++x) {
                const bool in = x >= window.x && x < window.x + window.width && y >= window.y &&
                                y < window.y + window.height;
                if (!in || !mask.has_pixel(x, y)) continue;
                x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = y;
            }
        const PixelWindow found = mask.bounds_in(window);
        ASSERT_EQ(found.width, x1 < 0 ? 0 : x1 - x0 + 1);
        ASSERT_EQ(mask.any_sample(samples_of(window)), x1 >= 0);
        if (x1 < 0) continue;
        EXPECT_EQ(found.x, x0);
        EXPECT_EQ(found.y, y0);
        EXPECT_EQ(found.height, y1 - y0 + 1);
    }
}

TEST(SampleMask, GrowsByOnePixelAllRound) {
    const SampleMask mask = random_mask({3, 4, 30, 20}, 1, 40), grown = mask.grown();
    for (int y = 4; y < 24; ++y)
        for (int x = 3; x < 33; ++x) {
            bool near = false;
            for (int v = y - 1; v <= y + 1; ++v)
                for (int u = x - 1; u <= x + 1; ++u) near |= mask.has_pixel(u, v);
            ASSERT_EQ(grown.has_pixel(x, y), near) << x << " " << y;
        }
}

/// Every plane holds the whole's number at a sample that is wanted, and 0 elsewhere.
void expect_samples_of(const GBuffer& whole, GBuffer some, const SampleMask& mask) {
    ASSERT_EQ(some.n_pixels(), whole.n_pixels());
    GBuffer expected = whole;
    const auto blank = [&](auto& plane) {
        for (int y = 0; y < whole.height && !plane.empty(); ++y)
            for (int x = 0; x < whole.width; ++x)
                if (!mask.has_sample(x, y)) plane[whole.index(x, y)] = 0;
    };
    blank(expected.hit);
    expected.for_each_plane(blank);
    EXPECT_EQ(some.hit, expected.hit);
    std::vector<double> found, wanted;
    some.for_each_plane([&](auto& p) { found.insert(found.end(), p.begin(), p.end()); });
    expected.for_each_plane([&](auto& p) { wanted.insert(wanted.end(), p.begin(), p.end()); });
    EXPECT_EQ(found, wanted);
    EXPECT_GT(std::count(some.hit.begin(), some.hit.end(), 1), 100);
    EXPECT_GT(std::count(whole.hit.begin(), whole.hit.end(), 1),
              2 * std::count(some.hit.begin(), some.hit.end(), 1));
}

class SamplesTest : public testing::TestWithParam<int> {};

TEST_P(SamplesTest, AreThoseOfTheWholePicture) {
    for (const bool sharp : {false, true}) {
        const auto model = sharp ? test::sharp_model(GetParam(), 7)
                                 : test::rough_model(GetParam(), 7);
        const SurfelTree tree = model.view();
        const ScenePart part{&tree, {}};
        const TraceScene scene(std::span(&part, 1), false);
        for (const std::uint64_t one_of : {3u, 50u}) {
            const SampleMask mask = random_mask({0, 0, 105, 105}, one_of, one_of);
            RenderRequest request = test::request_for(model, "right", false, 210);
            request.width = request.height = 210;
            request.wanted = kAllChannels;
            GBuffer whole, some;
            render_forward(tree, request, whole);
            render_forward(tree, request, some, &mask);
            expect_samples_of(whole, some, mask);
            render_traced(scene, request, whole);
            render_traced(scene, request, some, nullptr, &mask);
            expect_samples_of(whole, some, mask);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Degrees, SamplesTest, testing::Values(1, 2, 3));

TEST(PictureEdges, AreMarkedOnBothSides) {
    Picture p(9, 70);  // more rows than a thread takes at a time
    for (int y = 33; y < 70; ++y) {
        float* row = p.pixel(0, y);
        std::fill_n(row, 4 * 9, 1.0f);
    }
    const auto marks = edge_pixels(p, 0.5f);
    for (int y = 0; y < 70; ++y)
        for (int x = 0; x < 9; ++x) EXPECT_EQ(marks[p.index(x, y)], y == 32 || y == 33) << y;
}

TEST(PictureEdges, OfOnePixelAreAllAboutIt) {
    Picture p(11, 40);
    p.pixel(4, 31)[2] = 0.25f;  // its root is 0.5
    const auto marks = edge_pixels(p, 0.49f);
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 11; ++x)
            EXPECT_EQ(marks[p.index(x, y)], std::abs(x - 4) <= 1 && std::abs(y - 31) <= 1);
    const auto none = edge_pixels(p, 0.51f);
    EXPECT_EQ(std::count(none.begin(), none.end(), 1), 0);
}

TEST(PictureEdges, AlphaAloneIsOne) {
    Picture p(6, 3);
    for (int y = 0; y < 3; ++y) p.pixel(0, y)[3] = 1;
    const auto marks = edge_pixels(p);
    for (int x = 0; x < 6; ++x) EXPECT_EQ(marks[p.index(x, 1)], x < 2);
}

/// One picture of strips with and without hits, wider than a thread takes at a time.
TEST(PictureEdges, AreTheSameWhereWhatIsEmptyIsKnown) {
    Picture p(213, 75);
    std::vector<std::uint8_t> covered(p.n_pixels());
    for (int y = 0; y < p.height; ++y)
        for (int x = 0; x < p.width; ++x) {
            if ((x / 50 + y / 20) % 3 != 0) continue;
            covered[p.index(x, y)] = 1;
            for (int c = 0; c < 4; ++c)
                p.pixel(x, y)[c] = static_cast<float>((7 * x + 3 * y * y + 5 * c) % 31) / 31;
        }
    const auto marks = edge_pixels(p, 0.4f), known = edge_pixels(p, 0.4f, covered);
    EXPECT_EQ(marks, known);
    for (int y = 0; y < p.height; ++y)
        for (int x = 0; x < p.width; ++x) {
            float most = 0;
            for (int v = std::max(0, y - 1); v <= std::min(p.height - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(p.width - 1, x + 1); ++u)
                    for (int c = 0; c < 4; ++c)
                        most = std::max(most, std::abs(std::sqrt(p.pixel(u, v)[c]) -
                                                       std::sqrt(p.pixel(x, y)[c])));
            if (std::abs(most - 0.4f) > 1e-4f) {
                EXPECT_EQ(marks[p.index(x, y)], most > 0.4f) << x << ' ' << y;
            }
        }
}

}  // namespace
}  // namespace slim

#include "slim/model/surfel_encoder.h"

#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace slim::test {
namespace {

std::shared_ptr<const SharpSheets> random_sheets(std::uint64_t seed, int degree) {
    auto sheets = std::make_shared<SharpSheets>();
    sheets->n_extra = 1 + seed % 2;
    sheets->outer = seed % 3 == 0 ? Join::min : Join::max;
    for (std::size_t k = 0; k < sheets->n_extra; ++k) {
        Sheet& s = sheets->extra[k];
        s.frame = frame_from_normal(round_normal(random_direction(20 + k, seed)));
        for (std::size_t c = 0; c < static_cast<std::size_t>(n_coefficients(degree)); ++c)
            s.polynomial.a[c] = random_at(30 + k, 10 * seed + c);
    }
    return sheets;
}

/// Degrees 0 to `degree` (all the same unless `mixed`); every 7th sharp.
std::vector<Surfel> random_surfels(std::size_t n, int degree, bool mixed) {
    std::vector<Surfel> surfels;
    for (std::uint64_t i = 0; i < n; ++i) {
        const int own =
            mixed ? static_cast<int>(i % static_cast<std::uint64_t>(degree + 1)) : degree;
        Surfel s{random_in_cube(9, i),
                 0.01,
                 frame_from_normal(round_normal(random_direction(10, i))),
                 {},
                 own};
        for (std::size_t c = 0; c < static_cast<std::size_t>(n_coefficients(own)); ++c)
            s.polynomial.a[c] = random_at(11, 10 * i + c);
        if (i % 7 == 3) s.sharp = random_sheets(i, own);
        surfels.push_back(s);
    }
    return surfels;
}

TEST(SurfelEncoder, AnyOrderGivesTheSameArrays) {
    for (const bool mixed : {false, true}) {
        SCOPED_TRACE(mixed);
        const std::vector<Surfel> surfels = random_surfels(2500, 3, mixed);
        SurfelTreeData in_order, shuffled;
        in_order.header.degree = shuffled.header.degree = 3;
        encode_surfels(surfels, in_order);
        EXPECT_EQ(in_order.in_page.empty(), !mixed);
        SurfelEncoder encoder(
            surfels.size(), [&](std::size_t i) { return shape_of(surfels[i]); }, shuffled);
        for (std::size_t i = 0; i < surfels.size(); ++i) {
            const std::size_t node = i * 1499 % surfels.size();  // every node once: 1499 is prime
            encoder.put(node, surfels[node]);
        }
        EXPECT_EQ(in_order.records, shuffled.records);
        EXPECT_EQ(in_order.sheets, shuffled.sheets);
        EXPECT_EQ(in_order.page_start, shuffled.page_start);
        EXPECT_EQ(in_order.in_page, shuffled.in_page);
    }
}

TEST(SurfelEncoder, EverySharpNodeFindsItsOwnSheets) {
    std::vector<Surfel> surfels = random_surfels(2500, 2, false);
    SurfelTreeData data;
    data.header.degree = 2;
    encode_surfels(surfels, data);
    for (const Surfel& s : surfels) {
        TreeNode& node = data.nodes.emplace_back();
        node.degree = 2;
        node.flags = s.sharp ? kSharp : 0;
    }
    for (std::size_t i = 3; i < surfels.size(); i += 7) {
        const Surfel back = data.view().surfel(i);
        ASSERT_EQ(back.n_sheets(), surfels[i].n_sheets());
        ASSERT_EQ(back.sharp->outer, surfels[i].sharp->outer);
        for (std::size_t k = 0; k < back.sharp->n_extra; ++k) {
            ASSERT_EQ(back.sharp->extra[k].frame.normal, surfels[i].sharp->extra[k].frame.normal);
            for (std::size_t c = 0; c < 6; ++c)
                ASSERT_EQ(back.sharp->extra[k].polynomial.a[c],
                          static_cast<float>(surfels[i].sharp->extra[k].polynomial.a[c]));
        }
    }
}

}  // namespace
}  // namespace slim::test

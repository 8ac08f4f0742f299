#include "slim/smooth/pooled_bias.h"

#include "slim/base/parallel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kRung = 20;
constexpr double kDiagonal = 10;

/// 15 by 15 leaves, a third of the rung's radius apart, each with one rung.
class PooledBias : public testing::Test {
protected:
    PooledBias() {
        const double radius = rung_radius(kRung, kDiagonal);
        std::vector<Surfel> leaves;
        for (int i = 0; i < 15; ++i)
            for (int j = 0; j < 15; ++j)
                leaves.push_back({{i * radius / 3, j * radius / 3, 0},
                                  radius / 2,
                                  frame_from_normal(Vec3d{0, 0, 1}),
                                  {},
                                  2});
        model_.emplace(leaves);
        ladders_.resize(leaves.size());
        asked_.assign(leaves.size(), 1);
        for (BiasLadder& l : ladders_) l.widest = l.narrowest = kRung;
    }
    /// lift(i, j) of each leaf's place in the grid.
    template <class Lift>
    void lift(const Lift& lift, double error) {
        for (std::size_t n = 0; n < ladders_.size(); ++n) {
            const std::uint32_t node = model_->node(n);
            ladders_[n].lift[kRung] = static_cast<float>(lift(node / 15, node % 15));
            ladders_[n].sq_lift_error[kRung] = static_cast<float>(error * error);
            ladders_[n].sq_bias[kRung] = 1;
        }
    }
    double middle() const {
        const auto found = unshared_bias(*model_, ladders_, kDiagonal,
                                         [this](auto i, auto) { return asked_[i] != 0; });
        for (std::size_t n = 0; n < found.size(); ++n)
            if (model_->node(n) == 7 * 15 + 7) return std::sqrt(found[n][kRung]);
        return NAN;
    }
    std::optional<BallIndex> model_;
    std::vector<BiasLadder> ladders_;
    std::vector<std::uint8_t> asked_;
};

TEST_F(PooledBias, WhatAllHaveIsShared) {
    lift([](auto, auto) { return 0.3; }, 0);
    EXPECT_LT(middle(), 1e-3);
}

TEST_F(PooledBias, WhatChangesFromLeafToLeafIsNot) {
    lift([](auto i, auto j) { return (i + j) % 2 != 0 ? 0.4 : 0.2; }, 0);
    EXPECT_NEAR(middle(), 0.1, 0.01);
}

TEST_F(PooledBias, NoiseIsNoBias) {
    lift([](auto i, auto j) { return (i + j) % 2 != 0 ? 0.4 : 0.2; }, 0.1);
    EXPECT_LT(middle(), 0.03);
}

TEST_F(PooledBias, IsAtMostTheWholeAndTheSameForAnyNumberOfThreads) {
    lift([](auto i, auto j) { return (i + j) % 2 != 0 ? 40.0 : 20.0; }, 0);
    EXPECT_EQ(middle(), 1);
    lift([](auto i, auto j) { return 0.1 * i - 0.01 * j * j; }, 0.01);
    const auto many = unshared_bias(*model_, ladders_, kDiagonal,
                                    [this](auto i, auto) { return asked_[i] != 0; });
    const ThreadLimit one(1);
    EXPECT_EQ(many, unshared_bias(*model_, ladders_, kDiagonal,
                                  [this](auto i, auto) { return asked_[i] != 0; }));
}

TEST_F(PooledBias, ALeafThatIsNotAskedForHasAllOfItsBias) {
    lift([](auto i, auto j) { return (i + j) % 2 != 0 ? 0.4 : 0.2; }, 0);
    for (std::size_t n = 0; n < asked_.size(); ++n)
        if (model_->node(n) == 7 * 15 + 7) asked_[n] = 0;
    EXPECT_EQ(middle(), 1);  // all of the pooled bias
}

TEST_F(PooledBias, ALeafWithoutARungSaysNothingOfIt) {
    lift([](auto, auto) { return 0.3; }, 0);
    for (std::size_t n = 0; n < ladders_.size(); ++n)
        if (model_->node(n) == 7 * 15 + 8)
            ladders_[n].lift[kRung] = 50, ladders_[n].widest = kRungs;
    EXPECT_LT(middle(), 1e-3);
}

}  // namespace
}  // namespace slim

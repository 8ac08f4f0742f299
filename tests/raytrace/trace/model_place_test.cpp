#include "raytrace/trace/model_place.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

// Which models have a frame of their own, where it lies, and packets in it.

namespace slim {
namespace {

const SceneFrame kScene{{10, -20, 30}, 500};

/// A cube of so much of the scene's half diagonal, in its own.
Bbox cube(const Vec3d& center, double share) {
    const double half = share * kScene.unit / std::sqrt(3.0);
    Bbox box;
    box.extend(center - Vec3d{half, half, half}), box.extend(center + Vec3d{half, half, half});
    return box;
}

TEST(ModelPlace, OnlyModelsBelowASixteenthHaveAFrameOfTheirOwn) {
    EXPECT_TRUE(ModelPlace::of(cube(kScene.middle, 1), kScene).is_scene);
    EXPECT_TRUE(ModelPlace::of(cube({100, 0, 0}, 1.001 / 16), kScene).is_scene);
    const ModelPlace own = ModelPlace::of(cube({100, 0, 0}, 0.999 / 16), kScene);
    EXPECT_FALSE(own.is_scene);
    EXPECT_EQ(own.unit, 1.0f / 16);
}

TEST(ModelPlace, AModelWithoutSurfelsIsInTheScenesFrame) {
    const ModelPlace place = ModelPlace::of(Bbox{}, kScene);
    EXPECT_EQ(place.frame(kScene).unit, kScene.unit);
    EXPECT_EQ(place.frame(kScene).middle, kScene.middle);
}

// A single point: the smallest frame that two floats of the scene tell.
TEST(ModelPlace, AModelWithoutSizeHasAFiniteFrame) {
    const ModelPlace place = ModelPlace::of(cube({100, 0, 0}, 0), kScene);
    EXPECT_FALSE(place.is_scene);
    EXPECT_EQ(place.unit, std::exp2(-48.0f));
}

TEST(ModelPlace, TheFrameIsAPowerOfTwoAroundTheModel) {
    const Vec3d center{123.456, -78.9, 12.3};
    for (const double share : {0.06, 1e-3, 1e-6}) {
        const ModelPlace place = ModelPlace::of(cube(center, share), kScene);
        int exponent = 0;
        EXPECT_EQ(std::frexp(place.unit, &exponent), 0.5f);
        EXPECT_GE(static_cast<double>(place.unit), share * (1 - 1e-12));
        EXPECT_LT(static_cast<double>(place.unit), 2 * share);
        EXPECT_LT(length(place.frame(kScene).middle - center), kScene.unit * std::exp2(-48));
    }
}

// Along x at the model's middle: in at -sqrt(1.1), which is so far from the origin.
TEST(ModelPlace, PacketsBeginAtTheModelsSphere) {
    const ModelPlace place = ModelPlace::of(cube(kScene.middle + Vec3d{250, 0, 0}, 1e-3), kScene);
    RayPacket rays;
    rays.origin = LanesOfVec(Vec3f{-2, 0, 0}), rays.direction = LanesOfVec(Vec3f{1, 0, 0}),
    rays.far = kFar;
    rays.origin.y[0] = 0.01f;  // by the sphere
    const PlacedRays placed(place, rays);
    EXPECT_LT(static_cast<float>(placed.rays.far[0]), 0.0f);
    for (std::size_t k = 1; k < FloatV::size(); ++k) {
        EXPECT_NEAR(static_cast<float>(placed.rays.origin.x[k]), -std::sqrt(1.1f), 1e-6f);
        const double start = static_cast<double>(static_cast<float>(placed.start.high[k])) +
                             static_cast<double>(static_cast<float>(placed.start.low[k]));
        const double origin = static_cast<double>(static_cast<float>(placed.rays.origin.x[k])) +
                              static_cast<double>(static_cast<float>(placed.rays.origin_low.x[k]));
        // The way to the sphere and back to the middle: 2.5 of the scene.
        EXPECT_NEAR((start - origin) * static_cast<double>(place.unit), 2.5, 1e-12);
    }
}

}  // namespace
}  // namespace slim

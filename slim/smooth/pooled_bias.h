#pragma once

#include "slim/smooth/bias_ladder.h"
#include "slim/tree/ball_index.h"

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace slim {

/// The mean over a leaf, which counts twice, and those that hold its centre, of each rung's squared
/// bias; three times (notes/0003, 0004). In parallel, the same for any thread count.
/// ladders  of each leaf of the model
void pool_bias(const BallIndex& model, std::span<BiasLadder> ladders);

/// For each leaf the squared bias on its rungs that the leaves within three radii do not share, and
/// which is left once the mean is taken off (notes/0009): at most what pool_bias() has left in the
/// ladders, and that where it is not asked for. Length^2. In parallel, the same for any thread
/// count. Cost: at most 256 leaves a rung that is asked for, and the boxes of all that are so near.
std::vector<std::array<float, kRungs>> unshared_bias(
    const BallIndex& model, std::span<const BiasLadder> ladders, double diagonal,
    const std::function<bool(std::size_t leaf, std::size_t rung)>& is_asked);

}  // namespace slim

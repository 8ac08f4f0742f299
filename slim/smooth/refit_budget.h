#pragma once

#include <cstddef>
#include <cstdint>

namespace slim {

/// What a cloud may be fitted anew with.
struct RefitBudget {
    std::size_t points = 0;  ///< most of the cloud that are held; of a larger one a random share
    std::size_t leaves = 0;  ///< most of the model; one of more is taken as it is
    std::size_t fits = 0;    ///< most made anew; leaves that take more than the others are kept
    std::size_t batch = 0;   ///< of points that are smoothed together once those held are dropped
};

/// The most of a cloud's points that are held, however much memory there is.
inline constexpr std::size_t kMostSmoothPoints = std::size_t{1} << 22;

/// The least memory that smoothing a cloud is planned with.
inline constexpr std::uint64_t kLeastSmoothMemory = std::uint64_t{64} << 20;

/// Divides `memory` bytes, of which the program, its buffers and the index of the model's leaves
/// (600 bytes each) take theirs first: half of the rest for points (kMostSmoothPoints), down to a
/// quarter where then all leaves fit in, the other half for leaves while radii are sought, then for
/// fits (notes/0012). Of what the points leave, two batches of 2^16 to 2^20 points: the more lie
/// together the fewer surfels are asked of each (notes/0007).
RefitBudget refit_budget(std::uint64_t memory, std::size_t n_leaves);

}  // namespace slim

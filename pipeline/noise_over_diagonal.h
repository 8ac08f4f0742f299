#pragma once

#include <cmath>

namespace slim {

/// The standard deviation that lambda stands for, below which no fit tells detail from noise, over
/// the diagonal L: what all verbs call noise. 0 without a diagonal.
inline double noise_over_diagonal(double noise_variance, double diagonal) {
    return diagonal > 0 ? std::sqrt(noise_variance) / diagonal : 0;
}

/// Whether edges and bends, not noise, make up lambda: the geometric mean over places, which a few
/// of them do not change, is a tenth of it in standard deviation, or less.
inline bool is_mostly_edges(double noise_variance, double typical_variance) {
    return typical_variance <= 0.01 * noise_variance;
}

}  // namespace slim

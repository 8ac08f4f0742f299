#pragma once

#include <cmath>

namespace slim {

/// The standard deviation that lambda stands for, below which no fit tells detail from noise, over
/// the diagonal L: what all verbs call noise. 0 without a diagonal.
inline double noise_over_diagonal(double noise_variance, double diagonal) {
    return diagonal > 0 ? std::sqrt(noise_variance) / diagonal : 0;
}

}  // namespace slim

#pragma once

#include "slim/model/surfel.h"
#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <cmath>

namespace slim {

/// What the overlap of eq. (2) sums at a point (NUMERICS 3.4, notes/0004): the weight G with
/// support alpha rho, as the paper's words say; G with support rho;
/// or the quadratic B-spline reaching rho.
enum class CoverReading : unsigned char { a, b, c };

/// A leaf's share in the overlap at a squared relative distance (r / rho)^2. A lone leaf covers up
/// to 0.357, 0.536 and 0.70 of its radius.
inline float overlap_weight(CoverReading reading, float sq) {
    if (reading == CoverReading::a)
        return weight_kernel(sq / static_cast<float>(kTrim * kTrim));
    if (reading == CoverReading::b) return weight_kernel(sq);
    const float t = 1.5f * std::sqrt(sq), rest = 1.5f - t;
    return t <= 0.5f ? 0.75f - t * t : rest > 0 ? 0.5f * rest * rest : 0.0f;
}

/// How often a leaf counts in the overlap of a noisy cloud whose radius a fold or the want of
/// points limits, not E: G is 0.027 at the edge of its core, which it so covers as a whole. Its
/// like stand side by side in any number, each poor where it ends, and more of them do not better
/// that (notes/0010).
inline constexpr float kLimitedTimes = 4;

/// How often such a leaf counts where leaves are fitted a second time: six times the price of its
/// radius in E over eps^2, from once to fourfold. One that is far better than T asks for, but for
/// what ended its ladder, need not be helped by so many others (notes/0014).
inline float limited_times(double price, double sq_error) {
    constexpr double kTimesOfPrice = 6;
    if (!(kTimesOfPrice * price > sq_error)) return 1;
    return static_cast<float>(
        std::min(kTimesOfPrice * price / sq_error, static_cast<double>(kLimitedTimes)));
}

/// Least overlap of a covered point where leaves are fitted a second time: they err less where they
/// end (notes/0010).
inline constexpr float kRefittedCoverage = 0.085f;

}  // namespace slim

#pragma once

#include "slim/fit/slope_moments.h"

#include <array>
#include <cstddef>

namespace slim {

/// The normal equations of points and normals together:
/// sum G (w - P)^2 + ratio sum G |s - grad P|^2.
template <int Degree>
class SlopeSystem {
public:
    static constexpr std::size_t kBasis = Moments<Degree>::kBasis;

    SlopeSystem(const Moments<Degree>& points, const SlopeMoments<Degree>& slopes)
        : points_(points), sq_slope_(slopes.sq_slope) {
        for (std::size_t i = 1; i < kBasis; ++i) {
            const Term p = term(i);
            if (p.u > 0) right_[i] += p.u * slopes.along_u[place(p.u - 1, p.v)];
            if (p.v > 0) right_[i] += p.v * slopes.along_v[place(p.u, p.v - 1)];
            for (std::size_t j = 1; j <= i; ++j) {
                const Term q = term(j);
                double sum = 0;
                if (p.u > 0 && q.u > 0)
                    sum += p.u * q.u * points.monomial[place(p.u + q.u - 2, p.v + q.v)];
                if (p.v > 0 && q.v > 0)
                    sum += p.v * q.v * points.monomial[place(p.u + q.u, p.v + q.v - 2)];
                left_[i * kBasis + j] = sum;
            }
        }
    }

    NestedCholesky solve(double ratio) const {
        std::array<double, kBasis * kBasis> matrix;
        std::array<double, kBasis> right;
        for (std::size_t i = 0; i < kBasis; ++i) {
            right[i] = points_.height[i] + ratio * right_[i];
            for (std::size_t j = 0; j <= i; ++j)
                matrix[i * kBasis + j] =
                    points_.monomial[product_index(i, j)] + ratio * left_[i * kBasis + j];
        }
        return NestedCholesky(Degree, NestedCholesky::Matrix{matrix, kBasis}, right,
                              points_.sq_height + ratio * sq_slope_);
    }

    /// sum G (w - P)^2 and sum G |s - grad P|^2 of given coefficients.
    template <class Coefficients>
    double sq_heights_off(const Coefficients& a) const {
        double sum = points_.sq_height;
        for (std::size_t i = 0; i < a.size() && i < kBasis; ++i) {
            double row = 0;
            for (std::size_t j = 0; j < a.size() && j < kBasis; ++j)
                row += points_.monomial[product_index(i, j)] * a[j];
            sum += a[i] * (row - 2 * points_.height[i]);
        }
        return std::max(sum, 0.0);
    }
    template <class Coefficients>
    double sq_slopes_off(const Coefficients& a) const {
        double sum = sq_slope_;
        for (std::size_t i = 0; i < a.size() && i < kBasis; ++i) {
            double row = left_[i * kBasis + i] * a[i];
            for (std::size_t j = 0; j < i; ++j) row += 2 * left_[i * kBasis + j] * a[j];
            sum += a[i] * (row - 2 * right_[i]);
        }
        return std::max(sum, 0.0);
    }

private:
    struct Term {
        int u, v;  // exponents
    };
    static constexpr Term term(std::size_t k) {
        int d = 0, first = 0;
        while (first + d + 1 <= static_cast<int>(k)) first += ++d;
        const int v = static_cast<int>(k) - first;
        return {d - v, v};
    }
    static constexpr std::size_t place(int u, int v) {
        const int d = u + v;
        return static_cast<std::size_t>(d * (d + 1) / 2 + v);
    }

    const Moments<Degree>& points_;
    double sq_slope_;
    std::array<double, kBasis> right_{};
    std::array<double, kBasis * kBasis> left_{};
};

}  // namespace slim

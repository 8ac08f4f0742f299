#pragma once

#include "slim/base/lane_sums.h"
#include "slim/base/simd.h"

#include <array>
#include <cstddef>
#include <type_traits>

namespace slim {

/// A product that is rounded before it is added to anything: compilers may else take one and the
/// sum for an fma, and do so by chance.
template <class V>
[[gnu::always_inline]] inline V rounded(V product) {
#ifdef __AVX512VL__
    if constexpr (std::is_same_v<V, FloatV>) {
        auto lanes = static_cast<__m512>(product);
        asm("" : "+v"(lanes));
        return V(lanes);
    } else if constexpr (std::is_same_v<V, stdx::native_simd<double>>) {
        auto lanes = static_cast<__m512d>(product);
        asm("" : "+v"(lanes));
        return V(lanes);
    }
#endif
    return product;
}

/// Weights and local coordinates of some groups of points, and sums of moments over them. A pass
/// sums a few columns of the monomials G u^a v^b, of equal b, as many as the registers hold; column
/// b starts from G v^b and goes on by u.
template <int Degree, class V>
class LaneMoments {
public:
    static constexpr int kGroups = 16;  ///< whose sums lanes of floats hold well

    bool is_full() const { return n_ == kGroups; }
    void add(const V& g, const V& u, const V& v, const V& w) {
        const auto i = static_cast<std::size_t>(n_++);
        g_[i] = g, u_[i] = u, v_[i] = v, w_[i] = w;
    }
    /// Adds the sums over the groups to Sums (Moments<Degree>) and empties this.
    template <class Sums>
    void flush(Sums& out) {
        if constexpr (Degree <= 2) {
            sum_columns<0, 2 * Degree>(out);
        } else if constexpr (Degree == 3) {
            sum_columns<0, 1>(out), sum_columns<2, 6>(out);
        } else {
            static_assert(Degree == 4);
            sum_columns<0, 0>(out), sum_columns<1, 2>(out), sum_columns<3, 8>(out);
        }
        n_ = 0;
    }

private:
    static constexpr std::size_t kTop = 2 * Degree, kTopOfHeights = Degree;

    /// Place of u^a v^b in the order of the basis.
    static constexpr std::size_t place(std::size_t a, std::size_t b) {
        return (a + b) * (a + b + 1) / 2 + b;
    }
    /// Entries of columns before b, of those that begin at `first` and end with total degree `top`.
    static constexpr std::size_t before(std::size_t first, std::size_t b, std::size_t top) {
        std::size_t n = 0;
        for (std::size_t c = first; c < b && c <= top; ++c) n += top - c + 1;
        return n;
    }

    template <std::size_t First, std::size_t Last, class Sums>
    [[gnu::always_inline]] void sum_columns(Sums& out) {
        constexpr std::size_t kMonomials = before(First, Last + 1, kTop);
        constexpr std::size_t kHeights = before(First, Last + 1, kTopOfHeights);
        constexpr std::size_t kSquares = First == 0 ? 2 : 0;
        constexpr std::size_t kAll = kMonomials + kHeights + kSquares;
        std::array<V, (kAll + 7) / 8 * 8> sums{};
        for (std::size_t i = 0; i < static_cast<std::size_t>(n_); ++i) {
            const V u = u_[i], v = v_[i], w = w_[i];
            V head = g_[i];  // G v^b
            if constexpr (First == 0) {
                sums[kAll - 2] += head * w * w;
                sums[kAll - 1] += head * head;
            }
            for_constants<Last + 1>([&](auto column) __attribute__((always_inline)) {
                constexpr std::size_t b = decltype(column)::value;
                if constexpr (b > 0) head = head * v;
                if constexpr (b >= First) {
                    V m = head;
                    for_constants<kTop - b + 1>([&](auto power) __attribute__((always_inline)) {
                        constexpr std::size_t a = decltype(power)::value;
                        if constexpr (a > 0) m = m * u;
                        if constexpr (Degree > 2 && a + b == kTop) m = rounded(m);
                        sums[before(First, b, kTop) + a] += m;
                        if constexpr (a + b <= kTopOfHeights)
                            sums[kMonomials + before(First, b, kTopOfHeights) + a] += m * w;
                    });
                }
            });
        }
        const auto sum = lane_sums(sums);
        for_constants<Last - First + 1>([&](auto column) __attribute__((always_inline)) {
            constexpr std::size_t b = First + decltype(column)::value;
            for (std::size_t a = 0; a + b <= kTop; ++a)
                out.monomial[place(a, b)] += sum[before(First, b, kTop) + a];
            for (std::size_t a = 0; a + b <= kTopOfHeights; ++a)
                out.height[place(a, b)] += sum[kMonomials + before(First, b, kTopOfHeights) + a];
        });
        if constexpr (First == 0) out.sq_height += sum[kAll - 2], out.sq_weight += sum[kAll - 1];
    }

    int n_ = 0;
    std::array<V, kGroups> g_, u_, v_, w_;
};

}  // namespace slim

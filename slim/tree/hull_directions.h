#pragma once

#include "slim/base/simd.h"
#include "slim/base/vec.h"

#include <cstddef>
#include <cstdint>

namespace slim {

/// Directions to places of a grid of 9 x 9 on each face of a cube.
inline constexpr std::size_t kHullDirections = 9 * 9 * 9 - 7 * 7 * 7;

/// Some of the directions, and how far places found in each reach.
class HullDirections {
public:
    using Lanes = stdx::native_simd<double>;
    struct LanesOf3 {
        Lanes x, y, z;
    };

    /// None.
    HullDirections() {}
    /// All of them, with nothing found.
    static HullDirections all();

    std::size_t size() const { return n_; }
    /// Which of all directions entry k is.
    std::uint32_t id(std::size_t k) const { return id_[k]; }
    Vec3d at(std::size_t k) const { return {x_[k], y_[k], z_[k]}; }
    double reach(std::size_t k) const { return reach_[k]; }
    void set_reach(std::size_t k, double reach) { reach_[k] = reach; }

    /// Becomes those of `from` in which something may reach as far as what is found, or farther:
    /// most_of(lanes of directions) is no less than how far it reaches.
    template <class MostOf>
    void keep(const HullDirections& from, const MostOf& most_of) {
        n_ = 0;
        for (std::size_t k = 0; k < from.n_; k += Lanes::size()) {
            const auto load = [&](const double* v) { return Lanes(v + k, stdx::vector_aligned); };
            const LanesOf3 d{load(from.x_), load(from.y_), load(from.z_)};
            const Lanes reach = load(from.reach_);
            std::uint64_t bits = lane_bits(most_of(d) >= reach);
            if (k + Lanes::size() > from.n_) bits &= (std::uint64_t{1} << (from.n_ - k)) - 1;
            if (bits == 0) continue;
            compress_to<double>(d.x, bits, x_ + n_), compress_to<double>(d.y, bits, y_ + n_);
            compress_to<double>(d.z, bits, z_ + n_), compress_to<double>(reach, bits, reach_ + n_);
            compress_to<std::uint32_t>(
                LanesOfDouble<std::uint32_t>(from.id_ + k, stdx::element_aligned), bits, id_ + n_);
            n_ += static_cast<std::size_t>(std::popcount(bits));
        }
    }

private:
    static constexpr std::size_t kRoom = kHullDirections + 2 * Lanes::size();
    std::size_t n_ = 0;
    alignas(64) double x_[kRoom], y_[kRoom], z_[kRoom], reach_[kRoom];
    alignas(64) std::uint32_t id_[kRoom];
};

}  // namespace slim

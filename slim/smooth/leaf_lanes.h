#pragma once

#include "slim/base/bbox.h"
#include "slim/base/frame.h"
#include "slim/base/simd.h"
#include "slim/base/vec.h"
#include "slim/tree/ball_index.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace slim {

/// Where a line meets the blend of surfels: of a Projection what smoothing asks.
struct LanePut {
    Vec3d point, normal;  ///< the latter unit, outwards
};

/// The surfels about a few points that lie together, side by side: one instruction serves as many
/// as it has lanes of double (notes/0007). Quadratics without edges alone; others are asked one by
/// one (PointProjector). One a thread.
class LeafLanes {
public:
    /// Takes the surfels of an index whose balls meet the box.
    void gather(const BallIndex& index, const Bbox& box);
    /// Their numbers in the index, in its order.
    std::span<const std::uint32_t> numbers() const { return numbers_; }
    /// Whether all of them are such as this works on.
    bool are_plain() const { return plain_; }

    /// slim::project_along(p, n, supporters) and slim::normal_at(p, supporters) for a point of the
    /// box and those that hold it, but for the last bits: sums are in another order. Nothing also
    /// where the point lies beyond the rims of all of them; no normal where one of them faces away
    /// from it, as on both sides of a thin plate (sheet_normals_at).
    std::optional<LanePut> project_along(const Vec3d& p, const Vec3d& n);
    std::optional<Vec3d> normal_at(const Vec3d& p);

    /// Calls body(number, weight) for the surfels that hold the point that project_along() was
    /// asked last, in order; weight: G at |p - c| / rho.
    template <class Body>
    void for_supporters(const Body& body) const {
        for (std::size_t g = 0; g < groups_.size(); ++g)
            for (std::uint64_t bits = holds_[g]; bits != 0; bits &= bits - 1) {
                const std::size_t k = g * kGroup + static_cast<std::size_t>(std::countr_zero(bits));
                body(numbers_[k], weight_[k]);
            }
    }

private:
    using V = stdx::native_simd<double>;
    static constexpr std::size_t kGroup = V::size();
    /// As many surfels as there are lanes; a lane without one holds no point.
    struct Group {
        Vec3<V> center;
        Frame<V> frame;
        V radius, inverse_radius;
        std::array<V, 6> a;  // of the polynomial
        struct {
            V u, v, reach;
        } rims[2];
        bool any_rims;
    };
    struct Sums;
    static V rim_share(const Group& s, const V& u, const V& v);
    Group group_of(const BallIndex& index, std::size_t first) const;

    std::vector<std::uint32_t> numbers_;
    std::vector<Group> groups_;
    std::vector<std::uint64_t> holds_;  // of each group, which hold the point
    std::vector<double> weight_;        // of each surfel, at the point
    std::vector<Vec3<V>> gradients_;    // of each group, at a point without a normal
    bool plain_ = false;
};

}  // namespace slim

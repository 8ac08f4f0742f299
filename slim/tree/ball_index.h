#pragma once

#include "slim/base/bbox.h"
#include "slim/blend/leaf_hessians.h"
#include "slim/model/surfel.h"
#include "slim/model/surfel_tree.h"

#include <array>
#include <cstdint>
#include <vector>

namespace slim {

/// The leaves of a model, decoded, under an implicit tree of boxes: which of them hold a point?
/// For measuring and smoothing, which ask at millions of points. 290 bytes a leaf.
class BallIndex {
public:
    /// hessians: of the leaves, if curvature is to be blended; must outlive the index.
    explicit BallIndex(const SurfelTree& tree, const LeafHessians* hessians = nullptr);
    /// Of surfels that no model holds; node(i) is the place in the list.
    explicit BallIndex(std::vector<Surfel> leaves);

    std::size_t n_leaves() const { return leaves_.size(); }
    const Surfel& leaf(std::size_t number) const { return leaves_[number]; }

    /// A leaf that supporters() gave, by its number in the index, and the model's node of that
    /// number.
    std::size_t number_of(const Surfel* leaf) const {
        return static_cast<std::size_t>(leaf - leaves_.data());
    }
    std::uint32_t node(std::size_t number) const { return nodes_[number]; }

    /// Writes the leaves with |p - c| < rho to `out`, in the index's order (deterministic).
    /// Cost: about 0.25 us where five of 10,000 leaves hold the point.
    void supporters(const Vec3d& p, std::vector<const Surfel*>& out) const;
    /// Writes the numbers of the leaves whose balls meet a box to `out`, in order: for points that
    /// lie together, of which each is asked of these few alone.
    void near(const Bbox& box, std::vector<std::uint32_t>& out) const;

private:
    static constexpr std::size_t kFanout = 8;
    /// Boxes side by side, for lanes; rounded outwards to floats. A place without a box holds
    /// nothing.
    struct Boxes {
        std::array<std::array<float, kFanout>, 3> lo, hi;
        Boxes();
        void set(std::size_t i, const Bbox& box);
    };
    struct Ball {
        Vec3d center;
        double sq_radius;
    };
    static std::uint64_t meeting(const Boxes& boxes, const Vec3f& lo_down, const Vec3f& hi_up);
    template <class Body>
    void for_boxes_meeting(const Bbox& box, const Body& body) const;
    BallIndex(std::vector<Surfel> leaves, std::vector<std::uint32_t> nodes);
    void build(std::vector<Surfel>& leaves, const std::vector<std::uint32_t>& nodes);
    void add_level(const std::vector<Bbox>& boxes);

    std::vector<Surfel> leaves_;              // along a Morton curve
    std::vector<Ball> balls_;                 // of the leaves
    std::vector<std::uint32_t> nodes_;        // of the leaves
    std::vector<std::vector<Boxes>> levels_;  // 0: a place for each leaf; above, one for each
                                              // Boxes; the last is one
};

}  // namespace slim

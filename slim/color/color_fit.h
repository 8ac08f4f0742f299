#pragma once

#include "slim/model/surfel_color.h"
#include "slim/model/surfel_tree.h"
#include "slim/tree/ball_index.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Fits the colours of a cloud's points to the leaves of its model, by linear functions over each
/// leaf, weighted by G as the surface is; points may come in any number of pieces, the result
/// depends on their order in the last bits only.
///
/// memory  400 bytes a leaf, whatever the number of points
/// cost    about 0.6 us a point
class ColorFit {
public:
    explicit ColorFit(const SurfelTree& tree);

    /// positions in the frame of the job, normals as measured (empty: none; a point counts for
    /// leaves that face as it does), colours display-referred 0 to 1. Points in no leaf's ball
    /// count as lost.
    void add(std::span<const Vec3d> positions, std::span<const Vec3f> normals,
             std::span<const Vec3f> colors);

    /// One colour a node: of leaves the fit (a damped one, so that few points give no wild slopes),
    /// of internal nodes the mean of their children by points. Leaves without a point take their
    /// parent's.
    std::vector<SurfelColor> finish() const;

    std::uint64_t n_lost() const { return n_lost_; }

private:
    /// Weighted sums of 1, u, v and their products, and of these with the three channels.
    struct Sums {
        std::array<double, 6> moments{};
        std::array<std::array<double, 3>, 3> colors{};
    };
    /// What one point adds to one leaf.
    struct Share {
        std::uint32_t leaf;
        float weight, u, v;
    };
    void add_shares(const Vec3d& p, const Vec3f* normal, std::vector<const Surfel*>& found,
                    std::vector<Share>& shares) const;
    SurfelColor solve(const Sums& sums) const;

    const SurfelTree& tree_;
    BallIndex index_;
    std::vector<Sums> sums_;  ///< by leaf of the index
    std::uint64_t n_lost_ = 0;
};

}  // namespace slim

#pragma once

#include "slim/model/point_block.h"
#include "slim/neighbors/box_tree.h"

#include <cmath>
#include <cstddef>
#include <vector>

namespace slim {

/// Shares of good and bad normals in a cloud.
struct NormalAudit {
    std::size_t n = 0;         ///< points looked at
    std::size_t missing = 0;   ///< zero or non-finite
    std::size_t contrary = 0;  ///< opposed to neighbours that agree among themselves
    std::size_t noisy = 0;     ///< not opposed, yet more than 72 degrees off neighbours that agree
    /// pairs of neighbours with opposite normals, in a sample of buckets
    double opposed = 0;
    double compared = 0;       ///< pairs with normals along one line
    double across = 0;         ///< sum over opposed pairs of n_i . (p_j - p_i) ...
    double across_size = 0;    ///< ... and of its size
    /// points of these buckets on one side of which neighbours agree, while on the other they
    /// oppose it, ...
    std::size_t on_seams = 0;
    std::size_t looked_at = 0; ///< ... of so many

    /// Whether signs are mixed up: more pairs are opposed than a tenth of flipped normals explains
    /// (2 f (1 - f)), and it is no thin sheet or crack, of which one side lies behind or before the
    /// other.
    bool has_mixed_signs() const {
        return opposed > 0.2 * compared && std::abs(across) < 0.5 * across_size;
    }
    /// Whether there may be patches of flipped normals: of real scans 0 to 1 % of the points lie at
    /// seams, of small and noisy ones up to 9; a closer look tells (contrary_patches, notes/0006).
    bool has_seams() const {
        return static_cast<double>(on_seams) > 0.005 * static_cast<double>(looked_at);
    }
};

/// Gives the points whose normal opposes a clear majority of their neighbours the direction of that
/// majority: single-view scans see some points from behind a silhouette, registered clouds hold 0.4
/// to 1.3 % of them. A thin sheet has no majority (its two sides cancel), and stays as it is.
/// Neighbours: the points within half a bucket's diagonal (about 16). Normals that are zero count
/// as missing and stay. The block must be in Morton order (sort_along_curve).
/// Cost: 0.17 us a point and core (notes/0001); 24 bytes a point meanwhile. Parallel.
/// boxes: of the block's points
/// counted: the points that contrary and noisy are counted of; empty: all
/// judged: the points that are looked at, others are neighbours only; empty: all
NormalAudit repair_contrary_normals(PointBlock& points, const BoxTree& boxes,
                                    const std::vector<bool>& counted = {},
                                    const std::vector<bool>& judged = {});

}  // namespace slim

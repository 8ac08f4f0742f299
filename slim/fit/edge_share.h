#pragma once

#include "slim/model/point_block.h"
#include "slim/neighbors/point_pyramid.h"

#include <cstddef>

namespace slim {

/// What is known of a cloud before it is asked for its edges; lengths in model units.
struct EdgeQuestion {
    double spacing = 0;           ///< square root of the area that one of its points usually has
    double n_points = 0;          ///< of the whole cloud, of which the pyramid may hold a share
    double noise_variance = 0;    ///< lambda
    double typical_variance = 0;  ///< of a typical place
    double contrary_share = 0;    ///< of normals that noise turns out of a height field
};

/// How many of a cloud's places lie at feature edges.
struct EdgeShare {
    std::size_t asked = 0, at_edges = 0;
    double share() const {
        return asked > 0 ? static_cast<double>(at_edges) / static_cast<double>(asked) : 0;
    }
    /// log of how much likelier a cloud of many edges (kManyEdges) gives this than one of few.
    double evidence() const;
    /// Whether the cloud is a part with edges, for sharp surfels to follow: evidence() > 0, which
    /// is a share of more than kEdgeShare.
    bool are_features() const { return evidence() > 0; }
};

/// Shares that are told apart (notes/0015): heads, scans and terrain have 3 % of their places at
/// edges or fewer, parts from 6 % up.
inline constexpr double kFewEdges = 0.02, kManyEdges = 0.08;
/// Where both are as likely.
inline constexpr double kEdgeShare = 0.0436;

/// Looks for feature edges about random points of a cloud with normals: those first by priority, in
/// balls that hold a fiftieth of its area at any density (of small clouds 160 points), wider in
/// noise. A place lies at an edge where two or three sheets joined there, no
/// two of them back to back, follow its points clearly better than one height field does and are
/// borne out (fit_sharp, is_filled). Stops as soon as it is sure by Wald's sequential test, 1 error
/// in 100, at 512 places at the latest. The same for any number of threads; for a job in slices,
/// whose pyramid is one of a sample, the same but for normals that slices estimate otherwise.
/// Nothing asked of fewer than 500 points, nor where noise is as thick as the shape.
/// cost  10 to 50 us a place of a scan, of which 96 usually do, 100 us a place of a part
EdgeShare edge_share(const PointBlock& points, const PointPyramid& pyramid,
                     const EdgeQuestion& cloud);

}  // namespace slim

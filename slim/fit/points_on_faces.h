#pragma once

#include "slim/model/point_block.h"

namespace slim {

/// What tells a part in noise from an exact one; variances in length^2.
struct PartNoise {
    double variance = 0;          ///< lambda, to which edges add
    double typical_variance = 0;  ///< of a typical place
    double spacing = 0;           ///< square root of the area that a point usually has

    /// Noise that shows at the points' distance and makes a good share of lambda. That of exact
    /// parts is their edges', and a typical place has a hundredth of it or less (notes/0024).
    bool is_everywhere() const;
    /// Of the neighbours that points_on_faces() asks; length.
    double reach() const;
    /// The same of the points that it returns: what edges add to lambda stays.
    PartNoise left() const;
};

/// A noisy part's points, each moved along its normal to where its neighbours on the same face have
/// it. First the normals are averaged over neighbours whose normals are alike, several times, so
/// that those of a face agree and edges stay edges; how alike, is told by how much they usually
/// differ. Then points follow the planes across the normal half-way between two of them: those of a
/// cylinder, which it neither widens nor narrows. Points without a normal stay.
/// Where points lie densely, every so manieth of those about a bucket is asked, some 512.
/// The same for any number of threads. Cost: some 15 us a point, 96 bytes a point meanwhile
PointBlock points_on_faces(const PointBlock& points, double reach);

}  // namespace slim

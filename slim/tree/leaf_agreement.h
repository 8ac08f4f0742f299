#pragma once

#include "slim/model/surfel.h"
#include "slim/model/surfel_tree.h"

#include <array>
#include <cstddef>
#include <span>

namespace slim {

/// Places of a leaf's own surface, at which its neighbours are asked whether they are of the same:
/// the one under its centre and six half a radius about it; of a sharp leaf as many on every sheet,
/// where that makes the surface.
class LeafSamples {
public:
    struct Sample {
        Vec3d position;
        Vec3d normal;  ///< unit, outwards
    };

    explicit LeafSamples(const Surfel& leaf);

    std::span<const Sample> samples() const { return {samples_.data(), n_}; }
    double support_radius() const { return support_radius_; }

private:
    static constexpr std::size_t kPerSheet = 7;
    std::array<Sample, kPerSheet * kMostSheets> samples_;
    std::size_t n_ = 0;
    double support_radius_;
};

/// How two leaves whose balls overlap stand to each other, from the smaller one's samples inside
/// the larger one's ball: `agree` if at least four lie within kBelongs of the smaller radius of the
/// larger one's surface with normals less than 45 degrees apart, `nearly` if two do, `beside` if
/// any lies within two of the smaller radii of it. Rims do not count: what would lie beyond one
/// tells the sheet just as well.
enum class Meeting { apart, beside, nearly, agree };

Meeting meeting_of(const LeafSamples& smaller, const SurfelTree& tree, std::size_t larger);

/// meeting_of(...) == Meeting::agree, without a look at the surface of a leaf that cannot.
bool agrees(const LeafSamples& smaller, const SurfelTree& tree, std::size_t larger);

}  // namespace slim

#pragma once

#include "slim/model/surfel_color.h"
#include "slim/model/surfel_tree.h"
#include "slim/tree/ball_index.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// The colour of a model's surface: those of the leaves that hold a point, weighted by G as the
/// surface is.
class ColorBlend {
public:
    /// Both must outlive it. 290 bytes a leaf.
    ColorBlend(const SurfelTree& tree, std::span<const PackedColor> colors)
        : tree_(tree), colors_(colors), index_(tree) {}

    /// Display-referred colour at p (frame of the job) on a surface of unit normal n, of leaves
    /// that face as it does; where there is none, that of `node`. `found` keeps its memory.
    Vec3f at(const Vec3d& p, const Vec3d& n, std::uint32_t node,
             std::vector<const Surfel*>& found) const;

private:
    Vec3f of_node(const Surfel& surfel, std::size_t node, const Vec3d& p) const;

    const SurfelTree& tree_;
    std::span<const PackedColor> colors_;
    BallIndex index_;
};

}  // namespace slim

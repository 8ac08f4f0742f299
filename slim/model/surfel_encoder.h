#pragma once

#include "slim/model/surfel.h"
#include "slim/model/surfel_tree.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace slim {

/// What of a surfel decides where it and others stand in a model's arrays.
struct SurfelShape {
    Vec3d center;
    std::uint8_t degree = 0;
    std::uint8_t n_extra = 0;  ///< further sheets
};

inline SurfelShape shape_of(const Surfel& s) {
    return {s.center, static_cast<std::uint8_t>(s.degree),
            static_cast<std::uint8_t>(s.n_sheets() - 1)};
}

/// Rounds surfels to the file's floats: page origins, records, further sheets. Places are fixed by
/// the shapes, so that the surfels themselves may come one at a time and in any order: no more than
/// one of them needs to be in memory.
/// Where it takes 5 % fewer bytes, every record is as long as its own surfel's degree needs, and an
/// index says where each begins.
/// A surfel's frame must be the one its rounded normal gives (round_normal), or its surface turns.
class SurfelEncoder {
public:
    /// Lays out `out`, whose header's degree is set; shape(i) for i in [0, n), node order, the root
    /// first. Keeps a reference to `out`, not to `shape`; the first put() makes the room.
    using Shapes = std::function<SurfelShape(std::size_t node)>;
    SurfelEncoder(std::size_t n, const Shapes& shape, SurfelTreeData& out);

    /// Each node once, with a surfel of the shape that was announced. Returns its rims in the axes
    /// that it is stored with.
    PackedRims put(std::size_t node, const Surfel& surfel);

private:
    void lay_out_records(std::size_t n, const Shapes& shape);
    void make_room();
    void put_further_sheets(std::size_t node, const SharpSheets& more);

    SurfelTreeData& out_;
    std::size_t n_record_floats_ = 0, n_sheet_floats_ = 0;
};

/// All surfels of a model at once, node order.
void encode_surfels(std::span<const Surfel> surfels, SurfelTreeData& out);

/// A surfel of degree 0 or 1 in a frame whose slopes are zero: the same plane, up to the rounded
/// normal; further sheets likewise. Degrees 2 and 3 come back unchanged.
Surfel level_linear(const Surfel& surfel);

}  // namespace slim

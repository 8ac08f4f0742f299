#pragma once

#include "slim/base/bbox.h"
#include "slim/base/vec.h"
#include "slim/model/surfel.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Floats a surfel takes in the file: centre 3, radius 1, octahedral normal 2, then 1, 6 or 10
/// coefficients (a linear surfel's normal is turned so that its slopes are zero): 7, 12 or 16.
constexpr int floats_per_surfel(int degree) { return degree <= 1 ? 7 : 6 + n_coefficients(degree); }

/// Where records of unequal size stand: record i begins page_start[i / kSurfelsPerPage] +
/// in_page[i] floats into the records and is as long as its node's degree says. Empty where all are
/// as long as the model's degree says.
struct RecordIndex {
    std::span<const std::uint64_t> page_start;
    std::span<const std::uint16_t> in_page;
    bool empty() const { return in_page.empty(); }
};

inline constexpr std::uint32_t kNoNode = 0xffffffffu;
inline constexpr std::size_t kSurfelsPerPage = 1024;

enum NodeFlags : std::uint8_t {
    kLeaf = 1,       ///< carries the surface; the others stand in for their children when small
    kSaturated = 2,  ///< E still fell at the largest radius
    kForced = 4,     ///< radius not chosen by E: too few points, or the smallest radius
    kSharp = 8,      ///< two sheets or more: the further ones stand in an array of their own
    /// no part of the surface about it (slim/tree/loose_leaves.h), or above nothing else
    kLoose = 16,
    /// internal nodes: leaves agree with their surfel all over its ball, so that it shows what is
    /// below where that is finer than a picture (slim/tree/stand_ins.h). Older files have none
    kStandsIn = 32,
    kLimited = 64,  ///< radius ended by a fold or another sheet, not by E
};

/// Where the further sheets of a sharp node stand; sorted by node, so that smooth models carry
/// nothing.
struct SharpEntry {
    std::uint32_t node = 0;
    std::uint32_t first_sheet = 0;  ///< in the array of sheets
    std::uint8_t n_extra = 1;       ///< beside the node's own
    std::uint8_t outer = 0, inner = 0;  ///< Join
    std::uint8_t reserved = 0;
};
static_assert(sizeof(SharpEntry) == 12);

/// Floats a further sheet takes: octahedral normal 2 and the coefficients of its surfel's degree.
constexpr int floats_per_sheet(int degree) { return floats_per_surfel(degree) - 4; }

/// Node i of the ball tree owns surfel i. Node 0 is the root: it encloses everything and has no
/// surface. Children of a node stand together: [first_child, first_child + n_children). Parents
/// come first.
struct TreeNode {
    std::uint32_t first_child = kNoNode;
    std::uint32_t n_children = 0;
    /// ball about the surfel's centre that holds its ball and all below
    float bound_radius = 0;
    float fit_error = 0;        ///< eps, RMS residual, model units
    std::uint32_t n_points = 0; ///< points in the ball at the fit
    std::uint8_t level : 6 = 0;    ///< 1 is the coarsest
    std::uint8_t second_rim_high : 2 = 0;
    std::uint8_t degree : 2 = 0;   ///< 0..3, after fallbacks
    std::uint8_t second_rim_low : 6 = 0;
    std::uint8_t flags = 0;        ///< NodeFlags
    PackedRim rim = 0;             ///< first of rims(); the second fills the
                                   ///< gaps above, zero in older files

    /// Where its data end on one side or two.
    PackedRims rims() const {
        return {rim, static_cast<PackedRim>(second_rim_high << 6 | second_rim_low)};
    }
    void set_rims(PackedRims rims) {
        rim = rims.first;
        second_rim_low = rims.second & 63u;
        const unsigned high = rims.second >> 6;
        second_rim_high = high & 3u;
    }
    bool is_leaf() const { return (flags & kLeaf) != 0; }
    bool is_loose() const { return (flags & kLoose) != 0; }
};
static_assert(sizeof(TreeNode) == 24);

/// What a model says of itself; small, read first.
struct ModelHeader {
    /// largest degree; fixes the record size where there is no RecordIndex
    int degree = 2;
    Vec3d origin;               ///< world = origin + local
    Bbox bounds;                ///< of the input points, local frame
    double diagonal = 0;        ///< L
    double noise_variance = 0;  ///< lambda, length^2
    double mdl_threshold = 0;   ///< T_MDL, fraction of L
    std::uint64_t n_points = 0; ///< finite input points
    std::uint64_t n_leaves = 0;
    std::uint64_t seed = 0;
    /// Boxes of what pictures show without and with loose surfels (slim/tree/drawn_bounds.h); empty
    /// in older files.
    Bbox drawn, drawn_loose;
    /// Places whose convex hull is about that of what pictures show, local frame, and of the loose
    /// surfels beside it (slim/tree/drawn_hull.h); empty in older files.
    std::vector<Vec3d> hull, loose_hull;
};

/// Read-only view of a model, wherever its arrays live (a mapped file, or vectors in a test).
/// Coordinates are floats relative to the origin of the surfel's page (double, local frame).
class SurfelTree {
public:
    SurfelTree(const ModelHeader& header, std::span<const Vec3d> page_origins,
               std::span<const float> records, std::span<const TreeNode> nodes,
               std::span<const SharpEntry> sharp = {}, std::span<const float> sheets = {},
               const RecordIndex& index = {})
        : header_(header), page_origins_(page_origins), records_(records), nodes_(nodes),
          sharp_(sharp), sheets_(sheets), index_(index) {}

    const ModelHeader& header() const { return header_; }
    std::size_t n_nodes() const { return nodes_.size(); }
    const TreeNode& node(std::size_t i) const { return nodes_[i]; }
    std::span<const TreeNode> nodes() const { return nodes_; }
    std::span<const Vec3d> page_origins() const { return page_origins_; }
    std::span<const float> records() const { return records_; }
    std::span<const SharpEntry> sharp() const { return sharp_; }
    std::span<const float> sheets() const { return sheets_; }

    const RecordIndex& record_index() const { return index_; }
    /// The degree that record i has coefficients for: at least that of its surfel.
    int record_degree(std::size_t i) const {
        return index_.empty() ? header_.degree : nodes_[i].degree;
    }
    const float* record(std::size_t i) const {
        if (!index_.empty())
            return records_.data() + index_.page_start[i / kSurfelsPerPage] + index_.in_page[i];
        return records_.data() + i * static_cast<std::size_t>(floats_per_surfel(header_.degree));
    }
    Vec3d center(std::size_t i) const {
        const float* r = record(i);
        return page_origins_[i / kSurfelsPerPage] + Vec3d{r[0], r[1], r[2]};
    }
    double support_radius(std::size_t i) const { return record(i)[3]; }
    /// Surfel i in doubles; i = 0 (the root) has a centre and a radius only.
    Surfel surfel(std::size_t i) const;

private:
    static Sheet sheet(const float* record, int degree);
    std::shared_ptr<const SharpSheets> sharp_sheets(std::size_t i) const;

    ModelHeader header_;
    std::span<const Vec3d> page_origins_;
    std::span<const float> records_;
    std::span<const TreeNode> nodes_;
    std::span<const SharpEntry> sharp_;
    std::span<const float> sheets_;
    RecordIndex index_;
};

/// The arrays of a model in memory, as the tree stage builds them and tests make them.
struct SurfelTreeData {
    ModelHeader header;
    std::vector<Vec3d> page_origins;
    std::vector<float> records;
    std::vector<TreeNode> nodes;
    std::vector<SharpEntry> sharp;
    std::vector<float> sheets;
    std::vector<std::uint64_t> page_start;  ///< RecordIndex
    std::vector<std::uint16_t> in_page;

    SurfelTree view() const {
        return {header, page_origins, records, nodes, sharp, sheets, {page_start, in_page}};
    }
};

/// The normal as the file will give it back: fit in this frame (NUMERICS 2.1).
Vec3d round_normal(const Vec3d& unit_normal);

}  // namespace slim

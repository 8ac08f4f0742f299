#include "slim/tree/loose_leaves.h"

#include "slim/tree/leaf_pieces.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr std::uint64_t kSmallPiece = 1000;  // points: larger ones are never loose, nor looked at
constexpr double kHost = 10;                 // areas of a piece that the one beside it has
constexpr double kSparseBeside = 0.5, kEvidenceBeside = 40;
constexpr double kSparseAstray = 0.125, kEvidenceAstray = 3;
constexpr double kLargeShare = 0.1;  // of the model's area
// A piece that cannot be told from noise: radii in deviations of the noise, points, of the area
constexpr double kNoiseRadii = 9, kNoisePoints = 100, kNoiseShare = 2e-4;

/// Points and area (over pi) of leaves. Balls overlap, so both count parts of the surface more than
/// once: only their ratio and comparisons mean anything.
struct Extent {
    double points = 0, area = 0;
    double radius = 0;  ///< of the largest leaf

    void add(const Extent& e) {
        points += e.points, area += e.area;
        radius = std::max(radius, e.radius);
    }
    double density() const { return area > 0 ? points / area : 0; }
};

/// Few points say little, and less where they are sparse beside what there should be.
bool is_weak(const Extent& piece, double usual_density, double sparse, double evidence) {
    const double share = piece.density() / usual_density;
    return share < sparse && piece.points * share < evidence;
}

struct SmallPiece {
    Extent own;
    Extent hosts;  ///< leaves beside it, of pieces much larger than it
};

class LooseFinder {
public:
    explicit LooseFinder(const SurfelTree& tree) : tree_(tree), pieces_(tree) { measure(); }

    /// Nodes of loose leaves.
    std::vector<std::uint32_t> find(LooseCounts& counts) {
        list_small();
        join_small();
        for (std::uint32_t i = 0; i < pieces_.size(); ++i) counts.pieces += pieces_.piece(i) == i;
        look_beside();
        take(counts.beside, [&](const SmallPiece& piece) {
            return piece.hosts.points > 0 &&
                   is_weak(piece.own, piece.hosts.density(), kSparseBeside, kEvidenceBeside);
        });
        take_noise(counts, [](const SmallPiece& piece) { return piece.hosts.points > 0; });
        join_touching();
        take_noise(counts, [](const SmallPiece&) { return true; });
        take(counts.astray, [&](const SmallPiece& group) {
            return group.own.area < kLargeShare * all_.area &&
                   is_weak(group.own, all_.density(), kSparseAstray, kEvidenceAstray);
        });
        return std::move(loose_);
    }

private:
    using Joint = std::pair<std::uint32_t, std::uint32_t>;

    Extent extent_of(std::uint32_t leaf) const {
        const double r = pieces_.support_radius(leaf);
        return {static_cast<double>(tree_.node(pieces_.node(leaf)).n_points), r * r, r};
    }

    void measure() {
        extent_.assign(pieces_.size(), {});
        for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
            extent_[pieces_.piece(i)].add(extent_of(i));
            all_.add(extent_of(i));
        }
    }

    bool is_small(std::uint32_t piece) const {
        return extent_[piece].points < kSmallPiece && extent_[piece].area < kLargeShare * all_.area;
    }

    void list_small() {
        for (std::uint32_t i = 0; i < pieces_.size(); ++i)
            if (is_small(pieces_.piece(i))) leaves_.push_back(i);
    }

    /// Small pieces that nearly agree are one: a wall of few points holds together where the scales
    /// of a rim do not.
    void join_small() {
        std::vector<Joint> joints;
        pieces_.for_links(leaves_, [&](const LeafPieces::Link& link) {
            if (link.meeting == Meeting::nearly && is_small(pieces_.piece(link.other)))
                joints.emplace_back(link.leaf, link.other);
        });
        join(joints);
    }

    void look_beside() {
        pieces_.for_links(leaves_, [&](const LeafPieces::Link& link) {
            SmallPiece& piece = small_.at(pieces_.piece(link.leaf));
            if (area_of(pieces_.piece(link.other)) > kHost * piece.own.area)
                piece.hosts.add(extent_of(link.other));
        });
    }

    double area_of(std::uint32_t piece) const {
        const auto small = small_.find(piece);
        return small == small_.end() ? extent_[piece].area : small->second.own.area;
    }

    /// What is left of small pieces and touches: an object of few points is several pieces, a plate
    /// of strays one.
    void join_touching() {
        std::vector<Joint> joints;
        pieces_.for_links(leaves_, [&](const LeafPieces::Link& link) {
            if (std::binary_search(leaves_.begin(), leaves_.end(), link.other))
                joints.emplace_back(link.leaf, link.other);
        });
        join(joints);
    }

    /// Joins leaves of small pieces and measures what comes out.
    void join(const std::vector<Joint>& joints) {
        for (const auto& [i, j] : joints) pieces_.join(i, j);
        small_.clear();
        for (const std::uint32_t i : leaves_) small_[pieces_.piece(i)].own.add(extent_of(i));
    }

    /// Moves the leaves of small pieces that are loose out of the list, and counts them.
    template <class IsLoose>
    void take(std::uint64_t& count, IsLoose&& is_loose) {
        std::erase_if(leaves_, [&](std::uint32_t i) {
            if (!is_loose(small_.at(pieces_.piece(i)))) return false;
            loose_.push_back(pieces_.node(i));
            ++count;
            return true;
        });
    }

    /// Few points in leaves hardly larger than the noise, which strays beside a rim make as dense
    /// as a surface.
    template <class Where>
    void take_noise(LooseCounts& counts, Where&& where) {
        const double radius = kNoiseRadii * std::sqrt(tree_.header().noise_variance);
        take(counts.in_noise, [&](const SmallPiece& piece) {
            return where(piece) && piece.own.radius < radius && piece.own.points < kNoisePoints &&
                   piece.own.area < kNoiseShare * all_.area;
        });
    }

    const SurfelTree& tree_;
    LeafPieces pieces_;
    std::vector<Extent> extent_;  // of each piece, at its number, before small ones are joined
    Extent all_;
    std::vector<std::uint32_t> leaves_;  // of small pieces, less those found loose
    std::vector<std::uint32_t> loose_;   // nodes
    std::unordered_map<std::uint32_t, SmallPiece> small_;
};

/// Internal nodes above nothing but loose leaves; children come after their parents.
void mark_above(SurfelTreeData& tree) {
    for (std::size_t i = tree.nodes.size(); i-- > 1;) {
        TreeNode& node = tree.nodes[i];
        if (node.is_leaf() || node.n_children == 0) continue;
        const auto first = tree.nodes.begin() + node.first_child;
        if (std::all_of(first, first + node.n_children,
                        [](const TreeNode& n) { return n.is_loose(); }))
            node.flags |= kLoose;
    }
}

}  // namespace

LooseCounts mark_loose(SurfelTreeData& tree) {
    LooseCounts counts;
    const SurfelTree view = tree.view();
    const std::vector<std::uint32_t> loose = LooseFinder(view).find(counts);
    if (counts.loose() == tree.header.n_leaves) {
        counts.beside = counts.in_noise = counts.astray = 0;
        return counts;
    }
    for (const std::uint32_t node : loose) tree.nodes[node].flags |= kLoose;
    mark_above(tree);
    return counts;
}

}  // namespace slim

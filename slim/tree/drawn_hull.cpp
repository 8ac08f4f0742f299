#include "slim/tree/drawn_hull.h"

#include "slim/base/parallel.h"
#include "slim/tree/hull_directions.h"
#include "slim/tree/leaf_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>
#include <vector>

namespace slim {
namespace {

using Lanes = HullDirections::Lanes;
using LanesOf3 = HullDirections::LanesOf3;

/// A ball that holds all places of a leaf, or of some, moved into the box.
struct Ball {
    Vec3d center;
    double radius;

    Lanes most(const LanesOf3& d) const {
        return d.x * center.x + d.y * center.y + d.z * center.z + radius;
    }
};

Vec3d in_box(const Vec3d& p, const Bbox& box) {
    Vec3d out;
    for (std::size_t axis = 0; axis < 3; ++axis)
        out[axis] = std::clamp(p[axis], box.lo[axis], box.hi[axis]);
    return out;
}

/// How far what lies within `reach` of a place along each axis moves to be in the box: down from
/// above it, and up from below.
struct Moves {
    Vec3d down, up;

    Moves(const Vec3d& center, const Vec3d& reach, const Bbox& box) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            down[axis] = std::max(0.0, center[axis] + reach[axis] - box.hi[axis]);
            up[axis] = std::max(0.0, box.lo[axis] - (center[axis] - reach[axis]));
        }
    }
    double farthest() const { return length(down) + length(up); }
    Lanes most(const LanesOf3& d) const {
        const Lanes zero(0.0);
        return stdx::max(-d.x, zero) * down.x + stdx::max(d.x, zero) * up.x +
               stdx::max(-d.y, zero) * down.y + stdx::max(d.y, zero) * up.y +
               stdx::max(-d.z, zero) * down.z + stdx::max(d.z, zero) * up.z;
    }
};

/// How far a leaf's places, moved into the box, reach at most: a tighter bound than its ball.
class LeafBound {
public:
    LeafBound(const Surfel& s, const Bbox& box)
        : center_(s.center), extent_(s), moves_(s.center, extent_.along_axes(), box) {}

    Lanes most(const LanesOf3& d) const {
        Lanes far(0.0);
        for (std::size_t i = 0; i < extent_.n_discs; ++i) {
            const LeafExtent::Disc& disc = extent_.disc[i];
            const Lanes along = stdx::abs(d.x * disc.normal.x + d.y * disc.normal.y +
                                          d.z * disc.normal.z);
            const Lanes across = stdx::sqrt(stdx::max(1.0 - along * along, Lanes(0.0)));
            far = stdx::max(far, across * disc.radius + along * disc.height);
        }
        return d.x * center_.x + d.y * center_.y + d.z * center_.z + far + moves_.most(d);
    }

private:
    Vec3d center_;
    LeafExtent extent_;
    Moves moves_;
};

/// The farthest place found in each direction; of equally far ones the first by leaf and place, so
/// that it does not matter in which order they are met.
struct Farthest {
    HullDirections directions = HullDirections::all();
    std::array<Vec3d, kHullDirections> place;
    std::array<std::uint64_t, kHullDirections> order;
    std::uint64_t n_tests = 0;  ///< of something against a direction

    void add(std::size_t k, const Vec3d& p, std::uint64_t at) {
        add(k, p, dot(directions.at(k), p), at);
    }
    void add(const Farthest& other) {
        n_tests += other.n_tests;
        for (std::size_t k = 0; k < kHullDirections; ++k)
            if (other.directions.reach(k) > -INFINITY)
                add(k, other.place[k], other.directions.reach(k), other.order[k]);
    }

private:
    void add(std::size_t k, const Vec3d& p, double reach, std::uint64_t at) {
        const double found = directions.reach(k);
        if (reach < found || (reach == found && at >= order[k])) return;
        directions.set_reach(k, reach), place[k] = p, order[k] = at;
    }
};

/// Leaves side by side in the file, which are near each other in space for the most part.
constexpr std::size_t kBlock = 16, kBlocksAtOnce = 128;
/// More than a leaf's places have.
constexpr std::uint64_t kNumbers = 1024;

class Search {
public:
    Search(const SurfelTree& tree, bool loose, const Bbox& box) : tree_(tree), box_(box) {
        for (std::uint32_t i = 0; i < tree.n_nodes(); ++i)
            if (tree.node(i).is_leaf() && tree.node(i).is_loose() == loose) leaves_.push_back(i);
    }

    Farthest run() const {
        Farthest all = farthest_middles();
        std::vector<Farthest> parts(n_parts(), all);
        for (Farthest& part : parts) part.n_tests = 0;
        parallel_blocks(n_blocks(), kBlocksAtOnce, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b) add_block(b, parts[begin / kBlocksAtOnce]);
        });
        for (const Farthest& part : parts) all.add(part);
        return all;
    }

private:
    std::size_t n_blocks() const { return (leaves_.size() + kBlock - 1) / kBlock; }
    std::size_t n_parts() const { return (n_blocks() + kBlocksAtOnce - 1) / kBlocksAtOnce; }

    /// Of the middle of one leaf of each block: what the rest has to reach beyond.
    Farthest farthest_middles() const {
        std::vector<LeafPlace> middles;
        Farthest out;
        HullDirections beyond;
        for (std::size_t i = 0; i < leaves_.size(); i += kBlock) {
            middles.clear();
            append_places(tree_.surfel(leaves_[i]), middles, 1);
            for (const LeafPlace& middle : middles) {
                const Ball at{in_box(middle.position, box_), 0};
                beyond.keep(out.directions, [&](const LanesOf3& d) { return at.most(d); });
                out.n_tests += kHullDirections + beyond.size();
                add_place(i, middle, beyond, out);
            }
        }
        return out;
    }
    void add_place(std::size_t leaf, const LeafPlace& place, const HullDirections& some,
                   Farthest& out) const {
        const Vec3d at = in_box(place.position, box_);
        for (std::size_t k = 0; k < some.size(); ++k)
            out.add(some.id(k), at, leaf * kNumbers + place.number);
    }

    void add_block(std::size_t b, Farthest& out) const {
        const std::size_t begin = b * kBlock, n = std::min(kBlock, leaves_.size() - begin);
        std::array<Ball, kBlock> balls;
        const Ball all = balls_of(begin, n, balls);
        HullDirections of_block, of_leaf;
        of_block.keep(out.directions, [&](const LanesOf3& d) { return all.most(d); });
        out.n_tests += kHullDirections + n * of_block.size();
        if (of_block.size() == 0) return;
        for (std::size_t i = 0; i < n; ++i) {
            of_leaf.keep(of_block, [&](const LanesOf3& d) { return balls[i].most(d); });
            if (of_leaf.size() > 0) add_leaf(begin + i, of_leaf, out);
        }
    }
    /// The balls of some leaves; returns one about all.
    Ball balls_of(std::size_t begin, std::size_t n, std::array<Ball, kBlock>& balls) const {
        Bbox centers;
        for (std::size_t i = 0; i < n; ++i) {
            const Vec3d c = tree_.center(leaves_[begin + i]);
            const double radius = radius_of_places(tree_, leaves_[begin + i]);
            balls[i] = {c, radius + Moves(c, {radius, radius, radius}, box_).farthest()};
            centers.extend(c);
        }
        Ball all{centers.center(), 0};
        for (std::size_t i = 0; i < n; ++i)
            all.radius =
                std::max(all.radius, length(balls[i].center - all.center) + balls[i].radius);
        return all;
    }
    void add_leaf(std::size_t i, const HullDirections& of_leaf, Farthest& out) const {
        const Surfel leaf = tree_.surfel(leaves_[i]);
        const LeafBound bound(leaf, box_);
        HullDirections of_disc;
        of_disc.keep(of_leaf, [&](const LanesOf3& d) { return bound.most(d); });
        out.n_tests += of_leaf.size();
        if (of_disc.size() == 0) return;
        std::vector<LeafPlace> places;
        append_places(leaf, places);
        // Corners lie between those: of a box by a third of a leaf's radius.
        if (leaf.sharp || leaf.rims.any()) append_close_places(leaf, places);
        out.n_tests += places.size() * of_disc.size();
        for (const LeafPlace& place : places) add_place(i, place, of_disc, out);
    }

    const SurfelTree& tree_;
    const Bbox& box_;
    std::vector<std::uint32_t> leaves_;
};

/// Along an axis of the box the place moves onto its face.
Vec3d on_face(Vec3d p, const Vec3d& direction, const Bbox& box) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (std::abs(direction[axis]) == 1)
            p[axis] = direction[axis] > 0 ? box.hi[axis] : box.lo[axis];
    return p;
}

}  // namespace

std::vector<Vec3d> drawn_hull(const SurfelTree& tree, bool loose, const Bbox& box,
                              std::uint64_t* n_tests) {
    const Farthest farthest = Search(tree, loose, box).run();
    if (n_tests) *n_tests = farthest.n_tests;
    std::vector<Vec3d> hull;
    for (std::size_t k = 0; k < kHullDirections; ++k)
        if (farthest.directions.reach(k) > -INFINITY) {
            // The box with loose surfels is not theirs alone.
            hull.push_back(loose ? farthest.place[k]
                                 : on_face(farthest.place[k], farthest.directions.at(k), box));
        }
    const auto key = [](const Vec3d& p) { return std::tie(p.x, p.y, p.z); };
    std::sort(hull.begin(), hull.end(),
              [&](const Vec3d& a, const Vec3d& b) { return key(a) < key(b); });
    hull.erase(std::unique(hull.begin(), hull.end()), hull.end());
    return hull;
}

}  // namespace slim
